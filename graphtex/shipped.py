"""Graphs that ship with graphtex: found by name in a checkout and in an install."""

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


def find_graph(name: str | Path) -> Path:
    """Return the file of a graph: a path as it is, or a shipped graph by its name; GraphError if neither is there."""
    path = Path(name)
    if path.is_file():
        return path
    found = shipped_file(path)
    if found is not None:
        return found
    what = "is a folder, not a graph file" if path.is_dir() else "is no file and no graph that ships"
    hint = did_you_mean(_shipped_name(path), shipped_names(), label="shipped graphs")
    raise GraphError([Problem("", 0, 0, "", f"{str(name)!r} {what}{hint}")])


def shipped_file(path: Path) -> Path | None:
    """Return the file of the shipped graph that a path names, ``.yaml`` or ``graphs/`` written or not; None if none."""
    found = shipped_folder() / f"{_shipped_name(path)}.yaml"
    return found if not path.is_absolute() and found.is_file() else None


def _shipped_name(path: Path) -> str:
    return path.as_posix().removesuffix(".yaml").removesuffix(".yml").removeprefix("graphs/")


def graph_identity(path: Path | None) -> str:
    """Return the name under which a graph's last run is remembered: a shipped name or an absolute path."""
    if path is None:
        return "(built in Python)"
    folder = shipped_folder()
    full = path.resolve()
    return full.relative_to(folder).with_suffix("").as_posix() if full.is_relative_to(folder) else str(full)
