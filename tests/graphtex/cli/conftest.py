"""Command lines in this process and in others, with the nodes of `tests.graphtex.cli.pack` only."""

import importlib
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from graphtex.cli.app import call
from graphtex.packs import Registry, nodes_of
from tests.graphtex.cli import pack

ROOT = Path(__file__).resolve().parents[3]


@dataclass
class Told:
    """What a command line gave back."""

    status: int
    out: str
    err: str


Command = Callable[..., Told]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder that is the current one, with a cache of its own."""
    monkeypatch.setenv("GRAPHTEX_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.delenv("GRAPHTEX_DEBUG", raising=False)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "here"


@pytest.fixture
def registry(monkeypatch: pytest.MonkeyPatch) -> Registry:
    """The test pack in place of all installed ones, also in modules that are imported only later."""
    for name in ("graphtex.check", "graphtex.schema"):
        importlib.import_module(name)
    nodes = nodes_of(pack)
    small = Registry(nodes, dict.fromkeys(nodes, "pack"), ())
    for name in [
        name for name in sys.modules if name.startswith("graphtex.") and hasattr(sys.modules[name], "registry")
    ]:
        monkeypatch.setattr(sys.modules[name], "registry", lambda: small)
    return small


@pytest.fixture
def command(folder: Path, registry: Registry, capsys: pytest.CaptureFixture[str]) -> Command:
    """Carry out a command line in this process."""

    def run(*words: str) -> Told:
        status = call(words)
        said = capsys.readouterr()
        return Told(status, said.out, said.err)

    return run


@pytest.fixture
def environment(folder: Path) -> dict[str, str]:
    """The environment of a process that finds the test pack as an installed one."""
    info = folder.parent / "site" / "clipack-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: clipack\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[graphtex.nodes]\nclipack = tests.graphtex.cli.pack\n")
    paths = [str(info.parent), str(ROOT), str(ROOT / "nodes"), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in paths if path)}


class Process:
    """Carries out command lines in processes of their own."""

    def __init__(self, environment: dict[str, str], folder: Path) -> None:
        self._environment = environment
        self._folder = folder

    def __call__(self, *words: str) -> Told:
        return self._run("-m", "graphtex", *words)

    def python(self, code: str) -> Told:
        """Run Python code."""
        return self._run("-c", code)

    def _run(self, *words: str) -> Told:
        done = subprocess.run(
            [sys.executable, *words], capture_output=True, text=True, env=self._environment, cwd=self._folder,
            timeout=120, check=False,
        )  # fmt: skip
        return Told(done.returncode, done.stdout, done.stderr)


@pytest.fixture
def process(environment: dict[str, str], folder: Path) -> Process:
    """The command in processes of its own, with the test pack beside the installed ones."""
    return Process(environment, folder)


SMALL = """\
graphtex: 1
title: Small
seed: 7
inputs:
  value: {type: float, default: 0.25, min: 0, max: 2}
  textures: {type: "list[Image]", default: []}
nodes:
  base: {node: Flat, value: $value}
  sign: {node: Parity, image: base}
  lit: {node: Brighten, image: sign, by: 0.25}
outputs:
  image: {from: lit, file: image.num}
  base: {from: base, file: base.num}
"""


@pytest.fixture
def small(folder: Path) -> Path:
    """A graph file: base -> sign -> lit; sign comes out equal for all values up to 0.5."""
    file = folder / "small.yaml"
    file.write_text(SMALL)
    return file
