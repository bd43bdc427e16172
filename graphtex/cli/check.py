"""``graphtex check``: find all that is wrong with graph files."""

from pathlib import Path
from typing import TYPE_CHECKING

from graphtex.cli.terminal import DONE, WRONG, complain, count, out, say
from graphtex.errors import GraphError, Problem

if TYPE_CHECKING:
    from graphtex.document import Document


def check(first: str, /, *more: str) -> int:
    """Check graph files and tell all that is wrong; nothing runs.

    Parameters
    ----------
    first
        A graph file, a folder of graph files, or the name of a graph that ships with graphtex.
    more
        Others.
    """
    from graphtex.packs import registry

    problems = 0
    wrong = 0
    files = [file for name in (first, *more) for file in _files(name)]
    for file in files:
        found = _problems(file)
        complain(found)
        problems += len(found)
        wrong += bool(found)
        if not found:
            out(f"{file}: ok")
    for text in registry().broken:
        say(f"warning: {text}", "yellow")
    if problems:
        say(f"{count(problems, 'problem')} in {wrong} of {count(len(files), 'graph')}", "red")
    return WRONG if problems else DONE


def _files(name: str) -> list[str]:
    """Return the graph files of a folder, or the name as it is."""
    folder = Path(name)
    if folder.is_dir():
        return [str(file) for file in sorted(folder.rglob("*.yaml"))] or [name]
    return [name]


def _problems(name: str) -> tuple[Problem, ...]:
    from graphtex.bind import bind
    from graphtex.graph import load
    from graphtex.shipped import find_graph

    try:
        graph = load(find_graph(name))
        if _is_complete(graph):
            bind(graph)  # files that defaults and parameters name, and what `each:` expands to
    except GraphError as error:
        return error.problems
    return ()


def _is_complete(graph: "Document") -> bool:
    from graphtex.document import REQUIRED

    return all(kind.default is not REQUIRED for kind in graph.inputs.values())
