"""Graphs that ship with graphtex: found by name in a checkout and in an install."""

import os
from difflib import get_close_matches
from pathlib import Path

from graphtex.errors import GraphError, Problem, did_you_mean

_HERE = Path(__file__).resolve().parent


def shipped_folder() -> Path:
    """Return the folder of the shipped graphs: inside the package, or beside it in a checkout."""
    installed = _HERE / "_graphs"
    return installed if installed.is_dir() else _HERE.parent / "graphs"


def shipped_names() -> list[str]:
    """Return the names of the shipped graphs, such as ``perspective/feature-mask``."""
    folder = shipped_folder()
    return sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.yaml"))


def find_graph(name: str | os.PathLike[str]) -> Path:
    """Return the file of a graph: a path as it is, or a shipped graph by its name; GraphError if neither is there."""
    path = Path(name)
    if path.is_file():
        return path
    shipped = shipped_folder() / f"{_shipped_name(path)}.yaml"  # with `.yaml` or `graphs/` written or not
    if not path.is_absolute() and shipped.is_file():
        return shipped
    what = "is a folder, not a graph file" if path.is_dir() else "is no file and no graph that ships"
    raise GraphError([Problem("", 0, 0, "", f"{str(name)!r} {what}{_hint(path)}")])


def _hint(path: Path) -> str:
    """Return what may have been meant: a file beside, graphs of a shipped folder, or a shipped graph."""
    try:
        beside = [file.name for file in path.parent.iterdir() if file.suffix in (".yaml", ".yml")]
    except (OSError, ValueError):  # no folder, or a name that no folder can have
        beside = []
    near = get_close_matches(path.name, beside, n=1)
    if near:
        return f"; did you mean {str(path.with_name(near[0]))!r}?"
    name, names = _shipped_name(path), shipped_names()
    inside = [one for one in names if one.startswith(f"{name}/")]
    if inside:
        return f"; there are {', '.join(inside)}"
    last = [one for one in names if one.rpartition("/")[2] == name]
    if last:
        return f"; did you mean {' or '.join(map(repr, last))}?"
    hint = did_you_mean(name, names)
    return hint if "did you mean" in hint else "; `graphtex graphs` lists those that ship"


def _shipped_name(path: Path) -> str:
    return path.as_posix().removesuffix(".yaml").removesuffix(".yml").removeprefix("graphs/")


def graph_identity(path: Path | None) -> str:
    """Return the name under which a graph's last run is remembered: a shipped name or an absolute path."""
    if path is None:
        return "(built in Python)"
    folder = shipped_folder()
    full = path.resolve()
    return full.relative_to(folder).with_suffix("").as_posix() if full.is_relative_to(folder) else str(full)
