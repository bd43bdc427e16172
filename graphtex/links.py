"""What the arguments of a graph's entries mean: signatures of nodes and sub-graphs, references, types of references."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.graph import REQUIRED, SCALAR_TYPES, Entry, Graph, Input, Place
from graphtex.node import Node, Socket
from graphtex.packs import registry
from graphtex.parameters import shorten
from graphtex.sockets import ValueType, parse_type

Chain = tuple[Path, ...]  # the graph files on the way to this one: a sub-graph must not include one of them again


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


@dataclass(frozen=True)
class Signature:
    """What an entry takes and gives: one form for nodes and sub-graphs."""

    title: str
    sockets: Mapping[str, Socket]
    parameters: tuple[str, ...]
    outputs: Mapping[str, ValueType]
    node: Node[Any, Any] | None = None
    graph: Graph | None = None

    @property
    def model(self) -> type[BaseModel] | None:
        """The node's parameters; a sub-graph's are its scalar inputs."""
        return self.node.parameters if self.node else None


def is_scalar(kind: Input) -> bool:
    """Return whether an input goes into parameters, not sockets."""
    inner = kind.type[5:-1] if kind.type.startswith("list[") else kind.type
    return inner in SCALAR_TYPES


def entry_signature(graph: Graph, path: Place, entry: Entry, chain: Chain = ()) -> Signature:
    """Return what an entry takes and gives; GraphError if its node or its graph file is not there."""
    if entry.node:
        found = graph.own_nodes.get(entry.node) or registry().nodes.get(entry.node)
        if found is None:
            packs = registry()
            hint = did_you_mean(entry.node, [*packs.nodes, *graph.own_nodes], label="nodes")
            by_function = [made.name for made in packs.nodes.values() if made.function.__name__ == entry.node]
            hint = f"; did you mean {by_function[0]!r}?" if by_function else hint
            broken = f" ({'; '.join(packs.broken)})" if packs.broken else ""
            raise GraphError([graph.problem((*path, "node"), f"unknown node {entry.node!r}{hint}{broken}")])
        outputs = {name: socket.type for name, socket in found.outputs.items()}
        return Signature(found.name, found.inputs, tuple(found.parameters.model_fields), outputs, node=found)
    inner = included(graph, path, entry, chain)
    return subgraph_signature(inner, (*chain, _key(graph)))


def included(graph: Graph, path: Place, entry: Entry, chain: Chain) -> Graph:
    """Read the graph file that an entry includes; GraphError if it is missing, wrong or includes itself."""
    place = (*path, "graph")
    if not entry.graph:
        raise GraphError([])  # told at the entry
    try:
        file = (graph.base / entry.graph).resolve()
        exists = file.is_file()
    except (OSError, ValueError) as error:  # a name that no file can have
        raise GraphError([graph.problem(place, f"there is no graph file {shorten(entry.graph)}: {error}")]) from None
    if file in (*chain, _key(graph)):
        names = " -> ".join(step.name for step in (*chain, _key(graph), file) if step.name)
        raise GraphError([graph.problem(place, f"graph files include each other in a circle: {names}")])
    if not exists:
        near = (
            did_you_mean(file.name, [p.name for p in file.parent.glob("*.yaml")], label="files")
            if file.parent.is_dir()
            else ""
        )
        raise GraphError(
            [graph.problem(place, f"there is no graph file {entry.graph!r} beside {graph.file or 'this graph'}{near}")]
        )
    stat = file.stat()
    inner, problems = _read(file, stat.st_mtime_ns, stat.st_size)
    if inner is None or problems:
        raise GraphError(problems)
    return inner


@lru_cache(maxsize=64)
def _read(file: Path, mtime: int, size: int) -> tuple[Graph | None, list[Problem]]:
    from graphtex.files.disk import read_file

    return read_file(file)


def _key(graph: Graph) -> Path:
    return graph.file.resolve() if graph.file else Path()


def subgraph_signature(inner: Graph, chain: Chain) -> Signature:
    """Return what a graph takes and gives as an entry of another."""
    sockets, parameters = {}, []
    for name, kind in inner.inputs.items():
        if is_scalar(kind):
            parameters.append(name)
        else:
            try:
                value_type = parse_type(kind.type)
            except ValueError as error:
                raise GraphError([inner.problem(("inputs", name, "type"), str(error))]) from None
            sockets[name] = Socket(name, value_type, kind.default is not REQUIRED, (), kind.description)
    outputs = {}
    for name, output in inner.outputs.items():
        outputs[name] = reference_type(
            inner, ("outputs", name), reference(inner, ("outputs", name), output.source), chain
        )
    return Signature(inner.title or str(inner.file or "graph"), sockets, tuple(parameters), outputs, graph=inner)


def reference(graph: Graph, path: Place, value: Any) -> Reference:
    """Read one reference; GraphError for anything else."""
    if not isinstance(value, str) or not value:
        wanted = "a reference: node, node.socket or $input"
        raise GraphError([graph.problem(path, f"expected {wanted}, got {shorten(value)}")])
    if value.startswith("$"):
        return FromInput(value[1:])
    node, dot, socket = value.partition(".")
    return FromNode(node, socket if dot else None)


def reference_type(graph: Graph, path: Place, source: Reference, chain: Chain = ()) -> ValueType:
    """Return the type of what a reference gives; GraphError if there is no such thing."""
    if isinstance(source, FromInput):
        kind = graph.inputs.get(source.name)
        if kind is None:
            hint = did_you_mean(source.name, graph.inputs, label="inputs")
            raise GraphError([graph.problem(path, f"unknown graph input ${source.name}{hint}")])
        if is_scalar(kind):
            raise GraphError(
                [graph.problem(path, f"${source.name} is {kind.type}, which feeds parameters and no sockets")]
            )
        try:
            return parse_type(kind.type)
        except ValueError:
            raise GraphError([]) from None  # told at the input
    entry = graph.nodes.get(source.node)
    if entry is None:
        hint = did_you_mean(source.node, graph.nodes, label="nodes")
        if source.node in graph.inputs:
            hint = f"; the graph input is written ${source.node}"
        raise GraphError([graph.problem(path, f"unknown node {source.node!r}{hint}")])
    return output_type(graph, path, source, entry, chain)


def output_type(graph: Graph, path: Place, source: FromNode, entry: Entry, chain: Chain) -> ValueType:
    """Return the type of a node's output as other nodes see it: with `each:` a list."""
    signature = entry_signature(graph, ("nodes", source.node), entry, chain)
    socket = only_output(graph, path, source, signature)
    kind = signature.outputs[socket]
    if not entry.each:
        return kind
    if kind.many:
        raise GraphError(
            [graph.problem(path, f"{source.node} gives a list for each cell; a list of lists has no socket")]
        )
    return ValueType(kind.base, many=True, gaps=entry.on_error == "keep")


def only_output(graph: Graph, path: Place, source: FromNode, signature: Signature) -> str:
    """Return the output that a reference means; GraphError if it is unknown or one of several."""
    names = tuple(signature.outputs)
    if source.socket is None:
        if len(names) == 1:
            return names[0]
        if not names:
            raise GraphError([graph.problem(path, f"{source.node} ({signature.title}) has no outputs")])
        several = ", ".join(f"{source.node}.{name}" for name in names)
        raise GraphError(
            [graph.problem(path, f"{source.node} ({signature.title}) has several outputs; write one of {several}")]
        )
    if source.socket not in names:
        hint = did_you_mean(source.socket, names, label="outputs")
        raise GraphError(
            [graph.problem(path, f"{source.node} ({signature.title}) has no output {source.socket!r}{hint}")]
        )
    return source.socket


def socket_argument(graph: Graph, path: Place, value: Any) -> Reference | tuple[Reference, ...]:
    """Read an argument in a socket's place: a reference or a list of them."""
    if isinstance(value, list):
        return tuple(reference(graph, (*path, i), item) for i, item in enumerate(value))
    return reference(graph, path, value)


def parameter_argument(graph: Graph, path: Place, value: Any) -> FromInput | Measured | Literal:
    """Read an argument in a parameter's place."""
    if isinstance(value, dict) and set(value) == {"from"} and isinstance(value["from"], str):
        return Measured(reference(graph, (*path, "from"), value["from"]))
    if isinstance(value, str) and value.startswith("$") and not value.startswith("$$"):
        return FromInput(value[1:])
    return Literal(unescaped(value))


def unescaped(value: Any) -> Any:
    """Return plain data with ``$$`` at the start of a string as one dollar."""
    if isinstance(value, str):
        return value[1:] if value.startswith("$$") else value
    if isinstance(value, list):
        return [unescaped(item) for item in value]
    if isinstance(value, dict):
        return {key: unescaped(item) for key, item in value.items()}
    return value


def sources_of(graph: Graph, name: str) -> set[str]:
    """Return the ids of the nodes that a node reads from directly; faulty arguments are passed over."""
    entry = graph.nodes[name]
    found: set[str] = set()
    try:
        signature = entry_signature(graph, ("nodes", name), entry)
    except GraphError:
        return found
    for key, value in entry.arguments.items():
        try:
            for source in references_of(graph, ("nodes", name, key), value, key in signature.sockets):
                if isinstance(source, FromNode) and source.node in graph.nodes:
                    found.add(source.node)
        except GraphError:
            continue
    return found


def references_of(graph: Graph, path: Place, value: Any, is_socket: bool) -> tuple[Reference, ...]:
    """Return the references that an argument holds."""
    if is_socket:
        read = socket_argument(graph, path, value)
        return read if isinstance(read, tuple) else (read,)
    found = parameter_argument(graph, path, value)
    if isinstance(found, Measured):
        return (found.source,)
    return (found,) if isinstance(found, FromInput) else ()
