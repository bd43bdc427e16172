"""Damaged graph files: whatever is in a file, loading gives a graph or a GraphError whose problems have places."""

import random
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphtex.check import check
from graphtex.errors import GraphError
from graphtex.files import dumps, read
from graphtex.graph import load, loads
from tests.graphtex.test_schema import RIGHT, SHIPPED
from tests.graphtex.test_wrong_files import INNER

SMALL = """\
graphtex: 1
inputs:
  p: {type: Image, default: "made:x"}
  w: {type: int, default: 4, min: 1, max: 8, choices: [2, 4]}
nodes:
  n: {node: Noise, each: {width: [4, 8]}, seed: $w, on_error: keep}
  g: {graph: inner.yaml, picture: $p, level: 0.5}
  m: {node: Blend, images: n, mask: g.rough}
outputs:
  a: {from: m, file: a.tex, digits: 3}
  b: g.fine
"""
WORDS = [
    *("null", "~", "true", "no", "1e3", "-1", "0", ".nan", ".inf", "1e999", "9" * 300, "''", '""', "$w", "$p", "$"),
    *("[]", "{}", "[[]]", "{from: n}", "{from: $w}", "[n, n]", "{a: b}", "n", "m", "g.fine", "g.", ".", "..", "/"),
    *("Noise", "Image", '"list[Image]"', "list[", "int", "data", "inner.yaml", "outer.yaml", "made:y", "made:", "&a"),
    *("!!int", "<<", "|", ">", "- ", "? ", "#", "'", '"', "{", "}", "[", "]", ",", "\t", "\n", "\r", "\0", "\x85", "é"),
    *('"a\\0b"', '"\\ud800"', '"' + "long" * 100 + '"', "node", "graph", "each", "seed", "on_error", "from", "file"),
    *("$$", "a/b", "x", ":", "*a", "🧱", "type"),
]  # fmt: skip


def by_bytes(data, rng):
    """Overwrite, insert or remove a few bytes."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(changed))
        end = at + rng.choice([0, 1, 1, 3])
        changed[at:end] = bytes(
            rng.choice(b" \n\t:-,{}[]'\"$#&*!|>%@`\\01ax\x00\x80\xc3\xff") for _ in range(rng.randint(0, 2))
        )
    return bytes(changed)


def by_lines(data, rng):
    """Remove, double, swap, join or indent lines."""
    lines = data.splitlines(keepends=True)
    for _ in range(rng.randint(1, 3)):
        one, two = rng.randrange(len(lines)), rng.randrange(len(lines))
        match rng.randrange(5):
            case 0 if len(lines) > 1:
                del lines[one]
            case 1:
                lines.insert(two, lines[one])
            case 2:
                lines[one], lines[two] = lines[two], lines[one]
            case 3:
                lines[one] = lines[one].rstrip(b"\n")
            case _:
                lines[one] = b"  " + lines[one] if rng.random() < 0.5 else lines[one].removeprefix(b"  ")
    return b"".join(lines)


def by_tokens(data, rng):
    """Put other words in the place of some."""
    tokens = re.findall(r"[\w$./-]+|\s+|.", data.decode())
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(len(tokens))
        tokens[at] = rng.choice([rng.choice(WORDS), rng.choice(tokens), ""])
    return "".join(tokens).encode("utf-8", "surrogatepass")


def assert_told(error):
    assert error.problems
    for problem in error.problems:
        assert problem.message
        assert problem.line >= 1
        assert problem.column >= 1
    assert str(error)


@pytest.mark.parametrize("mutate", [by_bytes, by_lines, by_tokens])
def test_mutated_files(mutate, tmp_path, small_pack):
    """700 files for each kind of damage."""
    (tmp_path / "inner.yaml").write_text(INNER)
    path = tmp_path / "outer.yaml"
    rng = random.Random(f"seed of {mutate.__name__}")
    originals = [SMALL.encode(), SMALL.encode(), SMALL.encode(), INNER.encode(), RIGHT.encode()]
    loaded = 0
    for _ in range(700):
        path.write_bytes(mutate(rng.choice(originals), rng))
        try:
            graph = load(path)
        except GraphError as error:
            assert_told(error)
            continue
        loaded += 1
        assert read(dumps(graph)) == (graph, [])
    assert 10 < loaded < 400  # the damage is neither always harmless nor always the end of all structure


def test_mutated_shipped_files():
    """Damage to real graphs, checked with the real nodes."""
    rng = random.Random("shipped")
    for path in SHIPPED:
        for mutate in (by_bytes, by_lines, by_tokens):
            text = mutate(path.read_bytes(), rng).decode(errors="replace")
            graph, problems = read(text, path)
            if graph is not None:
                problems = problems + check(graph)
            assert all(problem.message for problem in problems)


YAMLISH = st.lists(
    st.sampled_from(
        ["\n", "\n  ", "\n    ", " ", ": ", "- ", ", ", "graphtex: 1\n", "nodes:\n  ", "inputs:\n  ", "outputs:\n  "]
    )
    | st.sampled_from(WORDS)
    | st.text(max_size=4),
    max_size=40,
).map("".join)


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(YAMLISH)
def test_text_that_resembles_yaml(small_pack, text):
    try:
        loads(text)
    except GraphError as error:
        assert_told(error)


PARTS = st.sampled_from(WORDS)
FLOW = st.recursive(
    PARTS,
    lambda inner: (
        st.lists(inner, max_size=3).map(lambda items: f"[{', '.join(items)}]")
        | st.dictionaries(PARTS, inner, max_size=3).map(
            lambda d: "{" + ", ".join(f"{k}: {v}" for k, v in d.items()) + "}"
        )
    ),
    max_leaves=6,
)
KEYS = st.sampled_from(
    ["node", "graph", "width", "image", "images", "mask", "level", "text", "strokes", "each", "seed", "on_error"]
)
INPUT_KEYS = st.sampled_from(["type", "default", "min", "max", "choices", "description"])


def entries(keys):
    return st.dictionaries(keys, FLOW, max_size=5).map(
        lambda d: "{" + ", ".join(f"{k}: {v}" for k, v in d.items()) + "}"
    )


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(entries(INPUT_KEYS), entries(KEYS), entries(KEYS), entries(st.sampled_from(["from", "file", "digits"])))
def test_any_values_in_right_places(small_pack, one, two, three, four):
    """The document is in order, so that checks of meaning see every kind of value."""
    nodes = f"nodes:\n  n: {{node: Noise, width: 4}}\n  m: {two}\n  l: {three}\n"
    try:
        loads(f"graphtex: 1\ninputs:\n  w: {one}\n{nodes}outputs:\n  o: {four}\n")
    except GraphError as error:
        assert_told(error)


@pytest.mark.parametrize(
    "text",
    [
        "graphtex: 1\nnodes: " + "{a: " * 5000,
        "graphtex: 1\nnodes:\n" + "".join(f"{' ' * i}a:\n" for i in range(300)),
        "&a [" + "*a, " * 10_000 + "]",
        "a: " + "x" * 900_000,
        "k" * 900_000 + ": 1",
        "'" * 200_000,
        "? " * 100_000,
        "!" * 100_000,
        "- " * 30 + "a\n" * 50_000,
        '"' + "\\x41" * 200_000 + '"',
        "graphtex: 1\nnodes: {" + "a: 1, " * 20_000 + "}",
    ],
    ids=lambda text: text[:20],
)
def test_large_nonsense(text, small_pack):
    """Bombs of every kind end in an error."""
    with pytest.raises(GraphError) as caught:
        loads(text)
    assert_told(caught.value)
