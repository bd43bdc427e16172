"""The first format is the only one, so the mechanism is tried on formats that were never published."""

import pytest

from graphtex.document import FORMAT, Entry
from graphtex.files import read
from graphtex.files.migrations import STEPS, bring_up


def rename_steps(document):
    """Format 0: `steps` was the name of `nodes`."""
    return {"nodes" if key == "steps" else key: value for key, value in document.items()}


def name_operations(document):
    """Format -1: `op` was the name of `node`."""
    steps = {name: {"node" if k == "op" else k: v for k, v in e.items()} for name, e in document["steps"].items()}
    return {**document, "steps": steps}


OLD = {0: rename_steps, -1: name_operations}


def test_no_step_is_missing():
    assert sorted(STEPS) == list(range(FORMAT - len(STEPS), FORMAT))


def test_the_present_format_stays():
    document = {"graphtex": 1, "steps": {}}
    assert bring_up(document, 1, OLD) is document


def test_steps_run_in_order():
    old = {"graphtex": -1, "steps": {"a": {"op": "X"}}}
    assert bring_up(old, -1, OLD) == {"graphtex": 1, "nodes": {"a": {"node": "X"}}}
    assert old == {"graphtex": -1, "steps": {"a": {"op": "X"}}}


def test_an_old_file_reads_as_the_new_one():
    graph, problems = read("graphtex: 0\nsteps: {a: {node: X}}\n", steps=OLD)
    assert problems == []
    assert graph is not None
    assert graph.nodes == {"a": Entry("X")}


def test_an_error_in_an_old_file_is_told_at_the_nearest_known_place():
    _, problems = read("graphtex: 0\nsteps:\n  a: {seed: 1}\n", steps=OLD)
    assert [(p.line, p.path) for p in problems] == [(1, "nodes.a")]


@pytest.mark.parametrize(
    ("version", "message"),
    [
        (2, "this file needs a newer graphtex: it has format 2, known is format 1"),
        (0, "there is no format 0; known is format 1"),
        (-(10**200), "known is format 1"),
    ],
)
def test_unknown_formats(version, message):
    graph, problems = read(f"graphtex: {version}\nfuture: true\n")
    assert graph is None
    assert [(p.line, p.column) for p in problems] == [(1, 11)]
    assert message in problems[0].message


def test_known_formats_are_named():
    with pytest.raises(ValueError, match=r"no format -2; known are formats -1 to 1"):
        bring_up({}, -2, OLD)
