"""Expands a checked graph: sub-graphs and `each:` are unfolded until tasks are left, each a call of one node."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from graphtex.document import Entry, Place
from graphtex.errors import GraphError, Problem
from graphtex.inputs import check_seed
from graphtex.links import Links, Signature
from graphtex.node import Node
from graphtex.parameters import files_of, validate, with_files
from graphtex.plan import PlannedOutput, Slot, Task, cells_of, stream_words
from graphtex.references import (
    FromInput,
    FromNode,
    Literal,
    Measured,
    Reference,
    is_input,
    parameter_argument,
    range_argument,
    reference,
    socket_argument,
)
from graphtex.values import Bound, Scalar, Values, absolute, require_file, scalar

Made = Mapping[str, Mapping[str, Bound]]


@dataclass(frozen=True)
class Scope:
    """One graph at one place of the expansion.

    Attributes
    ----------
    prefix
        Of the ids of its tasks.
    values
        What its inputs are bound to.
    seed
        Of its nodes' random streams.
    cell
        The id of the cell that may fail without ending the run, if it is in one.
    """

    links: Links
    prefix: str
    values: Mapping[str, Bound | Scalar]
    seed: int
    cell: str = ""


@dataclass(frozen=True)
class _Place:
    """One entry of a graph that is being expanded."""

    scope: Scope
    name: str
    entry: Entry
    signature: Signature
    problem: Problem  # an example with file, line and column

    @property
    def path(self) -> Place:
        return ("nodes", self.name)

    def at(self, path: Place, text: str) -> Problem:
        return self.scope.links.graph.problem(path, text)


class Expander:
    """Adds tasks to `values`; collects problems, after which the tasks are not complete."""

    def __init__(self, values: Values) -> None:
        self.values = values
        self.problems: list[Problem] = []

    def expand(self, scope: Scope) -> dict[str, PlannedOutput]:
        """Add the tasks of one graph and return its outputs."""
        graph = scope.links.graph
        made: dict[str, Mapping[str, Bound]] = {}
        for name in scope.links.order:
            example = graph.problem(("nodes", name), "", key=True)
            place = _Place(scope, name, graph.nodes[name], scope.links.signature(name), example)
            try:
                made[name] = self.entry(place, made)
            except GraphError as error:  # what depends on it cannot be expanded
                self.problems += error.problems
        outputs = {}
        for name, output in graph.outputs.items():
            path: Place = ("outputs", name)
            source = reference(graph, path, output.source)
            if isinstance(source, FromNode) and source.node not in made:
                continue
            found, kind = self.resolve(scope, path, source, made), scope.links.type_of(path, source)
            joined = isinstance(found, tuple)
            slots = found if isinstance(found, tuple) else (found,)
            outputs[name] = PlannedOutput(name, slots, kind, joined, output.file, output.options)
        return outputs

    def entry(self, place: _Place, made: Made) -> Mapping[str, Bound]:
        """Add one entry, with all cells of its `each:`; GraphError if it cannot be."""
        values = self.arguments(place, made)
        entry, scope = place.entry, place.scope
        if not entry.each:
            return self.cell(place, place.name, values, scope.cell)
        ranges = {key: self.range(place, key, value) for key, value in entry.each.items()}
        cells = []
        problems: list[Problem] = []
        for index, choice in cells_of(ranges):
            name = f"{place.name}{index}"
            cell = f"{scope.prefix}{name}" if entry.on_error == "keep" else scope.cell
            try:
                cells.append(self.cell(place, name, {**values, **choice}, cell))
            except GraphError as error:
                problems += error.problems
        if len(cells) < math.prod(map(len, ranges.values())):
            raise GraphError(problems)
        joined: dict[str, Bound] = {}
        for socket, kind in place.signature.outputs.items():
            if not kind.many:  # a list of lists has no socket, so nothing refers to it
                joined[socket] = tuple(slot for cell_made in cells if isinstance(slot := cell_made[socket], Slot))
        return joined

    def arguments(self, place: _Place, made: Made) -> dict[str, Bound | Scalar]:
        """Return an entry's arguments as slots (sockets and measured numbers) and scalars."""
        scope, graph = place.scope, place.scope.links.graph
        values: dict[str, Bound | Scalar] = {}
        for key, value in place.entry.arguments.items():
            path = (*place.path, key)
            if key in place.signature.sockets:
                read = socket_argument(graph, path, value)
                if isinstance(read, tuple):
                    values[key] = tuple(slot for one in read for slot in _slots(self.resolve(scope, path, one, made)))
                else:
                    values[key] = self.resolve(scope, path, read, made)
                continue
            found = parameter_argument(graph, path, value)
            if isinstance(found, Measured):
                values[key] = self.resolve(scope, path, found.source, made)
            else:
                values[key] = _bound(scope, found)
        seed = place.entry.seed
        if seed is not None:
            values["seed"] = scope.values[seed[1:]] if is_input(seed) else Scalar(seed, graph.base)
        return values

    def resolve(self, scope: Scope, path: Place, source: Reference, made: Made) -> Bound:
        """Return the slots that a reference means; GraphError if what it names could not be expanded."""
        if isinstance(source, FromInput):
            bound = scope.values[source.name]
            assert not isinstance(bound, Scalar)  # found by `check`
            return bound
        if source.node not in made:
            raise GraphError([])  # told already
        return made[source.node][scope.links.find(path, source)[0]]

    def range(self, place: _Place, key: str, value: Any) -> list[Bound | Scalar]:
        """Return what an argument ranges over: slots for a socket, scalars for a parameter."""
        path: Place = (*place.path, "each", key)
        scope, socket = place.scope, place.signature.sockets.get(key)
        found = range_argument(scope.links.graph, path, value)
        if isinstance(found, FromInput):
            bound = scope.values[found.name]
            if isinstance(bound, Slot):
                raise GraphError([place.at(path, f"{value} is computed here; computed values cannot be ranged over")])
            items: list[Any] = (
                [Scalar(one, bound.base) for one in bound.value] if isinstance(bound, Scalar) else [*bound]
            )
            if not items:
                raise GraphError([place.at(path, f"{value} is an empty list: there is nothing to range over")])
            return items
        made: list[Bound | Scalar] = []
        problems = []
        for index, item in enumerate(found):
            if socket is None or isinstance(item, FromInput):
                made.append(_bound(scope, item))
                continue
            try:
                task = f"{scope.prefix}{place.name}.{key}[{index}]"
                made.append(self.values.open(task, socket.type, item.value, scope.links.graph.base))
            except ValueError as error:
                problems.append(place.at((*path, index), str(error)))
        if problems:
            raise GraphError(problems)
        return made

    def cell(self, place: _Place, name: str, values: dict[str, Bound | Scalar], cell: str) -> Mapping[str, Bound]:
        """Add one node or one sub-graph with all its arguments known; GraphError if they do not fit."""
        values = dict(values)
        seed = self.own_seed(place, values.pop("seed", None))
        if place.signature.node is not None:
            return self.task(place, name, place.signature.node, values, seed, cell)
        inner = place.signature.inner
        assert inner is not None  # an entry is either
        prefix = f"{place.scope.prefix}{name}/"
        bound = self.inner_values(place, prefix, inner, values)
        below = Scope(inner, prefix, bound, place.scope.seed if seed is None else seed, cell)
        outputs = self.expand(below)
        if len(outputs) < len(inner.graph.outputs):
            raise GraphError([])  # told already
        return {key: output.slots if output.joined else output.slots[0] for key, output in outputs.items()}

    def own_seed(self, place: _Place, value: Bound | Scalar | None) -> int | None:
        """Return the seed of an entry's own, None if it has none; GraphError if it is no seed."""
        if value is None:
            return None
        try:
            if not isinstance(value, Scalar):
                raise ValueError("a seed is known before the run; a measured number is not")
            return check_seed(value.value)
        except ValueError as error:
            each = ("each", "seed") if "seed" in place.entry.each else ("seed",)
            raise GraphError([place.at((*place.path, *each), str(error))]) from None

    def inner_values(
        self, place: _Place, prefix: str, inner: Links, values: Mapping[str, Bound | Scalar]
    ) -> dict[str, Bound | Scalar]:
        """Return what the inputs of a sub-graph are bound to."""
        bound: dict[str, Bound | Scalar] = {}
        problems = []
        for key, kind in inner.graph.inputs.items():
            value = values.get(key)
            try:
                if isinstance(value, Scalar):
                    bound[key] = scalar(kind, value.value, value.base)
                elif value is not None:
                    bound[key] = value
                else:
                    bound[key] = self.values.bind(f"{prefix}${key}", kind, kind.default, inner.graph.base)
            except ValueError as error:
                given = replace(place.problem, path=f"{prefix[:-1]}.{key}", message=str(error))
                default = inner.graph.problem(("inputs", key, "default"), str(error))
                problems.append(given if value is not None else default)
        if problems:
            raise GraphError(problems)
        return bound

    def task(
        self, place: _Place, name: str, node: Node[Any, Any], values: Mapping[str, Any], seed: int | None, cell: str
    ) -> dict[str, Bound]:
        """Add one call of a node; GraphError if its parameters do not fit or a file is not there."""
        scope = place.scope
        task = f"{scope.prefix}{name}"
        inputs = {key: value for key, value in values.items() if key in node.inputs}
        measured = {key: value for key, value in values.items() if key not in inputs and isinstance(value, Slot)}
        scalars = {key: value for key, value in values.items() if isinstance(value, Scalar)}
        plain = {key: value.value for key, value in scalars.items()}
        parameters, faults = validate(node.parameters, plain, unknown=measured)
        problems = [replace(place.problem, path=_dotted(task, *path), message=text) for path, text in faults]
        files: list[Path] = []
        for key in type(parameters).model_fields if parameters is not None else ():
            value = getattr(parameters, key)
            base = scalars[key].base if key in scalars else scope.links.graph.base
            found = {file: absolute(base, file) for file in files_of(value)}
            plain[key] = with_files(value, partial(_placed, found))
            for file in found.values():
                try:
                    require_file(file)
                except ValueError as error:
                    problems.append(replace(place.problem, path=_dotted(task, key), message=str(error)))
            files += found.values()
        if problems:
            raise GraphError(problems)
        self.values.tasks[task] = Task(
            task,
            node,
            inputs,
            plain,
            tuple(files),
            measured,
            seed=scope.seed if seed is None else seed,
            spawn_key=stream_words(task) if seed is None else (),
            cell=cell,
            place=place.problem,
        )
        return {socket: Slot(task, socket) for socket in node.outputs}


def _bound(scope: Scope, found: FromInput | Literal) -> Bound | Scalar:
    return Scalar(found.value, scope.links.graph.base) if isinstance(found, Literal) else scope.values[found.name]


def _slots(bound: Bound) -> tuple[Slot, ...]:
    return bound if isinstance(bound, tuple) else (bound,)


def _placed(found: Mapping[Path, Path], file: Path) -> str:
    return str(found[file])


def _dotted(*path: str | int) -> str:
    return ".".join(map(str, path))
