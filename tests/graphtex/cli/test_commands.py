"""``check``, ``show``, ``schema``, ``new``, ``cache`` and ``demo``."""

import errno
import json
import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from graphtex.shipped import shipped_names
from tests.graphtex.cli.conftest import Command


def test_check_tells_all_problems_of_all_files_and_a_summary(command: Command, small: Path, folder: Path) -> None:
    (folder / "bad.yaml").write_text("graphtex: 1\nnodes:\n  a: {node: Flat, valu: 1}\n  b: {node: Nois}\n")
    told = command("check", "bad.yaml", "small.yaml", "gone.yaml")
    assert told.status == 2
    assert told.out == "small.yaml: ok\n"
    lines = told.err.splitlines()
    assert lines[0] == "bad.yaml:3:19: nodes.a.valu: Flat has no argument 'valu'; did you mean 'value'?"
    assert lines[1] == "bad.yaml:4:13: nodes.b.node: unknown node 'Nois'; did you mean 'Noise'?"
    assert lines[2].startswith("'gone.yaml' is no file")
    assert lines[3] == "3 problems in 2 of 3 graphs"


def test_check_finds_files_that_are_missing(command: Command, folder: Path) -> None:
    text = "graphtex: 1\nnodes: {a: {node: OpenNum, path: no.num}}\noutputs: {image: {from: a, file: a.num}}\n"
    (folder / "graph.yaml").write_text(text)
    told = command("check", "graph.yaml")
    assert told.status == 2
    assert f"there is no file '{folder}/no.num'" in told.err


def test_check_takes_a_folder_and_inputs_without_default_are_no_problem(
    command: Command, small: Path, folder: Path
) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "open.yaml").write_text(small.read_text().replace("default: 0.25, ", ""))
    told = command("check", ".")
    assert (told.status, told.out.splitlines(), told.err) == (0, ["small.yaml: ok", "sub/open.yaml: ok"], "")


def test_graphs_lists_what_ships_and_tells_what_one_takes_and_makes(command: Command, small: Path) -> None:
    told = command("graphs")
    lines = told.out.splitlines()
    assert [line.split()[0] for line in lines] == shipped_names()
    assert all(len(line.split()) > 2 for line in lines)  # a title each
    told = command("graphs", "small.yaml")
    assert told.out.splitlines() == [
        "small.yaml: Small",
        "",
        "Inputs, each given by --set NAME=VALUE",
        "  value     float, 0 to 2  default 0.25",
        "  textures  list[Image]    default []",
        "",
        "Outputs",
        "  image  Image",
        "  base   Image",
    ]
    assert (
        command("graphs", "smal.yaml").err
        == "'smal.yaml' is no file and no graph that ships; did you mean 'small.yaml'?\n"
    )


def test_show_writes_by_suffix_and_prints_mermaid(command: Command, small: Path) -> None:
    assert command("show", "small.yaml").out.lstrip().startswith(("flowchart", "graph", "---", "%%"))
    assert command("show", "small.yaml", "-o", "made/graph.svg").out == "made/graph.svg\n"
    assert ElementTree.parse("made/graph.svg").getroot().tag.endswith("svg")
    command("show", "small.yaml", "--output", "graph.html")
    assert "<html" in Path("graph.html").read_text()
    command("show", "small.yaml", "-o", "graph.mmd")
    assert Path("graph.mmd").read_text().strip() == command("show", "small.yaml").out.strip()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("graph.png", "-o: nothing draws '.png'; suffixes: .html, .mmd, .svg\n"),
        ("small.yaml/graph.svg", "-o: 'small.yaml/graph.svg' cannot be written: "),
    ],
)
def test_show_refuses_what_it_cannot_write(command: Command, small: Path, name: str, message: str) -> None:
    told = command("show", "small.yaml", "-o", name)
    assert told.status == 2
    assert told.err.startswith(message)


@pytest.mark.parametrize(
    ("words", "file"),
    [
        (("show", "small.yaml", "-o", "graph.svg"), "graph.svg"),
        (("schema", "-o", "all.json"), "all.json"),
        (("new", "mine.yaml"), "mine.yaml"),
    ],
)
def test_a_full_disk_leaves_no_part_of_a_file(
    command: Command, small: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...], file: str
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    before = sorted(Path().iterdir())
    told = command(*words)
    assert told.status == 2
    assert file in told.err
    assert "cannot be written: No space left on device" in told.err
    assert sorted(Path().iterdir()) == before


def test_schema_is_printed_or_written(command: Command) -> None:
    printed = json.loads(command("schema").out)
    assert "$schema" in printed
    assert command("schema", "-o", "graph.schema.json").out == "graph.schema.json\n"
    assert json.loads(Path("graph.schema.json").read_text()) == printed


def test_new_graph_and_pack(command: Command, folder: Path) -> None:
    told = command("new", "mine.yaml")
    assert told.out == "mine.yaml\n"
    assert "graphtex run mine.yaml" in told.err
    again = command("new", "mine.yaml")
    assert again.status == 2
    assert "is there already" in again.err
    told = command("new", "my-nodes", "--in", "packs")
    assert told.status == 0
    assert "packs/my-nodes/pyproject.toml" in told.out.splitlines()
    assert "pip install -e packs/my-nodes" in told.err
    assert all(Path(line).is_file() for line in told.out.splitlines())
    assert command("new", "No Name").status == 2


def test_cache_info_prune_verify_and_clear(command: Command, small: Path, folder: Path) -> None:
    assert "results     0 node runs, 0 stored values" in command("cache", "info").out
    command("run", "small.yaml", "--cache", "mine", "--set", "value=0.4")  # three nodes, three different results
    told = command("cache", "info", "--cache", "mine").out
    assert f"folder      {folder}/mine" in told
    assert "results     3 node runs, 3 stored values" in told
    assert command("cache", "verify", "--cache", "mine").out == "6 files checked, 0 removed\n"
    assert command("cache", "prune", "--size", "1GiB", "--cache", "mine").out.startswith("removed 0 node runs and 0 ")
    assert command("cache", "clear", "--cache", "mine").out.startswith("removed 3 node runs and 3 stored values: ")
    assert "results     0 node runs" in command("cache", "info", "--cache", "mine").out


def test_a_damaged_entry_is_found_and_removed(command: Command, small: Path, folder: Path) -> None:
    command("run", "small.yaml", "--cache", "mine")
    stored = max((path for path in (folder / "mine").rglob("*.npy")), key=lambda path: path.name)
    stored.chmod(0o644)
    stored.write_bytes(stored.read_bytes()[:-1] + b"x")
    told = command("cache", "verify", "--cache", "mine")
    assert told.status == 1
    assert "2 removed" in told.out  # the value, and the record that names it
    assert command("run", "small.yaml", "--cache", "mine").status == 0


def test_wrong_sizes_are_told(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    told = command("cache", "prune", "--size", "much")
    assert told.status == 2
    assert told.err.startswith("--size: cache size: expected such as '10GiB'")
    monkeypatch.setenv("GRAPHTEX_CACHE_SIZE", "much")
    told = command("cache", "info")
    assert told.status == 2
    assert told.err.startswith("GRAPHTEX_CACHE_SIZE: ")


def test_demo_tells_where_the_pictures_are(command: Command, small: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphtex.cli.demo.GRAPH", "small.yaml")
    told = command("demo")
    assert told.status == 0
    assert told.out.splitlines() == ["graphtex-out/demo/image.num", "graphtex-out/demo/base.num"]
    assert "The pictures are in graphtex-out/demo." in told.err
    assert command("demo", "--out", "there", "--quiet").out.splitlines()[0] == "there/image.num"


def test_report_is_written_also_for_a_failed_run(command: Command, small: Path, folder: Path) -> None:
    told = command("run", "small.yaml", "--report", "there/report.html")
    assert told.status == 0
    assert "report: there/report.html" in told.err.splitlines()
    assert "<html" in Path("there/report.html").read_text()
    text = small.read_text().replace("{node: Parity, image: base}", "{node: Fussy, image: base, limit: 0.1}")
    (folder / "bad.yaml").write_text(text)
    assert command("run", "bad.yaml", "--report", "bad.html").status == 1
    assert "at most 0.1 wanted" in Path("bad.html").read_text()
