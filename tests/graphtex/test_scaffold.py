"""The starters work as they are."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from graphtex.check import check
from graphtex.errors import GraphError
from graphtex.graph import load
from graphtex.scaffold import new_graph, new_pack


@pytest.fixture
def installed(tmp_path: Path) -> dict[str, str]:
    """An environment in which a pack made in the folder ``packs`` is installed, as far as its entry point goes."""
    new_pack("my-pack", tmp_path / "packs")
    told = tmp_path / "site" / "my_pack-0.1.0.dist-info"
    told.mkdir(parents=True)
    (told / "METADATA").write_text("Metadata-Version: 2.1\nName: my-pack\nVersion: 0.1.0\n")
    (told / "entry_points.txt").write_text("[graphtex.nodes]\nmy_pack = my_pack\n")
    source = tmp_path / "packs" / "my-pack" / "src"
    return {
        **os.environ,
        "PYTHONPATH": f"{source}{os.pathsep}{tmp_path / 'site'}",
        "GRAPHTEX_CACHE_DIR": str(tmp_path / "cache"),
    }


def test_pack_runs_and_passes_its_test(tmp_path: Path, installed: dict[str, str]):
    """Its node is found, its graph runs by the command line, and its own test passes."""
    pack = tmp_path / "packs" / "my-pack"

    def call(*command: str) -> str:
        done = subprocess.run([sys.executable, "-m", *command], cwd=pack, env=installed, capture_output=True, text=True)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    assert "levels" in call("graphtex", "nodes", "Posterize")
    assert "out/image.png" in call("graphtex", "run", "graphs/posterize.yaml", "--out", "out")
    assert "3 passed" in call("pytest", "-q", "-p", "no:cacheprovider")


def test_graph_is_right(tmp_path: Path):
    [file] = new_graph("my-graph.yaml", tmp_path)
    graph = load(file)
    assert graph.title == "My graph"
    assert check(graph) == []


@pytest.mark.parametrize("name", ["Posters", "9lives", "class", "a b", "../up"])
def test_refuses_names(tmp_path: Path, name: str):
    with pytest.raises(GraphError, match="a pack's name"):
        new_pack(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["graphtex", "graphtex-nodes", "numpy", "json"])
def test_refuses_names_of_installed_packages(tmp_path: Path, name: str):
    """Installed, the pack would stand in for them."""
    with pytest.raises(GraphError, match=f"the Python package {name.replace('-', '_')} is installed already"):
        new_pack(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_never_overwrites(tmp_path: Path):
    new_pack("mine", tmp_path)
    new_graph("mine.yaml", tmp_path)
    with pytest.raises(GraphError, match="is there already"):
        new_pack("mine", tmp_path)
    with pytest.raises(GraphError, match="is there already"):
        new_graph("mine.yaml", tmp_path)
