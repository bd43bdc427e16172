from pathlib import Path

import pytest

from graphtex.document import REQUIRED, Entry, Input, Output
from graphtex.files import read
from graphtex.graph import Graph

WHOLE = """\
graphtex: 1
title: Perspective
source: Dong, Zhou & Paul 2008, Fig. 1
description: |
  Two
  lines
seed: 7
inputs:
  exemplar: {type: Image, default: "sample:pebbles", open: {alpha: drop}, description: what to copy}
  width: {type: int, default: 512, min: 1, max: 4096.5}
  method: {type: str, choices: [ridges, "no", no]}
nodes:
  mask: {node: FeatureMask, image: $exemplar, method: $method}
  sweep:
    node: FeatureScale
    mask: mask
    price: $$5
    points: [[1, 2.0], {from: mask}]
    each: {window: [8, 16], seed: [1, 2]}
    on_error: keep
  part: {graph: ../splice.yaml, elements: [mask, sweep.result], seed: $s}
outputs:
  image: mask
  scale: {from: sweep, file: scale.png, depth: 16}
"""


def test_whole_file():
    graph, problems = read(WHOLE, Path("some/graph.yaml"))
    assert problems == []
    assert graph == Graph(
        title="Perspective",
        source="Dong, Zhou & Paul 2008, Fig. 1",
        description="Two\nlines\n",
        seed=7,
        inputs={
            "exemplar": Input("Image", "sample:pebbles", description="what to copy", open={"alpha": "drop"}),
            "width": Input("int", 512, 1, 4096.5),
            "method": Input("str", REQUIRED, choices=("ridges", "no", "no")),
        },
        nodes={
            "mask": Entry("FeatureMask", arguments={"image": "$exemplar", "method": "$method"}),
            "sweep": Entry(
                "FeatureScale",
                arguments={"mask": "mask", "price": "$$5", "points": [[1, 2.0], {"from": "mask"}]},
                each={"window": [8, 16], "seed": [1, 2]},
                on_error="keep",
            ),
            "part": Entry(graph="../splice.yaml", arguments={"elements": ["mask", "sweep.result"]}, seed="$s"),
        },
        outputs={"image": Output("mask"), "scale": Output("sweep", "scale.png", {"depth": 16})},
    )
    assert graph.file == Path("some/graph.yaml")
    assert graph.places["nodes", "part", "elements", 1] == (21, 50)
    assert graph.key_places["nodes", "sweep", "each", "seed"] == (19, 29)


def test_order_of_nodes_and_arguments_is_kept():
    graph, _ = read("graphtex: 1\nnodes:\n  z: {c: 1, node: X, a: 2}\n  a: {node: X}\n")
    assert graph is not None
    assert list(graph.nodes) == ["z", "a"]
    assert list(graph.nodes["z"].arguments) == ["c", "a"]


def test_sections_may_be_left_empty():
    graph, problems = read("graphtex: 1\ninputs:\n  # none yet\nnodes:\n  a: {node: X}\noutputs:\n")
    assert graph == Graph(nodes={"a": Entry("X")})
    assert problems == []


def test_a_wrong_part_leaves_the_rest_to_be_checked():
    graph, problems = read(
        "graphtex: 1\ninputs: {a: 5}\nnodes:\n  x: [1]\n  y: {node: B, seed: 3}\noutputs: {o: [x]}\n"
    )
    assert graph == Graph(inputs={"a": Input("")}, nodes={"x": Entry(), "y": Entry("B", seed=3)})
    assert [(p.line, p.column) for p in problems] == [(2, 13), (4, 6), (6, 14)]


def test_what_follows_from_broken_yaml_is_not_told_twice():
    """An alias has no value; that its place holds no text follows from that."""
    _, problems = read("graphtex: 1\ntitle: *t\nnodes: {a: {node: X}}\n")
    assert [p.path for p in problems] == ["title"]
    assert "aliases" in problems[0].message


def test_problems_name_file_place_and_path():
    _, problems = read("graphtex: 1\nseed: -1\nnodes: {a: {node: X}}\n", Path("a/b.yaml"))
    assert str(problems[0]) == "a/b.yaml:2:7: seed: a seed is a whole number from 0, got the number -1"


@pytest.mark.parametrize("text", ["", "\n# only a comment\n", "---\n", "graphtex", "- a\n- b\n", "5", "graphtex:1"])
def test_no_mapping_is_no_graph(text):
    graph, problems = read(text)
    assert graph is None
    assert len(problems) == 1
    assert "begins with `graphtex: 1`" in problems[0].message


def test_broken_yaml_is_no_graph():
    graph, problems = read("graphtex: 1\nnodes: {a: {node: X}\n")
    assert graph is None
    assert [(p.line, p.column) for p in problems] == [(2, 8)]
