"""With ``--json`` there is one object on stdout, whatever goes wrong."""

import json
from pathlib import Path

import pytest

from tests.graphtex.cli.conftest import Command


def wrong_graph(folder: Path, text: str) -> str:
    (folder / "graph.yaml").write_text(text)
    return "graph.yaml"


@pytest.mark.parametrize(
    ("words", "path", "told"),
    [
        (["small.yaml", "--set", "value=9"], "value", "at most 2"),
        (["small.yml"], "", "is no file and no graph that ships"),
        (["small.yaml", "--workers", "two"], "graphtex run", "--workers"),
        (["small.yaml", "--dry-run", "--only", "imag"], "only", "did you mean 'image'?"),
    ],
)
def test_json_is_one_object_when_the_request_is_wrong(
    command: Command, small: Path, words: list[str], path: str, told: str
) -> None:
    answer = command("run", *words, "--json")
    made = json.loads(answer.out)
    assert (answer.status, made["status"]) == (2, "wrong")
    (problem,) = made["problems"]
    assert problem["path"] == path
    assert told in problem["message"]
    assert told in answer.err


def test_json_gives_the_place_of_a_mistake_in_a_file(command: Command, folder: Path) -> None:
    made = json.loads(command("run", wrong_graph(folder, "graphtex: 1\nnodes: {a: {node: Flot}}\n"), "--json").out)
    (problem,) = made["problems"]
    assert (problem["file"], problem["line"], problem["column"], problem["path"]) == (
        "graph.yaml", 2, 19, "nodes.a.node",
    )  # fmt: skip


def test_one_output_that_cannot_be_written_costs_no_other(command: Command, folder: Path) -> None:
    Path("graphtex-out/graph/a.num").mkdir(parents=True)
    outputs = "outputs: {a: {from: f, file: a.num}, b: {from: f, file: b.num}}\n"
    answer = command(
        "run", wrong_graph(folder, "graphtex: 1\nnodes: {f: {node: Flat, value: 1}}\n" + outputs), "--json"
    )
    made = json.loads(answer.out)
    assert (answer.status, made["status"]) == (1, "failed")
    assert made["outputs"] == {"a": [], "b": ["graphtex-out/graph/b.num"]}
    assert "graphtex-out/graph/a.num: Is a directory" in answer.err
