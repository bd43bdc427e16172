"""The builder: graphs put together in Python, or loaded from files, saved and run.

The YAML file and the Python builder are two faces of one thing, the `graphtex.document.Document`.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from graphtex.document import NAME, REQUIRED, SCALAR_TYPES, Document, Entry, Input, Output, Place
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.files import read, read_file, save
from graphtex.node import Node
from graphtex.parameters import plain
from graphtex.shipped import find_graph
from graphtex.sockets import TYPES, find_type

if TYPE_CHECKING:
    from graphtex.run import RunResult


@dataclass(frozen=True)
class InputHandle:
    """A graph input, to be passed to `Graph.add`."""

    name: str


@dataclass(frozen=True)
class SocketHandle:
    """One output of an added node, to be passed to `Graph.add` or `Graph.output`."""

    reference: str


class NodeHandle:
    """An added node; its attributes are its outputs."""

    def __init__(self, name: str, outputs: tuple[str, ...]) -> None:
        self._name = name
        self._outputs = outputs

    def __getattr__(self, socket: str) -> SocketHandle:
        if socket.startswith("_"):  # asked for by copy and pickle, before there is anything
            raise AttributeError(socket)
        if socket not in self._outputs:
            raise AttributeError(
                f"{self._name} has no output {socket!r}{did_you_mean(socket, self._outputs, label='outputs')}"
            )
        return SocketHandle(self._name if len(self._outputs) == 1 else f"{self._name}.{socket}")

    def __repr__(self) -> str:
        return f"<{self._name}: {', '.join(self._outputs)}>"


class Graph(Document):
    """A graph of nodes.

    >>> g = Graph(title="Copy", seed=7)
    >>> g.input("size", "int", default=3)
    InputHandle(name='size')
    """

    def __repr__(self) -> str:
        parts = ", ".join(f"{key}: {' '.join(names)}" for key, names in
                          (("inputs", self.inputs), ("nodes", self.nodes), ("outputs", self.outputs)))  # fmt: skip
        return f"<Graph {self.title!r}; {parts}>"

    def input(self, name: str, type: Any, default: Any = REQUIRED, **bounds: Any) -> InputHandle:
        """Add a graph input; `type` is a socket type, a Python type or the name of one. Bounds as in `Input`.

        Raises
        ------
        GraphError
            If the name is taken or no name, or the type is unknown.
        """
        self._free_name(name, self.inputs, ("inputs", name))
        if "choices" in bounds:
            bounds["choices"] = tuple(bounds["choices"])
        self.inputs[name] = Input(_type_name(type), default if default is REQUIRED else plain(default), **bounds)
        return InputHandle(name)

    def add(
        self,
        node: "Node[Any, Any] | str | os.PathLike[str]",
        name: str | None = None,
        /,
        *,
        each: Mapping[str, Any] | None = None,
        seed: Any = None,
        on_error: Literal["stop", "keep"] = "stop",
        **arguments: Any,
    ) -> NodeHandle:
        """Add a node, or with a path another graph file as a sub-graph; arguments are handles or plain data.

        Parameters
        ----------
        name
            The node's id in the graph; without it the function's name, numbered if taken.
        each
            Arguments to range over: name to list, or to an input that is a list.
        """
        from graphtex.links import Links
        from graphtex.packs import registry

        if not isinstance(node, Node | str | os.PathLike):
            raise TypeError(f"add: expected a node, a function with @node, or a graph file, got {node!r}")
        own = node.function.__name__ if isinstance(node, Node) else Path(node).stem.replace("-", "_")
        if name is None:
            name = (
                own
                if own not in self.nodes
                else next(n for i in range(2, 1 << 30) if (n := f"{own}_{i}") not in self.nodes)
            )
        self._free_name(name, self.nodes, ("nodes", name))
        if isinstance(node, Node):
            known = self.own_nodes.get(node.name) or registry().nodes.get(node.name)
            if known is not None and known is not node:
                text = f"another node is called {node.name}, {known.function.__module__}.{known.function.__qualname__}"
                raise GraphError([self.problem(("nodes", name), text)])
            if known is None:
                self.own_nodes[node.name] = node
            entry = Entry(node=node.name)
        else:
            entry = Entry(graph=os.fspath(node))
        signature = Links(self).entry_signature(("nodes", name), entry)
        written = {key: _written(value, key in signature.sockets) for key, value in arguments.items()}
        ranges = {
            key: [_written(item, False) for item in value]
            if isinstance(value, list | tuple)
            else _written(value, False)
            for key, value in (each or {}).items()
        }
        self.nodes[name] = Entry(entry.node, entry.graph, written, ranges, _written(seed, False), on_error)
        return NodeHandle(name, tuple(signature.outputs))

    def output(
        self, name: str, source: "NodeHandle | SocketHandle | InputHandle", file: str | None = None, **options: Any
    ) -> None:
        """Name what a run returns and writes."""
        self._free_name(name, self.outputs, ("outputs", name))
        self.outputs[name] = Output(_written(source, True), file, {key: plain(value) for key, value in options.items()})

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the graph as a YAML file."""
        save(self, path)

    def run(self, **inputs: Any) -> "RunResult":
        """Run with these inputs, in this process, with the default cache; see `graphtex.run.run` for more choices."""
        from graphtex.run import run

        return run(self, inputs)

    def _free_name(self, name: str, taken: Mapping[str, Any], path: Place) -> None:
        if not NAME.fullmatch(name):
            raise GraphError([self.problem(path, f"a name is letters, digits, _ and -, got {name!r}")])
        if name in taken:
            raise GraphError([self.problem(path, f"the name {name!r} is taken")])


def load(path: str | os.PathLike[str]) -> Graph:
    """Return the graph of a file, or a shipped one by its name; GraphError with all that is wrong, also in meaning."""
    return _checked(*read_file(find_graph(path)))


def loads(text: str) -> Graph:
    """Return the graph that a text holds; GraphError with all that is wrong, in form and in meaning."""
    return _checked(*read(text))


def _checked(document: Document | None, problems: list[Problem]) -> Graph:
    from graphtex.check import check  # it needs networkx, which readers of files do not

    if document is not None:
        told = {(p.file, p.line, p.column) for p in problems}  # what follows from those is left out
        problems = problems + [p for p in check(document) if not p.line or (p.file, p.line, p.column) not in told]
    if document is None or problems:
        raise GraphError(problems)
    return Graph(**vars(document))


def _type_name(type: Any) -> str:
    if isinstance(type, str):
        return type
    kind = find_type(type)
    if kind is not None:
        return kind.name
    if getattr(type, "__origin__", None) is list:
        return f"list[{_type_name(type.__args__[0])}]"
    name = getattr(type, "__name__", str(type))
    if name in SCALAR_TYPES or name in TYPES:
        return name
    raise GraphError(
        [Problem("", 0, 0, "inputs", f"unknown type {name!r}{did_you_mean(name, [*TYPES, *SCALAR_TYPES])}")]
    )


def _written(value: Any, is_socket: bool) -> Any:
    """Return an argument in the form in which a file writes it."""
    if isinstance(value, InputHandle):
        return f"${value.name}"
    if isinstance(value, NodeHandle):
        if len(value._outputs) != 1:
            problem = f"has several outputs: write one of {', '.join(f'.{name}' for name in value._outputs)}"
            raise GraphError([Problem("", 0, 0, f"nodes.{value._name}", problem)])
        value = SocketHandle(value._name)
    if isinstance(value, SocketHandle):
        return value.reference if is_socket else {"from": value.reference}
    if is_socket and isinstance(value, np.ndarray):
        text = "an array does not stand in a graph; add an input, and give the array when it is run"
        raise GraphError([Problem("", 0, 0, "", text)])
    if is_socket and isinstance(value, list | tuple):
        return [_written(item, True) for item in value]
    return _escaped(plain(value)) if not is_socket else plain(value)


def _escaped(value: Any) -> Any:
    if isinstance(value, str):
        return f"${value}" if value.startswith("$") else value
    if isinstance(value, list):
        return [_escaped(item) for item in value]
    if isinstance(value, dict):
        return {key: _escaped(item) for key, item in value.items()}
    return value
