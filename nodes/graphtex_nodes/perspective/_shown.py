"""What a source map shows of maps, at any resolution."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import seam_neighbours
from graphtex_nodes.numerics.sources import Look, continued

Array = NDArray[Any]
Flags = NDArray[np.bool_]


class Shown:
    """What a source map (h, w, 6) shows of maps, with ``factor`` times as many rows and columns.

    Pixels that are not ``free`` fade into nothing; over borders that ``wrap`` around pieces fade into those beyond.
    """

    def __init__(
        self, source: Array, looks: list[Look], factor: float, free: Flags, wrap: tuple[bool, bool] = (False, False)
    ) -> None:
        self.source, self.looks, self.factor, self.free, self.wrap = source, looks, factor, free, wrap
        self.shapes = np.array([look.exemplar.shape[:2] for look in looks]) / factor
        self.rows, self.down = _pixels(source.shape[0], factor)
        self.columns, self.right = _pixels(source.shape[1], factor)
        self.channels = looks[0].exemplar.shape[2]

    @property
    def size(self) -> tuple[int, int]:
        """Rows and columns of the output."""
        return len(self.rows), len(self.columns)

    def enlarged(self, flags: Flags) -> Flags:
        """Flags (h, w) of the source map's pixels for those of the output."""
        result: Flags = flags[np.ix_(self.rows, self.columns)]
        return result

    def near_seams(self) -> Flags:
        """Which pixels of the output lie near others that show another piece."""
        return self.enlarged(seam_neighbours.near_seams(self.source, self.free, self.wrap))

    def copied(self, band: slice) -> Array:
        """Copies of the maps (rows, width, c) in a band of rows."""
        offsets = [part.ravel() for part in np.broadcast_arrays(self.down[band, None], self.right)]
        points = self.source[np.ix_(self.rows[band], self.columns)].reshape(-1, 6)
        return self._look(points, offsets).reshape(-1, len(self.columns), self.channels)

    def faded(self, chosen: Flags, band: slice, sharpness: float) -> tuple[Array, Array]:
        """Mean (n, c) of the pieces around, each continued up to the pixels that are ``chosen`` in a band of rows.

        What differs from a pixel's own piece counts (1 - ``sharpness`` * squared difference)^2, down to nothing.
        And the means (2, n, c) of their differences to the pixels below and to the right, 0 where no piece goes on.
        """
        y, x = np.nonzero(chosen[band])
        values, steps = np.zeros((len(y), self.channels)), np.zeros((2, len(y), self.channels))
        totals = np.zeros((3, len(y), 1))
        offset = [self.down[band][y], self.right[x]]
        place, parent = np.unique(self.rows[band][y] * self.source.shape[1] + self.columns[x], return_inverse=True)
        rows, columns = np.divmod(place, self.source.shape[1])
        around = seam_neighbours.around(self.source, self.free, rows, columns, self.wrap)
        apart = [part[:, None] - seam_neighbours.OFFSETS[:, axis] for axis, part in enumerate(offset)]
        weights = np.exp(-2 * (apart[0] ** 2 + apart[1] ** 2) / seam_neighbours.RADIUS**2)
        if sharpness > 0:
            own, owned = self._own(around, parent, weights, offset)
        for number in range(len(seam_neighbours.OFFSETS)):
            mine = np.flatnonzero(around.first[parent, number] == number)
            points, moved = around.points[parent[mine], number], [part[mine] for part in offset]
            if number > 0:  # a pixel's own piece shows its border if need be
                fits = self._inside(points, moved)
                mine, points, moved = mine[fits], points[fits], [part[fits] for part in moved]
            if not len(mine):
                continue
            weight = (weights[mine] * (around.first[parent[mine]] == number)).sum(axis=1, keepdims=True)
            shown = self._look(points, moved)
            if sharpness > 0:
                squared = ((shown - own[mine]) ** 2).sum(axis=1, keepdims=True)
                weight *= np.where(owned[mine], np.maximum(0, 1 - sharpness * squared), 1) ** 2
            values[mine] += weight * shown
            totals[2, mine] += weight
            for axis in (0, 1):
                ahead = [part + (side == axis) / self.factor for side, part in enumerate(moved)]
                goes = self._inside(points, ahead)
                next_ones = self._look(points[goes], [part[goes] for part in ahead])
                steps[axis, mine[goes]] += weight[goes] * (next_ones - shown[goes])
                totals[axis, mine[goes]] += weight[goes]
        values /= totals[2]
        steps /= np.where(totals[:2] > 0, totals[:2], 1)
        return values.astype(np.float32), steps.astype(np.float32)

    def _own(
        self, around: seam_neighbours.Around, parent: Array, weights: Array, offset: list[Array]
    ) -> tuple[Array, Array]:
        """Values (n, c) of the pieces that pixels belong to, and whether (n, 1) there is one that shows.

        A pixel of a larger map belongs to the piece of which the source map has most near it, by the squares of
        ``weights`` (n, 25): borders between pieces that do not fade then have no steps as wide as the map's pixels.
        """
        number = np.zeros(len(parent), np.intp)
        if self.factor != 1:
            first, share = around.first[parent], weights**2
            number = np.argmax([(share * (first == each)).sum(axis=1) for each in range(share.shape[1])], axis=0)
            number[~self._inside(around.points[parent, number], offset)] = 0
        there = around.first[parent, number] == number
        return self._look(around.points[parent, number], offset), there[:, None]

    def _inside(self, points: Array, offset: list[Array]) -> Flags:
        """Whether pieces go on at an offset from points (n, 6) of the source map."""
        places = continued(points, *offset)
        inside = (places > -0.5) & (places < self.shapes[points[:, 0].astype(np.intp)] - 0.5)
        result: Flags = np.all(inside, axis=1)
        return result

    def _look(self, points: Array, offset: list[Array]) -> Array:
        """Values (n, c) at an offset (down, right), in its pixels, from points (n, 6) of the source map."""
        places = continued(points, *offset)
        points = points.astype(np.float64)
        if self.factor != 1:
            places = (places + 0.5) * self.factor - 0.5
            whole = np.rint(places)
            places = np.where(np.abs(places - whole) < 1e-6, whole, places)
        points[:, 1:3] = places
        result = np.empty((len(points), self.channels), np.float32)
        for number, look in enumerate(self.looks):
            own = points[:, 0] == number
            if own.any():
                result[own] = look.at(points[own])
        return result


def _pixels(count: int, factor: float) -> tuple[Array, Array]:
    """For pixels of the output, along an axis: the pixel of the source map, and how far from its middle they lie."""
    place = (np.arange(max(1, round(count * factor))) + 0.5) / factor - 0.5
    nearest = np.clip(np.rint(place - 1e-9), 0, count - 1).astype(np.intp)
    return nearest, place - nearest
