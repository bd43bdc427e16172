"""Places of boxes and courses of links: columns from left to right, no box on another, no link across a box."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from graphtex.show.boxes import Body
from graphtex.show.layers import Layers, Vertex, Waypoint, Wire, arrange
from graphtex.show.scene import Link

BETWEEN = 20.0  # least distance of two boxes in a column
THREAD = 12.0  # height that links take where they pass a column
_LEAST_GAP, _WIDEST_GAP = 56.0, 190.0  # distance of two columns
_PASSES = 10


@dataclass(frozen=True)
class Placed:
    """A box at its place."""

    body: Body
    x: float
    y: float


@dataclass(frozen=True)
class Route:
    """A link and the course of its line, as SVG path data."""

    link: Link
    path: str


@dataclass(frozen=True)
class Layout:
    """The drawing: its size, its boxes and its lines."""

    width: float
    height: float
    boxes: tuple[Placed, ...]
    routes: tuple[Route, ...]


def layout(bodies: Sequence[Body], links: Sequence[Link]) -> Layout:
    """Place boxes and draw links; the top left corner is (0, 0)."""
    by_key = {body.box.key: body for body in bodies}
    layers = arrange([body.box for body in bodies], links)
    tops = _settle(layers, by_key)
    lefts, rights = _columns(layers, by_key, tops)
    placed: dict[str, Placed] = {}
    for layer, column in enumerate(layers.columns):
        for vertex in column:
            if isinstance(vertex, str):
                body = by_key[vertex]
                x = rights[layer] - body.width - body.margin if body.box.kind == "input" else lefts[layer]
                placed[vertex] = Placed(body, x, tops[vertex])
    layer_of = {vertex: layer for layer, column in enumerate(layers.columns) for vertex in column}
    routes = tuple(
        Route(link, _path(link, placed, (layer_of[link.source], layer_of[link.target]), tops, lefts, rights))
        for link in links
    )
    height = max((tops[v] + _height(v, by_key) for column in layers.columns for v in column), default=0.0)
    return Layout(rights[-1], height, tuple(placed[body.box.key] for body in bodies), routes)


def _height(vertex: Vertex, bodies: Mapping[str, Body]) -> float:
    return THREAD if isinstance(vertex, Waypoint) else bodies[vertex].height + bodies[vertex].margin


def _columns(
    layers: Layers, bodies: Mapping[str, Body], tops: Mapping[Vertex, float]
) -> tuple[list[float], list[float]]:
    """Return where each column begins and ends; steep links get wider gaps."""
    lefts, rights, x = [], [], 0.0
    for layer, column in enumerate(layers.columns):
        wide = max((bodies[v].width + bodies[v].margin for v in column if isinstance(v, str)), default=0.0)
        lefts.append(x)
        rights.append(x + wide)
        rises = [abs(_end(wire, bodies, tops) - _start(wire, bodies, tops)) for wire in layers.wires[layer]]
        x += wide + round(min(max([_LEAST_GAP, *(0.3 * rise for rise in rises)]), _WIDEST_GAP))
    return lefts, rights


def _out(wire: Wire, bodies: Mapping[str, Body]) -> float:
    return THREAD / 2 if isinstance(wire.source, Waypoint) else bodies[wire.source].outs[wire.out]


def _into(wire: Wire, bodies: Mapping[str, Body]) -> float:
    return THREAD / 2 if isinstance(wire.target, Waypoint) else bodies[wire.target].ins[wire.into]


def _start(wire: Wire, bodies: Mapping[str, Body], tops: Mapping[Vertex, float]) -> float:
    return tops[wire.source] + _out(wire, bodies)


def _end(wire: Wire, bodies: Mapping[str, Body], tops: Mapping[Vertex, float]) -> float:
    return tops[wire.target] + _into(wire, bodies)


def _path(
    link: Link,
    placed: Mapping[str, Placed],
    span: tuple[int, int],
    tops: Mapping[Vertex, float],
    lefts: Sequence[float],
    rights: Sequence[float],
) -> str:
    """Return a line that is level inside columns and bends only between them."""
    source, target = placed[link.source], placed[link.target]
    first, last = span
    y = source.y + source.body.outs[link.out]
    steps = [f"M{source.x + source.body.width:g},{y:g}H{rights[first]:g}"]
    for layer in range(first + 1, last + 1):
        if layer == last:
            next_y, stop = target.y + target.body.ins[link.into], target.x
        else:
            next_y, stop = tops[Waypoint(link.source, link.out, layer)] + THREAD / 2, rights[layer]
        middle = (rights[layer - 1] + lefts[layer]) / 2
        steps.append(f"C{middle:g},{y:g} {middle:g},{next_y:g} {lefts[layer]:g},{next_y:g}H{stop:g}")
        y = next_y
    return "".join(steps)


@dataclass(frozen=True)
class _Wish:
    """Where a neighbour would have a vertex, and how much that counts: long straight links count more."""

    wire: Wire
    weight: float


def _settle(layers: Layers, bodies: Mapping[str, Body]) -> dict[Vertex, float]:
    """Return the top of every vertex, the least being 0.

    Each column in turn takes the places nearest to those that its neighbours wish for, as far as its order allows.
    """
    tops: dict[Vertex, float] = {}
    for column in layers.columns:
        tops.update(zip(column, _offsets(column, bodies), strict=True))
    before: defaultdict[Vertex, list[_Wish]] = defaultdict(list)
    after: defaultdict[Vertex, list[_Wish]] = defaultdict(list)
    for wires in layers.wires:
        for wire in wires:
            weight = (8.0, 2.0, 1.0)[isinstance(wire.source, str) + isinstance(wire.target, str)]
            before[wire.target].append(_Wish(wire, weight))
            after[wire.source].append(_Wish(wire, weight))
    for index in range(_PASSES):
        back, both = index % 2 == 1, index >= _PASSES - 2
        for column in reversed(layers.columns) if back else layers.columns:
            wishes = [
                _mean_wish(vertex, before[vertex] if both or not back else [], after[vertex] if both or back else [],
                           bodies, tops)
                for vertex in column
            ]  # fmt: skip
            tops.update(zip(column, _spread(column, wishes, bodies), strict=True))
    least = min(tops.values(), default=0.0)
    return {vertex: float(round(y - least)) for vertex, y in tops.items()}


def _offsets(column: Sequence[Vertex], bodies: Mapping[str, Body]) -> list[float]:
    """Return the tops of a column's vertices when they stand as close as they may."""
    offsets: list[float] = []
    y = 0.0
    for above, vertex in zip([None, *column], column, strict=False):
        threads = isinstance(above, Waypoint) + isinstance(vertex, Waypoint)
        y += (BETWEEN, 0.6 * BETWEEN, 0.0)[threads] if above is not None else 0.0
        offsets.append(y)
        y += _height(vertex, bodies)
    return offsets


def _mean_wish(
    vertex: Vertex,
    before: Sequence[_Wish],
    after: Sequence[_Wish],
    bodies: Mapping[str, Body],
    tops: Mapping[Vertex, float],
) -> tuple[float, float]:
    """Return the top that would make a vertex's links level on average, and the weight of that."""
    told = [(_start(w.wire, bodies, tops) - _into(w.wire, bodies), w.weight) for w in before]
    told += [(_end(w.wire, bodies, tops) - _out(w.wire, bodies), w.weight) for w in after]
    weight = sum(weight for _, weight in told)
    return (sum(y * w for y, w in told) / weight, weight) if told else (tops[vertex], 0.1)


def _spread(column: Sequence[Vertex], wishes: Sequence[tuple[float, float]], bodies: Mapping[str, Body]) -> list[float]:
    """Return the tops with the least weighted squared distance to the wishes that keep order and distances.

    With the heights above each vertex taken off this is isotonic regression, which pooling adjacent violators solves.
    """
    offsets = _offsets(column, bodies)
    pools: list[tuple[float, float, int]] = []  # mean, weight, how many
    for (wish, weight), above in zip(wishes, offsets, strict=True):
        mean, count = wish - above, 1
        while pools and pools[-1][0] >= mean:
            other, other_weight, other_count = pools.pop()
            mean = (mean * weight + other * other_weight) / (weight + other_weight)
            weight, count = weight + other_weight, count + other_count
        pools.append((mean, weight, count))
    means = [mean for mean, _, count in pools for _ in range(count)]
    return [mean + above for mean, above in zip(means, offsets, strict=True)]
