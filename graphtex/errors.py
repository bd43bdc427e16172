"""What can go wrong, each as one exception that says where, what was got and what would fit."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any


@dataclass(frozen=True, order=True)
class Problem:
    """One mistake in a request or a graph file.

    Attributes
    ----------
    file, line, column
        Where it stands; line and column count from 1, 0 means unknown (a graph that was built in Python).
    path
        The place in the graph, such as ``nodes.mask.window``.
    message
        What is wrong, what was got and what would fit.
    """

    file: str
    line: int
    column: int
    path: str
    message: str

    def __str__(self) -> str:
        place = f"{self.file}:{self.line}:{self.column}: " if self.line else f"{self.file}: " if self.file else ""
        return f"{place}{self.path + ': ' if self.path else ''}{self.message}"


class GraphtexError(Exception):
    """Base of all errors that graphtex raises on purpose."""


class GraphError(GraphtexError, ValueError):
    """A graph, a graph file or a request to run it is wrong; holds all problems found, in order of place."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(set(problems)))
        super().__init__("\n".join(str(problem) for problem in self.problems))

    def __reduce__(self) -> tuple[Any, ...]:
        return GraphError, (self.problems,)


class DeclarationError(GraphtexError, TypeError):
    """A function cannot become a node, a writer or a view, because of how it is declared."""


class Cancelled(GraphtexError):
    """The run was asked to stop."""


class NodeFailed(GraphtexError):
    """A node raised; the message names the node, the shapes of its inputs and the cause."""

    def __init__(self, task: str, message: str) -> None:
        self.task = task
        self.message = message
        self.result: Any = None  # the run's results as far as they go, set when the whole run ends by this
        super().__init__(f"{task}: {message}")

    def __reduce__(self) -> tuple[Any, ...]:
        return NodeFailed, (self.task, self.message)  # without the results: they stay where the run was


def did_you_mean(word: str, known: Iterable[str], *, label: str = "known") -> str:
    """Return the end of an error message: the nearest of the known words, or all of them if they are few.

    >>> did_you_mean("widow", ["window", "method"])
    "; did you mean 'window'?"
    >>> did_you_mean("x", ["window", "method"])
    '; known: method, window'
    """
    words = sorted(set(known))
    near = get_close_matches(word, words, n=1, cutoff=0.6) or [w for w in words if w.lower() == word.lower()][:1]
    if near:
        return f"; did you mean {near[0]!r}?"
    return f"; {label}: {listing(words)}" if words else f"; there is no {label.removesuffix('s')} at all"


def listing(words: Sequence[str], limit: int = 12) -> str:
    """Join words by commas and cut a long list.

    >>> listing(["a", "b", "c"], limit=2)
    'a, b and 1 more'
    """
    shown = ", ".join(words[:limit])
    return shown if len(words) <= limit else f"{shown} and {len(words) - limit} more"
