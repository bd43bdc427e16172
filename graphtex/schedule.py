"""Runs a plan: an in-degree ready queue over an executor, with the cache in front of it and events behind it."""

import heapq
import threading
import time
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, field
from typing import Literal

from graphtex import events
from graphtex.cache import Cache, CacheUnavailable, EntryLost, KeyParts, Output
from graphtex.context import usable_cores
from graphtex.errors import Cancelled, GraphtexError, NodeFailed
from graphtex.executors import Executor
from graphtex.keys import Keys, found_outputs, given_values
from graphtex.plan import Plan, Slot, Task
from graphtex.sockets import Gap
from graphtex.work import Call, Held, InputLost, Monitor, Outcome

Status = Literal["ran", "cached", "failed", "skipped"]
Emit = Callable[[events.Event], None]


@dataclass
class Report:
    """What became of one task."""

    task: Task
    status: Status
    seconds: float = 0.0
    key: str = ""
    why: str = ""
    message: str = ""
    warnings: tuple[str, ...] = ()


@dataclass
class Finished:
    """What became of a plan: a report for each task that was reached, and the values that are still held."""

    reports: dict[str, Report] = field(default_factory=dict)
    held: dict[Slot, Held | Gap] = field(default_factory=dict)
    parts: dict[str, KeyParts] = field(default_factory=dict)
    failure: NodeFailed | None = None


def schedule(
    plan: Plan,
    executor: Executor,
    *,
    cache: Cache | None = None,
    emit: Emit = lambda event: None,
    cancel: threading.Event | None = None,
    explain: Callable[[Task, KeyParts | None], str] = lambda task, parts: "",
    keep_all: bool = False,
) -> Finished:
    """Run all tasks of a plan.

    Parameters
    ----------
    explain
        Says why a task that is not cached must run.
    keep_all
        Keep every value, not only those of the outputs; for reports of runs without a cache.

    Raises
    ------
    NodeFailed
        Only by way of `Finished.failure`: what has finished stays.
    Cancelled
        If `cancel` was set; what has finished is in the cache.
    """
    run = _Run(plan, executor, cache, emit, cancel or threading.Event(), explain, keep_all)
    try:
        run.go()
    except BaseException:
        run.cancel.set()
        raise
    return run.finished


class _Run:
    def __init__(
        self,
        plan: Plan,
        executor: Executor,
        cache: Cache | None,
        emit: Emit,
        cancel: threading.Event,
        explain: Callable[[Task, KeyParts | None], str],
        keep_all: bool,
    ) -> None:
        self.plan, self.executor, self.cache, self.cancel, self.explain = plan, executor, cache, cancel, explain
        self._emit, self._emit_lock = emit, threading.Lock()
        self.finished = Finished(held=given_values(plan, digests=cache is not None))
        self.keys = Keys()
        self.order = {task: index for index, task in enumerate(plan.tasks)}
        self.waiting = {task: plan.dag.in_degree(task) for task in plan.tasks}
        self.ready = [(self.order[task], task) for task, count in self.waiting.items() if count == 0]
        heapq.heapify(self.ready)
        self.running: dict[Future[Outcome], str] = {}
        self.in_flight: dict[str, list[str]] = {}  # key -> tasks that wait for the one that makes it
        self.blocked: dict[str, set[str]] = {}  # task -> tasks whose lost outputs it waits for
        self.forced: set[str] = set()  # tasks that must run though their outputs' digests are known
        self.done: set[str] = set()
        pinned = {slot for output in plan.outputs.values() for slot in output.slots}
        self.readers: dict[Slot, int] = dict.fromkeys(pinned, 1)  # how many still want the value; outputs for ever
        for task in plan.tasks.values():
            for slot in task.slots:
                self.readers[slot] = self.readers.get(slot, 0) + 1
            if keep_all:
                self.readers.update({Slot(task.id, name): 1 << 30 for name in task.node.outputs})
        self.monitor = Monitor(
            lambda task, share, text: self.emit(events.Progress(task, share, text)),
            self.warn,
            lambda: self.stopping,
        )
        self.told: set[str] = set()  # warnings of the run itself, told once each
        self.threads = max(1, usable_cores() // executor.workers)

    def emit(self, event: events.Event) -> None:
        """Pass an event on, one at a time, from whichever thread."""
        with self._emit_lock:
            self._emit(event)

    def warn(self, task: str, text: str) -> None:
        """Pass a warning on; one of the run itself only once."""
        if task or text not in self.told:
            self.told.add(text)
            self.emit(events.Warned(task, text))

    def go(self) -> None:
        """Run everything, and again what was lost from the store before the outputs were read."""
        for task in self.plan.tasks.values():
            self.emit(events.Planned(task.id, task.node.name))
        self.loop()
        while not self.stopping and (lost := self.load_outputs()):
            self.force(lost)
            self.loop()

    def load_outputs(self) -> tuple[Slot, ...]:
        """Read the values of the plan's outputs; return those that the store has lost."""
        lost = []
        for slot in {slot for output in self.plan.outputs.values() for slot in output.slots}:
            held = self.finished.held[slot]
            if isinstance(held, Held) and not held.in_memory:
                try:
                    self.finished.held[slot] = Held(held.type, held.load(self.cache), held.digest)
                except EntryLost:
                    lost.append(slot)
        return tuple(lost)

    def loop(self) -> None:
        while self.ready or self.running:
            while self.ready and len(self.running) < self.executor.workers and not self.stopping:
                self.start(self.plan.tasks[heapq.heappop(self.ready)[1]])
            if not self.running:
                if self.stopping:
                    break
                continue
            for future in wait(self.running, timeout=0.1, return_when=FIRST_COMPLETED).done:
                self.collect(self.running.pop(future), future)
        if self.cancel.is_set() and self.finished.failure is None:
            self.emit(events.Stopped(""))
            raise Cancelled("the run was cancelled; what had finished is kept")

    @property
    def stopping(self) -> bool:
        return self.cancel.is_set() or self.finished.failure is not None

    def start(self, task: Task) -> None:
        """Find a task's outputs in the cache, or hand it to the executor."""
        broken = self.broken_input(task)
        if broken:
            self.skip(task, broken)
            return
        parts = None
        key = ""
        if self.cache is not None:
            parts = self.keys.parts(task, self.finished.held)
            if parts is not None:
                key = parts.key()
                self.finished.parts[task.id] = parts
        if key and task.id not in self.forced:
            if key in self.in_flight:
                self.in_flight[key].append(task.id)
                return
            begun = time.perf_counter()
            found = found_outputs(task, key, self.cache) if self.cache is not None else None
            if found is not None:
                outputs, warnings, _ = found
                for text in warnings:
                    self.emit(events.Warned(task.id, text))
                report = Report(task, "cached", time.perf_counter() - begun, key, warnings=warnings)
                self.emit(events.Cached(task.id, report.seconds))
                self.complete(task, outputs, report)
                return
        self.submit(task, key, parts)

    def submit(self, task: Task, key: str, parts: KeyParts | None) -> None:
        why = "its stored result was lost" if task.id in self.forced else self.explain(task, parts)
        self.finished.reports[task.id] = Report(task, "ran", key=key, why=why)
        if key:
            self.in_flight.setdefault(key, [])
        self.emit(events.Started(task.id, why))
        inputs: dict[str, Held | Gap | tuple[Held | Gap, ...]] = {}
        for name, source in (*task.inputs.items(), *task.measured.items()):
            inputs[name] = (
                tuple(self.finished.held[s] for s in source)
                if isinstance(source, tuple)
                else self.finished.held[source]
            )
        future = self.executor.submit(Call(task, inputs, self.threads), self.monitor, self.cache)
        self.running[future] = task.id

    def collect(self, name: str, future: "Future[Outcome]") -> None:
        """Take what came of a call."""
        task, report = self.plan.tasks[name], self.finished.reports[name]
        try:
            outcome = future.result()
        except InputLost as lost:
            self.rerun_producers(task, lost.slots)
            return
        except Cancelled:
            self.finished.reports.pop(name)
            self.emit(events.Stopped(name))
            return
        except (GraphtexError, MemoryError) as error:
            cause = error if isinstance(error, NodeFailed) else NodeFailed(name, str(error) or type(error).__name__)
            self.fail(task, report, cause)
            return
        report.seconds, report.warnings = outcome.seconds, outcome.warnings
        if report.key and self.cache is not None:
            outputs = {socket: Output(str(held.type), held.digest) for socket, held in outcome.outputs.items()}
            try:
                self.cache.record(report.key, task.node.name, outputs, outcome.seconds, outcome.warnings)
            except CacheUnavailable as error:
                self.warn("", str(error))
        self.emit(events.Finished(name, outcome.seconds))
        self.complete(task, dict(outcome.outputs), report)

    def complete(self, task: Task, outputs: dict[str, Held], report: Report) -> None:
        """Hold a task's outputs and free those that wait for them."""
        self.finished.reports[task.id] = report
        for socket, held in outputs.items():
            if self.readers.get(Slot(task.id, socket), 0) > 0 or held.in_memory is False:
                self.finished.held[Slot(task.id, socket)] = held
            else:
                self.finished.held[Slot(task.id, socket)] = Held(held.type, None, held.digest, in_memory=False)
        self.release(task)
        self.free_followers(report.key)
        self.free_blocked(task.id)
        self.free_readers(task)

    def release(self, task: Task) -> None:
        """Drop from memory what nobody reads any more."""
        if task.id in self.done:
            return
        for slot in task.slots:
            self.readers[slot] -= 1
            held = self.finished.held.get(slot)
            if self.readers[slot] == 0 and isinstance(held, Held) and slot not in self.plan.given:
                self.finished.held[slot] = Held(held.type, None, held.digest, in_memory=False)

    def free_readers(self, task: Task) -> None:
        if task.id in self.done:
            return
        self.done.add(task.id)
        for reader in sorted(self.plan.dag.successors(task.id), key=self.order.__getitem__):
            self.waiting[reader] -= 1
            if self.waiting[reader] == 0:
                heapq.heappush(self.ready, (self.order[reader], reader))

    def free_followers(self, key: str) -> None:
        for follower in self.in_flight.pop(key, ()):
            heapq.heappush(self.ready, (self.order[follower], follower))

    def free_blocked(self, name: str) -> None:
        self.forced.discard(name)
        for task, missing in list(self.blocked.items()):
            missing.discard(name)
            if not missing:
                del self.blocked[task]
                heapq.heappush(self.ready, (self.order[task], task))

    def rerun_producers(self, task: Task, slots: tuple[Slot, ...]) -> None:
        """Let the tasks run again whose stored outputs are gone or damaged, then this one."""
        self.free_followers(self.finished.reports.pop(task.id).key)
        producers = {slot.task for slot in slots}
        self.blocked[task.id] = set(producers)
        self.force(slots)

    def force(self, slots: tuple[Slot, ...]) -> None:
        """Let the tasks that make some values run, whatever the cache says."""
        for name in sorted({slot.task for slot in slots}, key=self.order.__getitem__):
            if name not in self.forced:
                self.forced.add(name)
                heapq.heappush(self.ready, (self.order[name], name))

    def broken_input(self, task: Task) -> str:
        """Return the failed task that this one cannot do without, or nothing; gaps fill lists that take them."""
        for name, source in (*task.inputs.items(), *task.measured.items()):
            socket = task.node.inputs.get(name)
            for slot in source if isinstance(source, tuple) else (source,):
                held = self.finished.held.get(slot)
                if isinstance(held, Gap) and not (
                    socket is not None and socket.type.gaps and isinstance(source, tuple)
                ):
                    return slot.task
        return ""

    def fail(self, task: Task, report: Report, error: NodeFailed) -> None:
        report.status, report.message = "failed", str(error).removeprefix(f"{task.id}: ")
        self.emit(events.Failed(task.id, report.message))
        if not task.keep_going:
            self.finished.failure = self.finished.failure or error
            return
        self.leave_gap(task, report)

    def skip(self, task: Task, cause: str) -> None:
        report = Report(task, "skipped", message=f"needs {cause}, which failed")
        self.emit(events.Skipped(task.id, cause))
        self.leave_gap(task, report)

    def leave_gap(self, task: Task, report: Report) -> None:
        self.finished.reports[task.id] = report
        label = task.id.partition("/")[0]
        for socket in task.node.outputs:
            self.finished.held[Slot(task.id, socket)] = Gap(label, report.message)
        self.release(task)
        self.free_followers(report.key)
        self.free_blocked(task.id)
        self.free_readers(task)
