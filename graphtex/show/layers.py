"""Layers of a drawing: which column each box stands in, and in which order, so that few links cross.

The layered method of Sugiyama, Tagawa and Toda (1981): longest paths, dummy points where a link passes a column, and
sweeps that order each column by the barycentre of its neighbours. Links from one port share their dummy points.
"""

from bisect import bisect_right, insort
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from graphtex.show.scene import Box, Link

_SWEEPS = 12
_SWAPS = 4  # passes that exchange neighbours


@dataclass(frozen=True)
class Waypoint:
    """Where links from one port pass a column."""

    box: str
    port: str
    layer: int


Vertex = str | Waypoint


@dataclass(frozen=True)
class Wire:
    """A piece of links between two neighbouring columns; ports are empty at waypoints."""

    source: Vertex
    out: str
    target: Vertex
    into: str


@dataclass(frozen=True)
class Layers:
    """The columns in order, and the wires between each column and the next."""

    columns: tuple[tuple[Vertex, ...], ...]
    wires: tuple[tuple[Wire, ...], ...]


def arrange(boxes: Sequence[Box], links: Sequence[Link]) -> Layers:
    """Return columns in a good order; the same boxes and links always give the same one."""
    layer_of = assign(boxes, links)
    depth = max(layer_of.values(), default=0) + 1
    columns: list[list[Vertex]] = [[] for _ in range(depth)]
    for box in boxes:
        columns[layer_of[box.key]].append(box.key)
    wires: list[dict[Wire, None]] = [{} for _ in range(depth)]  # dicts keep the order and drop doubles
    for link in links:
        first, last = layer_of[link.source], layer_of[link.target]
        before: Vertex = link.source
        for layer in range(first + 1, last + 1):
            after: Vertex = link.target if layer == last else Waypoint(link.source, link.out, layer)
            if isinstance(after, Waypoint) and after not in columns[layer]:
                columns[layer].append(after)
            wires[layer - 1][
                Wire(before, link.out if layer == first + 1 else "", after, link.into if layer == last else "")
            ] = None
            before = after
    ports = {box.key: (_places([p.name for p in box.ins]), _places([p.name for p in box.outs])) for box in boxes}
    order = _Order(columns, [tuple(part) for part in wires], ports)
    order.improve()
    return Layers(tuple(tuple(column) for column in order.columns), tuple(order.wires))


def assign(boxes: Sequence[Box], links: Iterable[Link]) -> dict[str, int]:
    """Return each box's column: the longest path to it; what feeds more than it reads moves close to its readers."""
    readers: dict[str, list[str]] = {box.key: [] for box in boxes}
    sources: dict[str, list[str]] = {box.key: [] for box in boxes}
    for link in links:
        readers[link.source].append(link.target)
        sources[link.target].append(link.source)
    layer: dict[str, int] = {}
    left = {key: len(found) for key, found in sources.items()}
    ready = [key for key, count in left.items() if count == 0]
    for key in ready:  # grows while it is read: a topological order
        layer[key] = max((layer[source] + 1 for source in sources[key]), default=0)
        for reader in readers[key]:
            left[reader] -= 1
            if left[reader] == 0:
                ready.append(reader)
    for key in reversed(ready):
        if readers[key] and len(readers[key]) > len(sources[key]):
            layer[key] = min(layer[reader] for reader in readers[key]) - 1
    first = min(layer.values(), default=0)
    return {key: value - first for key, value in layer.items()}


def _places(names: Sequence[str]) -> dict[str, float]:
    """Return how far down a box each port is, between 0 and 1."""
    return {name: (i + 1) / (len(names) + 1) for i, name in enumerate(names)}


class _Order:
    """Columns whose order is being improved."""

    def __init__(
        self,
        columns: list[list[Vertex]],
        wires: list[tuple[Wire, ...]],
        ports: dict[str, tuple[dict[str, float], dict[str, float]]],
    ) -> None:
        self.columns, self.wires, self.ports = columns, wires, ports
        self.place: dict[Vertex, int] = {}
        for column in columns:
            self.number(column)

    def number(self, column: Sequence[Vertex]) -> None:
        self.place.update({vertex: i for i, vertex in enumerate(column)})

    def start(self, wire: Wire) -> float:
        """Return how far down its column a wire starts."""
        inner = self.ports[wire.source][1][wire.out] if isinstance(wire.source, str) else 0.5
        return self.place[wire.source] + inner

    def end(self, wire: Wire) -> float:
        inner = self.ports[wire.target][0][wire.into] if isinstance(wire.target, str) else 0.5
        return self.place[wire.target] + inner

    def crossings(self, wires: Iterable[Wire]) -> int:
        """Count the pairs of wires between two columns that cross."""
        seen: list[float] = []
        count = 0
        for _, end in sorted((self.start(wire), self.end(wire)) for wire in wires):
            count += len(seen) - bisect_right(seen, end)
            insort(seen, end)
        return count

    def total(self) -> int:
        return sum(self.crossings(part) for part in self.wires)

    def improve(self) -> None:
        """Sweep to and fro and keep the best order that was met; then exchange neighbours while that helps."""
        best, least = [list(column) for column in self.columns], self.total()
        for sweep in range(_SWEEPS):
            if least == 0:
                break
            backwards = sweep % 2 == 1
            for layer in reversed(range(len(self.columns))) if backwards else range(len(self.columns)):
                self.sort(layer, backwards)
            crossed = self.total()
            if crossed < least:
                best, least = [list(column) for column in self.columns], crossed
        self.columns = best
        for column in best:
            self.number(column)
        for _ in range(_SWAPS):
            if not sum(self.exchange(layer) for layer in range(len(self.columns))):
                break

    def sort(self, layer: int, backwards: bool) -> None:
        """Order a column by the mean place of its neighbours on one side; those without neighbours stay put."""
        found: defaultdict[Vertex, list[float]] = defaultdict(list)
        if backwards:
            for wire in self.wires[layer]:
                found[wire.source].append(self.end(wire))
        elif layer > 0:
            for wire in self.wires[layer - 1]:
                found[wire.target].append(self.start(wire))
        column = self.columns[layer]
        moving = iter(
            sorted((v for v in column if v in found), key=lambda v: (sum(found[v]) / len(found[v]), self.place[v]))
        )
        self.columns[layer] = [next(moving) if vertex in found else vertex for vertex in column]
        self.number(self.columns[layer])

    def exchange(self, layer: int) -> bool:
        """Exchange neighbours in a column where fewer wires cross then."""
        column, changed = self.columns[layer], False
        touching: defaultdict[Vertex, list[Wire]] = defaultdict(list)
        for wire in self.wires[layer]:
            touching[wire.source].append(wire)
        leading: defaultdict[Vertex, list[Wire]] = defaultdict(list)
        if layer > 0:
            for wire in self.wires[layer - 1]:
                leading[wire.target].append(wire)
        for i in range(len(column) - 1):
            above, below = column[i], column[i + 1]
            sides = ([*touching[above], *touching[below]], [*leading[above], *leading[below]])
            before = sum(map(self.crossings, sides))
            if before == 0:
                continue
            self.place[above], self.place[below] = i + 1, i
            if sum(map(self.crossings, sides)) < before:
                column[i], column[i + 1] = below, above
                changed = True
            else:
                self.place[above], self.place[below] = i, i + 1
        return changed
