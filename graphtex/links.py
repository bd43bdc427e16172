"""What a graph's entries and references lead to: signatures of nodes and sub-graphs, types of references.

`Links` is one graph with all of that looked up, each thing once; checking and binding share it.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import networkx as nx
from pydantic import BaseModel

from graphtex.document import REQUIRED, Document, Entry, Input, Place
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.node import Node, Socket
from graphtex.packs import registry
from graphtex.parameters import shorten
from graphtex.references import FromInput, FromNode, Reference, is_scalar, reference, references_of
from graphtex.sockets import ValueType, parse_type


@dataclass(frozen=True)
class Signature:
    """What an entry takes and gives: one form for nodes and sub-graphs.

    Attributes
    ----------
    sockets, parameters
        What goes in. A sub-graph's parameters are its scalar inputs.
    node, inner
        What it is: exactly one is there.
    """

    title: str
    sockets: Mapping[str, Socket]
    parameters: tuple[str, ...]
    outputs: Mapping[str, ValueType]
    node: Node[Any, Any] | None = None
    inner: "Links | None" = None

    @property
    def graph(self) -> Document | None:
        """The sub-graph; None for a node."""
        return self.inner.graph if self.inner else None

    @property
    def model(self) -> type[BaseModel] | None:
        """The node's parameters; None for a sub-graph."""
        return self.node.parameters if self.node else None


class Links:
    """A graph, with what its entries and references mean.

    It holds for the graph as it is when asked; a graph that has changed since needs new links.

    Parameters
    ----------
    chain
        The graph files on the way to this one: it must not include one of them again.
    files
        The links of files that are included anywhere, shared by all links of one root.
    """

    def __init__(self, graph: Document, chain: tuple[Path, ...] = (), files: "dict[Path, Links] | None" = None) -> None:
        self.graph = graph
        self.chain = (*chain, graph.file.resolve() if graph.file else Path())
        self._files = {} if files is None else files
        self._signatures: dict[str, Signature | tuple[Problem, ...]] = {}
        self._found: dict[Reference, tuple[str, ValueType]] = {}

    def signature(self, name: str) -> Signature:
        """Return what an entry takes and gives; GraphError if its node or its graph file is not there."""
        found = self._signatures.get(name)
        if found is None:
            try:
                found = self.entry_signature(("nodes", name), self.graph.nodes[name])
            except GraphError as error:
                found = error.problems
            self._signatures[name] = found
        if isinstance(found, tuple):
            raise GraphError(found)
        return found

    def entry_signature(self, path: Place, entry: Entry) -> Signature:
        """Return what an entry at a path would take and give; GraphError as `signature`."""
        if not entry.node:
            return _graph_signature(self._included(path, entry))
        packs = registry()
        node = self.graph.own_nodes.get(entry.node) or packs.nodes.get(entry.node)
        if node is not None:
            return _node_signature(node)
        hint = did_you_mean(entry.node, [*packs.nodes, *self.graph.own_nodes], label="nodes")
        by_function = [made.name for made in packs.nodes.values() if made.function.__name__ == entry.node]
        hint = f"; did you mean {by_function[0]!r}?" if by_function else hint
        broken = f" ({'; '.join(packs.broken)})" if packs.broken else ""
        raise GraphError([self.graph.problem((*path, "node"), f"unknown node {entry.node!r}{hint}{broken}")])

    def _included(self, path: Place, entry: Entry) -> "Links":
        """Read the graph file that an entry includes; GraphError if it is missing, wrong or includes itself."""
        place = (*path, "graph")
        if not entry.graph:
            raise GraphError([])  # told at the entry
        try:
            file = (self.graph.base / entry.graph).resolve()
            exists = file.is_file()
        except (OSError, ValueError) as error:  # a name that no file can have
            text = f"there is no graph file {shorten(entry.graph)}: {error}"
            raise GraphError([self.graph.problem(place, text)]) from None
        if file in self.chain:
            names = " -> ".join(step.name for step in (*self.chain[self.chain.index(file) :], file))
            raise GraphError([self.graph.problem(place, f"graph files include each other in a circle: {names}")])
        if file not in self._files:
            if not exists:
                beside = [p.name for p in file.parent.glob("*.yaml")] if file.parent.is_dir() else []
                near = did_you_mean(file.name, beside, label="files") if beside else ""
                text = f"there is no graph file {entry.graph!r} beside {self.graph.file or 'this graph'}{near}"
                raise GraphError([self.graph.problem(place, text)])
            stat = file.stat()
            inner, problems = _read(file, stat.st_mtime_ns, stat.st_size)
            if inner is None or problems:
                raise GraphError(problems)
            self._files[file] = Links(inner, self.chain, self._files)
        return self._files[file]

    def find(self, path: Place, source: Reference) -> tuple[str, ValueType]:
        """Return the output socket that a reference at a path means (empty for an input), and its type.

        With `each:` an output is a list. GraphError if there is no such thing, or one of several could be meant.
        """
        found = self._found.get(source)
        if found is None:
            if isinstance(source, FromInput):
                found = "", self._input_type(path, source)
            else:
                found = self._output(path, source)
            self._found[source] = found
        return found

    def type_of(self, path: Place, source: Reference) -> ValueType:
        """Return the type of what a reference gives; GraphError as `find`."""
        return self.find(path, source)[1]

    def input_of(self, path: Place, source: FromInput) -> Input:
        """Return a graph input; GraphError if there is none of the name."""
        kind = self.graph.inputs.get(source.name)
        if kind is None:
            hint = did_you_mean(source.name, self.graph.inputs, label="inputs")
            raise GraphError([self.graph.problem(path, f"unknown graph input ${source.name}{hint}")])
        return kind

    def _input_type(self, path: Place, source: FromInput) -> ValueType:
        kind = self.input_of(path, source)
        if is_scalar(kind):
            text = f"${source.name} is {kind.type}, which feeds parameters and no sockets"
            raise GraphError([self.graph.problem(path, text)])
        return _parsed(kind)

    def _output(self, path: Place, source: FromNode) -> tuple[str, ValueType]:
        entry = self.graph.nodes.get(source.node)
        if entry is None:
            hint = did_you_mean(source.node, self.graph.nodes, label="nodes")
            if source.node in self.graph.inputs:
                hint = f"; the graph input is written ${source.node}"
            raise GraphError([self.graph.problem(path, f"unknown node {source.node!r}{hint}")])
        signature = self.signature(source.node)
        socket = self._only_output(path, source, signature)
        kind = signature.outputs[socket]
        if not entry.each:
            return socket, kind
        if kind.many:
            text = f"{source.node} gives a list for each cell; a list of lists has no socket"
            raise GraphError([self.graph.problem(path, text)])
        return socket, ValueType(kind.base, many=True)

    def _only_output(self, path: Place, source: FromNode, signature: Signature) -> str:
        names, who = tuple(signature.outputs), f"{source.node} ({signature.title})"
        if source.socket in names:
            return source.socket
        if source.socket is not None:
            text = f"{who} has no output {source.socket!r}{did_you_mean(source.socket, names, label='outputs')}"
        elif len(names) == 1:
            return names[0]
        elif names:
            text = f"{who} has several outputs; write one of {', '.join(f'{source.node}.{name}' for name in names)}"
        else:
            text = f"{who} has no outputs"
        raise GraphError([self.graph.problem(path, text)])

    @cached_property
    def order(self) -> tuple[str, ...]:
        """The nodes in a topological order, in the file's order where that is free; for a graph without cycles."""
        flow: nx.DiGraph[str] = nx.DiGraph()
        flow.add_nodes_from(self.graph.nodes)
        flow.add_edges_from((source, name) for name, sources in self.flow.items() for source in sources)
        place = {name: index for index, name in enumerate(self.graph.nodes)}
        return tuple(nx.lexicographical_topological_sort(flow, key=place.__getitem__))

    @cached_property
    def flow(self) -> Mapping[str, tuple[str, ...]]:
        """The nodes that each node reads from directly, in order; faulty arguments are passed over."""
        return {name: tuple(dict.fromkeys(self._sources(name))) for name in self.graph.nodes}

    def _sources(self, name: str) -> Iterator[str]:
        try:
            signature = self.signature(name)
        except GraphError:
            return
        for key, value in self.graph.nodes[name].arguments.items():
            try:
                found = references_of(self.graph, ("nodes", name, key), value, key in signature.sockets)
            except GraphError:
                continue
            yield from (s.node for s in found if isinstance(s, FromNode) and s.node in self.graph.nodes)


@lru_cache(maxsize=1024)
def _node_signature(node: Node[Any, Any]) -> Signature:
    outputs = {name: socket.type for name, socket in node.outputs.items()}
    return Signature(node.name, node.inputs, tuple(node.parameters.model_fields), outputs, node=node)


def _graph_signature(inner: Links) -> Signature:
    graph = inner.graph
    sockets = {
        name: Socket(name, _parsed(kind), kind.default is not REQUIRED, (), kind.description)
        for name, kind in graph.inputs.items()
        if not is_scalar(kind)
    }
    outputs = {}
    for name, output in graph.outputs.items():
        path = ("outputs", name)
        outputs[name] = inner.type_of(path, reference(graph, path, output.source))
    title = graph.title or str(graph.file or "graph")
    return Signature(title, sockets, tuple(key for key in graph.inputs if key not in sockets), outputs, inner=inner)


def _parsed(kind: Input) -> ValueType:
    try:
        return parse_type(kind.type)
    except ValueError:
        raise GraphError([]) from None  # told at the input


@lru_cache(maxsize=64)
def _read(file: Path, mtime: int, size: int) -> tuple[Document | None, list[Problem]]:
    from graphtex.files.disk import read_file

    return read_file(file)
