"""A graph as data: inputs, nodes and outputs, as a graph file holds them.

Arguments are kept in the form in which a file writes them: ``"mask"`` or ``"mask.edges"`` in a socket's place,
``"$name"`` for a graph input, ``"$$"`` for a plain dollar, ``{"from": "node.socket"}`` for a measured number in a
parameter's place, and plain data otherwise. What they mean is decided in one place, `graphtex.links`.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from graphtex.errors import Problem
from graphtex.node import Node

Place = tuple[str | int, ...]
FORMAT = 1
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")
NAMED_AFTER = re.compile(r"\{([^{}]*)\}")  # in an output's file: the list input after whose files its items are named
SCALAR_TYPES = ("int", "float", "str", "bool", "file", "data")


class _Required:
    """The default of an input that has none."""

    def __repr__(self) -> str:
        return "REQUIRED"


REQUIRED: Any = _Required()


@dataclass(frozen=True)
class Input:
    """A graph input.

    Attributes
    ----------
    type
        A socket type (``Image``), ``int``, ``float``, ``str``, ``bool``, ``file`` (a path), ``data`` (any plain data),
        or a list of one (``list[Image]``, ``list[int]``).
    default
        `REQUIRED`, a literal, or for socket types a path or ``scheme:name``.
    min, max, choices
        What a value may be; None means no bound.
    open
        Parameters of the node that opens a file for a socket type; what comes in another way has no use for them.
    """

    type: str
    default: Any = REQUIRED
    min: float | None = None
    max: float | None = None
    choices: tuple[Any, ...] | None = None
    description: str = ""
    open: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Entry:
    """A node of a graph: a `node` by its name or another `graph` by its file, with arguments in file form."""

    node: str = ""
    graph: str = ""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    each: Mapping[str, Any] = field(default_factory=dict)
    seed: Any = None
    on_error: Literal["stop", "keep"] = "stop"


@dataclass(frozen=True)
class Output:
    """What a run returns and writes: a reference, the file's name and options of its writer.

    ``{pictures}`` in the name of a list's file stands for the names of the files that the list input `pictures` got.
    """

    source: str
    file: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(eq=False)
class Document:
    """What a graph file holds, with the places of its parts; equal if the contents are, wherever they were read."""

    title: str = ""
    source: str = ""
    seed: int = 0
    description: str = ""
    inputs: dict[str, Input] = field(default_factory=dict)
    nodes: dict[str, Entry] = field(default_factory=dict)
    outputs: dict[str, Output] = field(default_factory=dict)
    file: Path | None = field(default=None)  # where it was read from
    places: Mapping[Place, tuple[int, int]] = field(default_factory=dict, repr=False)  # line, column of values
    key_places: Mapping[Place, tuple[int, int]] = field(default_factory=dict, repr=False)
    own_nodes: dict[str, Node[Any, Any]] = field(default_factory=dict, repr=False)  # nodes of no pack

    @property
    def base(self) -> Path:
        """The folder that relative paths start from: that of the file, or the current one."""
        return self.file.parent if self.file else Path.cwd()

    def problem(self, path: Place, message: str, *, key: bool = False) -> Problem:
        """Return a problem at the nearest place of `path` that is known; `key` means the key, not its value."""
        shown = ".".join(str(part) for part in path)
        tables = (self.key_places, self.places) if key else (self.places, self.key_places)
        for length in range(len(path), -1, -1):
            for table in tables if length == len(path) else (self.key_places, self.places):
                if path[:length] in table:
                    line, column = table[path[:length]]
                    return Problem(str(self.file or ""), line, column, shown, message)
        return Problem(str(self.file or ""), 0, 0, shown, message)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Document):
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in _CONTENT)

    __hash__ = None  # type: ignore[assignment]  # it can change


_CONTENT = ("title", "source", "seed", "description", "inputs", "nodes", "outputs")
