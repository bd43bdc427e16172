import math
import re
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphtex.document import REQUIRED, SCALAR_TYPES, Document, Entry, Input, Output
from graphtex.errors import GraphError
from graphtex.files import dumps, read, read_file
from graphtex.node import RESERVED

CANONICAL = """\
graphtex: 1
title: Perspective-aware synthesis from a feature mask
source: Dong, Zhou & Paul 2008, Fig. 1
description: |
  Several lines
    with their indentation

  and an empty one.
seed: 7
inputs:
  exemplar: {type: Image, default: "sample:pebbles", open: {encoding: raw}}
  width: {type: int, default: 512, min: 1, max: 4096}
  method: {type: str, default: "no", choices: ["no", ridges, "12:30", "1e3"]}
  pictures: {type: "list[Image]", default: []}
nodes:
  mask: {node: FeatureMask, image: $exemplar, method: $method}
  scale: {node: FeatureScale, mask: mask, gain: 2.0, limit: 1.0e+300, each: {window: [8, 16]}, on_error: keep}
  montage:
    node: Montage
    base: scale
    label: a, b
    strokes:
      - {points: [[10, 10.5], [20, 30], [40, 50], [60, 70], [80, 90]], radius: 4, softness: 0.5, label: background}
      - points:
          - [100000000, 1000000000, 1000000000, 10000000000, 10000000000, 1000000000, 10000000000, 10000000, 1000]
          - []
        label: a label that would not have fitted on one line together with all of the points in front of it
        radius: {}
    seed: $seed
outputs:
  image: montage.image
  scale: {from: scale, file: scale.exr, depth: 16}
"""


def test_canonical_form():
    """The text above is a fixed point, and shows every layout."""
    graph, problems = read(CANONICAL)
    assert problems == []
    assert graph is not None
    assert dumps(graph) == CANONICAL


def test_smallest():
    assert dumps(Document(nodes={"a": Entry("X")})) == "graphtex: 1\nnodes:\n  a: {node: X}\n"


def test_lines_are_at_most_120_columns_unless_a_single_value_is_longer():
    graph = Document(nodes={f"n{i}": Entry("N", arguments={"items": list(range(10**i, 10**i + 30))}) for i in range(6)})
    assert max(len(line) for line in dumps(graph).splitlines()) <= 120


@pytest.mark.parametrize(
    ("text", "written"),
    [
        *[(word, f'"{word}"') for word in ("no", "On", "y", "null", "~", "", "true", "1", "1e3", "0x1F", ".inf", "-")],
        *[
            (word, f'"{word}"')
            for word in ("12:30", "2024-01-01", "a: b", "a #b", " a", "a ", "*.png", "@a", "!a", "&")
        ],
        *[(word, f'"{word}"') for word in ("- a", "? a", "|", "%a", "`a", "[a", "{a", "'a", "=", "<<")],
        ('say "a\\b"', 'say "a\\b"'),
        ('"a\\b"', '"\\"a\\\\b\\""'),
        ("$exemplar", "$exemplar"),
        ("$$5", "$$5"),
        ("größe 石", "größe 石"),
        ("a\tb", '"a\\tb"'),
        ("a\u2028b", '"a\\u2028b"'),
        ("a\x85b", '"a\\x85b"'),
        ("\U000e0001", '"\\U000e0001"'),
        ("a, b [c]?", "a, b [c]?"),
        ("\n", '"\\n"'),
        ("a\n", "|\n  a"),
        ("a\nb", "|-\n  a\n  b"),
        (" a\nb", '" a\\nb"'),
        ("a\n\n", '"a\\n\\n"'),
    ],
)
def test_text_is_quoted_where_it_would_be_read_as_something_else(text, written):
    graph = Document(source=text, nodes={"a": Entry("X")})
    expected = f"source: {written}\n" if text else ""
    assert dumps(graph) == f"graphtex: 1\n{expected}nodes:\n  a: {{node: X}}\n"
    assert read(dumps(graph)) == (graph, [])


def test_text_with_brackets_is_quoted_inside_of_braces():
    assert 'label: "a, b [c]?"' in dumps(Document(nodes={"a": Entry("X", arguments={"label": "a, b [c]?"})}))


@pytest.mark.parametrize(
    ("number", "written"),
    [
        *[(1, "1"), (1.0, "1.0"), (-0.0, "-0.0"), (0, "0"), (1e300, "1.0e+300"), (1.5e-7, "1.5e-07"), (0.1, "0.1")],
        *[(math.inf, ".inf"), (-math.inf, "-.inf"), (math.nan, ".nan"), (10**30, "1" + "0" * 30), (True, "true")],
    ],
)
def test_numbers(number, written):
    graph = Document(nodes={"a": Entry("X", arguments={"value": number})})
    text = dumps(graph)
    assert f"value: {written}}}" in text
    again, _ = read(text)
    assert again is not None
    assert repr(again.nodes["a"].arguments["value"]) == repr(number)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (Entry("X", arguments={"a": object()}), "nodes.a.a: no plain data: object"),
        (Entry("X", arguments={"a": [{"b": np.zeros(2)}]}), "nodes.a.a.0.b: no plain data: ndarray"),
        (Entry("X", arguments={"a": np.float64(1)}), "no plain data: float64"),
        (Entry("X", arguments={"a": {1: 2}}), "nodes.a.a: a key is text of at most 100 characters, got 1"),
        (Entry("X", arguments={"a": {"k" * 101: 2}}), "a key is text of at most 100 characters"),
        (Entry("X", arguments={"a": "\ud800"}), "half of a surrogate pair"),
        (Entry("X", arguments={"a": "x" * 100_001}), "100001 characters"),
        (Entry("X", arguments={"a": 10**5000}), "a number of more than 250 digits"),
        (Entry("X", arguments={"seed": 1}), "nodes.a: 'seed' is a reserved word"),
        (Entry("X", arguments={"node": "Y"}), "'node' is a reserved word"),
        (Entry(), "expected `node: <name>` or `graph: <file>`, got neither"),
        (Entry("X", "y.yaml"), "either a `node` or a `graph`"),
    ],
)
def test_refuses_what_no_file_can_hold(entry, message):
    with pytest.raises(GraphError, match=re.escape(message)):
        dumps(Document(nodes={"a": entry}))


def test_refuses_what_is_too_deep():
    value = []
    for _ in range(60):
        value = [value]
    with pytest.raises(GraphError, match="nested deeper than 50 levels"):
        dumps(Document(nodes={"a": Entry("X", arguments={"a": value})}))


def test_the_deepest_that_is_read_is_written():
    value = []
    for _ in range(46):  # and four levels above it: document, nodes, entry, argument
        value = [value]
    graph = Document(nodes={"a": Entry("X", arguments={"a": value})})
    assert read(dumps(graph)) == (graph, [])


def test_refuses_names_that_are_none():
    with pytest.raises(GraphError, match="a name is letters, digits"):
        dumps(Document(nodes={"a b": Entry("X")}))


NAMES = st.from_regex(r"[A-Za-z_][A-Za-z0-9_-]{0,12}", fullmatch=True)
TEXTS = (
    st.text(max_size=30)
    | st.sampled_from(["no", "on", "null", "~", "1e3", "0o17", "12:30", "$x", "$$", "$", "a: b", "x\ny\n", "\n", "- a"])
    | st.text(alphabet=":#,[]{}&*!|>'\"%@`?- \n\tab1é石🧱\x85\u2028", max_size=150)
)
NUMBERS = st.integers() | st.integers(-(10**200), 10**200) | st.floats(allow_nan=False)
PLAIN = st.recursive(
    st.none() | st.booleans() | NUMBERS | TEXTS,
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=20), inner, max_size=5),
    max_leaves=20,
)
FREE = NAMES.filter(lambda name: name not in RESERVED | {"from", "file"})
SOME_TEXT = TEXTS.filter(bool)
INPUTS = st.builds(
    Input,
    st.sampled_from([*SCALAR_TYPES, "Image", "list[Image]", "list[int]"]),
    st.just(REQUIRED) | PLAIN,
    st.none() | st.integers(-5, 5) | st.floats(-5, 5),
    st.none() | st.integers(-5, 5) | st.floats(-5, 5),
    st.none() | st.lists(PLAIN, min_size=1, max_size=3).map(tuple),
    TEXTS,
)
ARGUMENTS = st.dictionaries(FREE, PLAIN, max_size=4)
WORDS = st.sampled_from(["stop", "keep"])
ENTRIES = st.builds(Entry, SOME_TEXT, st.just(""), ARGUMENTS, ARGUMENTS, st.none() | st.integers(0) | SOME_TEXT, WORDS)
ENTRIES |= st.builds(Entry, st.just(""), SOME_TEXT, ARGUMENTS, ARGUMENTS, st.none() | st.integers(0), WORDS)
OUTPUTS = st.builds(Output, SOME_TEXT, st.none() | SOME_TEXT, ARGUMENTS)
GRAPHS = st.builds(
    Document,
    title=TEXTS,
    source=TEXTS,
    seed=st.integers(0, 10**100),
    description=TEXTS,
    inputs=st.dictionaries(NAMES, INPUTS, max_size=3),
    nodes=st.dictionaries(NAMES, ENTRIES, max_size=3),
    outputs=st.dictionaries(NAMES, OUTPUTS, max_size=3),
)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(GRAPHS)
def test_round_trip_is_exact(graph):
    """Equal also in repr: floats stay floats, -0.0 keeps its sign, keys their order."""
    text = dumps(graph)
    again, problems = read(text)
    assert problems == []
    assert again == graph
    assert repr(again) == repr(graph)
    assert dumps(again) == text


@settings(max_examples=60, deadline=None)
@given(PLAIN)
def test_other_readers_agree(value):
    """PyYAML, a reader of YAML 1.1, takes what is written for the same data."""
    text = dumps(Document(nodes={"a": Entry("X", arguments={"value": value})}))
    assert repr(yaml.safe_load(text)["nodes"]["a"].get("value")) == repr(value)


def test_shipped_graphs_survive():
    """What is read from a file that was written by hand is what is read from its canonical form."""
    for path in sorted((Path(__file__).parents[3] / "graphs").rglob("*.yaml")):
        graph, problems = read_file(path)
        assert problems == []
        assert graph is not None
        assert read(dumps(graph)) == (graph, [])
