"""The scheduler: order, workers, tasks that wait for each other, and values that were lost."""

import threading
from concurrent.futures import Future

import pytest

from graphtex import Gap, NodeFailed, events, run
from graphtex.bind import bind
from graphtex.cache import Cache
from graphtex.executors import SerialExecutor, ThreadsExecutor
from graphtex.graph import loads
from graphtex.plan import Slot
from graphtex.schedule import schedule
from graphtex.work import Call, InputLost, Monitor, Outcome, execute
from tests.graphtex import tiny
from tests.graphtex.tiny import CALLS

pytestmark = pytest.mark.usefixtures("tiny_nodes")


def plan_of(nodes: str, outputs: str = "out: a"):
    return bind(loads(f"graphtex: 1\nnodes:\n{nodes}\noutputs: {{{outputs}}}\n"))


class Recording(SerialExecutor):
    """Keeps calls until enough of them, or the last, have come; then ends the latest first."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self.most = 0
        self.order: list[str] = []
        self.open: list[tuple[Call, Monitor, Cache | None, Future[Outcome]]] = []

    def submit(self, call, monitor, cache):
        future: Future[Outcome] = Future()
        self.open.append((call, monitor, cache, future))
        self.order.append(call.task.id)
        self.most = max(self.most, len(self.open))
        threading.Timer(0.01, self.end).start()
        return future

    def end(self) -> None:
        call, monitor, cache, future = self.open.pop()
        future.set_result(execute(call, monitor, cache))


FAN = ("  one: {node: Const}\n  c1: {node: Add, image: one, amount: 1}\n  c2: {node: Add, image: one, amount: 2}\n"
       "  c3: {node: Add, image: one, amount: 3}\n  a: {node: Total, images: [c1, c2, c3]}")  # fmt: skip


@pytest.mark.parametrize(("workers", "most"), [(1, 1), (2, 2), (8, 3)])
def test_as_many_calls_at_once_as_there_are_workers(workers, most):
    executor = Recording(workers)
    finished = schedule(plan_of(FAN), executor)
    assert executor.most == most
    assert executor.order[0] == "one"
    assert executor.order[-1] == "a"
    assert finished.held[Slot("a", "result")].value[0, 0, 0] == 6


def test_what_is_ready_starts_in_the_order_of_the_plan():
    executor = Recording(1)
    schedule(plan_of("  z: {node: Const}\n  y: {node: Const}\n  x: {node: Add, image: y}\n  w: {node: Add, image: z}\n"
                     "  a: {node: Total, images: [x, w]}"), executor)  # fmt: skip
    assert executor.order == ["z", "y", "x", "w", "a"]


def test_kernel_threads_share_the_cores_with_the_workers(monkeypatch):
    monkeypatch.setattr("graphtex.schedule.usable_cores", lambda: 8)
    seen = []

    class Looking(SerialExecutor):
        workers = 3

        def submit(self, call, monitor, cache):
            seen.append(call.threads)
            return super().submit(call, monitor, cache)

    schedule(plan_of("  a: {node: Const}"), Looking())
    assert seen == [2]


def test_a_task_that_waits_for_one_of_the_same_key_runs_itself_if_that_fails(tmp_path):
    nodes = ("  c: {node: Fragile, each: {value: [1, 1]}, bad: 1, on_error: keep}\n  a: {node: Survey, cells: c}")  # fmt: skip
    with ThreadsExecutor(2) as executor:
        finished = schedule(plan_of(nodes), executor, cache=Cache(tmp_path))
    assert {task: report.status for task, report in finished.reports.items()} == {
        "c[0]": "failed",
        "c[1]": "failed",
        "a": "ran",
    }
    assert finished.held[Slot("c[1]", "result")] == Gap("c[1]", "value: 1 is bad")
    assert CALLS.count("fragile 1") == 2


class Forgetful(SerialExecutor):
    """Reports the inputs of some tasks as lost, so many times."""

    def __init__(self, **times: int) -> None:
        self.times = times
        self.order: list[str] = []

    def submit(self, call, monitor, cache):
        self.order.append(call.task.id)
        if self.times.get(call.task.id, 0) > 0:
            self.times[call.task.id] -= 1
            future: Future[Outcome] = Future()
            future.set_exception(InputLost(call.task.slots))
            return future
        return super().submit(call, monitor, cache)


def test_lost_inputs_are_made_again_as_often_as_need_be(tmp_path):
    executor = Forgetful(a=2, c2=1)
    finished = schedule(plan_of(FAN), executor, cache=Cache(tmp_path))
    assert {report.status for report in finished.reports.values()} == {"ran"}
    assert finished.held[Slot("a", "result")].value[0, 0, 0] == 6
    assert executor.order == ["one", "c1", "c2", "one", "c2", "c3", "a", "c1", "c2", "c3", "a", "c1", "c2", "c3", "a"]


def test_a_failure_while_something_lost_is_made_again_ends_the_run(tmp_path):
    class Worse(Forgetful):
        def submit(self, call, monitor, cache):
            if self.order.count("one") == 1 and call.task.id == "one":
                self.order.append("one")
                future: Future[Outcome] = Future()
                future.set_exception(NodeFailed("one", "no more"))
                return future
            return super().submit(call, monitor, cache)

    finished = schedule(plan_of(FAN), Worse(c1=1), cache=Cache(tmp_path))
    assert str(finished.failure) == "one: no more"


def test_a_failure_stops_what_runs_beside_it():
    nodes = "  w: {node: Wait}\n  f: {node: Fragile, image: one, value: 1, bad: 1}\n  one: {node: Const}\n"
    told = []
    with ThreadsExecutor(2) as executor:
        finished = schedule(plan_of(nodes, "w: w, f: f"), executor, emit=told.append)
    assert finished.failure is not None
    assert events.Stopped("w") in told
    assert "w" not in finished.reports


def test_events_come_one_at_a_time_from_whichever_thread():
    inside = threading.Lock()

    def emit(event: events.Event) -> None:
        assert inside.acquire(blocking=False)
        threading.Event().wait(0.002)
        inside.release()

    nodes = "  one: {node: Const}\n" + "".join(f"  w{i}: {{node: Warns, image: one}}\n" for i in range(6))
    outputs = ", ".join(f"w{i}: w{i}" for i in range(6))
    with ThreadsExecutor(3) as executor:
        schedule(plan_of(nodes, outputs), executor, emit=emit)
    assert CALLS.count("warns") == 6


def test_what_the_run_itself_has_to_say_is_said_once():
    told = []
    tell = events.told_once(told.append)
    for event in (
        events.Warned("", "x"),
        events.Warned("a", "x"),
        events.Warned("", "x"),
        events.Warned("a", "x"),
        events.Warned("", "y"),
    ):
        tell(event)
    assert [(event.task, event.text) for event in told] == [("", "x"), ("a", "x"), ("a", "x"), ("", "y")]


def test_a_long_chain_needs_no_recursion():
    nodes = "  n0: {node: Const}\n" + "".join(f"  n{i}: {{node: Add, image: n{i - 1}}}\n" for i in range(1, 1200))
    g = loads(f"graphtex: 1\nnodes:\n{nodes}outputs: {{out: n1199}}\n")
    assert run(g, cache=False)["out"][0, 0, 0] == 1199
    assert tiny.CALLS[-1] == "add 1"
