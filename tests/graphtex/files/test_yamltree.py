import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graphtex.files.scalars import resolve
from graphtex.files.yamltree import MAX_DEPTH, MAX_SIZE, described, parse


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *[(word, word) for word in ("no", "on", "Yes", "off", "y", "nULL", "tRUE", "12:30", "190:20:30", "2024-01-01")],
        *[
            (word, word)
            for word in ("0b101", "1_000", "0o8", "0xG", "-0x1F", "+0o7", "1e", "e3", ".", "+", "-", "1.2.3")
        ],
        *[(word, word) for word in ("inf", "nan", "Infinity", "- .inf", "=", "١٢")],
        *[(word, None) for word in ("", "~", "null", "Null", "NULL")],
        *[(word, True) for word in ("true", "True", "TRUE")],
        *[(word, False) for word in ("false", "False", "FALSE")],
        *[("0", 0), ("-0", 0), ("0777", 777), ("+12", 12), ("-19", -19), ("0o17", 15), ("0x1F", 31)],
        *[("1e3", 1000.0), ("1.", 1.0), (".5", 0.5), ("-.5E-1", -0.05), ("+1.5", 1.5), ("12e03", 12000.0)],
        *[(".inf", math.inf), ("+.Inf", math.inf), ("-.INF", -math.inf)],
    ],
)
def test_core_schema(text, value):
    """Scalars of YAML 1.2.2, section 10.3.2, and words that only YAML 1.1 takes for more than text."""
    got, fault = resolve(text)
    assert (got, type(got), fault) == (value, type(value), "")


def test_not_a_number():
    assert all(math.isnan(resolve(word)[0]) for word in (".nan", ".NaN", ".NAN"))


def test_negative_zero_keeps_its_sign():
    assert math.copysign(1, resolve("-0.0")[0]) == -1


def test_marks_of_keys_values_and_items():
    tree = parse("nodes:\n  mask: {node: A, window:  32}\n  b:\n    images: [x,\n      y]\n    none:\n")
    assert tree.data == {"nodes": {"mask": {"node": "A", "window": 32}, "b": {"images": ["x", "y"], "none": None}}}
    assert tree.places[()] == (1, 1)
    assert tree.places["nodes",] == (2, 3)
    assert tree.places["nodes", "mask"] == (2, 9)
    assert tree.places["nodes", "mask", "window"] == (2, 28)
    assert tree.places["nodes", "b", "images", 1] == (5, 7)
    assert tree.places["nodes", "b", "none"] == (6, 10)
    assert tree.key_places["nodes",] == (1, 1)
    assert tree.key_places["nodes", "mask", "window"] == (2, 19)
    assert not tree.problems


def test_columns_count_characters_and_every_kind_of_line_break():
    tree = parse("a: 1\r\nb: 2\rc: {größe🧱: [1, x]}\n")
    assert tree.key_places["c",] == (3, 1)
    assert tree.places["c", "größe🧱", 1] == (3, 17)


def test_a_byte_order_mark_is_passed_over():
    assert parse("\ufeffa: 1").places["a",] == (1, 4)


def test_quotes_and_blocks_are_always_text():
    assert parse("[\"1\", '~', \"no\", 'a''b', \"\\x41\\u00e9\\U0001f9f1\\/\"]").data == [
        "1",
        "~",
        "no",
        "a'b",
        "Aé🧱/",
    ]
    assert parse("a: |\n  12\nb: >-\n  x\n  y\n").data == {"a": "12\n", "b": "x y"}


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("a: 1\nb: 2\na: 3\n", 3, 1, "the key 'a' is there twice, first at 1:1"),
        ("a: {b: 1, 'b': 2}", 1, 11, "a.b: the key 'b' is there twice, first at 1:5"),
        ("1: x", 1, 1, "a key is text, got the number 1; quote it"),
        ("{a: {true: x}}", 1, 6, "a: a key is text, got true; quote it"),
        ("~: x", 1, 1, "a key is text, got nothing"),
        ("{[a]: b}", 1, 2, "a key is text, got a list"),
        ("a: {{size}}", 1, 5, "a key is text, got a mapping; text with braces needs quotes"),
        ("k" * 101 + ": 1", 1, 1, "a key has at most 100 characters, got 101"),
        ("<<: {a: 1}", 1, 1, "merge keys"),
        ("a: !!python/object/apply:os.system [ls]", 1, 4, "got !!python/object/apply:os.system"),
        ("a: !local x", 1, 4, "tags are not part of a graph file, got !local"),
        ("a: !!str 1", 1, 4, "got !!str"),
        ("a: &x {b: 1}", 1, 4, "anchors and aliases are not part of a graph file"),
        ("a: 1\nb: *a", 2, 4, "(*a)"),
        ("*a : 1", 1, 1, "(*a)"),
        ("a: 1\n---\nb: 2", 2, 1, "a second document"),
        ("a: 1e999", 1, 4, "1e999 is too large"),
        ("a: " + "9" * 251, 1, 4, "a number of 251 digits"),
        ("a: " + "x" * 100_001, 1, 4, "100001 characters in one value"),
        ('a: "\\ud83e\\uddf1"', 1, 4, "half of a surrogate pair"),
        ("a: x\x07", 1, 5, "a control character, U+0007"),
        ("a: 'b\u2028c'", 1, 6, "written \\u2028"),
        ("a: 1\n\ufeffb: 2", 2, 1, "U+FEFF"),
        ("a: \ud800", 1, 4, "half of a surrogate pair"),
        ("a: " + "[" * 60, 1, 4 + MAX_DEPTH - 1, "nested deeper than 50 levels"),
        ("{a: " * 100_000, 1, 1 + 4 * MAX_DEPTH, "nested deeper than 50 levels"),
        ("- " * 100_000, 1, 1 + 2 * MAX_DEPTH, "nested deeper than 50 levels"),
        ("#" * (MAX_SIZE + 1), 0, 0, "longer than 1048576 characters"),
    ],
)
def test_refuses(text, line, column, message):
    """Valid YAML that a graph file must not hold."""
    first = parse(text).problems[0]
    assert (first.line, first.column) == (line, column)
    assert message in str(first)


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("a: 'x\nb: 1", 1, 4, "this quoted text is not closed"),
        ('a: "x\n---\n', 1, 4, "this quoted text is not closed"),
        ("a: {b: [1, 2}", 1, 13, "expected ',' or ']' of the list that begins at 1:8, got '}'"),
        ("a: {b: 1\n", 1, 4, "this '{' is not closed by '}'"),
        ("a: {b: 1\nc: {d: 2}\n", 2, 2, "expected ',' or '}' of the mapping that begins at 1:4, got ':'"),
        ("a: {type: list[Image]}", 1, 15, 'as in type: "list[Image]"'),
        ("a: [1,, 2]", 1, 7, "expected a value, got ','"),
        ("a: b]\nc: ]", 2, 4, "expected a value, got ']'"),
        ("\ta: 1", 1, 1, "a tab; YAML is indented and separated by spaces"),
        ("a:\n\tb: 1", 2, 1, "a tab"),
        ("a: @x", 1, 4, "text that begins with '@' needs quotes"),
        ("a: *.png", 1, 4, "text that begins with '*' needs quotes"),
        ("a: & b", 1, 4, "text that begins with '&' needs quotes"),
        ("a: !<b", 1, 4, "text that begins with '!' needs quotes"),
        ("a: |b", 1, 5, "text that begins with '|' or '>' needs quotes"),
        ("title: Stone: a study", 1, 13, "text with ': ' in it needs quotes"),
        ("a: 1\n  b: 2", 2, 4, "lines of one mapping or list begin in the same column"),
        ("a:\n    b: 1\n  c: 2", 3, 3, "the indentation does not fit: got a mapping here"),
        ("a: - 1", 1, 4, "a list does not begin here"),
        ("a: 1\nb\n", 2, 1, "found no ':' behind the name"),
        ('a: "C:\\dir"', 1, 8, "a backslash is written \\\\"),
        ('a: "\\UFFFFFFFF"', 1, 7, "an escape that stands for no character"),
        ("{a: 1}}", 1, 7, "the document has ended before this"),
        ("%YAML 2.0\n---\na: 1", 1, 1, "incompatible YAML document"),
    ],
)
def test_explains_what_is_no_yaml(text, line, column, message):
    tree = parse(text)
    last = tree.problems[-1]
    assert not tree.complete
    assert (last.line, last.column) == (line, column)
    assert message in last.message


def test_all_problems_are_told():
    tree = parse("a: &x 1\n1: !t 2\nb: *x\nb: {c: 1, c: 2}\n")
    assert [(p.line, p.column) for p in tree.problems] == [(1, 4), (2, 1), (2, 4), (3, 4), (4, 1), (4, 11)]


def test_first_of_two_keys_stays():
    tree = parse("a: {x: 1}\na: {x: 2, y: 3}\n")
    assert tree.data == {"a": {"x": 1}}
    assert tree.places["a", "x"] == (1, 8)
    assert ("a", "y") not in tree.places


def test_unprintable_characters_are_not_listed_without_end():
    assert len(parse("\x00" * 1000).problems) == 20


LETTERS = st.characters(exclude_categories=["Cc", "Cs", "Cn", "Zl", "Zp"], exclude_characters="\ufeff") | st.just("\n")
TEXT = st.text(LETTERS, max_size=100)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | TEXT,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(TEXT, inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=150, deadline=None)
@given(JSON, st.sampled_from([None, 2]))
def test_json_is_yaml(value, indent):
    """Another writer: JSON is a part of YAML 1.2."""
    tree = parse(json.dumps(value, ensure_ascii=False, indent=indent))
    assert tree.problems == []
    assert repr(tree.data) == repr(value)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (None, "nothing"),
        (True, "true"),
        (1.5, "the number 1.5"),
        ("x", "the text 'x'"),
        ([1], "a list of 1"),
        ({}, "{}"),
        ({"a": 1, "b": 2, "c": 3, "d": 4}, "a mapping with a, b, c, ..."),
    ],
)
def test_described(value, words):
    assert described(value) == words


def test_long_text_is_cut():
    assert len(described("x" * 500)) < 80
