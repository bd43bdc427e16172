"""Graphs that are right in form and in meaning, or an error that tells all that is wrong."""

import os

from graphtex.errors import GraphError, Problem
from graphtex.files.disk import read_file
from graphtex.files.reader import read
from graphtex.graph import Graph


def loads(text: str) -> Graph:
    """Return the graph that a text holds; GraphError with all that is wrong, in form and in meaning."""
    return _checked(*read(text))


def load(path: str | os.PathLike[str]) -> Graph:
    """Return the graph of a file; GraphError with all that is wrong, in form and in meaning."""
    return _checked(*read_file(path))


def _checked(graph: Graph | None, problems: list[Problem]) -> Graph:
    from graphtex.check import check  # it needs networkx, which readers of files do not

    if graph is not None:
        told = {(p.file, p.line, p.column) for p in problems}  # what follows from those is left out
        problems = problems + [p for p in check(graph) if not p.line or (p.file, p.line, p.column) not in told]
    if graph is None or problems:
        raise GraphError(problems)
    return graph
