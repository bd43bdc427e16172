"""Large pieces that take over the scraps between them, with seams along minimum cuts (Kwatra et al. 2003)."""

from collections import deque
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import cut_kernels, piece_kernels
from graphtex_nodes.numerics.parallel import Work, begun_rows, for_rows
from graphtex_nodes.numerics.piece_kernels import AREA

Array = NDArray[np.float32]
Field = NDArray[np.int32]
Flags = NDArray[np.bool_]

Box = tuple[int, int, int, int]
"""First row, the one behind the last, first column and the one behind the last."""

SIDES = ((4, 2, 64), (2, 1, 6))
"""Blocks: their side, every how many pixels costs are looked at, and how far a piece may grow; all in pixels."""
LEAST = 400
"""Pixels of a piece from which it may grow: smaller ones are scraps, which are there to be taken over."""
AHEAD = 3
"""Pieces, the one that is cut among them, whose costs are found at a time: others are found while one is cut."""
LEAD = 0.4
"""Share of a piece's costs that a helping thread finds in one go, as long as a cut takes: that holds the GIL."""


@dataclass(frozen=True)
class Costs:
    """What a source map costs, in units of squared differences of colour.

    Attributes
    ----------
    pull
        Weights (c,) of squared differences from the wanted image.
    join
        Cost of each pair of neighbouring pixels from different pieces, beside their differences.
    busy
        Squared difference of neighbouring pixels in a piece at which a seam shows half as much as on plain ground.
    """

    pull: Array
    join: float
    busy: float


def recut(
    exemplar: Array, usable: NDArray[np.uint8], image: Array, source: Field, costs: Costs, work: Work,
    wrap: tuple[bool, bool] = (False, False),
) -> Field:  # fmt: skip
    """Source map (h, w, 2) in which pieces have grown as long as that lowers the cost.

    One piece after the other, the largest first, takes over what it can around it: a minimum cut (alpha expansion,
    Boykov et al. 2001, in a box around the piece). Cuts are found for blocks of pixels, first of large ones, then of
    small ones along the seams that these left.

    Parameters
    ----------
    exemplar
        Shape (eh, ew, c); ``usable`` (eh, ew) is 0 where a pixel must not be copied.
    image
        What the output should look like, with the exemplar's channels.
    source
        Rows and columns; negative where pixels are known: these stay as the image has them, and pieces beside them pay
        for how their continuation differs.
    wrap
        Whether the output wraps around along its rows and columns.
    """
    height, width = source.shape[:2]
    halves = [side // 2 if around else 0 for side, around in zip((height, width), wrap, strict=True)]
    if not any(halves):
        return _recut(exemplar, usable, image, source, costs, work, wrap)
    for turn in (halves, [-half for half in halves]):
        # borders that join come to lie in the middle, where pieces can grow over them, then back again
        source, image = np.roll(source, turn, (0, 1)), np.ascontiguousarray(np.roll(image, turn, (0, 1)))
        source = _recut(exemplar, usable, image, source, costs, work, wrap)
    return source


def _recut(
    exemplar: Array, usable: NDArray[np.uint8], image: Array, source: Field, costs: Costs, work: Work,
    held: tuple[bool, bool],
) -> Field:  # fmt: skip
    """One turn of :func:`recut`; blocks along borders that are ``held`` stay."""
    known = source[..., 0] < 0
    pieces, unknown = _blocks(source, known, SIDES[0][0])
    before = pieces.copy()
    for number, (side, step, reach) in enumerate(SIDES):
        if number > 0:
            finer = SIDES[number - 1][0] // side
            size = [-(-count // side) for count in known.shape]
            pieces, before, unknown = (_enlarged(part, finer, size) for part in (pieces, before, unknown))
        free = unknown.copy() if number == 0 else unknown & _near_seams(pieces, reach // side)
        for axis, holds in enumerate(held):
            if holds:
                free.swapaxes(0, axis)[[0, -1]] = False
        _grow(exemplar, usable, image, known, pieces, free, (side, step, reach), costs, work)
    # between scraps that nothing took over seams stay where they were to the pixel
    labels, found = _pieces(pieces)
    settled = found[labels, AREA] >= LEAST // SIDES[-1][0] ** 2
    settled |= _shifts(pieces) != _shifts(before)
    flags, result = settled.view(np.uint8), source.copy()

    def band(first: int, stop: int) -> None:
        piece_kernels.settle(pieces, flags, SIDES[-1][0], usable, result, first, stop)

    for_rows(band, result.shape[0], 10.0 * result.shape[1], work)
    return result


def _grow(
    exemplar: Array, usable: NDArray[np.uint8], image: Array, known: Flags, pieces: Field, free: Flags,
    blocks: tuple[int, int, int], costs: Costs, work: Work,
) -> None:  # fmt: skip
    """Let pieces (rows, columns, 2) of blocks grow over ``free`` ones, the largest piece first."""
    side, step, reach = blocks
    number, ends = np.empty(free.shape, np.int32), np.empty((2 * free.size, 2), np.int32)
    terms, caps, counts = np.empty((free.size, 2)), np.empty(2 * free.size), np.zeros(2, np.int64)
    # one more row and column, where the neighbours to the left of the first column and above the first row would be
    present = np.full((free.shape[0] + 1, free.shape[1] + 1, 3), -1, np.float32)
    grown = np.empty((*free.shape, 5), np.float32)
    weights = costs.pull, np.float32(costs.join), np.float32(costs.busy)
    flags, open_ = known.view(np.uint8), free.view(np.uint8)

    def begun(piece: Sequence[int], box: Box) -> AbstractContextManager[Callable[[], None]]:
        above, where = max(0, box[0] - 1), np.array(box)

        def band(first: int, stop: int) -> None:
            cut_kernels.growth_costs(
                exemplar, usable, image, flags, pieces, open_, *piece, where, side, step, *weights, present, grown,
                above + first, above + stop,
            )  # fmt: skip

        return begun_rows(band, box[1] - above, (box[3] - box[2]) * (side // step) ** 2 * 100, work, LEAD)

    def cut(piece: Sequence[int], box: Box) -> None:
        cut_kernels.growth_graph(
            pieces, open_, *piece, np.array(box), present, grown, number, terms, ends, caps, counts
        )
        nodes, edges = counts.tolist()
        if nodes:
            inside = slice(box[0], box[1]), slice(box[2], box[3])
            taken = np.append(_minimum_cut(terms[:nodes], ends[:edges], caps[:edges]), False)[number[inside]]
            pieces[inside][taken] = piece
            rows, columns = np.nonzero(taken)
            rows, columns = rows + box[0], columns + box[2]
            present[rows, columns] = present[rows, columns - 1, 1] = present[rows - 1, columns, 2] = -1

    turns = deque(_largest(pieces, max(1, LEAST // side**2), -(-reach // side)))
    shifts = pieces.reshape(-1, 2)
    started: deque[tuple[Sequence[int], Box, Callable[[], None]]] = deque()  # whose costs are being found
    with ExitStack() as bands:
        while turns or started:
            while turns and len(started) < AHEAD and all(_apart(box, turns[0][1]) for _, box, _ in started):
                first, box = turns.popleft()
                piece = shifts[first].tolist()
                started.append((piece, box, bands.enter_context(begun(piece, box))))
            piece, box, finish = started[0]
            finish()
            cut(piece, box)
            started.popleft()


def _apart(one: Box, other: Box) -> bool:
    """Whether the first piece's cut changes nothing that the costs of the other one are found from."""
    gaps = other[0] - one[1], one[0] - other[1], other[2] - one[3], one[2] - other[3]
    return max(gaps) > 1


def _minimum_cut(terms: NDArray[np.float64], ends: Field, caps: NDArray[np.float64]) -> Flags:
    """Which nodes (n,) take over, by ``terms`` (n, 2) for doing so and for staying and edges (m) between nodes."""
    import maxflow

    graph = maxflow.GraphFloat(len(terms), len(ends))
    nodes = graph.add_nodes(len(terms))
    graph.add_grid_tedges(nodes, terms[:, 0], terms[:, 1])
    graph.add_edges(ends[:, 0], ends[:, 1], caps, np.zeros(len(caps)))
    graph.maxflow()
    taken: Flags = graph.get_grid_segments(nodes)
    return taken


def _blocks(source: Field, known: Flags, side: int) -> tuple[Field, Flags]:
    """Shift (rows, columns, 2) of the unknown pixel nearest to each block's middle, and whether there is one."""
    order = sorted(np.ndindex(side, side), key=lambda at: abs(2 * at[0] + 1 - side) + abs(2 * at[1] + 1 - side))
    rows, columns = (-(-count // side) for count in known.shape)
    pieces, found = np.zeros((rows, columns, 2), np.int32), np.zeros((rows, columns), bool)
    for down, right in order if known.any() else order[:1]:
        y = np.minimum(np.arange(rows) * side + down, known.shape[0] - 1)
        x = np.minimum(np.arange(columns) * side + right, known.shape[1] - 1)
        fresh = ~found & ~known[np.ix_(y, x)]
        shifts = source.take(y, 0).take(x, 1)
        shifts[..., 0] -= y[:, None]
        shifts[..., 1] -= x
        np.copyto(pieces, shifts, where=fresh[..., None])
        found |= fresh
    return pieces, found


def _enlarged(blocks: NDArray[Any], factor: int, size: Sequence[int]) -> NDArray[Any]:
    """Values of blocks for each of the ``factor`` x ``factor`` smaller ones, as many as there are of these."""
    result: NDArray[Any] = blocks.repeat(factor, axis=0).repeat(factor, axis=1)[: size[0], : size[1]]
    return np.ascontiguousarray(result)


def _near_seams(pieces: Field, reach: int) -> Flags:
    """Which blocks have another piece within so many blocks."""
    shifts = _shifts(pieces)
    near = np.zeros(shifts.shape, bool)
    down, right = shifts[1:] != shifts[:-1], shifts[:, 1:] != shifts[:, :-1]
    near[1:] |= down
    near[:-1] |= down
    near[:, 1:] |= right
    near[:, :-1] |= right
    for lines in (near, near.T):
        seams = lines.copy("K")
        for shift in range(1, min(reach, len(lines))):
            lines[shift:] |= seams[:-shift]
            lines[:-shift] |= seams[shift:]
    return near


def _shifts(pieces: Field) -> NDArray[np.int64]:
    """Shifts (rows, columns, 2) as one number each."""
    shifts: NDArray[np.int64] = np.ascontiguousarray(pieces).view(np.int64)[..., 0]
    return shifts


def _pieces(pieces: Field) -> tuple[Field, NDArray[np.int64]]:
    """Number of the piece (rows, columns) that each block of shifts belongs to, and what is known of pieces (n, 6).

    What hangs together and has one shift is a piece; for its columns see ``piece_kernels.FIRST``.
    """
    labels, count = np.empty(pieces.shape[:2], np.int32), np.zeros(1, np.int64)
    found = np.empty((labels.size, 6), np.int64)
    piece_kernels.label_pieces(pieces, labels, found, count)
    return labels, found[: int(count[0])]


def _largest(pieces: Field, least: int, reach: int) -> list[tuple[int, Box]]:
    """A block of each piece of at least so many, the largest piece first, and the box ``reach`` around the piece.

    Pieces may change before their turn comes: one that was taken over has lost it to what is in its place.
    """
    rows, columns = pieces.shape[:2]
    found = _pieces(pieces)[1]
    found = found[found[:, AREA] >= least]
    return [
        (first, (max(0, top - reach), min(rows, bottom + reach), max(0, left - reach), min(columns, right + reach)))
        for first, _, top, bottom, left, right in found[np.argsort(-found[:, AREA], kind="stable")].tolist()
    ]
