"""What is to be drawn of a graph: boxes with ports, and links between them; no sizes and no places yet."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any, Literal

from graphtex.check import check_links
from graphtex.document import REQUIRED, Document, Entry, Input
from graphtex.errors import GraphError
from graphtex.links import Links, Signature
from graphtex.parameters import plain
from graphtex.references import FromInput, Reference, is_scalar, range_argument, reference, references_of, unescaped
from graphtex.sockets import ValueType

MAX_LINES = 6  # parameters shown in a box
MAX_VALUE = 26  # characters of a parameter's value

Kind = Literal["input", "node", "graph", "output"]


@dataclass(frozen=True)
class Port:
    """Where links end at a box; `type` is a socket type's name or a scalar's, `many` a list of it."""

    name: str
    type: str
    many: bool = False


@dataclass(frozen=True)
class Box:
    """A graph input, a node, a sub-graph or a graph output.

    Attributes
    ----------
    key
        ``$name`` for an input, ``name`` for a node or sub-graph, ``>name`` for an output.
    lines
        Parameters that differ from their defaults, a line each.
    stack
        How many cells an `each:` makes, such as ``× 3 × 3``; empty without.
    """

    key: str
    kind: Kind
    title: str
    subtitle: str
    lines: tuple[str, ...] = ()
    ins: tuple[Port, ...] = ()
    outs: tuple[Port, ...] = ()
    stack: str = ""
    about: str = ""


@dataclass(frozen=True)
class Link:
    """A connection of two ports; `measured`: a number that feeds a parameter."""

    source: str
    out: str
    target: str
    into: str
    type: str
    many: bool = False
    measured: bool = False


@dataclass(frozen=True)
class Mark:
    """What became of a box in a run: ran, cached, failed, skipped or waiting, with a short text and a link."""

    status: str
    text: str
    href: str = ""


@dataclass(frozen=True)
class Scene:
    """All boxes, inputs first and outputs last, and all links."""

    boxes: tuple[Box, ...]
    links: tuple[Link, ...]


def scene(graph: Document) -> Scene:
    """Return what is to be drawn; GraphError with all its problems if the graph is faulty."""
    links = Links(graph)
    problems = check_links(links)
    if problems:
        raise GraphError(problems)
    boxes = [_input_box(name, kind) for name, kind in graph.inputs.items()]
    drawn: list[Link] = []
    for name, entry in graph.nodes.items():
        box, into = _entry_box(links, name, entry)
        boxes.append(box)
        drawn += into
    for name, output in graph.outputs.items():
        source = reference(graph, ("outputs", name), output.source)
        start, out, kind = _origin(links, source)
        boxes.append(Box(f">{name}", "output", name, kind_text(kind), _file_line(output.file), ins=(_port("", kind),)))
        drawn.append(Link(start, out, f">{name}", "", kind.base.name, kind.many))
    return Scene(tuple(boxes), tuple(drawn))


def brief(value: Any, limit: int = MAX_VALUE) -> str:
    """Return a parameter's value as a short text.

    >>> brief([1, 2.5, "a"]), brief({"points": [1, 2]}), brief(True)
    ('1, 2.5, a', '{points}', 'true')
    """
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "none"}[value]
    if isinstance(value, Mapping):
        return cut("{" + ", ".join(map(str, value)) + "}", limit)
    if isinstance(value, list | tuple):
        text = ", ".join(brief(item, limit) for item in value)
        return text if len(text) <= limit and text else f"{len(value)} items"
    return cut(f"{value:g}" if isinstance(value, float) else str(value), limit)


def cut(text: str, limit: int) -> str:
    """Return a text on one line, with an ellipsis where it was too long."""
    text = " ".join(text.split())
    return text if len(text) <= limit else f"{text[: limit - 1]}…"


def kind_text(kind: ValueType) -> str:
    """Return such as ``Image`` or ``list of Image``."""
    return f"list of {kind.base.name}" if kind.many else kind.base.name


def _port(name: str, kind: ValueType) -> Port:
    return Port(name, kind.base.name, kind.many)


def _scalar_port(name: str, kind: Input) -> Port:
    many = kind.type.startswith("list[")
    return Port(name, kind.type[5:-1] if many else kind.type, many)


def _file_line(file: str | None) -> tuple[str, ...]:
    return (cut(file, MAX_VALUE),) if file else ()


def _input_box(name: str, kind: Input) -> Box:
    port = _scalar_port("", kind)
    default = () if kind.default is REQUIRED else (brief(kind.default),)
    subtitle = f"list of {port.type}" if port.many else port.type
    return Box(f"${name}", "input", name, subtitle, default, outs=(port,), about=kind.description)


def _origin(links: Links, source: Reference) -> tuple[str, str, ValueType]:
    """Return the box, the port and the type that a reference to a socket's value means."""
    socket, kind = links.find((), source)
    return (f"${source.name}" if isinstance(source, FromInput) else source.node), socket, kind


def _entry_box(links: Links, name: str, entry: Entry) -> tuple[Box, list[Link]]:
    signature = links.signature(name)
    ports: list[Port] = []
    into: list[Link] = []
    lines: list[str] = []
    for key, value, ranged in _arguments(entry):
        found = _references(links.graph, key, value, ranged, key in signature.sockets)
        if not found:
            lines += _literal_line(signature, key, value, ranged)
            continue
        ends = [_link(links, source, name, key, value) for source in found]
        into += ends
        port = _port(key, signature.sockets[key].type) if key in signature.sockets else Port(key, ends[0].type)
        ports.append(port)
    if entry.on_error == "keep":
        lines.append("on_error=keep")
    if len(lines) > MAX_LINES:
        lines[MAX_LINES - 1 :] = [f"+ {len(lines) - MAX_LINES + 1} more"]
    outs = tuple(_port(key, _seen(kind, entry)) for key, kind in signature.outputs.items())
    about = signature.node.summary if signature.node else signature.title
    kind: Kind = "node" if signature.node else "graph"
    subtitle = entry.node or PurePath(entry.graph).name
    box = Box(name, kind, name, subtitle, tuple(lines), tuple(ports), outs, _stack(links.graph, entry), about)
    return box, into


def _arguments(entry: Entry) -> Iterator[tuple[str, Any, bool]]:
    """Yield name, value and whether the argument is ranged over."""
    for key, value in entry.arguments.items():
        yield key, value, False
    for key, value in entry.each.items():
        yield key, value, True
    if entry.seed is not None:
        yield "seed", entry.seed, False


def _references(graph: Document, key: str, value: Any, ranged: bool, is_socket: bool) -> tuple[Reference, ...]:
    if not ranged:
        return references_of(graph, (key,), value, is_socket)
    items = range_argument(graph, (key,), value)  # literals, or inputs, or both
    return tuple(item for item in (items if isinstance(items, tuple) else (items,)) if isinstance(item, FromInput))


def _link(links: Links, source: Reference, name: str, key: str, value: Any) -> Link:
    if isinstance(source, FromInput) and is_scalar(links.graph.inputs[source.name]):
        port = _scalar_port("", links.graph.inputs[source.name])
        return Link(f"${source.name}", "", name, key, port.type, port.many)
    start, out, kind = _origin(links, source)
    return Link(start, out, name, key, kind.base.name, kind.many, measured=isinstance(value, Mapping))


def _literal_line(signature: Signature, key: str, value: Any, ranged: bool) -> list[str]:
    if ranged:
        return [f"{key} in {brief(unescaped(value))}"]
    if key in signature.sockets:
        return []  # an empty list: nothing flows
    value = unescaped(value)
    return [] if key != "seed" and plain(_default(signature, key)) == value else [f"{key}={brief(value)}"]


def _default(signature: Signature, key: str) -> Any:
    if signature.model is not None:
        info = signature.model.model_fields[key]
        return REQUIRED if info.is_required() else info.default
    assert signature.graph is not None
    return signature.graph.inputs[key].default


def _seen(kind: ValueType, entry: Entry) -> ValueType:
    """Return an output's type as other nodes see it."""
    return ValueType(kind.base, many=True) if entry.each else kind


def _stack(graph: Document, entry: Entry) -> str:
    sizes = []
    for value in entry.each.values():
        items = graph.inputs[value[1:]].default if isinstance(value, str) else value
        sizes.append(str(len(items)) if isinstance(items, list) else "n")
    return " ".join(f"× {size}" for size in sizes)
