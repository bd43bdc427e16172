"""How a pattern of points goes on beyond its picture."""

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.splicing._pattern import LEAST_SHARED, apart, distances

Array = NDArray[Any]

FITS = 0.2
"""A pattern repeats by a vector if points then lie within this share of the spacing of others, in the mean."""
NEARLY_ALL, ROOM = 0.95, 1.3
"""How much farther places where copies meet may be from all points than nearly all between points of the picture."""
GRID = 8
"""Places in such a distance that are looked at."""
BLOCK = 3
"""Places in a row of a block that the one in its middle may speak for; odd."""
MOST_MOVED = 200_000
"""Points that are moved at once: 3 MB."""


class Tiling:
    """The pattern of a picture (height, width) carried on; what does not depend on how far is worked out once.

    Within its picture it stays as it is; beyond, it repeats by two vectors at which it agrees with itself, or else by
    the sides of its picture, less what its margins are wider than they would be between neighbours. Where copies then
    leave more room than there is anywhere between points of the picture, since elements that its border cuts were not
    found, points are put in; not where a picture has margins that are as wide as distances between points.
    """

    def __init__(self, points: Array, size: tuple[int, int], unit: float) -> None:
        self.points, self.size, self.unit = points, size, unit
        self.edge = np.array(size[::-1]) - 0.5

    def over(self, low: Array, high: Array) -> Array:
        """The points (n, 2) in the box from ``low`` to ``high``, both (x, y)."""
        kept = self.points[((self.points >= low) & (self.points <= high)).all(axis=1)]
        if (low >= -0.5).all() and (high <= self.edge).all():
            return kept
        sides, corner, cell = self._cell
        first, last = self._filled
        corners = np.array([[low[0], low[1]], [high[0], low[1]], [low[0], high[1]], [high[0], high[1]]])
        reach = (corners - corner) @ np.linalg.inv(sides)
        (left, top), (right, bottom) = np.floor(reach.min(axis=0)).astype(int), np.ceil(reach.max(axis=0)).astype(int)
        i, j = np.mgrid[left - 1 : right + 2, top - 1 : bottom + 2].reshape(2, -1)
        found = (np.stack([i, j], axis=1) @ sides)[:, None] + cell
        found = found.reshape(-1, 2)
        found = found[((found >= low) & (found <= high)).all(axis=1)]
        found = found[((found < first) | (found > last)).any(axis=1)]
        joined = apart(np.concatenate([kept, found]), 0.4 * self.unit)
        margins = np.stack([self.points.min(axis=0) + 0.5, self.edge - self.points.max(axis=0)])
        return joined if margins.max() > self.unit else without_gaps(joined, ROOM * self._widest, low, high)

    @cached_property
    def _filled(self) -> tuple[Array, Array]:
        """First and last corner (x, y) of the part of the picture that is filled: half a distance around the points.

        No more than one unit is taken off a side: a wider margin belongs to the pattern.
        """
        around = max(1.0, float(np.median(distances(self.points)))) / 2
        first = np.clip(self.points.min(axis=0) - around, -0.5, self.unit - 0.5)
        return first, np.clip(self.points.max(axis=0) + around, self.edge - self.unit, self.edge)

    @cached_property
    def _cell(self) -> tuple[Array, Array, Array]:
        """Two vectors (2, 2) by which the pattern repeats, the corner of what they repeat, and its points."""
        first, last = self._filled
        sides = self._periods(last - first)
        corner = (first + last - sides.sum(axis=0)) / 2
        share = (self.points - corner) @ np.linalg.inv(sides)
        cell = self.points[((share >= 0) & (share < 1)).all(axis=1)]
        return (sides, corner, cell) if len(cell) else (np.diag(last - first), corner, self.points)

    def _periods(self, sides: Array) -> Array:
        """Two vectors (2, 2) by which the pattern repeats, half the given sides long at least; by default these."""
        result = np.diag(sides)
        if len(self.points) < 2 * LEAST_SHARED:
            return result
        shifts = (self.points[None] - self.points[:, None]).reshape(-1, 2)
        for axis in (0, 1):
            along, across = shifts[:, axis], np.abs(shifts[:, 1 - axis])
            side = result[axis, axis]
            chosen = shifts[(along >= 0.5 * side) & (along <= side) & (across <= 0.6 * self.unit)]
            chosen = np.unique(chosen.round(1), axis=0)
            best = FITS * self.unit
            for shift, misfit in zip(chosen, self._misfits(chosen), strict=True):
                if misfit < best - 1e-9:
                    best = misfit
                    result[axis] = shift
        return result

    def _misfits(self, shifts: Array) -> Array:
        """Mean distance of shifted points to the nearest others, both ways, where the pictures overlap; (k,)."""
        from scipy.spatial import cKDTree

        last = np.array(self.size[::-1]) - 1
        tree = cKDTree(self.points)
        totals, counts = np.zeros((2, len(shifts)))
        step = max(1, MOST_MOVED // (2 * len(self.points)))
        for start in range(0, len(shifts), step):
            part = shifts[start : start + step]
            moved = self.points + np.stack([part, -part], axis=1)[:, :, None]
            inside = ((moved >= 0) & (moved <= last)).all(axis=-1)
            away, owner = np.asarray(tree.query(moved[inside])[0]), np.nonzero(inside)[0]
            totals[start : start + step] = np.bincount(owner, away, len(part))
            counts[start : start + step] = np.bincount(owner, minlength=len(part))
        return np.where(counts >= LEAST_SHARED, totals / np.maximum(counts, 1), np.inf)

    @cached_property
    def _widest(self) -> float:
        """How far nearly all places between points, in the box around these, are from the nearest one at most."""
        from scipy.spatial import cKDTree

        x, y = _axes(self.points.min(axis=0), self.points.max(axis=0), self.unit / GRID)
        return float(np.quantile(np.asarray(cKDTree(self.points).query(_grid(x, y))[0]), NEARLY_ALL))


def without_gaps(points: Array, widest: float, low: Array, high: Array) -> Array:
    """The points, and one in each place of a box that is farther than `widest` from all, the farthest first."""
    if len(points) == 0 or (high - low).min() <= 2 * widest:
        return points
    x, y = _axes(low + widest, high - widest, widest / GRID)  # beyond the box there may be others
    places, away = far_places(points, x, y, widest)
    added = []
    while len(away) and away.max() > widest:
        added.append(places[away.argmax()])
        away = np.minimum(away, np.hypot(*(places - added[-1]).T))
    return np.concatenate([points, added]) if added else points


def far_places(points: Array, x: Array, y: Array, widest: float) -> tuple[Array, Array]:
    """Places (k, 2) of a grid, all that are farther than `widest` from all points among them, and how far they are."""
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    middles = [axis[np.minimum(np.arange(BLOCK // 2, len(axis) + BLOCK // 2, BLOCK), len(axis) - 1)] for axis in (x, y)]
    # distances change no faster than places: a block whose middle is near enough need not be looked at
    across, down = (float(np.diff(axis).max(initial=0)) for axis in (x, y))
    reach = BLOCK // 2 * np.hypot(across, down)
    near = np.asarray(tree.query(_grid(*middles))[0]).reshape(len(middles[1]), -1) + reach * (1 + 1e-9) > widest
    chosen = near[np.ix_(np.arange(len(y)) // BLOCK, np.arange(len(x)) // BLOCK)]
    places = _grid(x, y)[chosen.ravel()]
    return places, np.asarray(tree.query(places)[0])


def _axes(low: Array, high: Array, step: float) -> tuple[Array, Array]:
    """Coordinates x and y of a grid over a box, about a step apart."""
    counts = np.maximum(np.ceil((high - low) / step), 1).astype(int) + 1
    x, y = (np.linspace(first, last, count) for first, last, count in zip(low, high, counts, strict=True))
    return x, y


def _grid(x: Array, y: Array) -> Array:
    """Places (n, 2) of a grid, row by row."""
    return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
