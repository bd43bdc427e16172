"""What users type: several values after one option, and ``name=value`` for graph inputs."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphtex.errors import GraphError, Problem, did_you_mean

if TYPE_CHECKING:
    from graphtex.document import Document, Input
    from graphtex.graph import Graph

_PAIR = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*=")


def spread(words: Sequence[str]) -> list[str]:
    """Return a command line in which ``--set a=1 b=2`` is ``--set a=1 --set b=2``, and so ``--only``.

    What follows `--only` counts as another output only if the graph was named before; it would be the graph otherwise.

    >>> spread(["run", "g.yaml", "--only", "a", "b", "--seed", "3"])
    ['run', 'g.yaml', '--only', 'a', '--only', 'b', '--seed', '3']
    """
    made: list[str] = []
    option, expects, named = "", False, False
    for index, word in enumerate(words):
        if word == "--":
            return made + list(words[index:])
        if word.startswith("-") and not expects:
            option, expects = word, word in _VALUED
        elif expects:
            expects = False
        elif (option == "--set" and _PAIR.match(word)) or (option == "--only" and named):
            made.append(option)
        else:
            named, option = bool(made), ""  # the first bare word is the command
        made.append(word)
    return made


_VALUED = ("--set", "--out", "--seed", "--only", "--executor", "--workers", "--cache", "--report")


def given_inputs(graph: "Document", pairs: Sequence[str]) -> dict[str, Any]:
    """Return the inputs that ``name=value`` texts give, each read as its input's type; GraphError with all faults."""
    from graphtex.inputs import read_text

    values: dict[str, Any] = {}
    problems = []
    for pair in pairs:
        name, equals, text = pair.partition("=")
        path, message = "--set", ""
        if not equals or not name:
            message = f"expected name=value, got {pair!r}; inputs: {', '.join(graph.inputs) or 'none'}"
        elif name not in graph.inputs:
            message = f"the graph has no input {name!r}{did_you_mean(name, graph.inputs, label='inputs')}"
            message += _also(name, message, graph.inputs)
        elif name in values:
            hint = f"; a list is written {name}=a,b" if graph.inputs[name].type.startswith("list[") else ""
            path, message = f"--set {name}", f"given twice{hint}"
        else:
            try:
                values[name] = read_text(graph.inputs[name], _at_home(graph.inputs[name], text))
            except ValueError as error:
                path, message = f"--set {name}", str(error)
        if message:
            problems.append(Problem("", 0, 0, path, message))
    if problems:
        raise GraphError(problems)
    return values


def _also(name: str, message: str, inputs: Mapping[str, "Input"]) -> str:
    """Return the list of inputs where the hint has named only the nearest."""
    return f"; inputs: {', '.join(inputs)}" if "did you mean" in message and len(inputs) > 1 else ""


def _at_home(kind: "Input", text: str) -> str:
    """Return the text with ``~`` as a path has it: the shell leaves it alone after ``name=``."""
    if not text.startswith("~") or kind.type in ("str", "data", "list[str]", "list[data]"):
        return text
    return ",".join(str(Path(part).expanduser()) if part.startswith("~") else part for part in text.split(","))


def read_graph(name: str) -> "Graph":
    """Return a checked graph by its file or shipped name; GraphError with all that is wrong."""
    from graphtex.graph import load
    from graphtex.shipped import find_graph

    return load(find_graph(name))
