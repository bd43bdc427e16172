"""``graphtex why``."""

from pathlib import Path

from tests.graphtex.cli.conftest import SMALL, Command


def test_a_node_that_never_ran(command: Command, small: Path) -> None:
    told = command("why", "small.yaml", "base")
    assert (told.status, told.out) == (0, "base: runs: not run before\n")


def test_nothing_changed(command: Command, small: Path) -> None:
    command("run", "small.yaml")
    assert command("why", "small.yaml", "lit").out == "lit: cached: nothing changed\n"


def test_old_and_new_value_of_what_changed(command: Command, small: Path) -> None:
    command("run", "small.yaml")
    told = command("why", "small.yaml", "base", "--set", "value=0.5")
    assert told.out.splitlines() == ["base: runs; since the last run changed", "  parameter value: 0.25 -> 0.5"]


def test_the_node_upstream_that_decides_and_the_node_s_own_change(command: Command, small: Path) -> None:
    command("run", "small.yaml")
    told = command("why", "small.yaml", "lit", "--set", "value=0.5")
    assert told.out == "lit: runs unless its input comes out equal: base runs and decides\n"
    small.write_text(SMALL.replace("by: 0.25", "by: 0.5"))
    assert command("why", "small.yaml", "lit", "--set", "value=0.5").out.splitlines() == [
        "lit: runs unless its input comes out equal: base runs and decides; besides, since the last run changed",
        "  parameter by: 0.25 -> 0.5",
    ]


def test_a_result_from_before_the_last_run(command: Command, small: Path) -> None:
    command("run", "small.yaml")
    command("run", "small.yaml", "--set", "value=0.75")
    assert command("why", "small.yaml", "base").out.splitlines() == [
        "base: cached, from before the last run; since the last run changed",
        "  parameter value: 0.75 -> 0.25",
    ]


def test_a_result_that_is_gone(command: Command, small: Path) -> None:
    command("run", "small.yaml")
    command("cache", "prune", "--size", "0")
    assert command("why", "small.yaml", "base").out == "base: runs: its result is not stored\n"


def test_a_change_of_seed(command: Command, folder: Path) -> None:
    text = "graphtex: 1\nseed: 1\nnodes: {a: {node: Noise}}\noutputs: {image: {from: a, file: a.num}}\n"
    (folder / "graph.yaml").write_text(text)
    command("run", "graph.yaml")
    told = command("why", "graph.yaml", "a", "--seed", "2")
    assert told.out.splitlines()[0] == "a: runs; since the last run changed"
    assert told.out.splitlines()[1].startswith("  random stream (seed): [1,")


def test_cells_are_told_of_one_by_one(command: Command, folder: Path) -> None:
    (folder / "graph.yaml").write_text(
        "graphtex: 1\nnodes: {a: {node: Flat, each: {value: [0, 1]}}}\noutputs: {image: {from: a, file: a.num}}\n"
    )
    assert command("why", "graph.yaml", "a").out.splitlines() == [
        "a[0]: runs: not run before",
        "a[1]: runs: not run before",
    ]
    assert command("why", "graph.yaml", "a[1]").out.splitlines() == ["a[1]: runs: not run before"]


def test_an_unknown_node(command: Command, small: Path) -> None:
    told = command("why", "small.yaml", "bas")
    assert (told.status, told.err) == (2, "the graph has no node 'bas'; did you mean 'base'?\n")


def test_an_input_stands_for_what_opens_it(command: Command, folder: Path) -> None:
    (folder / "a.num").write_text("0.5\n")
    (folder / "graph.yaml").write_text(
        "graphtex: 1\ninputs:\n  photo: {type: Image, default: a.num}\n"
        "nodes: {b: {node: Parity, image: $photo}}\noutputs: {image: {from: b, file: b.num}}\n"
    )
    assert command("why", "graph.yaml", "photo").out == "$photo: runs: not run before\n"
    assert command("why", "graph.yaml", "$photo").out == "$photo: runs: not run before\n"
    command("run", "graph.yaml")
    (folder / "a.num").write_text("0.6\n")
    told = command("why", "graph.yaml", "photo").out.splitlines()
    assert told[0] == "$photo: runs; since the last run changed"
    assert told[1] == "  content of parameter path has changed"
