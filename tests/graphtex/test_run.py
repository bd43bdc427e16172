"""Runs: what comes out, what is not run again, what happens when nodes fail or the store is damaged."""

import threading
from pathlib import Path

import numpy as np
import pytest

from graphtex import Cancelled, Gap, Graph, GraphError, NodeFailed, events, run
from graphtex.cache import Cache, CacheUnavailable, EntryLost
from graphtex.executors import ThreadsExecutor
from graphtex.graph import loads
from tests.graphtex import (
    pack,  # noqa: F401 (registers what opens `made:`)
    tiny,
)
from tests.graphtex.tiny import CALLS, picture

pytestmark = pytest.mark.usefixtures("tiny_nodes")


def graph(nodes: str, inputs: str = "", outputs: str = "out: a", seed: int = 0) -> Graph:
    head = f"seed: {seed}\n" + (f"inputs:\n{inputs}\n" if inputs else "")
    return loads(f"graphtex: 1\n{head}nodes:\n{nodes}\noutputs: {{{outputs}}}\n")


def values(result, name: str = "out") -> list[float]:
    return result[name][0, :, 0].tolist()


def ran(result) -> list[str]:
    return [task for task, report in result.reports.items() if report.status == "ran"]


def calls() -> list[str]:
    """Return what has been called since this was last asked."""
    made = list(CALLS)
    CALLS.clear()
    return made


# --- values


def test_values_flow():
    g = graph(
        "  one: {node: Const, value: 3}\n  h: {node: Halves, image: one}\n  m: {node: Average, image: h.low}\n"
        "  a: {node: Add, image: $p, amount: {from: m}}",
        "  p: {type: Image}",
        "out: a, h: h.high, m: m, p: $p",
    )
    given = picture(1, 2)
    result = run(g, {"p": given}, cache=False)
    assert values(result) == [2.5, 3.5]
    assert result["m"] == 1.5
    assert list(result) == ["out", "h", "m", "p"]
    assert len(result) == 4
    assert not result["out"].flags.writeable
    assert not result["p"].flags.writeable
    assert given.flags.writeable
    assert not result.failed
    with pytest.raises(KeyError, match=r"no output 'uot'; did you mean 'out'\?"):
        result["uot"]


def test_composites_lists_and_optional_sockets_flow(tmp_path):
    g = graph(
        "  s: {node: Scatter, count: 4}\n  n: {node: Count, elements: s}\n  c: {node: Const, each: {value: [1, 2]}}\n"
        "  a: {node: Total, images: c}\n  f: {node: Fragile, value: 1}",
        outputs="n: n, s: s, c: c, out: a, f: f",
    )
    for _ in range(2):  # computed, then from the store
        result = run(g, cache=tmp_path)
        assert result["n"] == 4
        assert result["s"].scales.tolist() == [1, 2, 3, 4]
        assert [cell[0, 0, 0] for cell in result["c"]] == [1, 2]
        assert values(result) == [3, 3]


def test_a_result_is_shown_by_the_names_of_its_outputs():
    g = Graph(title="Copy")
    g.output("out", g.add(tiny.add, image=g.input("p", "Image")))
    assert repr(g) == "<Graph 'Copy'; inputs: p, nodes: add, outputs: out>"
    assert repr(run(g, {"p": picture(1)}, cache=False)) == "<RunResult: out>"


def test_only_runs_what_some_outputs_need():
    g = graph("  a: {node: Const}\n  b: {node: Add, image: a}\n  c: {node: Whole, image: a}", outputs="b: b, c: c")
    assert list(run(g, only=["c"], cache=False)) == ["c"]
    assert calls() == ["const 0", "whole"]
    assert list(run(g, only="b", cache=False)) == ["b"]
    with pytest.raises(GraphError, match="only: no output 'd'"):
        run(g, only=["d"], cache=False)


def test_a_graph_without_outputs_has_nothing_to_run_for():
    g = Graph()
    g.add(tiny.const)
    with pytest.raises(GraphError, match="the graph has no outputs"):
        run(g, cache=False)


def test_a_graph_runs_with_the_default_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("GRAPHTEX_CACHE_DIR", str(tmp_path))
    g = graph("  a: {node: Const, value: $by}", "  by: {type: float}")
    assert values(g.run(by=2)) == [2, 2]
    assert (tmp_path / "results" / "objects").is_dir()


# --- random streams


RANDOM = ("  a: {node: Grain}\n  b: {node: Grain}\n  o: {node: Grain, seed: 5}\n  p: {node: Grain, seed: 5}\n"
          "  v: {node: Grain, each: {seed: [1, 2, 1]}}\n  c: {node: Grain, each: {size: [2, 3]}}\n  w: {node: Add, image: b}")  # fmt: skip
OUTPUTS = "a: a, b: b, o: o, p: p, v: v, c: c, w: w"


def test_streams_depend_on_seed_and_id_alone():
    one = run(graph(RANDOM, outputs=OUTPUTS), cache=False)
    assert values(one, "a") != values(one, "b")
    assert (
        values(one, "o")
        == values(one, "p")
        == np.random.default_rng(np.random.SeedSequence(5)).random(2, np.float32).tolist()
    )
    assert values(run(graph(RANDOM, outputs=OUTPUTS, seed=1), cache=False), "o") == values(one, "o")
    assert values(run(graph(RANDOM, outputs=OUTPUTS, seed=1), cache=False), "a") != values(one, "a")
    assert values(run(graph(RANDOM, outputs=OUTPUTS), cache=False, seed=1), "a") != values(one, "a")
    first, second, third = (cell[0, :, 0].tolist() for cell in one["v"])
    assert first == third != second
    small, large = (cell[0, :, 0].tolist() for cell in one["c"])
    assert large[:2] == small  # cells share their stream
    more = graph("  new: {node: Grain}\n" + RANDOM, outputs=OUTPUTS + ", new: new")
    assert all(values(run(more, cache=False), name) == values(one, name) for name in "ab")


@pytest.mark.parametrize("executor", ["serial", 1, 2])
@pytest.mark.parametrize("cached", [False, True])
def test_the_same_bytes_on_any_executor_with_and_without_a_cache(executor, cached, tmp_path):
    g = graph(RANDOM, outputs=OUTPUTS)
    expected = run(g, cache=False)
    how = {"executor": "serial"} if executor == "serial" else {"executor": "threads", "workers": executor}
    for _ in range(2):
        result = run(g, cache=tmp_path if cached else False, **how)
        for name in result:
            assert [item.tobytes() for item in result[name]] == [item.tobytes() for item in expected[name]]


# --- not running again


CHAIN = ("  one: {node: Const, value: $x}\n  low: {node: Whole, image: one}\n  up: {node: Add, image: low, amount: $y}\n"
         "  far: {node: Grain}\n  a: {node: Both, image: up, mask: far}")  # fmt: skip
XY = "  x: {type: float, default: 1}\n  y: {type: float, default: 2}"


@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
def test_a_second_run_does_no_node_s_work(tmp_path, how):
    g = graph(CHAIN, XY)
    first = run(g, cache=tmp_path, **how)
    assert sorted(calls()) == ["add 2", "both", "const 1", "grain", "whole"]
    second = run(g, cache=tmp_path, **how)
    assert calls() == []
    assert second["out"].tobytes() == first["out"].tobytes()
    assert {report.status for report in second.reports.values()} == {"cached"}


def test_a_changed_parameter_reruns_what_depends_on_it(tmp_path):
    g = graph(CHAIN, XY)
    run(g, cache=tmp_path)
    calls()
    result = run(g, {"y": 3}, cache=tmp_path)
    assert calls() == ["add 3", "both"]
    assert result.reports["up"].why == "parameter amount: 2.0 -> 3.0"
    assert run(g, {"y": 2}, cache=tmp_path).reports["up"].status == "cached"
    assert run(g, cache=tmp_path, seed=1).reports["far"].why.startswith("random stream (seed): ")
    assert calls() == ["grain", "both"]


def test_an_output_that_comes_out_equal_cuts_off_what_follows(tmp_path):
    g = graph(CHAIN, XY)
    run(g, cache=tmp_path)
    calls()
    assert ran(run(g, {"x": 1.5}, cache=tmp_path)) == ["one", "low"]
    assert calls() == ["const 1.5", "whole"]


def test_equal_values_that_are_reached_by_another_way_are_hits(tmp_path):
    run(graph("  one: {node: Const, value: 3}\n  a: {node: Add, image: one}"), cache=tmp_path)
    calls()
    result = run(graph("  a: {node: Add, image: $p}", "  p: {type: Image}"), {"p": picture(3, 3)}, cache=tmp_path)
    assert (calls(), values(result)) == ([], [4, 4])


def test_an_edited_file_under_the_same_name_is_seen(tmp_path):
    file = tmp_path / "n.txt"
    file.write_text("1 2")
    g = graph(f"  a: {{node: Read, path: {file}}}")
    run(g, cache=tmp_path / "cache")
    file.write_text("1 3")
    assert values(run(g, cache=tmp_path / "cache")) == [1, 3]
    assert calls() == ["read n.txt", "read n.txt"]
    file.write_text("1 2")
    assert values(run(g, cache=tmp_path / "cache")) == [1, 2]
    assert calls() == []


def test_a_file_that_changes_during_the_run_is_not_taken_for_what_it_was(tmp_path):
    file = tmp_path / "n.txt"
    file.write_text("1")
    told = []
    g = graph(f"  a: {{node: Rewrite, path: {file}, text: '2 3'}}")
    assert values(run(g, cache=tmp_path / "cache", emit=told.append)) == [2, 3]
    assert [event.text for event in told if isinstance(event, events.Warned)] == [
        "a file that it reads changed during the run; its result is not kept for later runs"]  # fmt: skip
    file.write_text("1")
    calls()
    run(g, cache=tmp_path / "cache")
    assert calls() == ["rewrite"]


@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
def test_two_tasks_with_one_key_run_once(tmp_path, how):
    g = graph(
        "  one: {node: Const, value: 3}\n  two: {node: Const, value: 3.0}\n  a: {node: Both, image: one, mask: two}"
    )
    result = run(g, cache=tmp_path, **how)
    assert calls() == ["const 3", "both"]
    assert {task: report.status for task, report in result.reports.items()} == {
        "one": "ran",
        "two": "cached",
        "a": "ran",
    }


def test_warnings_are_told_again_on_a_hit(tmp_path):
    g = graph("  one: {node: Const}\n  a: {node: Warns, image: one}")
    for status in ("ran", "cached"):
        told = []
        result = run(g, cache=tmp_path, emit=told.append)
        assert events.Warned("a", "it is odd") in told
        assert (result.reports["a"].status, result.reports["a"].warnings) == (status, ("it is odd",))


# --- a store that is damaged, emptied, read-only or full


def objects(folder: Path) -> list[Path]:
    return sorted(folder.glob("objects/??/*"))


def spoil(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[-200 % len(content)] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    "damage",
    [spoil, Path.unlink, lambda path: path.write_bytes(path.read_bytes()[:-10]), lambda path: path.write_bytes(b"")],
)
@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
def test_damaged_and_evicted_values_are_computed_again_and_never_used(tmp_path, damage, how):
    g = graph(CHAIN, XY.replace("default: 1", "default: 1.5"), "out: a, up: up")
    expected = run(g, cache=tmp_path)
    for path in objects(tmp_path):
        damage(path)
    calls()
    result = run(g, cache=tmp_path, **how)
    assert result["out"].tobytes() == expected["out"].tobytes()
    assert result["up"].tobytes() == expected["up"].tobytes()
    assert sorted(calls()) == ["add 2", "both", "const 1.5", "grain", "whole"]
    run(g, cache=tmp_path)
    assert calls() == []


def test_a_damaged_output_alone_is_computed_again_from_what_is_stored(tmp_path):
    g = graph("  one: {node: Const, value: 3}\n  a: {node: Add, image: one}")
    run(g, cache=tmp_path)
    (output,) = [path for path in objects(tmp_path) if np.load(path)[0, 0, 0] == 4]
    spoil(output)
    calls()
    result = run(g, cache=tmp_path)
    assert values(result) == [4, 4]
    assert calls() == ["add 1"]
    assert (result.reports["one"].status, result.reports["a"].why) == ("cached", "its stored result was lost")


@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
def test_a_value_that_is_lost_in_the_middle_of_a_run_is_made_again(tmp_path, how):
    g = graph("  one: {node: Const, value: 3}\n  low: {node: Whole, image: one}\n  m: {node: Average, image: low}\n"
              "  a: {node: Add, image: low, amount: {from: m}}", outputs="out: a")  # fmt: skip
    run(g, cache=tmp_path)
    inner = graph("  one: {node: Const, value: 3}\n  low: {node: Whole, image: one}\n  m: {node: Average, image: low}\n"
                  "  a: {node: Both, image: low, mask: one}", outputs="out: a, m: m")  # fmt: skip
    calls()

    def lose(event: events.Event) -> None:
        if isinstance(event, events.Cached) and event.task == "low":
            for path in objects(tmp_path):
                path.unlink()

    result = run(inner, cache=tmp_path, emit=lose, **how)
    assert values(result) == [9, 9]
    assert result["m"] == 3
    assert set(calls()) == {"const 3", "whole", "both", "average"}
    assert {report.status for report in result.reports.values()} == {"ran"}


def test_a_damaged_record_is_a_miss(tmp_path):
    g = graph(CHAIN, XY)
    run(g, cache=tmp_path)
    for path in tmp_path.glob("index/??/*"):
        path.write_text("{}")
    calls()
    run(g, cache=tmp_path)
    assert len(calls()) == 5


def test_a_folder_that_is_none_is_told_once_and_the_run_goes_on(tmp_path):
    (tmp_path / "file").write_text("")
    told = []
    result = run(graph(CHAIN, XY), cache=tmp_path / "file" / "cache", emit=told.append)
    assert len(calls()) == 5
    assert not result.failed
    assert len([event for event in told if isinstance(event, events.Warned)]) == 1


def test_a_disk_that_is_full_is_told_once_and_the_run_goes_on(tmp_path):
    told = []
    g = graph(CHAIN.replace("a: {node", "same: {node: Grain, seed: 3}\n  a: {node"), XY, "out: a, same: same")

    def full(*args):
        raise OSError(28, "No space left on device")

    with pytest.MonkeyPatch.context() as patch:

        def fill(event: events.Event) -> None:
            told.append(event)
            if isinstance(event, events.Finished) and event.task == "one":
                patch.setattr(Path, "replace", full)

        result = run(g, cache=tmp_path, emit=fill)
    assert result["out"].shape == (1, 2, 1)
    (warned,) = [event.text for event in told if isinstance(event, events.Warned)]
    assert warned.endswith("No space left on device")
    assert len(calls()) == 6


def test_what_was_not_stored_is_not_recorded(tmp_path):
    def unavailable(*args):
        raise CacheUnavailable("no room")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Cache, "put", unavailable)
        run(graph(CHAIN, XY), cache=tmp_path)
    assert list(tmp_path.glob("index/??/*")) == []


# --- failures


CELLS = "  c: {node: Fragile, each: {value: [0, 1, 2]}, bad: 1, on_error: keep}\n"


@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
@pytest.mark.parametrize("cached", [True, False])
def test_a_cell_that_may_fail_leaves_a_gap(tmp_path, how, cached):
    g = graph(CELLS + "  s: {node: Survey, cells: c}\n  t: {node: Total, images: c}\n  u: {node: Add, image: t}\n"
              "  v: {node: Whole, image: s}", outputs="c: c, s: s, u: u, v: v")  # fmt: skip
    told = []
    for _ in range(2):
        result = run(g, cache=tmp_path if cached else False, emit=told.append, **how)
        assert result.failed
        assert values(result, "s") == [0, -1, 2]
        assert values(result, "v") == [0, -1, 2]
        assert result["c"][1] == Gap("c[1]", "value: 1 is bad")
        assert result["c"][2][0, 0, 0] == 2
        assert result["u"] == Gap("u", "needs c[1], which failed")
        status = {task: report.status for task, report in result.reports.items()}
        assert status["c[1]"] == "failed"
        assert status["t"] == status["u"] == "skipped"
    assert events.Failed("c[1]", "value: 1 is bad") in told
    assert events.Skipped("t", "c[1]") in told


def test_a_sub_graph_that_may_fail_is_one_gap(tmp_path):
    (tmp_path / "in.yaml").write_text(
        "graphtex: 1\ninputs:\n  v: {type: float}\nnodes:\n  f: {node: Fragile, value: $v, bad: 1}\n"
        "  a: {node: Add, image: f}\n  b: {node: Whole, image: f}\noutputs: {out: a, low: b}\n"
    )
    g = graph(f"  c: {{graph: {tmp_path}/in.yaml, each: {{v: [0, 1]}}, on_error: keep}}\n  s: {{node: Survey, cells: c.out}}\n"
              "  r: {node: Reasons, cells: c.low}", outputs="s: s, r: r, c: c.low")  # fmt: skip
    result = run(g, cache=False)
    assert values(result, "s") == [1, -1]
    assert result["c"][1].label == "c[1]"
    assert result["r"] == len("c[1]") + len("needs c[1]/f, which failed")


PICTURES = "  pictures: {type: 'list[Image]'}\n"
EACH_PICTURE = "  c: {node: Add, each: {image: $pictures}, on_error: keep}\n  s: {node: Survey, cells: c}\n"


@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
def test_a_file_that_cannot_be_opened_costs_only_the_cells_that_read_it(tmp_path, how):
    for name, text in {"a": "1", "b": "no number", "c": "3"}.items():
        (tmp_path / f"{name}.tex").write_text(text)
    result = run(graph(EACH_PICTURE, PICTURES, "s: s"), {"pictures": tmp_path}, cache=False, **how)
    assert values(result, "s") == [2, -1, 4]
    assert result.failed
    assert result.reports["$pictures[1]"].status == "failed"
    assert result.reports["c[1]"].message == "needs $pictures[1], which failed"


@pytest.mark.parametrize(
    ("more", "outputs"), [("  w: {node: Survey, cells: $pictures}\n", "s: s, w: w"), ("", "s: s, p: $pictures")]
)
def test_a_file_that_something_else_needs_too_ends_the_run(tmp_path, more, outputs):
    (tmp_path / "b.tex").write_text("no number")
    with pytest.raises(NodeFailed, match="could not convert string"):
        run(graph(EACH_PICTURE + more, PICTURES, outputs), {"pictures": tmp_path}, cache=False)


@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
def test_the_first_failure_ends_the_run_and_what_had_finished_stays(tmp_path, how):
    g = graph("  one: {node: Const, value: 3}\n  two: {node: Add, image: one}\n  f: {node: Fragile, image: two, value: 1, bad: $bad}\n"
              "  a: {node: Whole, image: f}", "  bad: {type: float, default: 1}", "out: a, two: two")  # fmt: skip
    with pytest.raises(NodeFailed) as caught:
        run(g, cache=tmp_path, **how)
    assert str(caught.value) == "f: value: 1 is bad [inputs: image float32 (1, 2, 1)]"
    assert caught.value.task == "f"
    assert isinstance(caught.value.__cause__, ValueError)
    result = caught.value.result
    assert values(result, "two") == [4, 4]
    assert isinstance(result["out"], Gap)
    assert result.failed
    assert "a" not in result.reports
    assert result.reports["f"].seconds > 0
    calls()
    assert values(run(g, {"bad": 2}, cache=tmp_path, **how)) == [1]
    assert calls() == ["fragile 1", "whole"]


@pytest.mark.parametrize(
    ("node", "told"),
    [
        ("{node: Fragile, image: one, value: 1, bad: 1}", "a: value: 1 is bad [inputs: image float32 (1, 2, 1)]"),
        ("{node: Liar, image: one}", "a: Liar broke its own output's type: result: Image is float32, got bool"),
        ("{node: Const, size: {from: m}}", "a: size: should be a valid integer, got 3.5"),
        (
            "{node: Total, images: [one, other]}",
            "a: all input arrays must have the same shape [inputs: images list of 2]",
        ),
    ],
)
def test_a_failure_tells_node_shapes_and_cause(node, told):
    g = graph(
        f"  one: {{node: Const, value: 3.5}}\n  other: {{node: Const, size: 3}}\n  m: {{node: Average, image: one}}\n  a: {node}"
    )
    with pytest.raises(NodeFailed) as caught:
        run(g, cache=False)
    assert str(caught.value).startswith(told)


def test_a_fault_in_a_node_is_told_with_its_line():
    g = graph("  one: {node: Const}\n  a: {node: Wait, image: one}")
    told = pytest.raises(NodeFailed, match=r"^a: KeyError: 'nothing' \(.*test_run\.py:\d+\)")
    with pytest.MonkeyPatch.context() as patch, told:
        patch.setattr(tiny.ENTERED, "set", lambda: {}["nothing"])
        run(g, cache=False)


# --- stopping


@pytest.mark.parametrize("how", [{}, {"executor": "threads", "workers": 2}])
def test_a_run_is_cancelled_from_another_thread_and_leaves_what_had_finished(tmp_path, how):
    g = graph(
        "  one: {node: Const, value: 3}\n  w: {node: Wait, image: one}\n  a: {node: Add, image: w}",
        outputs="out: a, one: one",
    )
    cancel, told = threading.Event(), []

    def stop() -> None:
        assert tiny.ENTERED.wait(10)
        cancel.set()

    stopper = threading.Thread(target=stop)
    stopper.start()
    with pytest.raises(Cancelled, match="the run was cancelled"):
        run(g, cache=tmp_path, cancel=cancel, emit=told.append, **how)
    stopper.join()
    assert calls() == ["const 3", "wait"]
    assert told[-2:] == [events.Stopped("w"), events.Stopped("")]
    assert list(tmp_path.glob("tmp/*")) == []
    assert list(tmp_path.glob("runs/*")) == []
    run(g, only=["one"], cache=tmp_path)
    assert calls() == []


def test_a_run_that_was_cancelled_before_it_began_runs_nothing():
    cancel = threading.Event()
    cancel.set()
    with pytest.raises(Cancelled):
        run(graph("  a: {node: Const}"), cache=False, cancel=cancel)
    assert calls() == []


def test_an_interrupt_in_a_serial_run_goes_through_and_what_had_finished_stays(tmp_path):
    g = graph("  one: {node: Const, value: 3}\n  a: {node: Wait, image: one}")

    def interrupt() -> None:
        raise KeyboardInterrupt

    cancel = threading.Event()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tiny.ENTERED, "set", interrupt)
        with pytest.raises(KeyboardInterrupt):
            run(g, cache=tmp_path, cancel=cancel)
    assert not cancel.is_set()
    assert list(tmp_path.glob("runs/*")) == []
    calls()
    run(graph("  a: {node: Const, value: 3}"), cache=tmp_path)
    assert calls() == []


def test_a_listener_that_raises_ends_the_run_and_the_threads(tmp_path):
    def emit(event: events.Event) -> None:
        if isinstance(event, events.Finished):
            raise RuntimeError("no more")

    g = graph("  w: {node: Wait}\n  a: {node: Const}", outputs="w: w, a: a")
    with pytest.raises(RuntimeError, match="no more"):
        run(g, cache=tmp_path, emit=emit, executor="threads", workers=2)


# --- memory, events, history


@pytest.mark.parametrize("cached", [True, False])
def test_values_that_nobody_reads_any_more_are_dropped(tmp_path, cached):
    nodes = "  t0: {node: Tracked}\n" + "".join(f"  t{i}: {{node: Tracked, image: t{i - 1}}}\n" for i in range(1, 5))
    result = run(graph(nodes, outputs="out: t4"), cache=tmp_path if cached else False)
    assert calls() == ["alive 0", "alive 1", "alive 1", "alive 1", "alive 1"]
    assert [made() is not None for made in tiny.ALIVE] == [False] * 4 + [True]
    assert result["out"].shape == (64, 64, 1)


@pytest.mark.parametrize("cached", [True, False])
def test_an_output_that_nobody_reads_is_dropped_at_once(tmp_path, cached):
    nodes = "  s: {node: Spares}\n  a: {node: Tracked, image: s.used}"
    run(graph(nodes), cache=tmp_path if cached else False)
    assert calls() == ["spares", "alive 1"]


def test_all_values_are_kept_where_a_report_wants_them():
    g = graph(
        "  t0: {node: Tracked}\n  t1: {node: Tracked, image: t0}\n  t2: {node: Tracked, image: t1}", outputs="out: t2"
    )
    result = run(g, cache=False, keep_all=True)
    assert all(made() is not None for made in tiny.ALIVE)
    slots = [slot for slot in result.finished.held if slot.task == "t0"]
    assert result.value(slots[0]).shape == (64, 64, 1)


def test_a_value_that_was_dropped_comes_from_the_store_if_that_holds_it(tmp_path):
    g = graph("  one: {node: Const, value: 3}\n  a: {node: Add, image: one}")
    result = run(g, cache=tmp_path)
    (slot,) = [slot for slot in result.finished.held if slot.task == "one"]
    assert result.value(slot)[0, 0, 0] == 3
    Cache(tmp_path).clear()
    with pytest.raises(EntryLost):
        result.value(slot)


def test_the_events_of_a_run(tmp_path):
    g = graph("  one: {node: Const}\n  a: {node: Warns, image: one}")
    told: list[events.Event] = []
    run(g, cache=tmp_path, emit=told.append)
    assert [(type(event).__name__, event.task) for event in told] == [
        ("Planned", "one"), ("Planned", "a"), ("Started", "one"), ("Finished", "one"), ("Started", "a"),
        ("Progress", "a"), ("Warned", "a"), ("Finished", "a")]  # fmt: skip
    assert told[2] == events.Started("one", "not run before")
    assert told[5] == events.Progress("a", 0.5, "half")


def test_a_graph_s_history_keeps_what_was_not_reached_and_forgets_what_is_gone(tmp_path):
    cache = Cache(tmp_path)
    g = graph(
        "  one: {node: Const}\n  a: {node: Add, image: one}\n  b: {node: Whole, image: one}", outputs="a: a, b: b"
    )
    run(g, cache=cache)
    run(g, {}, only=["a"], cache=cache)
    (history,) = list(tmp_path.glob("history/*"))
    assert history.is_file()
    assert set(cache.last_run("(built in Python)")) == {"one", "a", "b"}
    run(graph("  one: {node: Const}", outputs="one: one"), cache=cache)
    assert set(cache.last_run("(built in Python)")) == {"one"}


def test_a_caller_s_executor_serves_several_runs():
    with ThreadsExecutor(2) as executor:
        for _ in range(2):
            assert values(run(graph("  a: {node: Const, value: 2}"), cache=False, executor=executor)) == [2, 2]


@pytest.mark.parametrize(
    ("how", "told"),
    [({"executor": "thread"}, "unknown executor 'thread'; did you mean 'threads'"), ({"executor": "threads", "workers": 0}, "at least one worker"),
     ({"workers": 2}, "the serial executor has one worker, got 2")],
)  # fmt: skip
def test_wrong_executors_are_told(how, told):
    with pytest.raises(GraphError, match=told):
        run(graph("  a: {node: Const}"), cache=False, **how)


def test_a_wrong_size_in_the_environment_is_a_wrong_request(tmp_path, monkeypatch):
    monkeypatch.setenv("GRAPHTEX_CACHE_SIZE", "much")
    with pytest.raises(GraphError, match="GRAPHTEX_CACHE_SIZE: cache size: expected"):
        run(graph("  a: {node: Const}"), cache=tmp_path)
