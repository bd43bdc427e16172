"""What references and entries lead to."""

import pytest

from graphtex import Graph, GraphError
from graphtex.document import Entry, Input, Output
from graphtex.graph import load
from graphtex.links import Links
from graphtex.references import (
    FromInput,
    FromNode,
    Literal,
    Measured,
    is_scalar,
    parameter_argument,
    range_argument,
    reference,
    references_of,
    socket_argument,
    unescaped,
)

pytestmark = pytest.mark.usefixtures("tiny_nodes")
G = Graph()


def test_references_are_nodes_sockets_or_inputs():
    assert reference(G, (), "mask") == FromNode("mask", None)
    assert reference(G, (), "mask.edges") == FromNode("mask", "edges")
    assert reference(G, (), "$size") == FromInput("size")
    for wrong in ("", 3, None, ["a"], {"from": "a"}):
        with pytest.raises(GraphError, match=r"expected a reference: node, node.socket or \$input"):
            reference(G, (), wrong)
    assert socket_argument(G, (), ["a", "b.c"]) == (FromNode("a", None), FromNode("b", "c"))


def test_parameters_are_literals_inputs_or_measured():
    assert parameter_argument(G, (), "mask") == Literal("mask")
    assert parameter_argument(G, (), "$size") == FromInput("size")
    assert parameter_argument(G, (), {"from": "a.b"}) == Measured(FromNode("a", "b"))
    assert parameter_argument(G, (), {"from": "a", "to": "b"}) == Literal({"from": "a", "to": "b"})
    assert parameter_argument(G, (), {"from": 3}) == Literal({"from": 3})
    assert parameter_argument(G, (), "$$5") == Literal("$5")
    assert unescaped({"a": ["$$x", "x$$"]}) == {"a": ["$x", "x$$"]}


def test_ranges_are_inputs_or_lists_of_literals_and_inputs():
    assert range_argument(G, (), "$all") == FromInput("all")
    assert range_argument(G, (), [1, "$a", "$$b"]) == (Literal(1), FromInput("a"), Literal("$b"))
    for wrong in ([], "all", 3, [{"from": "a"}], {"from": "a"}):
        with pytest.raises(GraphError, match="computed values cannot be ranged over"):
            range_argument(G, (), wrong)


def test_the_references_of_an_argument():
    assert references_of(G, (), ["a", "$b"], True) == (FromNode("a", None), FromInput("b"))
    assert references_of(G, (), {"from": "a"}, False) == (FromNode("a", None),)
    assert references_of(G, (), "a", False) == ()


@pytest.mark.parametrize(
    ("kind", "scalar"), [("int", True), ("list[file]", True), ("Image", False), ("list[Image]", False)]
)
def test_scalars_feed_parameters(kind, scalar):
    assert is_scalar(Input(kind)) is scalar


@pytest.fixture
def graph():
    return Graph(
        inputs={"picture": Input("Image"), "size": Input("int", 3), "odd": Input("Imag")},
        nodes={
            "split": Entry("Halves", arguments={"image": "$picture"}),
            "one": Entry("Const"),
            "cells": Entry("Fragile", each={"value": [1, 2]}),
            "splits": Entry("Halves", each={"image": ["made:a"]}),
            "sum": Entry("Total", arguments={"images": ["one", "split.low", "one", "$picture"]}),
            "measured": Entry("Add", arguments={"image": "one", "amount": {"from": "sum"}}),
            "gone": Entry("Gone"),
        },
    )


@pytest.mark.parametrize(
    ("text", "socket", "kind"),
    [("$picture", "", "Image"), ("split.low", "low", "Image"), ("one", "result", "Image"), ("one.result", "result", "Image"),
     ("cells", "result", "list[Image]"), ("splits.high", "high", "list[Image]")],
)  # fmt: skip
def test_a_reference_has_a_socket_and_a_type(graph, text, socket, kind):
    found = Links(graph).find((), reference(graph, (), text))
    assert (found[0], str(found[1])) == (socket, kind)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("$pictur", "unknown graph input $pictur; did you mean 'picture'?"),
        ("$size", "$size is int, which feeds parameters and no sockets"),
        ("picture", "unknown node 'picture'; the graph input is written $picture"),
        ("splt", "unknown node 'splt'; did you mean 'split'?"),
        ("split", "split (Halves) has several outputs; write one of split.low, split.high"),
        ("split.lo", "split (Halves) has no output 'lo'; did you mean 'low'?"),
        ("one.image", "one (Const) has no output 'image'; outputs: result"),
        ("gone", "nodes.gone.node: unknown node 'Gone'"),
    ],
)
def test_a_reference_that_leads_nowhere_is_told(graph, text, told):
    with pytest.raises(GraphError) as caught:
        Links(graph).type_of((), reference(graph, (), text))
    assert str(caught.value).startswith(told)


def test_a_type_that_is_unknown_is_told_at_the_input_only(graph):
    with pytest.raises(GraphError) as caught:
        Links(graph).type_of((), FromInput("odd"))
    assert caught.value.problems == ()


def test_what_flows_where(graph):
    flow = Links(graph).flow
    assert flow["sum"] == ("one", "split")
    assert flow["measured"] == ("one", "sum")
    assert flow["gone"] == flow["cells"] == ()


def test_the_order_is_topological_and_else_that_of_the_file():
    g = Graph(nodes={
        "d": Entry("Add", arguments={"image": "b"}), "a": Entry("Const"), "c": Entry("Const"),
        "b": Entry("Add", arguments={"image": "c"})})  # fmt: skip
    assert Links(g).order == ("a", "c", "b", "d")


def test_things_are_looked_up_once(graph, monkeypatch):
    asked = []
    links = Links(graph)
    monkeypatch.setattr(
        links, "entry_signature", lambda path, entry: asked.append(path) or Links.entry_signature(links, path, entry)
    )
    for _ in range(3):
        links.type_of((), FromNode("one", None))
        with pytest.raises(GraphError):
            links.signature("gone")
    assert asked == [("nodes", "one"), ("nodes", "gone")]


def test_a_function_s_name_in_place_of_the_node_s_is_seen_through():
    with pytest.raises(GraphError, match="unknown node 'halves'; did you mean 'Halves'"):
        Links(Graph(nodes={"a": Entry("halves")})).signature("a")


def test_a_sub_graph_has_the_signature_of_its_inputs_and_outputs(tmp_path):
    inner = Graph(title="Inner", nodes={"a": Entry("Add", arguments={"image": "$picture", "amount": "$by"})})
    inner.inputs = {"picture": Input("Image"), "other": Input("Image", "made:x"), "by": Input("float", 1.0)}
    inner.outputs = {"out": Output("a"), "same": Output("$picture")}
    inner.save(tmp_path / "inner.yaml")
    g = Graph(
        file=tmp_path / "outer.yaml", nodes={"one": Entry(graph="inner.yaml"), "two": Entry(graph="./inner.yaml")}
    )
    links = Links(g)
    signature = links.signature("one")
    assert signature.title == "Inner"
    assert {name: str(socket) for name, socket in signature.sockets.items()} == {
        "picture": "Image",
        "other": "Image (optional)",
    }
    assert signature.parameters == ("by",)
    assert {name: str(kind) for name, kind in signature.outputs.items()} == {"out": "Image", "same": "Image"}
    assert signature.node is signature.model is None
    assert links.signature("two").inner is signature.inner


def test_graphs_that_include_each_other_are_told_with_the_circle(tmp_path):
    for name, other in (("a", "b"), ("b", "c"), ("c", "b")):
        (tmp_path / f"{name}.yaml").write_text(
            f"graphtex: 1\nnodes:\n  n: {{graph: {other}.yaml}}\noutputs: {{o: n}}\n"
        )
    with pytest.raises(GraphError) as caught:
        load(tmp_path / "a.yaml")
    (problem,) = caught.value.problems
    assert problem.message == "graph files include each other in a circle: b.yaml -> c.yaml -> b.yaml"
    assert problem.file == str(tmp_path / "c.yaml")
