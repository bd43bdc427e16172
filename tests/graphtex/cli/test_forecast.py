"""What a dry run tells of graphs with many tasks."""

import json
from pathlib import Path

from tests.graphtex.cli.conftest import Command


def forecast(command: Command, folder: Path, nodes: str, output: str) -> dict[str, str]:
    (folder / "graph.yaml").write_text(
        f"graphtex: 1\nnodes:\n{nodes}outputs: {{image: {{from: {output}, file: a.num}}}}\n"
    )
    told = json.loads(command("run", "graph.yaml", "--dry-run", "--json").out)
    assert told["status"] == "done"
    found = told["nodes"]
    return {node["id"]: node["why"] for node in found}


def test_all_that_decide_are_named_in_order_a_long_list_is_cut(command: Command, folder: Path) -> None:
    flats = "".join(f"  f{i}: {{node: Flat, value: {i / 100}}}\n" for i in range(20))
    signs = "".join(f"  s{i}: {{node: Parity, image: f{i}}}\n" for i in range(20))
    names = ", ".join(f"s{i}" for i in range(20))
    rows = f"  two: {{node: Row, images: [s1, f0]}}\n  all: {{node: Row, images: [two, {names}]}}\n"
    why = forecast(command, folder, flats + signs + rows, "all")
    assert why["s3"] == "not run before; f3 decides"
    assert why["two"] == "not run before; f0, f1 decide"
    assert why["all"].startswith("not run before; f0, f1, f2, ")
    assert why["all"].endswith(" and 8 more decide")


def test_a_long_chain_is_told_node_by_node(command: Command, folder: Path) -> None:
    """With a walk up from each node this would take minutes."""
    chain = "".join(f"  n{i}: {{node: Parity, image: n{i + 1}}}\n" for i in range(1500))
    why = forecast(command, folder, f"{chain}  n1500: {{node: Flat}}\n", "n0")
    assert len(why) == 1501
    assert why["n0"] == why["n1499"] == "not run before; n1500 decides"
