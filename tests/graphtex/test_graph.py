"""The builder: what it writes down, what it refuses, and that files say the same."""

import copy
from pathlib import Path

import numpy as np
import pytest

from graphtex import Elements, Graph, GraphError, Image, node
from graphtex.bind import bind
from graphtex.document import REQUIRED, Entry, Input, Output
from graphtex.files import dumps
from graphtex.graph import InputHandle, SocketHandle, load, loads
from tests.graphtex import tiny

pytestmark = pytest.mark.usefixtures("tiny_nodes")


@node(name="Add")
def other_add(image: Image) -> Image:
    """Take the name of another node."""
    return image


@node
def stray(image: Image) -> Image:
    """Belong to no pack."""
    return image


def whole_graph() -> Graph:
    """Make a graph in which everything occurs."""
    g = Graph(title="All", source="here", seed=7, description="two\nlines")
    picture = g.input("picture", Image, default="made:stone", description="what it is made of")
    pictures = g.input("pictures", list[Image], default=["made:a", "made:b"])
    size = g.input("size", int, default=3, min=1, max=9)
    seeds = g.input("seeds", "list[int]", default=[1, 2])
    g.input("text", str, default="$5", choices=["$5", "b"])
    first = g.add(tiny.const, value=0.5, size=size)
    second = g.add(tiny.add, image=picture, amount=2)
    split = g.add(tiny.halves, image=first)
    mean = g.add(tiny.average, "mean", image=split.high)
    g.add(tiny.add, "measured", image=second, amount=mean)
    cells = g.add(tiny.fragile, "cells", each={"image": pictures, "value": [1, 2]}, on_error="keep", bad=2)
    grains = g.add(tiny.grain, each={"seed": seeds, "image": ["made:x", picture]})
    total = g.add(tiny.total, images=[first, split.low, picture])
    g.add(tiny.survey, cells=cells)
    g.add(tiny.grain, "own", seed=size)
    g.add(tiny.read, path="$odd.txt")
    g.output("total", total, file="total.tex", digits=3)
    g.output("grains", grains)
    g.output("picture", picture)
    return g


def test_the_builder_writes_down_what_a_file_says():
    g = whole_graph()
    assert g.inputs["picture"] == Input("Image", "made:stone", description="what it is made of")
    assert g.inputs["pictures"].type == "list[Image]"
    assert g.inputs["size"] == Input("int", 3, 1, 9)
    assert g.inputs["text"].choices == ("$5", "b")
    assert g.nodes["const"] == Entry("Const", "", {"value": 0.5, "size": "$size"})
    assert g.nodes["add"] == Entry("Add", "", {"image": "$picture", "amount": 2})
    assert g.nodes["mean"] == Entry("Average", "", {"image": "halves.high"})
    assert g.nodes["measured"].arguments["amount"] == {"from": "mean"}
    assert g.nodes["cells"].each == {"image": "$pictures", "value": [1, 2]}
    assert g.nodes["cells"].on_error == "keep"
    assert g.nodes["grain"].each == {"seed": "$seeds", "image": ["made:x", "$picture"]}
    assert g.nodes["total"].arguments["images"] == ["const", "halves.low", "$picture"]
    assert g.nodes["own"].seed == "$size"
    assert g.nodes["read"].arguments["path"] == "$$odd.txt"
    assert g.outputs["total"] == Output("total", "total.tex", {"digits": 3})
    assert g.outputs["picture"] == Output("$picture")


def test_a_file_gives_the_same_graph_back(tmp_path):
    g = whole_graph()
    text = dumps(g)
    assert loads(text) == g
    assert dumps(loads(text)) == text
    g.save(tmp_path / "g.yaml")
    again = load(tmp_path / "g.yaml")
    assert again == g
    assert again.base == tmp_path
    assert Graph().base == Path.cwd()


def test_a_graph_from_a_file_and_one_from_the_builder_are_bound_to_the_same_tasks(tmp_path):
    g = whole_graph()
    del g.nodes["read"]
    one, two = bind(g), bind(loads(dumps(g)))
    assert one.tasks == two.tasks
    assert one.outputs == two.outputs


def test_ids_are_the_functions_names_numbered_where_taken():
    g = Graph()
    names = [g.add(tiny.const)._name for _ in range(3)] + [g.add(tiny.const, "const_4")._name]
    assert names == ["const", "const_2", "const_3", "const_4"]


def test_handles_name_outputs():
    g = Graph()
    one, two = g.add(tiny.const), g.add(tiny.halves, image="const")
    assert one.result == SocketHandle("const")
    assert two.low == SocketHandle("halves.low")
    assert repr(two) == "<halves: low, high>"
    assert copy.copy(two).low == two.low
    with pytest.raises(AttributeError, match="halves has no output 'hihg'; did you mean 'high'"):
        two.hihg  # noqa: B018


def test_input_types_are_socket_types_python_types_or_names():
    g = Graph()
    kinds = {"a": Image, "b": list[Image], "c": int, "d": list[float], "e": "file", "f": Elements, "g": "list[Image]"}
    assert [g.input(name, kind) for name, kind in kinds.items()] == [InputHandle(name) for name in kinds]
    assert [kind.type for kind in g.inputs.values()] == [
        "Image", "list[Image]", "int", "list[float]", "file", "Elements", "list[Image]"]  # fmt: skip
    assert g.inputs["a"].default is REQUIRED
    with pytest.raises(GraphError, match="unknown type 'ndarray'"):
        g.input("x", np.ndarray)


@pytest.mark.parametrize(
    ("build", "told"),
    [
        (lambda g: g.add(tiny.const, "a b"), "nodes.a b: a name is letters, digits, _ and -, got 'a b'"),
        (lambda g: g.add(tiny.const, "const"), "nodes.const: the name 'const' is taken"),
        (lambda g: g.input("size", int), "inputs.size: the name 'size' is taken"),
        (lambda g: g.output("out", g.add(tiny.const)), "outputs.out: the name 'out' is taken"),
        (lambda g: g.add(tiny.add, image=g.add(tiny.halves, image="const")), "nodes.halves: has several outputs: write one of .low, .high"),
        (lambda g: g.add(other_add, image="const"), "nodes.other_add: another node is called Add, tests.graphtex.tiny.add"),
        (lambda g: g.add("nowhere.yaml"), "nodes.nowhere.graph: there is no graph file 'nowhere.yaml' beside this graph"),
        (lambda g: g.add(tiny.add, image=tiny.picture(1)), "an array does not stand in a graph; add an input"),
    ],
)  # fmt: skip
def test_refuses_at_once(build, told):
    g = Graph()
    g.input("size", int)
    g.output("out", g.add(tiny.const))
    before = dict(g.nodes)
    with pytest.raises(GraphError) as caught:
        build(g)
    assert str(caught.value).startswith(told)
    assert set(g.nodes) - set(before) <= {"halves", "const_2"}


def test_a_sub_graph_is_added_by_its_file(tmp_path):
    inner = Graph()
    inner.output("brighter", inner.add(tiny.add, image=inner.input("picture", Image)))
    inner.save(tmp_path / "to-light.yaml")
    g = Graph()
    made = g.add(tmp_path / "to-light.yaml", picture=g.add(tiny.const))
    assert g.nodes["to_light"] == Entry("", str(tmp_path / "to-light.yaml"), {"picture": "const"})
    assert made.brighter == SocketHandle("to_light")


def test_what_is_neither_a_node_nor_a_file_is_not_added():
    with pytest.raises(TypeError, match=r"add: expected a node, a function with @node, or a graph file, got <built-in"):
        Graph().add(len)


def test_a_node_of_no_pack_stays_with_its_graph():
    g = Graph()
    g.output("image", g.add(stray, image=g.add(tiny.const)))
    assert g.own_nodes == {"Stray": stray}
    assert bind(g).tasks["stray"].node is stray
    with pytest.raises(GraphError, match="unknown node 'Stray'"):
        loads(dumps(g))


def test_problems_name_the_nearest_known_place():
    g = loads("graphtex: 1\nnodes:\n  a: {node: Const, value: 3}\noutputs: {image: a}\n")
    assert (g.problem(("nodes", "a", "value"), "x").line, g.problem(("nodes", "a", "value"), "x").column) == (3, 27)
    assert g.problem(("nodes", "a", "value"), "x", key=True).column == 20
    assert g.problem(("nodes", "a", "gone", 3), "x").column == 3
    assert str(g.problem(("nodes", "a", "gone", 3), "x")).endswith("nodes.a.gone.3: x")
    assert str(Graph().problem(("nodes",), "x")) == "nodes: x"
