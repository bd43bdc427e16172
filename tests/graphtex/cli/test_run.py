"""``graphtex run`` in this process: outputs, statuses, messages, JSON, dry run."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.graphtex.cli.conftest import Command

GRAPH = """\
graphtex: 1
inputs:
  limit: {{type: float, default: 0.2}}
nodes:
  base: {{node: Flat, value: 0.5}}
  other: {{node: Flat, value: 0.1}}
  {entry}
outputs:
  before: {{from: other, file: before.num}}
  after: {{from: {output}, file: after.num}}
"""
FAILS = GRAPH.format(
    entry="bad: {node: Fussy, image: base, limit: $limit}\n  next: {node: Parity, image: bad}", output="next"
)
KEEPS = GRAPH.format(
    entry="bad: {node: Fussy, image: base, each: {limit: [0.2, 0.9]}, on_error: keep}\n  all: {node: Row, images: bad}",
    output="bad",
)


def values(path: str | Path) -> list[float]:
    return np.loadtxt(path, ndmin=2).ravel().tolist()


def write(folder: Path, text: str, name: str = "graph.yaml") -> str:
    (folder / name).write_text(text)
    return name


def test_outputs_are_written_to_a_folder_named_after_the_graph(command: Command, small: Path) -> None:
    told = command("run", "small.yaml")
    assert told.status == 0
    assert told.out.splitlines() == ["graphtex-out/small/image.num", "graphtex-out/small/base.num"]
    assert values("graphtex-out/small/base.num") == [0.25] * 4
    assert values("graphtex-out/small/image.num") == [0.25] * 4  # 0.25 is no more than half: 0, and lit by 0.25


def test_out_and_only(command: Command, small: Path) -> None:
    told = command("run", "small.yaml", "--out", "there", "--only", "base")
    assert told.out.splitlines() == ["there/base.num"]
    assert [path.name for path in Path("there").iterdir()] == ["base.num"]
    assert command("run", "small.yaml", "--out", "there", "--only", "image", "base").out.splitlines() == [
        "there/image.num",
        "there/base.num",
    ]


def test_set_gives_inputs_their_types(command: Command, small: Path) -> None:
    command("run", "small.yaml", "--set", "value=1")  # an int is read as the input's float
    assert values("graphtex-out/small/base.num") == [1.0] * 4
    assert values("graphtex-out/small/image.num") == [1.25] * 4


def test_set_takes_lists_folders_and_patterns_from_the_current_folder(command: Command, folder: Path) -> None:
    (folder / "elsewhere").mkdir()
    text = """\
graphtex: 1
inputs:
  textures: {type: "list[Image]"}
  widths: {type: "list[int]", default: [1]}
nodes:
  all: {node: Row, images: $textures}
  some: {node: Flat, each: {width: $widths}}
outputs:
  image: {from: all, file: image.num}
  some: {from: some, file: some.num}
"""
    graph = write(folder / "elsewhere", text)
    (folder / "maps").mkdir()
    for name, value in (("a", 0.1), ("b", 0.2), ("c", 0.3)):
        (folder / "maps" / f"{name}.num").write_text(f"{value}\n{value}\n")
    for given, first_row in (
        ("maps/c.num,maps/a.num", [0.3, 0.1]),
        ("maps", [0.1, 0.2, 0.3]),
        ("maps/[bc].num", [0.2, 0.3]),
    ):
        told = command("run", f"elsewhere/{graph}", "--out", "o", "--set", f"textures={given}", "widths=[1, 3]")
        assert told.status == 0, told.err
        assert values("o/image.num")[: len(first_row)] == first_row
    assert [len(values(f"o/some-{index}.num")) for index in (0, 1)] == [2, 6]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--set", "value"], "--set: expected name=value, got 'value'; inputs: value, textures"),
        (["--set", "=3"], "--set: expected name=value, got '=3'; inputs: value, textures"),
        (
            ["--set", "valu=3"],
            "--set: the graph has no input 'valu'; did you mean 'value'?; inputs: value, textures",
        ),
        (["--set", "x=3"], "--set: the graph has no input 'x'; inputs: textures, value"),
        (["--set", "value=1", "value=2"], "--set value: given twice"),
        (["--set", "value=much"], "value: expected float, got 'much'"),
        (["--set", "value=3"], "value: should be at most 2, got 3"),
        (["--set", "textures=no.num"], "textures: there is no file '{folder}/no.num'"),
        (["--only", "imag"], "only: no output 'imag'; did you mean 'image'?"),
        (["--seed", "-1"], "--seed: a seed is a whole number from 0, got -1"),
        (["--executor", "thread"], "executor: unknown executor 'thread'; did you mean 'threads'?"),
        (["--workers", "0"], "workers: at least one worker, got 0"),
        (["--cache", "c", "--no-cache"], "--no-cache: --cache was given too; choose one"),
        (["--out", "small.yaml"], "--out: the folder 'small.yaml' cannot be made: File exists"),
        (["--report", "."], "--report: '.' is a folder; the report is a file"),
        (["--report", "small.yaml/a.html"], "--report: the folder 'small.yaml' cannot be made: File exists"),
        (["--sed", "3"], "graphtex run: Unknown option: --sed. Did you mean --seed? (see graphtex run --help)"),
    ],
)
def test_wrong_requests_are_told_and_nothing_runs(
    command: Command, small: Path, folder: Path, words: list[str], message: str
) -> None:
    told = command("run", "small.yaml", *words)
    assert told.status == 2
    assert told.err.splitlines() == [message.format(folder=folder)]
    assert told.out == ""


def test_all_wrong_inputs_are_told_at_once(command: Command, small: Path) -> None:
    told = command("run", "small.yaml", "--set", "a=1", "--set", "b", "--set", "value=1", "--set", "value=2")
    assert told.status == 2
    assert len(told.err.splitlines()) == 3


def test_problems_of_the_file_have_its_places(command: Command, folder: Path) -> None:
    text = "graphtex: 1\nnodes:\n  a: {node: Flatt}\n  b: {node: Brighten, image: c}\noutputs: {image: b}\n"
    told = command("run", write(folder, text))
    assert told.status == 2
    assert told.err.splitlines() == [
        "graph.yaml:3:13: nodes.a.node: unknown node 'Flatt'; did you mean 'Flat'?",
        "graph.yaml:4:30: nodes.b.image: unknown node 'c'; nodes: a, b",
    ]


@pytest.mark.parametrize("name", ["nowhere.yaml", "", "/", "no/where", "perspective/"])
def test_an_unknown_graph_is_told(command: Command, name: str) -> None:
    told = command("run", name)
    assert told.status == 2
    what = "is a folder, not a graph file" if name in ("", "/") else "is no file and no graph that ships"
    assert told.err.startswith(f"{name!r} {what}")
    assert len(told.err.splitlines()) == 1


def test_progress_is_plain_lines_and_quiet_says_nothing(command: Command, small: Path) -> None:
    told = command("run", "small.yaml")
    lines = told.err.splitlines()
    assert lines[0] == "base: Flat runs (not run before)"
    assert lines[1].startswith("base: done in ")
    assert lines[-1].startswith("3 nodes: 3 ran; ")
    again = command("run", "small.yaml").err.splitlines()
    assert again[:3] == ["base: cached", "sign: cached", "lit: cached"]
    assert again[3].startswith("3 nodes: 3 cached; ")
    assert command("run", "small.yaml", "--quiet").err == ""


def test_a_changed_input_runs_only_what_it_changes(command: Command, small: Path) -> None:
    command("run", "small.yaml")
    told = command("run", "small.yaml", "--set", "value=0.5", "--json", "--quiet")
    nodes = {node["id"]: node for node in json.loads(told.out)["nodes"]}
    assert {name: node["status"] for name, node in nodes.items()} == {"base": "ran", "sign": "ran", "lit": "cached"}
    assert nodes["base"]["why"] == "parameter value: 0.25 -> 0.5"
    assert nodes["sign"]["why"] == "input image has changed"
    assert nodes["lit"]["why"] == ""


def test_json_is_one_object_with_all_that_a_script_needs(command: Command, small: Path) -> None:
    told = command("run", "small.yaml", "--json", "--set", "value=0.75", "--seed", "5")
    made = json.loads(told.out)
    assert made["graph"] == str(small)
    assert made["seed"] == 5
    assert made["status"] == "done"
    assert made["outputs"] == {"image": ["graphtex-out/small/image.num"], "base": ["graphtex-out/small/base.num"]}
    assert [(node["id"], node["node"]) for node in made["nodes"]] == [
        ("base", "Flat"),
        ("sign", "Parity"),
        ("lit", "Brighten"),
    ]
    assert made["nodes"][2]["warnings"] == ["too bright"]
    assert all(len(node["key"]) == 64 and node["seconds"] >= 0 for node in made["nodes"])
    assert made["totals"] | {"seconds": 0} == {
        "nodes": 3, "ran": 3, "cached": 0, "failed": 0, "skipped": 0, "waiting": 0, "seconds": 0,
    }  # fmt: skip
    assert "warning: lit: too bright" in told.err.splitlines()
    quiet = command("run", "small.yaml", "--quiet", "--set", "value=0.75")
    assert quiet.err == "warning: lit: too bright\n"  # progress is not told, what is doubtful is


def test_the_seed_option_replaces_the_graph_s(command: Command, folder: Path) -> None:
    text = "graphtex: 1\nseed: 1\nnodes: {a: {node: Noise}}\noutputs: {image: {from: a, file: a.num}}\n"
    graph = write(folder, text)
    made = []
    for words in ([], ["--seed", "2"], ["--seed", "1"]):
        command("run", graph, *words)
        made.append(values("graphtex-out/graph/a.num"))
    assert made[0] == made[2] != made[1]


def test_a_failing_node_gives_status_1_and_what_was_made_is_written(command: Command, folder: Path) -> None:
    told = command("run", write(folder, FAILS))
    assert told.status == 1
    assert told.out.splitlines() == ["graphtex-out/graph/before.num"]
    message = "bad: image: at most 0.2 wanted, got 0.5 [inputs: image float32 (2, 2, 1)]"
    assert told.err.splitlines()[-1] == f"failed: {message}"
    assert "Traceback" not in told.err
    made = json.loads(command("run", "graph.yaml", "--json", "--quiet").out)
    assert made["status"] == "failed"
    assert made["outputs"] == {"before": ["graphtex-out/graph/before.num"], "after": []}
    assert [(n["id"], n["status"]) for n in made["nodes"]] == [
        ("base", "cached"),
        ("other", "cached"),
        ("bad", "failed"),
        ("next", "waiting"),
    ]
    assert made["totals"]["waiting"] == 1
    assert made["nodes"][2]["message"] == message.removeprefix("bad: ")


def test_kept_failures_are_listed_at_the_end_and_give_status_1(command: Command, folder: Path) -> None:
    told = command("run", write(folder, KEEPS))
    assert told.status == 1
    assert told.out.splitlines() == ["graphtex-out/graph/before.num", "graphtex-out/graph/after-1.num"]
    assert told.err.splitlines()[-1].startswith("failed: bad[0]: image: at most 0.2 wanted")
    assert ": 3 ran, 1 failed; " in told.err.splitlines()[-2]


def test_a_cell_that_failed_is_told_with_its_file(command: Command, folder: Path) -> None:
    (folder / "photos").mkdir()
    for name, grey in (("a", "0.1"), ("b", "0.5")):
        (folder / "photos" / f"{name}.num").write_text(f"{grey}\n")
    text = (
        'graphtex: 1\ninputs: {p: {type: "list[Image]", default: photos}}\n'
        "nodes: {bad: {node: Fussy, limit: 0.2, each: {image: $p}, on_error: keep}}\n"
        "outputs: {image: {from: bad, file: c.num}}\n"
    )
    told = command("run", write(folder, text))
    assert told.err.splitlines()[-1].startswith("failed: bad[1] (b.num): image: at most 0.2 wanted")


def test_a_fault_in_a_node_names_its_line_and_debug_shows_the_traceback(command: Command, folder: Path) -> None:
    text = "graphtex: 1\nnodes: {a: {node: Flat}, b: {node: Faulty, image: a}}\noutputs: {image: b}\n"
    graph = write(folder, text.replace("image: b}", "image: {from: b, file: b.num}}"))
    told = command("run", graph)
    assert told.status == 1
    assert "failed: b: KeyError: 'nothing' (" in told.err
    assert "Traceback" not in told.err
    assert "Traceback" in command("--debug", "run", graph).err


def test_without_cache_nothing_is_stored(command: Command, small: Path, folder: Path) -> None:
    made = [json.loads(command("run", "small.yaml", "--no-cache", "--json").out)["totals"]["ran"] for _ in range(2)]
    assert made == [3, 3]
    assert not (folder.parent / "cache").exists()


def test_the_cache_option_names_the_folder(command: Command, small: Path, folder: Path) -> None:
    command("run", "small.yaml", "--cache", "mine")
    assert (folder / "mine" / "index").is_dir()
    assert not (folder.parent / "cache").exists()
    assert json.loads(command("run", "small.yaml", "--cache", "mine", "--json").out)["totals"]["cached"] == 3


def test_workers_run_nodes_in_threads_with_the_same_result(command: Command, small: Path) -> None:
    command("run", "small.yaml", "--no-cache", "--out", "one")
    assert command("run", "small.yaml", "--no-cache", "--out", "two", "--workers", "2").status == 0
    assert Path("one/image.num").read_bytes() == Path("two/image.num").read_bytes()


def test_dry_run_tells_what_is_cached_what_runs_and_what_depends(command: Command, small: Path) -> None:
    first = command("run", "small.yaml", "--dry-run")
    assert first.status == 0
    assert [line.split()[:3] for line in first.out.splitlines()] == [
        ["id", "node", "forecast"],
        ["base", "Flat", "runs"],
        ["sign", "Parity", "runs"],
        ["lit", "Brighten", "runs"],
    ]
    assert not Path("graphtex-out").exists()
    command("run", "small.yaml")
    told = command("run", "small.yaml", "--dry-run", "--json", "--set", "value=0.5")
    nodes = {node["id"]: (node["forecast"], node["why"]) for node in json.loads(told.out)["nodes"]}
    assert nodes == {
        "base": ("runs", "parameter value: 0.25 -> 0.5"),
        "sign": ("maybe", "base decides"),
        "lit": ("maybe", "base decides"),
    }
    assert command("run", "small.yaml", "--dry-run", "--only", "base").out.count("cached") == 1
    assert command("run", "small.yaml", "--dry-run", "--no-cache").out.count("no cache") == 3


def test_what_nodes_print_is_kept_out_of_the_result(command: Command, folder: Path) -> None:
    text = "graphtex: 1\nnodes: {a: {node: Chatty}}\noutputs: {image: {from: a, file: a.num}}\n"
    told = command("run", write(folder, text), "--json")
    assert json.loads(told.out)["status"] == "done"
    assert "chatter" in told.err.splitlines()


def test_a_cache_that_cannot_be_used_is_warned_of_once_and_the_run_goes_on(command: Command, small: Path) -> None:
    told = command("run", "small.yaml", "--cache", "small.yaml")
    assert told.status == 0
    assert "warning: running without cache: " in told.err
    assert told.err.count("running without cache") == 1
    assert command("run", "small.yaml", "--cache", "small.yaml", "--dry-run").status == 0


def test_a_wrong_size_in_the_environment_is_a_wrong_request(
    command: Command, small: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GRAPHTEX_CACHE_SIZE", "much")
    for words in (["run", "small.yaml"], ["run", "small.yaml", "--dry-run"], ["why", "small.yaml", "lit"]):
        told = command(*words)
        assert told.status == 2
        assert told.err.startswith("GRAPHTEX_CACHE_SIZE: ")


@pytest.mark.parametrize("option", ["--out", "--report"])
def test_a_folder_that_cannot_be_written_to_is_told_before_anything_runs(
    command: Command, small: Path, monkeypatch: pytest.MonkeyPatch, option: str
) -> None:
    Path("shut").mkdir()
    monkeypatch.setattr("os.access", lambda path, mode: Path(path).name != "shut")  # root may write anywhere
    told = command("run", "small.yaml", option, {"--out": "shut", "--report": "shut/report.html"}[option])
    assert told.status == 2
    assert told.err == f"{option}: the folder 'shut' cannot be written to\n"


def test_an_output_that_cannot_be_written_gives_status_1(command: Command, small: Path) -> None:
    Path("o/image.num").mkdir(parents=True)
    told = command("run", "small.yaml", "--out", "o")
    assert told.status == 1
    assert told.err.splitlines()[-1].startswith("o/image.num: ")
