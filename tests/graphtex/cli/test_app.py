"""The command as a whole: help, versions, errors, what is imported."""

from pathlib import Path

import pytest

import graphtex
from graphtex.cli.app import call
from graphtex.cli.arguments import spread
from tests.graphtex.cli.conftest import Command, Process

COMMANDS = ("cache", "check", "demo", "new", "nodes", "run", "schema", "show", "why")
HEAVY = ("numba", "scipy", "skimage", "OpenImageIO", "PIL", "tifffile", "numpy", "pydantic", "networkx", "yaml", "dask")


def test_help_names_all_commands_and_is_what_comes_without_one(command: Command) -> None:
    told = command("--help")
    assert told.status == 0
    assert all(f"\n│ {name} " in told.out for name in COMMANDS)
    assert "130 interrupted" in told.out
    assert command() == told


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_has_its_help(command: Command, name: str) -> None:
    told = command(name, "--help")
    assert told.status == 0
    assert f"Usage: graphtex {name} " in told.out


def test_version(command: Command) -> None:
    assert command("--version").out == f"{graphtex.__version__}\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["rnu"], 'graphtex: Unknown command "rnu". Did you mean "run"?'),
        (["run"], "graphtex run: Command "),
        (["run", "a.yaml", "b.yaml"], "graphtex run: Unused Tokens: ['b.yaml']"),
        (["run", "a.yaml", "--seed", "x"], "graphtex run: Invalid value for --seed"),
        (["cache", "wash"], "graphtex cache: "),
    ],
)
def test_a_wrong_command_line_is_one_line_and_status_2(command: Command, words: list[str], message: str) -> None:
    told = command(*words)
    assert told.status == 2
    assert told.err.startswith(message)
    assert len(told.err.splitlines()) == 1
    assert told.err.endswith(" --help)\n")


def test_several_values_may_follow_set_and_only() -> None:
    assert spread(["run", "g", "--set", "a=1", "b=2", "--only", "x", "y", "--json"]) == [
        "run", "g", "--set", "a=1", "--set", "b=2", "--only", "x", "--only", "y", "--json",
    ]  # fmt: skip
    assert spread(["run", "--only", "x", "g", "--set", "a=1"]) == ["run", "--only", "x", "g", "--set", "a=1"]
    assert spread(["run", "--set", "a=1", "b=2", "g"]) == ["run", "--set", "a=1", "--set", "b=2", "g"]
    assert spread(["run", "g", "--set", "a=--x", "--", "b=2"]) == ["run", "g", "--set", "a=--x", "--", "b=2"]


def test_an_internal_error_is_one_line_with_a_hint(
    command: Command, small: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fall(*_: object, **__: object) -> None:
        raise RuntimeError("over\nboard")

    monkeypatch.setattr("graphtex.shipped.find_graph", fall)
    told = command("run", "small.yaml")
    assert told.status == 1
    assert told.err == (
        "internal error: RuntimeError: over board "
        "(a fault in graphtex or a node pack; --debug or GRAPHTEX_DEBUG=1 shows the traceback)\n"
    )
    assert "Traceback" in command("run", "small.yaml", "--debug").err
    monkeypatch.setenv("GRAPHTEX_DEBUG", "1")
    assert "Traceback" in command("run", "small.yaml").err


def test_ctrl_c_outside_a_run_is_status_130(small: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("graphtex.shipped.find_graph", stop)
    assert call(["run", "small.yaml"]) == 130


def test_help_imports_nothing_heavy_and_a_list_of_nodes_no_kernels(process: Process) -> None:
    code = (
        "import sys; sys.argv = ['graphtex', {word!r}]; from graphtex.__main__ import main; main();"
        "print([name for name in {heavy} if name in sys.modules])"
    )
    assert process.python(code.format(word="--help", heavy=HEAVY)).out.splitlines()[-1] == "[]"
    light = HEAVY[: HEAVY.index("numpy")]
    assert process.python(code.format(word="nodes", heavy=light)).out.splitlines()[-1] == "[]"


def test_garbage_is_collected_while_nodes_run(process: Process, small: Path) -> None:
    """Loading does without the collector; a run, which may be long, has it, but for what loading made."""
    code = (
        "import gc, sys; sys.argv = ['graphtex', *{words!r}]; from graphtex.__main__ import main; main();"
        "print(gc.isenabled(), gc.get_freeze_count() > 1000)"
    )
    assert process.python(code.format(words=["check", str(small)])).out.splitlines()[-1] == "False False"
    assert process.python(code.format(words=["run", str(small)])).out.splitlines()[-1] == "True True"
