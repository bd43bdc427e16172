"""How arguments of a graph's entries are written: references, graph inputs, measured numbers, literals, ranges.

Nothing is looked up here; `graphtex.links` says what a reference leads to.
"""

from dataclasses import dataclass
from typing import Any

from graphtex.document import SCALAR_TYPES, Document, Input, Place
from graphtex.errors import GraphError
from graphtex.parameters import shorten


@dataclass(frozen=True)
class FromNode:
    """A reference to a node's output."""

    node: str
    socket: str | None  # None: its only one


@dataclass(frozen=True)
class FromInput:
    """A reference to a graph input."""

    name: str


@dataclass(frozen=True)
class Measured:
    """A number that a node measures, in a parameter's place."""

    source: FromNode | FromInput


@dataclass(frozen=True)
class Literal:
    """Plain data."""

    value: Any


Reference = FromNode | FromInput


def is_scalar(kind: Input) -> bool:
    """Return whether an input goes into parameters, not sockets."""
    return kind.type.removeprefix("list[").removesuffix("]") in SCALAR_TYPES


def reference(graph: Document, path: Place, value: Any) -> Reference:
    """Read one reference; GraphError for anything else."""
    if not isinstance(value, str) or not value:
        wanted = "a reference: node, node.socket or $input"
        raise GraphError([graph.problem(path, f"expected {wanted}, got {shorten(value)}")])
    if value.startswith("$"):
        return FromInput(value[1:])
    node, dot, socket = value.partition(".")
    return FromNode(node, socket if dot else None)


def socket_argument(graph: Document, path: Place, value: Any) -> Reference | tuple[Reference, ...]:
    """Read an argument in a socket's place: a reference or a list of them."""
    if isinstance(value, list):
        return tuple(reference(graph, (*path, i), item) for i, item in enumerate(value))
    return reference(graph, path, value)


def is_input(value: Any) -> bool:
    """Return whether a value in a parameter's place is the name of a graph input."""
    return isinstance(value, str) and value.startswith("$") and not value.startswith("$$")


def parameter_argument(graph: Document, path: Place, value: Any) -> FromInput | Measured | Literal:
    """Read an argument in a parameter's place."""
    if isinstance(value, dict) and set(value) == {"from"} and isinstance(value["from"], str):
        return Measured(reference(graph, (*path, "from"), value["from"]))
    return FromInput(value[1:]) if is_input(value) else Literal(unescaped(value))


def unescaped(value: Any) -> Any:
    """Return plain data with ``$$`` at the start of a string as one dollar."""
    if isinstance(value, str):
        return value[1:] if value.startswith("$$") else value
    if isinstance(value, list):
        return [unescaped(item) for item in value]
    if isinstance(value, dict):
        return {key: unescaped(item) for key, item in value.items()}
    return value


def range_argument(graph: Document, path: Place, value: Any) -> FromInput | tuple[FromInput | Literal, ...]:
    """Read what an `each:` ranges over: an input that is a list, or a list of literals and inputs."""
    if is_input(value):
        return FromInput(value[1:])
    if isinstance(value, list) and value:
        read = [parameter_argument(graph, (*path, i), item) for i, item in enumerate(value)]
        items = tuple(item for item in read if not isinstance(item, Measured))
        if len(items) == len(read):
            return items
    wanted = "a list with at least one item, or $input; computed values cannot be ranged over"
    raise GraphError([graph.problem(path, f"expected {wanted}, got {shorten(value)}")])


def references_of(graph: Document, path: Place, value: Any, is_socket: bool) -> tuple[Reference, ...]:
    """Return the references that an argument holds."""
    if is_socket:
        read = socket_argument(graph, path, value)
        return read if isinstance(read, tuple) else (read,)
    found = parameter_argument(graph, path, value)
    if isinstance(found, Measured):
        return (found.source,)
    return (found,) if isinstance(found, FromInput) else ()
