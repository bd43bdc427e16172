"""Runs a plan: an in-degree ready queue over an executor, with the cache in front of it and events behind it."""

import heapq
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, wait

from graphtex import events
from graphtex.cache import Cache, CacheUnavailable, KeyParts, Output
from graphtex.context import usable_cores
from graphtex.errors import Cancelled, NodeFailed
from graphtex.executors import Executor
from graphtex.holding import Holding
from graphtex.keys import Keys, found_outputs
from graphtex.plan import Plan, Slot, Task
from graphtex.reports import Finished, Report
from graphtex.sockets import Gap
from graphtex.work import Call, Held, InputLost, Monitor, Outcome

Emit = Callable[[events.Event], None]
Explain = Callable[[Task, KeyParts | None], str]


def schedule(
    plan: Plan,
    executor: Executor,
    *,
    cache: Cache | None = None,
    emit: Emit = lambda event: None,
    cancel: threading.Event | None = None,
    explain: Explain = lambda task, parts: "",
    keep_all: bool = False,
) -> Finished:
    """Run all tasks of a plan.

    Parameters
    ----------
    explain
        Says why a task that is not cached must run.
    keep_all
        Keep every value, not only those of the outputs; for reports of runs without a cache.

    Returns
    -------
    What became of it. A node that raised is `Finished.failure`: what had finished before stays.

    Raises
    ------
    Cancelled
        If `cancel` was set; what has finished is in the cache.
    """
    holding = Holding(plan, cache, keep_all=keep_all)
    run = _Run(plan, executor, cache, emit, cancel or threading.Event(), explain, holding)
    try:
        run.go()
    except BaseException:
        run.aborted = True  # calls that are still running stop at their next chance
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
        explain: Explain,
        holding: Holding,
    ) -> None:
        self.plan, self.executor, self.cache, self.cancel, self.explain = plan, executor, cache, cancel, explain
        self.holding = holding
        self.finished = Finished(held=holding.held)
        self.aborted = False
        self._emit, self._emit_lock = emit, threading.Lock()
        self.keys = Keys(lambda text: self.warn("", text), cache)
        self.order = {task: index for index, task in enumerate(plan.tasks)}
        self.waiting = {task: plan.dag.in_degree(task) for task in plan.tasks}
        self.ready: list[tuple[int, str]] = []  # heap of tasks whose inputs are there, by their place in the plan
        self.push(task for task, count in self.waiting.items() if count == 0)
        self.running: dict[Future[Outcome], str] = {}
        self.begun: dict[str, float] = {}  # when each running task was handed out
        self.lent: dict[str, dict[Slot, Held | Gap]] = {}  # what each running task was given
        self.in_flight: dict[str, list[str]] = {}  # key -> tasks that wait for the one that is making it
        self.blocked: dict[str, set[str]] = {}  # task -> tasks that it waits for as their stored outputs were lost
        self.forced: set[str] = set()  # tasks that must run though the digests of their outputs are known
        self.done: set[str] = set()
        self.causes: dict[str, str] = {}  # skipped task -> the failed one that it would need
        self.monitor = Monitor(
            lambda task, share, text: self.emit(events.Progress(task, share, text)), self.warn, lambda: self.stopping
        )
        self.threads = max(1, usable_cores() // executor.workers)

    @property
    def stopping(self) -> bool:
        """Whether nothing more is to be started, and what runs is to stop."""
        return self.aborted or self.cancel.is_set() or self.finished.failure is not None

    def emit(self, event: events.Event) -> None:
        """Pass an event on, one at a time, from whichever thread."""
        with self._emit_lock:
            self._emit(event)

    def warn(self, task: str, text: str) -> None:
        """Pass a warning on."""
        self.emit(events.Warned(task, text))

    def push(self, tasks: Iterable[str]) -> None:
        """Add tasks to those that can start."""
        for task in tasks:
            heapq.heappush(self.ready, (self.order[task], task))

    def go(self) -> None:
        """Run everything, and again what the store had lost when the outputs were read."""
        for task in self.plan.tasks.values():
            self.emit(events.Planned(task.id, task.node.name))
        self.loop()
        while not self.stopping and (lost := self.holding.load_outputs()):
            self.force(lost)
            self.loop()

    def loop(self) -> None:
        while self.running or (self.ready and not self.stopping):
            while self.ready and len(self.running) < self.executor.workers and not self.stopping:
                self.start(self.plan.tasks[heapq.heappop(self.ready)[1]])
            over = [future for future in self.running if future.done()]
            if self.running and not over:  # now and then somebody may have asked to stop
                over = list(wait(self.running, timeout=0.1, return_when=FIRST_COMPLETED).done)
            while over:  # nothing here keeps a future, and with it values, any longer
                self.collect(self.running.pop(over[-1]), over.pop())
        if self.cancel.is_set() and self.finished.failure is None:
            self.emit(events.Stopped(""))
            raise Cancelled("the run was cancelled; what had finished is kept")

    def start(self, task: Task) -> None:
        """Find a task's outputs in the cache, or hand it to the executor."""
        broken = self.holding.broken_input(task)
        if broken:
            broken = self.causes.setdefault(task.id, self.causes.get(broken, broken))
            self.emit(events.Skipped(task.id, broken))
            self.leave_gap(task, Report(task, "skipped", message=f"needs {broken}, which failed"))
            return
        parts, key = None, ""
        if self.cache is not None:
            parts = self.keys.parts(task, self.holding.held)
            if parts is not None:
                key = parts.key()
                self.finished.parts[task.id] = parts
        if key and task.id not in self.forced:
            if key in self.in_flight:
                self.in_flight[key].append(task.id)
                return
            if self.find(task, key):
                return
        self.submit(task, key, parts)

    def find(self, task: Task, key: str) -> bool:
        """Take a task's outputs from the cache; False if they are not there."""
        assert self.cache is not None  # there is a key
        begun = time.perf_counter()
        found = found_outputs(task, key, self.cache)
        if found is None:
            return False
        outputs, warnings = found
        for text in warnings:
            self.emit(events.Warned(task.id, text))
        report = Report(task, "cached", time.perf_counter() - begun, key, warnings=warnings)
        self.emit(events.Cached(task.id, report.seconds))
        self.complete(task, outputs, report)
        return True

    def submit(self, task: Task, key: str, parts: KeyParts | None) -> None:
        why = "its stored result was lost" if task.id in self.forced else self.explain(task, parts)
        self.finished.reports[task.id] = Report(task, "ran", key=key, why=why)
        if key:
            self.in_flight.setdefault(key, [])
        self.emit(events.Started(task.id, why))
        self.begun[task.id] = time.perf_counter()
        try:
            future = self.executor.submit(Call(task, self.holding.inputs(task), self.threads), self.monitor, self.cache)
        except Exception as error:  # noqa: BLE001 (a broken pool, an unpicklable value: told as the task's failure)
            future = Future()
            future.set_exception(error)
        self.running[future] = task.id
        self.lent[task.id] = {slot: self.finished.held[slot] for slot in task.slots}

    def collect(self, name: str, future: "Future[Outcome]") -> None:
        """Take what came of a call."""
        task, report, lent = self.plan.tasks[name], self.finished.reports[name], self.lent.pop(name)
        elapsed = time.perf_counter() - self.begun.pop(name)
        error = future.exception()
        if isinstance(error, InputLost):
            self.rerun_producers(task, error.slots, lent)
        elif isinstance(error, Cancelled) and self.stopping:
            self.finished.reports.pop(name)
            self.emit(events.Stopped(name))
        elif isinstance(error, NodeFailed):
            self.fail(task, report, error, elapsed)
        elif isinstance(error, Exception):
            failure = NodeFailed(name, f"{type(error).__name__}: {error}")
            failure.__cause__ = error
            self.fail(task, report, failure, elapsed)
        elif error is not None:  # KeyboardInterrupt in a thread, for instance
            raise error
        else:
            outcome = future.result()
            report.seconds, report.warnings = outcome.seconds, outcome.warnings
            self.record(task, report, outcome)
            self.emit(events.Finished(name, outcome.seconds))
            self.complete(task, outcome.outputs, report)

    def record(self, task: Task, report: Report, outcome: Outcome) -> None:
        """Let the cache remember what came of a task."""
        if self.cache is None or not report.key or not all(held.stored for held in outcome.outputs.values()):
            return
        if not self.keys.still_hold(task):
            self.warn(task.id, "a file that it reads changed during the run; its result is not kept for later runs")
            return
        outputs = {socket: Output(str(held.type), held.digest) for socket, held in outcome.outputs.items()}
        try:
            self.cache.record(report.key, task.node.name, outputs, outcome.seconds, outcome.warnings)
        except CacheUnavailable as error:
            self.warn("", str(error))

    def complete(self, task: Task, outputs: Mapping[str, Held | Gap], report: Report) -> None:
        """Hold a task's outputs and free those that wait for them."""
        self.finished.reports[task.id] = report
        self.holding.keep(task, outputs)
        self.push(self.in_flight.pop(report.key, ()))
        self.free_blocked(task.id)
        if task.id not in self.done:  # it is when it had to run again
            self.done.add(task.id)
            self.holding.release(task)
            for reader in self.plan.dag.successors(task.id):
                self.waiting[reader] -= 1
                if self.waiting[reader] == 0:
                    self.push([reader])

    def free_blocked(self, name: str) -> None:
        self.forced.discard(name)
        for task, missing in list(self.blocked.items()):
            missing.discard(name)
            if not missing:
                del self.blocked[task]
                self.push([task])

    def rerun_producers(self, task: Task, slots: tuple[Slot, ...], lent: Mapping[Slot, Held | Gap]) -> None:
        """Let the tasks run again whose stored outputs are gone or damaged, then this one.

        What was made again since the task was started, because another task had lost it too, is only read again.
        """
        self.push(self.in_flight.pop(self.finished.reports.pop(task.id).key, ()))
        lost = tuple(slot for slot in slots if self.finished.held[slot] is lent[slot])
        if not lost:
            self.push([task.id])
            return
        self.blocked[task.id] = {slot.task for slot in lost}
        self.force(lost)

    def force(self, slots: tuple[Slot, ...]) -> None:
        """Let the tasks that make some values run, whatever the cache says."""
        for name in dict.fromkeys(slot.task for slot in slots):
            if name not in self.forced:
                self.forced.add(name)
                self.push([name])

    def fail(self, task: Task, report: Report, error: NodeFailed, elapsed: float) -> None:
        report.status, report.message, report.seconds = "failed", error.message, elapsed
        self.emit(events.Failed(task.id, report.message))
        if task.cell:
            self.leave_gap(task, report)
        else:
            self.finished.failure = self.finished.failure or error

    def leave_gap(self, task: Task, report: Report) -> None:
        """Put gaps in place of a task's outputs and go on."""
        gap = Gap(task.cell or task.id, report.message)
        self.complete(task, dict.fromkeys(task.node.outputs, gap), report)
