"""Runs a graph from Python: bind, schedule, and hand back what the outputs are."""

import os
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphtex import events
from graphtex.bind import bind
from graphtex.cache import Cache, CacheUnavailable, KeyParts
from graphtex.cache import explain as explain_change
from graphtex.document import Document
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.executors import Executor, make_executor
from graphtex.plan import Plan, Task
from graphtex.reports import Finished, Report
from graphtex.schedule import Emit, schedule
from graphtex.shipped import graph_identity
from graphtex.sockets import Gap
from graphtex.work import Held


@dataclass(frozen=True)
class RunResult(Mapping[str, Any]):
    """The outputs of a run by name; arrays are read-only.

    Attributes
    ----------
    plan
        What was to be run.
    reports
        What became of each task, by its id.
    """

    plan: Plan
    finished: Finished
    cache: Cache | None

    def __repr__(self) -> str:
        return f"<RunResult: {', '.join(self)}>"

    def __getitem__(self, name: str) -> Any:
        if name not in self.plan.outputs:
            raise KeyError(f"no output {name!r}{did_you_mean(name, self.plan.outputs, label='outputs')}")
        output = self.plan.outputs[name]
        values = [self.value(slot) for slot in output.slots]
        return values if output.joined else values[0]

    def __iter__(self) -> Iterator[str]:
        return iter(self.plan.outputs)

    def __len__(self) -> int:
        return len(self.plan.outputs)

    @property
    def reports(self) -> Mapping[str, Report]:
        """What became of each task, by its id."""
        return self.finished.reports

    @property
    def failed(self) -> bool:
        """Whether a task failed; a run with ``on_error: keep`` goes on after that."""
        return any(report.status in ("failed", "skipped") for report in self.reports.values())

    def value(self, slot: Any) -> Any:
        """Return the value of any task's output: a `Gap` if it failed or was not reached; `EntryLost` if not kept."""
        held = self.finished.held.get(slot, Gap(slot.task, "the run ended before it"))
        return held.load(self.cache) if isinstance(held, Held) else held


def run(
    graph: Document,
    inputs: Mapping[str, Any] | None = None,
    *,
    seed: int | None = None,
    only: str | Sequence[str] = (),
    executor: str | Executor = "serial",
    workers: int | None = None,
    cache: Cache | str | os.PathLike[str] | bool = True,
    emit: Emit = lambda event: None,
    cancel: threading.Event | None = None,
    base: Path | None = None,
    keep_all: bool = False,
) -> RunResult:
    """Run a graph and return its outputs.

    Parameters
    ----------
    inputs
        Arrays, numbers, paths or ``scheme:name`` strings by input name.
    seed
        Replaces the graph's seed.
    only
        Names of the outputs that are wanted; without it all.
    executor
        ``serial`` or ``threads``, or an executor that the caller has opened and closes.
    cache
        A cache, its folder, True for the default one or False for none.
    emit
        Called with each event, one at a time.
    cancel
        Set it, from another thread or a signal handler, to stop the run.
    base
        Where relative paths in `inputs` start; without it the current folder.

    Raises
    ------
    GraphError
        If the graph or the request is wrong; nothing has run.
    NodeFailed
        If a node raised; what had finished is cached. It carries what there is as ``error.result``.
    Cancelled
        If the run was stopped.
    """
    emit = events.told_once(emit)
    whole = bind(graph, inputs, seed=seed, base=base)
    plan = restrict(whole, only)
    with ExitStack() as stack:
        # a caller's own executor stays open, for the next run
        runner = stack.enter_context(make_executor(executor, workers)) if isinstance(executor, str) else executor
        used = open_cache(cache, stack, emit)
        explain = Explainer(whole, used)
        finished = schedule(plan, runner, cache=used, emit=emit, cancel=cancel, explain=explain, keep_all=keep_all)
        explain.remember(finished.parts, emit)
    result = RunResult(plan, finished, used)
    if finished.failure is not None:
        finished.failure.result = result
        raise finished.failure
    return result


def restrict(plan: Plan, only: str | Sequence[str]) -> Plan:
    """Return the plan for some of its outputs; GraphError for a name that it does not have, or if it has none."""
    if not plan.outputs:
        raise GraphError([plan.graph.problem(("outputs",), "the graph has no outputs: there is nothing to run for")])
    only = [only] if isinstance(only, str) else only
    unknown = [name for name in only if name not in plan.outputs]
    if unknown:
        raise GraphError(
            Problem("", 0, 0, "only", f"no output {name!r}{did_you_mean(name, plan.outputs, label='outputs')}")
            for name in unknown
        )
    return plan.only({name: plan.outputs[name] for name in only} if only else dict(plan.outputs))


def open_cache(cache: Cache | str | os.PathLike[str] | bool, stack: ExitStack, emit: Emit) -> Cache | None:
    """Return the cache that a run uses, its session entered; None with a warning if it cannot be written."""
    if cache is False:
        return None
    opened = cache if isinstance(cache, Cache) else make_cache(None if cache is True else Path(cache))
    try:
        return stack.enter_context(opened.session())
    except CacheUnavailable as error:
        emit(events.Warned("", f"running without cache: {error}"))
        return None


def make_cache(folder: Path | None) -> Cache:
    """Return the cache in a folder, without one the user's own; GraphError if its size in the environment is none."""
    try:
        return Cache(folder)
    except ValueError as error:
        raise GraphError([Problem("", 0, 0, "", str(error))]) from error


class Explainer:
    """Says why a task must run: what changed since the graph's last recorded run."""

    def __init__(self, plan: Plan, cache: Cache | None) -> None:
        self._plan, self._cache = plan, cache
        self._name = graph_identity(plan.graph.file)
        self._last = (cache.last_run(self._name) or {}) if cache is not None else {}

    def __call__(self, task: Task, parts: KeyParts | None) -> str:
        """Return a sentence, such as ``parameter window: 16 -> 32``."""
        if self._cache is None:
            return "no cache"
        if parts is None:
            return "its code has no source file to compare"
        old = self._last.get(task.id)
        if old is None:
            return "not run before"
        return "; ".join(str(change) for change in explain_change(old, parts)) or "its result is not stored"

    def remember(self, parts: Mapping[str, KeyParts], emit: Emit) -> None:
        """Record what the keys of this run were made of; tasks that were not reached keep what they had."""
        if self._cache is None:
            return
        kept = {task: old for task, old in self._last.items() if task in self._plan.tasks}
        try:
            self._cache.record_run(self._name, {**kept, **parts})
        except CacheUnavailable as error:
            emit(events.Warned("", str(error)))
