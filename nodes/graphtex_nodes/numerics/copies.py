"""Where an output shows the same part of its exemplar again, and how far it shows one piece."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import copies_kernels

Array = NDArray[np.float32]
Field = NDArray[np.int32]

NEAREST, FARTHEST = 2, 4
"""Distances at which a piece goes on, or does not, in sixths of the exemplar's smaller side."""


class Shown(NamedTuple):
    """What parts of an exemplar the parts of an output show.

    Attributes
    ----------
    counts
        How often windows in each of a x b tiles of the output show each cell of the exemplar, int32
        (a, b, h / cell, w / cell), both rounded up.
    tile, cell
        Sides of a tile in windows of the output, and of a cell in windows of the exemplar.
    step
        Distance of neighbouring windows of the output in pixels.
    reach
        Half the exemplar's smaller side, in windows of the output.
    """

    counts: NDArray[np.int32]
    tile: int
    cell: int
    step: int
    reach: float


def shown(field: Field, shape: tuple[int, int], step: int) -> Shown:
    """What the sources (rows, columns, 2) of an output's windows show of the h x w windows of an exemplar.

    Tiles have a sixth of the exemplar's smaller side. Cells are smaller than tiles.
    """
    reach = min(shape) / 2 / step
    tile = max(1, round(reach / 3))
    cell = step * max(1, tile // 2)
    counts = np.zeros(
        [-(-side // part) for side, part in zip((*field.shape[:2], *shape), (tile, tile, cell, cell), strict=True)],
        np.int32,
    )
    copies_kernels.count_shown(field, cell, counts)
    return Shown(counts, tile, cell, step, reach)


def crowding(found: Shown) -> Array:
    """How many other copies of each cell of the exemplar are shown around each tile of the output.

    Those count that are at most half the exemplar away, but not the nearest: a tile and the eight around it are the
    place itself. Without a charge for them copies meet as chance has it: the eye finds those that are close together.
    Neighbouring cells share what they are shown: they hold the same elements.

    Returns
    -------
    float32, as large as ``found.counts``.
    """
    copies = np.empty(found.counts.shape, np.float32)
    copies_kernels.copies_around(found.counts, round(found.reach / found.tile), copies)
    copies *= np.float32((found.step / found.cell) ** 2)
    return copies


def stretch(found: Shown) -> tuple[Array, float]:
    """How far each cell of the exemplar, shown in each tile of the output, would go on with a piece there.

    What counts is a ring around a tile, :data:`NEAREST` to :data:`FARTHEST` sixths of the exemplar away: how much of it
    shows the exemplar at the same shift.

    Returns
    -------
    share, common
        float32, as large as ``found.counts``: share of the ring, and the mean of it over what is shown.
    """
    from scipy.ndimage import uniform_filter

    lines = found.tile * found.step / found.cell
    going_on = _going_on(found.counts, FARTHEST, lines) - _going_on(found.counts, NEAREST - 1, lines)
    ring = (2 * FARTHEST + 1) ** 2 - (2 * NEAREST - 1) ** 2
    share = uniform_filter(going_on.astype(np.float32), (1, 1, 3, 3), mode="nearest")
    share *= np.float32((found.step / found.cell) ** 2 / ring)
    return share, float((found.counts * share).sum(dtype=np.float64) / found.counts.sum())


def _going_on(counts: NDArray[np.int32], radius: int, lines: float) -> NDArray[np.int32]:
    """Sums (a, b, h, w) over the tiles at most ``radius`` away each way of what goes on, ``lines`` cells a tile."""
    for axis in (0, 1):
        total = np.zeros_like(counts)
        for shift in range(-radius, radius + 1):
            here, there = [slice(None)] * 4, [slice(None)] * 4
            for along, move in ((axis, shift), (axis + 2, round(shift * lines))):
                side = counts.shape[along]
                here[along] = slice(max(0, -move), max(0, min(side, side - move)))
                there[along] = slice(max(0, move), max(0, min(side, side + move)))
            total[tuple(here)] += counts[tuple(there)]
        counts = total
    return counts
