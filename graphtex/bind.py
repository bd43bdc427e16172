"""Turns a checked graph and the values of its inputs into a `Plan`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import networkx as nx

from graphtex import links
from graphtex.check import check
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.graph import REQUIRED, Entry, Graph, Input, Place
from graphtex.handlers import find_opener
from graphtex.inputs import check_scalar, expand_paths
from graphtex.links import FromInput, Literal, Measured, Reference, Signature
from graphtex.parameters import files_of, validate, with_files
from graphtex.plan import Plan, PlannedOutput, Slot, Task, absolute, cells_of, stream_words
from graphtex.sockets import ValueType, parse_type

Bound = Slot | tuple[Slot, ...]


@dataclass(frozen=True)
class Scalar:
    """A graph input's value for parameters: plain data, and the folder that paths in it start from."""

    value: Any
    base: Path


def bind(
    graph: Graph, inputs: Mapping[str, Any] | None = None, *, seed: int | None = None, base: Path | None = None
) -> Plan:
    """Check a graph, bind its inputs and expand it.

    Parameters
    ----------
    inputs
        Arrays, numbers, paths or ``scheme:name`` strings by input name; missing ones take their defaults.
    seed
        Replaces the graph's seed.
    base
        Where relative paths in `inputs` start; without it the current folder.

    Raises
    ------
    GraphError
        With all problems of the graph, then with all problems of the inputs.
    """
    problems = check(graph)
    if problems:
        raise GraphError(problems)
    builder = _Builder(graph, {}, {}, [])
    values = builder.bind_inputs(graph, inputs or {}, base or Path.cwd())
    if builder.problems:
        raise GraphError(builder.problems)
    outputs = builder.expand(_Scope(graph, "", values, graph.seed if seed is None else seed))
    if builder.problems:
        raise GraphError(builder.problems)
    return Plan(graph, builder.tasks, builder.given, outputs)


@dataclass(frozen=True)
class _Scope:
    """One graph at one place of the expansion."""

    graph: Graph
    prefix: str
    values: Mapping[str, "Bound | Scalar"]
    seed: int
    keep_going: bool = False
    chain: links.Chain = ()


@dataclass
class _Builder:
    root: Graph
    tasks: dict[str, Task]
    given: dict[Slot, tuple[ValueType, Any]]
    problems: list[Problem]
    opened: dict[tuple[str, str], Slot] = field(default_factory=dict)

    def bind_inputs(self, graph: Graph, inputs: Mapping[str, Any], base: Path) -> dict[str, Bound | Scalar]:
        for name in inputs:
            if name not in graph.inputs:
                hint = did_you_mean(name, graph.inputs, label="inputs")
                self.problems.append(Problem("", 0, 0, name, f"the graph has no input {name!r}{hint}"))
        values: dict[str, Bound | Scalar] = {}
        for name, kind in graph.inputs.items():
            value = inputs.get(name, kind.default)
            start = base if name in inputs else graph.base
            if value is REQUIRED:
                self.problems.append(
                    graph.problem(("inputs", name), f"{name} has no default: a value of type {kind.type} is required")
                )
                continue
            try:
                values[name] = self.bind_input(f"${name}", kind, value, start)
            except ValueError as error:
                where = (
                    Problem("", 0, 0, name, str(error))
                    if name in inputs
                    else graph.problem(("inputs", name, "default"), str(error))
                )
                self.problems.append(where)
        return values

    def bind_input(self, task: str, kind: Input, value: Any, base: Path) -> "Bound | Scalar":
        if links.is_scalar(kind):
            return Scalar(check_scalar(kind, value), base)
        wanted = parse_type(kind.type)
        if not wanted.many:
            return self.open(task, wanted, value, base)
        items = expand_paths(value, wanted, base)
        return tuple(self.open(f"{task}[{i}]", ValueType(wanted.base), item, base) for i, item in enumerate(items))

    def open(self, task: str, kind: ValueType, value: Any, base: Path) -> Slot:
        """Return the slot of a given value, or of the node that opens a path or name."""
        if isinstance(value, Slot):
            return value
        if not isinstance(value, str | Path):
            slot = Slot(task, "value")
            self.given[slot] = (kind, kind.check(value, task.removeprefix("$")))
            return slot
        opener, text = find_opener(kind.base, str(value))
        if opener.suffixes:
            file = absolute(base, Path(text))
            if not file.is_file():
                raise ValueError(
                    f"there is no file {str(file)!r}" if not file.is_dir() else f"{str(file)!r} is a folder, not a file"
                )
            text = str(file)
        known = self.opened.get((opener.node.name, text))
        if known is not None:
            return known
        parameters, faults = validate(opener.node.parameters, {opener.parameter: text})
        if parameters is None:
            raise ValueError(faults[0][1])
        plain = with_files(parameters, str)
        self.tasks[task] = Task(task, opener.node, {}, plain, seed=self.root.seed, spawn_key=stream_words(task))
        slot = Slot(task, next(iter(opener.node.outputs)))
        return self.opened.setdefault((opener.node.name, text), slot)

    def expand(self, scope: _Scope) -> dict[str, PlannedOutput]:
        """Add the tasks of one graph and return its outputs."""
        graph = scope.graph
        flow: nx.DiGraph[str] = nx.DiGraph()
        flow.add_nodes_from(graph.nodes)
        flow.add_edges_from((source, name) for name in graph.nodes for source in links.sources_of(graph, name))
        order = {name: index for index, name in enumerate(graph.nodes)}
        made: dict[str, dict[str, Bound]] = {}
        for name in nx.lexicographical_topological_sort(flow, key=order.__getitem__):
            made[name] = self.expand_entry(scope, name, graph.nodes[name], made)
        outputs = {}
        for name, output in graph.outputs.items():
            path: Place = ("outputs", name)
            source = links.reference(graph, path, output.source)
            found = self.resolve(scope, path, source, made)
            kind = links.reference_type(graph, path, source, scope.chain)
            slots = found if isinstance(found, tuple) else (found,)
            outputs[name] = PlannedOutput(name, slots, kind, isinstance(found, tuple), output.file, output.options)
        return outputs

    def expand_entry(
        self, scope: _Scope, name: str, entry: Entry, made: Mapping[str, Mapping[str, Bound]]
    ) -> dict[str, Bound]:
        path: Place = ("nodes", name)
        signature = links.entry_signature(scope.graph, path, entry, scope.chain)
        base = self.arguments(scope, path, entry, signature, made)
        if not entry.each:
            return self.expand_cell(scope, name, entry, signature, base)
        ranges = {key: self.range_items(scope, name, key, value, signature) for key, value in entry.each.items()}
        cells = [
            self.expand_cell(scope, f"{name}{index}", entry, signature, {**base, **choice})
            for index, choice in cells_of(ranges)
        ]
        joined: dict[str, Bound] = {}
        for socket in signature.outputs:
            items = [cell[socket] for cell in cells]
            joined[socket] = tuple(item for item in items if isinstance(item, Slot))
        return joined

    def range_items(self, scope: _Scope, name: str, key: str, value: Any, signature: Signature) -> list[Any]:
        """Return what an argument ranges over: slots for a socket, scalars for a parameter."""
        path: Place = ("nodes", name, "each", key)
        socket = signature.sockets.get(key)
        if isinstance(value, str):
            bound = scope.values[value[1:]]
            return [Scalar(item, bound.base) for item in bound.value] if isinstance(bound, Scalar) else list(bound)  # type: ignore[arg-type]
        items: list[Any] = []
        for index, item in enumerate(value):
            if socket is None:
                items.append(Scalar(links.unescaped(item), scope.graph.base))
                continue
            try:
                items.append(self.open(f"{scope.prefix}{name}.{key}[{index}]", socket.type, item, scope.graph.base))
            except ValueError as error:
                self.problems.append(scope.graph.problem((*path, index), str(error)))
        return items

    def arguments(
        self, scope: _Scope, path: Place, entry: Entry, signature: Signature, made: Mapping[str, Mapping[str, Bound]]
    ) -> dict[str, Any]:
        """Return an entry's arguments as slots (sockets and measured numbers) and scalars."""
        values: dict[str, Any] = {}
        for key, value in entry.arguments.items():
            place = (*path, key)
            if key in signature.sockets:
                read = links.socket_argument(scope.graph, place, value)
                if isinstance(read, tuple):
                    parts = [self.resolve(scope, place, item, made) for item in read]
                    values[key] = tuple(
                        slot for part in parts for slot in (part if isinstance(part, tuple) else (part,))
                    )
                else:
                    values[key] = self.resolve(scope, place, read, made)
                continue
            found = links.parameter_argument(scope.graph, place, value)
            if isinstance(found, Literal):
                values[key] = Scalar(found.value, scope.graph.base)
            elif isinstance(found, Measured):
                values[key] = self.resolve(scope, place, found.source, made)
            else:
                values[key] = scope.values[found.name]
        if isinstance(entry.seed, str):
            values["seed"] = scope.values[entry.seed[1:]]
        elif entry.seed is not None:
            values["seed"] = Scalar(entry.seed, scope.graph.base)
        return values

    def resolve(self, scope: _Scope, path: Place, source: Reference, made: Mapping[str, Mapping[str, Bound]]) -> Bound:
        if isinstance(source, FromInput):
            bound = scope.values[source.name]
            assert not isinstance(bound, Scalar)  # checked by `check`
            return bound
        entry = scope.graph.nodes[source.node]
        signature = links.entry_signature(scope.graph, ("nodes", source.node), entry, scope.chain)
        return made[source.node][links.only_output(scope.graph, path, source, signature)]

    def expand_cell(
        self, scope: _Scope, name: str, entry: Entry, signature: Signature, values: dict[str, Any]
    ) -> dict[str, Bound]:
        """Add one node or one sub-graph with all its arguments known."""
        own_seed = values.pop("seed", None)
        keep = scope.keep_going or entry.on_error == "keep"
        if signature.node is not None:
            return self.add_task(scope, name, signature.node, values, own_seed, keep)
        inner = signature.graph
        assert inner is not None
        chain = (*scope.chain, scope.graph.file.resolve() if scope.graph.file else Path())
        bound: dict[str, Bound | Scalar] = {}
        for key, kind in inner.inputs.items():
            if key in values:
                bound[key] = values[key]
                continue
            try:
                bound[key] = self.bind_input(f"{scope.prefix}{name}/${key}", kind, kind.default, inner.base)
            except ValueError as error:
                self.problems.append(inner.problem(("inputs", key, "default"), str(error)))
        if self.problems:
            return dict.fromkeys(signature.outputs, ())
        seed = scope.seed if own_seed is None else own_seed.value
        below = _Scope(inner, f"{scope.prefix}{name}/", bound, seed, keep_going=keep, chain=chain)
        return {key: output.slots if output.joined else output.slots[0] for key, output in self.expand(below).items()}

    def add_task(
        self, scope: _Scope, name: str, node: Any, values: Mapping[str, Any], own_seed: Scalar | None, keep: bool
    ) -> dict[str, Bound]:
        task = f"{scope.prefix}{name}"
        place = scope.graph.problem(("nodes", name.split("[")[0]), "", key=True)
        plain: dict[str, Any] = {}
        measured = {}
        for key, value in values.items():
            if key in node.inputs:
                continue
            if isinstance(value, Slot):
                measured[key] = value
            else:
                plain[key] = value.value
        parameters, faults = validate(node.parameters, plain, unknown=measured)
        if faults:
            self.problems += [
                Problem(place.file, place.line, place.column, f"{task}.{'.'.join(map(str, p))}", t) for p, t in faults
            ]
            return {socket: Slot(task, socket) for socket in node.outputs}
        if parameters is not None:
            plain = {
                key: self.with_absolute(value, values[key].base if key in plain else scope.graph.base, task, key, place)
                for key, value in parameters
            }
        inputs = {key: value for key, value in values.items() if key in node.inputs}
        seed, words = (scope.seed, stream_words(task)) if own_seed is None else (own_seed.value, ())
        self.tasks[task] = Task(task, node, inputs, plain, measured, seed, words, keep, place)
        return {socket: Slot(task, socket) for socket in node.outputs}

    def with_absolute(self, value: Any, base: Path, task: str, key: str, place: Problem) -> Any:
        """Return a parameter as plain data with absolute paths; missing files become problems."""
        for file in files_of(value):
            if not absolute(base, file).is_file():
                text = f"there is no file {str(absolute(base, file))!r}"
                self.problems.append(Problem(place.file, place.line, place.column, f"{task}.{key}", text))
        return with_files(value, lambda file: str(absolute(base, file)))
