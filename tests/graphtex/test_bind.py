"""Binding: what inputs become, how `each:` and sub-graphs unfold, under which ids, and what is told where they do not."""

import errno
from pathlib import Path

import numpy as np
import pytest

from graphtex import Graph, GraphError
from graphtex.bind import bind
from graphtex.files import read_file
from graphtex.graph import loads
from graphtex.plan import Slot
from tests.graphtex import (
    pack,
    tiny,
)
from tests.graphtex.tiny import picture

pytestmark = pytest.mark.usefixtures("tiny_nodes")


def graph(nodes: str, inputs: str = "", outputs: str = "out: a") -> Graph:
    head = f"inputs:\n{inputs}\n" if inputs else ""
    return loads(f"graphtex: 1\n{head}nodes:\n{nodes}\noutputs: {{{outputs}}}\n")


def write(path: Path, nodes: str, inputs: str = "", outputs: str = "out: a", top: str = "") -> Graph:
    """Write a graph file and read it."""
    head = f"inputs:\n{inputs}\n" if inputs else ""
    path.write_text(f"graphtex: 1\n{top}{head}nodes:\n{nodes}\noutputs: {{{outputs}}}\n")
    found, problems = read_file(path)
    assert found is not None
    assert problems == []
    return found


def told(call) -> list[str]:
    with pytest.raises(GraphError) as caught:
        call()
    return [str(problem) for problem in caught.value.problems]


PICTURES = '  pictures: {type: "list[Image]", default: ["made:a", "made:bb"]}'


def test_literals_and_defaults_become_canonical_parameters():
    plan = bind(graph("  a: {node: Const, value: 1}"))
    assert plan.tasks["a"].parameters == {"value": 1.0, "size": 2}
    assert type(plan.tasks["a"].parameters["value"]) is float
    assert plan.outputs["out"].slots == (Slot("a", "result"),)


def test_inputs_are_given_opened_or_plain():
    g = graph(
        "  a: {node: Fragile, image: $picture, value: $by}",
        "  picture: {type: Image, default: 'made:stone'}\n  by: {type: float, default: 1}",
    )
    plan = bind(g)
    assert plan.tasks["$picture"].node is pack.made
    assert plan.tasks["$picture"].parameters == {"name": "stone"}
    assert plan.tasks["a"].inputs == {"image": Slot("$picture", "result")}
    assert plan.tasks["a"].parameters["value"] == 1.0
    given = bind(g, {"picture": picture(3).astype(np.float64), "by": 2})
    assert list(given.tasks) == ["a"]
    ((slot, (kind, value)),) = given.given.items()
    assert (slot, str(kind), value.dtype) == (Slot("$picture", "value"), "Image", np.float32)
    assert given.tasks["a"].parameters["value"] == 2.0


def test_files_start_where_they_are_named(tmp_path, monkeypatch):
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        folder.mkdir()
        for name in ("p.tex", "q.tex", "n.txt"):
            (folder / name).write_text("1")
    monkeypatch.chdir(here)
    g = write(
        there / "g.yaml",
        "  a: {node: Fragile, image: $p}\n  b: {node: Fragile, image: $q}\n  c: {node: Read, path: n.txt}\n"
        "  d: {node: Read, path: $n}",
        "  p: {type: Image, default: p.tex}\n  q: {type: Image, default: q.tex}\n  n: {type: file, default: n.txt}",
        "a: a, b: b, c: c, d: d",
    )
    plan = bind(g, {"q": "q.tex"})
    paths = {name: plan.tasks[name].parameters["path"] for name in ("$p", "$q", "c", "d")}
    assert paths == {"$p": f"{there}/p.tex", "$q": f"{here}/q.tex", "c": f"{there}/n.txt", "d": f"{there}/n.txt"}
    assert plan.tasks["c"].files == (there / "n.txt",)
    other = bind(g, {"q": "q.tex", "n": "n.txt"}, base=here)
    assert other.tasks["d"].parameters["path"] == f"{here}/n.txt"
    assert bind(g, {"n": Path("n.txt")}).tasks["d"].parameters["path"] == f"{here}/n.txt"


def test_what_is_opened_twice_is_opened_once():
    inputs = "  p: {type: Image, default: 'made:x'}\n  q: {type: Image, default: 'made:x'}"
    plan = bind(graph("  a: {node: Both, image: $p, mask: $q}", inputs))
    assert list(plan.tasks) == ["$p", "a"]
    assert set(plan.tasks["a"].inputs.values()) == {Slot("$p", "result")}


@pytest.mark.parametrize(
    ("each", "cells"),
    [
        ("{value: [1, 2, 3]}", [{"value": 1.0}, {"value": 2.0}, {"value": 3.0}]),
        ("{value: $numbers}", [{"value": 5.0}, {"value": 6.0}]),
        ("{value: [$number, 2]}", [{"value": 4.0}, {"value": 2.0}]),
        ("{seed: [1, 2]}", [{"seed": 1}, {"seed": 2}]),
        ("{seed: $numbers}", [{"seed": 5}, {"seed": 6}]),
        ("{seed: [$number, 8]}", [{"seed": 4}, {"seed": 8}]),
        ("{image: ['made:a', 'made:bb']}", [{"image": "a"}, {"image": "bb"}]),
        ("{image: $pictures}", [{"image": "a"}, {"image": "bb"}]),
        ("{image: [$picture, 'made:a']}", [{"image": "stone"}, {"image": "a"}]),
    ],
)
def test_each_ranges_over_literals_inputs_and_seeds(each, cells):
    inputs = (f"{PICTURES}\n  numbers: {{type: 'list[int]', default: [5, 6]}}\n  number: {{type: int, default: 4}}\n"
              "  picture: {type: Image, default: 'made:stone'}")  # fmt: skip
    plan = bind(graph(f"  a: {{node: Fragile, each: {each}}}", inputs))
    made = [plan.tasks[f"a[{i}]"] for i in range(len(cells))]
    assert plan.outputs["out"].slots == tuple(Slot(task.id, "result") for task in made)
    assert plan.outputs["out"].joined
    for task, cell in zip(made, cells, strict=True):
        if "image" in cell:
            assert plan.tasks[task.inputs["image"].task].parameters == {"name": cell["image"]}
        elif "seed" in cell:
            assert (task.seed, task.spawn_key) == (cell["seed"], ())
        else:
            assert task.parameters["value"] == cell["value"]


def test_products_have_stable_ids_in_the_order_of_the_ranges():
    plan = bind(graph("  a: {node: Fragile, each: {image: $pictures, value: [1, 2, 3]}}", PICTURES))
    assert [task for task in plan.tasks if task[0] == "a"] == [
        "a[0,0]",
        "a[0,1]",
        "a[0,2]",
        "a[1,0]",
        "a[1,1]",
        "a[1,2]",
    ]
    assert plan.tasks["a[1,2]"].inputs["image"] == Slot("$pictures[1]", "result")
    assert plan.tasks["a[1,2]"].parameters["value"] == 3.0


def test_joined_lists_flow_into_list_sockets_alone_and_with_others():
    plan = bind(graph(
        "  a: {node: Const, each: {value: [1, 2]}}\n  b: {node: Total, images: a}\n  c: {node: Total, images: $pictures}\n"
        "  d: {node: Total, images: [b, c]}", PICTURES, "a: b, b: c, d: d"))  # fmt: skip
    assert plan.tasks["b"].inputs["images"] == (Slot("a[0]", "result"), Slot("a[1]", "result"))
    assert plan.tasks["c"].inputs["images"] == (Slot("$pictures[0]", "result"), Slot("$pictures[1]", "result"))
    assert plan.tasks["d"].inputs["images"] == (Slot("b", "result"), Slot("c", "result"))


def test_a_folder_and_a_pattern_are_ranged_over(tmp_path):
    for name in ("b.tex", "a.tex", "c.txt"):
        (tmp_path / name).write_text("1")
    g = graph("  a: {node: Fragile, each: {image: $pictures}}", PICTURES)
    for value in (".", "*.tex", tmp_path, f"{tmp_path}/[ab].tex"):
        plan = bind(g, {"pictures": value}, base=tmp_path)
        assert [plan.tasks[f"$pictures[{i}]"].parameters["path"] for i in range(2)] == [
            str(tmp_path / name) for name in ("a.tex", "b.tex")]  # fmt: skip
        assert len(plan.tasks) == 4


def test_a_folder_of_a_graph_that_is_named_from_elsewhere(tmp_path, monkeypatch):
    (tmp_path / "my graphs" / "photos").mkdir(parents=True)
    (tmp_path / "my graphs" / "photos" / "a.tex").write_text("1")
    monkeypatch.chdir(tmp_path)
    for default in ("photos", "photos/*.tex"):
        inputs = f'  x: {{type: "list[Image]", default: "{default}"}}'
        plan = bind(write(Path("my graphs/g.yaml"), "  a: {node: Fragile, each: {image: $x}}", inputs))
        assert plan.tasks["$x[0]"].parameters["path"] == str(tmp_path / "my graphs" / "photos" / "a.tex")


def test_given_lists_may_mix_arrays_and_names():
    plan = bind(graph("  a: {node: Total, images: $pictures}", PICTURES), {"pictures": [picture(1), "made:x"]})
    assert plan.tasks["a"].inputs["images"] == (Slot("$pictures[0]", "value"), Slot("$pictures[1]", "result"))


INNER = "  grain: {node: Grain, image: $picture, size: $size}\n  a: {node: Add, image: grain, amount: $by}"
INNER_INPUTS = ("  picture: {type: Image, default: in.tex}\n  size: {type: int, default: 3, max: 9}\n"
                "  by: {type: float, default: 1}")  # fmt: skip


@pytest.fixture
def inner(tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "in.tex").write_text("1 2")
    write(tmp_path / "deep" / "inner.yaml", INNER, INNER_INPUTS, top="seed: 99\n")
    return tmp_path


def test_a_sub_graph_unfolds_with_its_own_paths_and_the_outer_seed(inner):
    g = write(
        inner / "g.yaml",
        "  one: {node: Const}\n  a: {graph: deep/inner.yaml, picture: one}\n  b: {graph: deep/inner.yaml, size: 4}",
        outputs="a: a, b: b",
        top="seed: 5\n",
    )
    plan = bind(g)
    assert sorted(plan.tasks) == ["a/a", "a/grain", "b/$picture", "b/a", "b/grain", "one"]
    assert plan.tasks["a/grain"].inputs == {"image": Slot("one", "result")}
    assert plan.tasks["b/$picture"].parameters == {"path": str(inner / "deep" / "in.tex"), "gain": 1.0}
    assert (plan.tasks["a/grain"].parameters["size"], plan.tasks["b/grain"].parameters["size"]) == (3, 4)
    assert {task.seed for task in plan.tasks.values()} == {5}
    assert plan.tasks["a/grain"].spawn_key != plan.tasks["b/grain"].spawn_key
    assert plan.outputs["a"].slots == (Slot("a/a", "result"),)


def test_a_seed_of_a_sub_graph_s_entry_replaces_the_graph_s_within_it(inner):
    g = write(
        inner / "g.yaml",
        "  a: {graph: deep/inner.yaml, seed: 8}\n  b: {graph: deep/inner.yaml, each: {seed: [1, 2]}}",
        outputs="a: a, b: b",
    )
    plan = bind(g, seed=3)
    assert {name: plan.tasks[name].seed for name in ("a/grain", "b[0]/grain", "b[1]/grain")} == {
        "a/grain": 8, "b[0]/grain": 1, "b[1]/grain": 2}  # fmt: skip
    assert plan.tasks["b[0]/grain"].spawn_key == plan.tasks["b[1]/grain"].spawn_key != ()


def test_a_measured_number_goes_through_a_sub_graph_s_input(inner):
    g = write(
        inner / "g.yaml",
        "  one: {node: Const}\n  mean: {node: Average, image: one}\n  a: {graph: deep/inner.yaml, by: {from: mean}}",
    )
    task = bind(g).tasks["a/a"]
    assert task.measured == {"amount": Slot("mean", "result")}
    assert "amount" not in task.parameters


def test_the_matrix_of_all_pairs_is_one_entry(tmp_path):
    write(tmp_path / "splice.yaml", "  warp: {node: Both, image: $elements, mask: $arrangement}\n  a: {node: Grain, image: warp}",
          "  elements: {type: Image}\n  arrangement: {type: Image}")  # fmt: skip
    g = write(tmp_path / "g.yaml", "  cell: {graph: splice.yaml, each: {elements: $pictures, arrangement: $pictures}}\n"
              "  a: {node: Total, images: cell}", PICTURES)  # fmt: skip
    plan = bind(g)
    assert [name for name in plan.tasks if name.endswith("/warp")] == [
        f"cell[{i},{j}]/warp" for i in (0, 1) for j in (0, 1)
    ]
    assert plan.tasks["cell[0,1]/warp"].inputs == {
        "image": Slot("$pictures[0]", "result"), "mask": Slot("$pictures[1]", "result")}  # fmt: skip
    assert plan.tasks["a"].inputs["images"] == tuple(Slot(f"cell[{i},{j}]/a", "result") for i in (0, 1) for j in (0, 1))
    assert len({plan.tasks[f"cell[{i},{j}]/a"].spawn_key for i in (0, 1) for j in (0, 1)}) == 1


def test_sub_graphs_within_sub_graphs_and_each_within_each(tmp_path):
    write(tmp_path / "in.yaml", "  a: {node: Const, value: $v}", "  v: {type: float}")
    write(tmp_path / "mid.yaml", "  in: {graph: in.yaml, each: {v: $vs}}\n  a: {node: Total, images: in}",
          "  vs: {type: 'list[float]'}", "out: a, all: in")  # fmt: skip
    g = write(tmp_path / "g.yaml", "  mid: {graph: mid.yaml, vs: [1, 2]}\n  a: {node: Total, images: mid.all}")
    plan = bind(g)
    assert list(plan.tasks) == ["mid/in[0]/a", "mid/in[1]/a", "mid/a", "a"]
    assert plan.tasks["a"].inputs["images"] == (Slot("mid/in[0]/a", "result"), Slot("mid/in[1]/a", "result"))
    twice = write(
        tmp_path / "h.yaml", "  mid: {graph: mid.yaml, each: {vs: [[1, 2], [3]]}}\n  a: {node: Total, images: mid.out}"
    )
    assert [task for task in bind(twice).tasks if "in[" in task] == [
        "mid[0]/in[0]/a",
        "mid[0]/in[1]/a",
        "mid[1]/in[0]/a",
    ]


def test_cells_that_may_fail_carry_the_id_of_the_innermost(tmp_path):
    write(tmp_path / "in.yaml", "  b: {node: Fragile}\n  a: {node: Fragile, image: b, each: {value: [1]}, on_error: keep}\n"
          "  c: {node: Survey, cells: a}", outputs="out: c")  # fmt: skip
    g = write(tmp_path / "g.yaml", "  k: {graph: in.yaml, each: {seed: [1]}, on_error: keep}\n  l: {graph: in.yaml}\n"
              "  a: {node: Survey, cells: k}", outputs="a: a, b: l")  # fmt: skip
    cells = {task.id: task.cell for task in bind(g).tasks.values()}
    assert cells == {"k[0]/b": "k[0]", "k[0]/a[0]": "k[0]/a[0]", "k[0]/c": "k[0]", "l/b": "", "l/a[0]": "l/a[0]",
                     "l/c": "", "a": ""}  # fmt: skip


def test_random_streams_do_not_depend_on_other_nodes_nor_on_the_order_of_inputs():
    inputs = "  p: {type: Image, default: 'made:x'}"
    small = bind(graph("  a: {node: Grain, image: $p}", inputs))
    large = bind(
        graph(
            "  new: {node: Grain, image: $n}\n  a: {node: Grain, image: $p}",
            "  n: {type: Image, default: 'made:x'}\n" + inputs,
            "out: a, new: new",
        )
    )
    assert small.tasks["a"].spawn_key == large.tasks["a"].spawn_key
    assert small.tasks["$p"].spawn_key == large.tasks["$n"].spawn_key


def test_the_seed_is_the_graph_s_or_what_replaces_it():
    g = graph("  a: {node: Grain}\n  b: {node: Grain, seed: 4}", outputs="a: a, b: b")
    g.seed = 7
    assert [task.seed for task in bind(g).tasks.values()] == [7, 4]
    plan = bind(g, seed=9)
    assert [task.seed for task in plan.tasks.values()] == [9, 4]
    assert [len(task.spawn_key) for task in plan.tasks.values()] == [8, 0]
    assert told(lambda: bind(g, seed=-1)) == ["seed: a seed is a whole number from 0, got -1"]


@pytest.mark.parametrize(
    ("values", "problems"),
    [
        ({}, ["inputs.picture: picture has no default: a value of type Image is required"]),
        ({"picture": "made:x", "pictur": 3}, ["pictur: the graph has no input 'pictur'; did you mean 'picture'?"]),
        ({"picture": np.zeros((2, 2, 3), np.uint8)}, ["picture: Image is float32, got uint8; convert it: x / 255 as float32"]),
        ({"picture": "made:x", "by": 20}, ["by: should be at most 9, got 20"]),
        ({"picture": "nowhere.tex", "by": "x"}, ["by: expected float, got 'x'", "picture: there is no file "]),
        ({"picture": "a.nix"}, ["picture: nothing opens a file ending in '.nix' as Image"]),
        ({"picture": ""}, ["picture: expected a path or scheme:name to open as Image, got an empty text"]),
        ({"picture": "/"}, ["picture: '/' is a folder; Image is opened from one file"]),
        ({"picture": None}, ["picture: expected Image: float32 (h, w, c), got NoneType"]),
    ],
)  # fmt: skip
def test_all_that_is_wrong_with_the_given_values_is_told(values, problems):
    g = graph(
        "  a: {node: Add, image: $picture, amount: $by}",
        "  picture: {type: Image}\n  by: {type: float, default: 1, max: 9}",
    )
    got = told(lambda: bind(g, values))
    assert len(got) == len(problems)
    assert all(start in text for text, start in zip(got, problems, strict=True))


def test_what_an_input_is_for_is_told_with_what_is_wrong():
    """The graph's author can say what to take instead; a fault of the file's own default needs no such help."""
    inputs = "  picture: {type: Image, description: a photograph; other/graph takes models}\n"
    g = graph("  a: {node: Add, image: $picture, amount: 1}", inputs)
    (got,) = told(lambda: bind(g, {"picture": "a.nix"}))
    assert got.endswith("(a photograph; other/graph takes models)")


@pytest.mark.parametrize("folder", [False, True])
def test_what_may_not_be_read_is_told_before_anything_runs(tmp_path, monkeypatch, folder):
    """Of root nothing is kept back: the error of the system is made by hand."""
    (tmp_path / "a.tex").write_text("1")

    def refuse(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(Path, "iterdir" if folder else "open", refuse)
    g = graph("  a: {node: Fragile, each: {image: $pictures}}", PICTURES)
    wrong = str(tmp_path) if folder else str(tmp_path / "a.tex")
    assert told(lambda: bind(g, {"pictures": wrong})) == [f"pictures: {wrong!r} cannot be read: Permission denied"]


@pytest.mark.parametrize(
    ("nodes", "inputs", "given", "problem"),
    [
        ("  a: {node: Fragile, each: {image: $p}}", '  p: {type: "list[Image]"}', {"p": []}, "nodes.a.each.image: $p is an empty list: there is nothing to range over"),
        ("  a: {node: Fragile, each: {image: $p}}", '  p: {type: "list[Image]"}', {"p": "*.nix"}, "p: no file matches '*.nix'"),
        ("  a: {node: Fragile, each: {image: $p}}", '  p: {type: "list[Image]"}', {"p": [np.zeros(3)]}, "p: expected Image: float32 (h, w, c), got shape (3,)"),
        ("  a: {node: Grain, seed: $s}", "  s: {type: int}", {"s": -1}, "nodes.a.seed: a seed is a whole number from 0, got -1"),
        ("  a: {node: Grain, each: {seed: $s}}", '  s: {type: "list[int]"}', {"s": [1, -2]}, "nodes.a.each.seed: a seed is a whole number from 0, got -2"),
        ("  a: {node: Const, size: $s}", "  s: {type: int}", {"s": 0}, "a.size: should be greater than or equal to 1, got 0"),
        ("  a: {node: Const, each: {size: $s}}", '  s: {type: "list[int]"}', {"s": [1, 0]}, "a[1].size: should be greater than or equal to 1, got 0"),
        ("  a: {node: Read, path: $f}", "  f: {type: file}", {"f": "gone"}, "a.path: there is no file "),
        ("  a: {node: Fragile, each: {image: [gone.tex]}}", "", {}, "nodes.a.each.image.0: there is no file "),
    ],
)  # fmt: skip
def test_what_only_the_values_show_is_told_at_the_entry(nodes, inputs, given, problem):
    (got,) = told(lambda: bind(graph(nodes, inputs), given))
    assert problem in got


def test_what_a_sub_graph_does_not_admit_is_told_with_the_cell(inner):
    g = write(
        inner / "g.yaml",
        "  a: {graph: deep/inner.yaml, each: {size: $sizes}}",
        "  sizes: {type: 'list[int]', default: [1, 20]}",
    )
    assert told(lambda: bind(g))[0].endswith("g.yaml:5:3: a[1].size: should be at most 9, got 20")
    (inner / "deep" / "in.tex").unlink()
    fine = write(inner / "g.yaml", "  a: {graph: deep/inner.yaml}")
    (problem,) = told(lambda: bind(fine))
    assert "deep/inner.yaml:4:35: inputs.picture.default: there is no file" in problem


def test_a_measured_number_is_no_seed(tmp_path):
    write(tmp_path / "in.yaml", "  a: {node: Grain, seed: $s}", "  s: {type: int}")
    g = write(
        tmp_path / "g.yaml",
        "  one: {node: Const}\n  mean: {node: Average, image: one}\n  a: {graph: in.yaml, s: {from: mean}}",
    )
    (problem,) = told(lambda: bind(g))
    assert problem.endswith("nodes.a.seed: a seed is known before the run; a measured number is not")


def test_a_faulty_graph_is_told_before_its_inputs():
    g = Graph()
    g.output("out", g.add(tiny.const))
    g.nodes["x"] = g.nodes["const"].__class__("Gone")
    assert told(lambda: bind(g, {"nothing": 1}))[0].startswith("nodes.x.node: unknown node 'Gone'")
