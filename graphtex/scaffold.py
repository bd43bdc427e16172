"""Starters: a node pack that works as it is, or a graph file."""

import keyword
import re
from importlib.util import find_spec
from pathlib import Path
from string import Template

from graphtex.errors import GraphError, Problem
from graphtex.whole import write_text

_TEMPLATES = Path(__file__).resolve().parent / "_templates"


def new_pack(name: str, folder: Path) -> list[Path]:
    """Write a pack with one node, one graph and one test into ``folder / name``; return the files.

    Raises
    ------
    GraphError
        If the name cannot be a package's or is one that Python knows, or the folder is there already; nothing is
        written then.
    """
    package = name.replace("-", "_")
    if not re.fullmatch(r"[a-z][a-z0-9_-]*", name) or keyword.iskeyword(package):
        raise _refused(name, "a pack's name is lower-case letters, digits, - and _, and no word of Python's")
    target = folder / name
    if target.exists():
        raise _refused(name, f"{str(target)!r} is there already")
    if find_spec(package) is not None:
        raise _refused(name, f"the Python package {package} is installed already; a pack needs a name of its own")
    places = {
        "pyproject.toml": "pyproject.toml",
        "README.md": "README.md",
        "__init__.py": f"src/{package}/__init__.py",
        "posterize.py": f"src/{package}/posterize.py",
        "posterize.yaml": "graphs/posterize.yaml",
        "test_posterize.py": "tests/test_posterize.py",
    }
    return [
        _write(_TEMPLATES / "pack" / f"{key}.txt", target / place, name=name, package=package)
        for key, place in places.items()
    ]


def new_graph(name: str, folder: Path) -> list[Path]:
    """Write a starter graph as ``folder / name``, which ends in ``.yaml``; return the file.

    Raises
    ------
    GraphError
        If the file is there already.
    """
    target = folder / name
    if target.exists():
        raise _refused(name, f"{str(target)!r} is there already")
    return [_write(_TEMPLATES / "graph.yaml.txt", target, title=target.stem.replace("-", " ").capitalize())]


def _write(template: Path, target: Path, **values: str) -> Path:
    target.parent.mkdir(parents=True, exist_ok=True)
    write_text(target, Template(template.read_text(encoding="utf-8")).substitute(values))
    return target


def _refused(name: str, reason: str) -> GraphError:
    return GraphError([Problem("", 0, 0, name, reason)])
