"""Executors: what the scheduler asks of one is enough for workers in other processes."""

import multiprocessing
import pickle
import queue
import threading
from concurrent.futures import Future, ProcessPoolExecutor

import numpy as np
import pytest

from graphtex import Cancelled, Gap, GraphError, NodeFailed, Problem, events, run
from graphtex.bind import bind
from graphtex.cache import Cache, EntryLost
from graphtex.executors import SerialExecutor, ThreadsExecutor, make_executor
from graphtex.graph import loads
from graphtex.keys import given_values
from graphtex.plan import Slot
from graphtex.work import Call, Held, InputLost, Monitor, Outcome, execute
from tests.graphtex import tiny
from tests.graphtex.tiny import picture

pytestmark = pytest.mark.usefixtures("tiny_nodes")

_messages = None
_stop = None


def _begin(messages, stop) -> None:
    global _messages, _stop
    _messages, _stop = messages, stop


def _work(call: Call, cache: Cache | None) -> Outcome:
    monitor = Monitor(
        lambda *told: _messages.put(("progress", *told)), lambda *told: _messages.put(("warning", *told)), _stop.is_set
    )
    return execute(call, monitor, cache).stripped()


class Processes:
    """Two workers in processes of their own: values go by the store, messages by a queue."""

    workers = 2

    def submit(self, call: Call, monitor: Monitor, cache: Cache | None) -> "Future[Outcome]":
        self.monitor = monitor
        return self.pool.submit(_work, call.stripped(), cache)

    def listen(self) -> None:
        while not self.over.is_set() or not self.messages.empty():
            if self.monitor is not None and self.monitor.cancelled():
                self.stop.set()
            try:
                kind, *told = self.messages.get(timeout=0.02)
            except queue.Empty:
                continue
            (self.monitor.on_progress if kind == "progress" else self.monitor.on_warning)(*told)

    def __enter__(self):
        spawn = multiprocessing.get_context("spawn")
        self.monitor, self.over = None, threading.Event()
        self.messages, self.stop = spawn.Queue(), spawn.Event()
        self.pool = ProcessPoolExecutor(self.workers, spawn, _begin, (self.messages, self.stop))
        self.listener = threading.Thread(target=self.listen)
        self.listener.start()
        return self

    def __exit__(self, *_):
        self.pool.shutdown()
        self.over.set()
        self.listener.join()
        self.messages.close()
        self.messages.join_thread()


@pytest.fixture(scope="module")
def processes():
    with Processes() as executor:
        yield executor


GRAPH = """graphtex: 1
inputs: {p: {type: Image}}
nodes:
  g: {node: Grain}
  h: {node: Halves, image: g}
  s: {node: Scatter}
  n: {node: Count, elements: s}
  m: {node: Add, image: h.low, amount: {from: n}}
  w: {node: Warns, image: $p}
  c: {node: Fragile, each: {value: [0, 1, 2]}, bad: 1, on_error: keep}
  v: {node: Survey, cells: c}
outputs: {m: m, w: w, v: v, s: s}
"""


@pytest.mark.parametrize("cached", [True, False])
def test_a_run_in_other_processes_gives_the_same_bytes(processes, tmp_path, cached):
    g, given = loads(GRAPH), {"p": picture(1, 2)}
    expected = run(g, given, cache=False)
    here, told = list(tiny.CALLS), []
    result = run(g, given, cache=tmp_path if cached else False, executor=processes, emit=told.append)
    assert here == tiny.CALLS  # nothing ran in this process
    for name in "mwv":
        assert result[name].tobytes() == expected[name].tobytes()
        assert not result[name].flags.writeable
    assert not result["s"].scales.flags.writeable
    assert result["s"].scales.tolist() == expected["s"].scales.tolist()
    assert {task: report.status for task, report in result.reports.items()} == {
        task: report.status for task, report in expected.reports.items()}  # fmt: skip
    assert result.finished.held[Slot("c[1]", "result")] == Gap("c[1]", "value: 1 is bad")
    assert events.Warned("w", "it is odd") in told
    assert events.Progress("w", 0.5, "half") in told
    if cached:
        again = run(g, given, cache=tmp_path)
        assert {report.status for name, report in again.reports.items() if name != "c[1]"} == {"cached"}


def test_what_a_worker_does_not_find_in_the_store_is_made_again(processes, tmp_path):
    g = loads(
        "graphtex: 1\nnodes: {a: {node: Const, value: 3}, b: {node: Add, image: a}, c: {node: Whole, image: b}}\noutputs: {c: c}\n"
    )
    run(g, only=["c"], cache=tmp_path)
    for path in tmp_path.glob("objects/??/*"):
        if np.load(path)[0, 0, 0] == 4:
            path.write_bytes(b"")
    for path in tmp_path.glob("index/??/*"):  # so that c runs and does not find b
        if b'"Whole"' in path.read_bytes():
            path.unlink()
    result = run(g, cache=tmp_path, executor=processes)
    assert result["c"][0, 0, 0] == 4
    assert result.reports["b"].why == "its stored result was lost"


def test_a_failure_in_another_process_is_told_as_here(processes, tmp_path):
    g = loads(
        "graphtex: 1\nnodes: {a: {node: Const}, b: {node: Fragile, image: a, value: 1, bad: 1}}\noutputs: {b: b, a: a}\n"
    )
    with pytest.raises(NodeFailed) as caught:
        run(g, cache=tmp_path, executor=processes)
    assert str(caught.value) == "b: value: 1 is bad [inputs: image float32 (1, 2, 1)]"
    assert caught.value.result["a"].shape == (1, 2, 1)


def test_a_run_in_other_processes_is_cancelled(tmp_path):
    g = loads("graphtex: 1\nnodes: {a: {node: Wait}}\noutputs: {a: a}\n")
    cancel = threading.Event()

    def emit(event: events.Event) -> None:
        if isinstance(event, events.Started):
            threading.Timer(0.1, cancel.set).start()

    with Processes() as executor, pytest.raises(Cancelled):
        run(g, cache=tmp_path, executor=executor, emit=emit, cancel=cancel)


class Broken(SerialExecutor):
    """An executor that has lost its workers."""

    def submit(self, call, monitor, cache):
        raise RuntimeError("the pool is gone")


class Odd(SerialExecutor):
    """An executor whose calls end by something that is no failure of a node."""

    def __init__(self, error):
        self.error = error

    def submit(self, call, monitor, cache):
        future = Future()
        future.set_exception(self.error)
        return future


@pytest.mark.parametrize(
    ("executor", "told"),
    [
        (Broken(), "a: RuntimeError: the pool is gone"),
        (Odd(MemoryError("no room")), "a: MemoryError: no room"),
        (Odd(Cancelled("by itself")), "a: Cancelled: by itself"),
    ],
)
def test_what_goes_wrong_with_an_executor_is_told_of_the_task(executor, told):
    with pytest.raises(NodeFailed) as caught:
        run(loads("graphtex: 1\nnodes: {a: {node: Const}}\noutputs: {a: a}\n"), cache=False, executor=executor)
    assert str(caught.value) == told


def same(value):
    return pickle.loads(pickle.dumps(value))


def test_what_travels_can_be_pickled(tmp_path):
    plan = bind(loads(GRAPH), {"p": picture(1, 2)})
    held = given_values(plan, digests=True)
    call = Call(plan.tasks["w"], {"image": held[Slot("$p", "value")]}, 2)
    again = same(call)
    assert again.task == call.task
    assert again.task.node is tiny.warns
    assert again.inputs["image"].type == call.inputs["image"].type
    outcome = execute(again, Monitor(print, lambda *told: None, lambda: False), Cache(tmp_path))
    assert same(outcome).outputs["result"].value.tolist() == outcome.outputs["result"].value.tolist()
    assert same(outcome).warnings == ("it is odd",)


def test_errors_travel_whole():
    failed = same(NodeFailed("a", "it broke"))
    assert (str(failed), failed.task, failed.message, failed.result) == ("a: it broke", "a", "it broke", None)
    assert same(InputLost((Slot("a", "b"),))).slots == (Slot("a", "b"),)
    problem = Problem("f", 1, 2, "p", "m")
    assert same(GraphError([problem])).problems == (problem,)
    assert isinstance(same(Cancelled("x")), Cancelled)


def test_only_what_the_store_holds_is_left_out(tmp_path):
    kind = tiny.const.outputs["result"].type
    stored, other, gap = Held(kind, 1, "d", stored=True), Held(kind, 2, "e"), Gap("a", "b")
    call = Call(bind(loads(GRAPH), {"p": picture(1)}).tasks["v"], {"cells": (stored, other, gap), "x": stored})
    assert call.stripped().inputs == {
        "cells": (Held(kind, None, "d", in_memory=False, stored=True), other, gap), "x": stored.dropped()}  # fmt: skip
    assert Outcome({"a": stored, "b": other}, 1.0, ()).stripped().outputs == {"a": stored.dropped(), "b": other}
    with pytest.raises(EntryLost):
        stored.dropped().load(Cache(tmp_path))


def test_a_worker_tells_all_inputs_that_are_lost(tmp_path):
    task = bind(loads(GRAPH), {"p": picture(1)}).tasks["m"]
    gone = {name: Held(task.node.inputs["image"].type, None, "0" * 64, in_memory=False) for name in ("image", "amount")}
    with pytest.raises(InputLost) as caught:
        execute(Call(task, gone), Monitor(print, print, lambda: False), Cache(tmp_path))
    assert caught.value.slots == (Slot("h", "low"), Slot("n", "result"))


def test_the_serial_executor_is_done_at_once_and_lets_interrupts_through():
    plan = bind(loads("graphtex: 1\nnodes: {a: {node: Const, value: 2}}\noutputs: {a: a}\n"))
    with SerialExecutor() as executor:
        future = executor.submit(Call(plan.tasks["a"], {}), Monitor(print, print, lambda: False), None)
        assert future.done()
        assert future.result().outputs["result"].value[0, 0, 0] == 2


def test_executors_by_name():
    assert isinstance(make_executor(), SerialExecutor)
    with make_executor("threads", 3) as executor:
        assert isinstance(executor, ThreadsExecutor)
        assert executor.workers == 3
    for name, workers in (("thread", None), ("threads", 0), ("serial", 2)):
        with pytest.raises(GraphError):
            make_executor(name, workers)
