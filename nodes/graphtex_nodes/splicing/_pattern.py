"""Point patterns: their spacing, their orientation, and how they go on beyond their picture."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

ANGLES = 360
"""Directions over half a turn at which a pattern is projected."""
PEAK = 2.2
"""A direction is one of the pattern's if the variance there is so many times the median over all directions."""
SIMILAR = 0.5
"""Peaks of less than this share of the highest are not candidates."""
MOST = 6
FITS = 0.2
"""A pattern repeats by a vector if points then lie within this share of the spacing of others, in the mean."""
LEAST_SHARED = 4
NEARLY_ALL, ROOM = 0.95, 1.3
"""How much farther places where copies meet may be from all points than nearly all between points of the picture."""
GRID = 8
"""Places in such a distance that are looked at."""


def spacing(points: Array, size: tuple[int, int] | None, neighbours: int) -> float:
    """Mean distance to the nearest ``neighbours`` points, or to all others if there are fewer.

    Only points count whose neighbours are nearer than the border of their picture (height, width), since others may
    have nearer ones beyond it; all if there is none such.
    """
    from scipy.spatial import cKDTree

    count = min(neighbours, len(points) - 1)
    nearest = np.asarray(cKDTree(points).query(points, k=[*range(2, count + 2)])[0])
    if size is not None:
        border = np.minimum(points, np.array(size[::-1]) - 1 - points).min(axis=1)
        inner = nearest[:, -1] <= border
        if inner.any():
            nearest = nearest[inner]
    return float(nearest.mean())


def distances(points: Array) -> Array:
    """Distance of each point to the nearest other one, (n,)."""
    from scipy.spatial import cKDTree

    found: Array = np.asarray(cKDTree(points).query(points, k=[2])[0])[:, 0]
    return found


def orientations(points: Array, unit: float) -> Array:
    """Angles (degrees, clockwise, in [0, 180)) of the pattern's rows, strongest first; empty if it has none.

    The Radon transform of the points within a disc about their centroid, as histograms of their distance from a line
    through it. Along a row of a lattice points fall into few bins: the variance over the bins has a peak there
    (Jafari-Khouzani & Soltanian-Zadeh 2005).
    """
    from scipy.ndimage import gaussian_filter1d

    offset = points - points.mean(axis=0)
    # as in a picture of the points, whatever is beyond the largest circle about the middle would favour the corners
    reach = min(np.abs(offset).max(axis=0))
    offset = offset[(offset**2).sum(axis=1) <= reach**2]
    if len(offset) < 2 * LEAST_SHARED:
        return np.empty(0)
    angles = np.arange(ANGLES) * np.pi / ANGLES
    distance = offset @ np.stack([-np.sin(angles), np.cos(angles)])
    width = unit / 24
    half = int(np.ceil(reach / width)) + 6
    bins = np.rint(distance / width).astype(np.int64) + half
    count = 2 * half + 1
    projected = np.bincount((bins + count * np.arange(ANGLES)).ravel(), minlength=count * ANGLES)
    smooth = gaussian_filter1d(projected.reshape(ANGLES, count).astype(np.float64), 2.0, mode="constant")
    chord = np.sqrt(np.maximum(reach**2 - ((np.arange(count) - half) * width) ** 2, 0))
    variance = np.var(smooth / (chord + unit), axis=1)
    peaks = (variance >= np.roll(variance, 1)) & (variance > np.roll(variance, -1))
    peaks &= (variance > PEAK * np.median(variance)) & (variance >= SIMILAR * variance.max())
    found = np.flatnonzero(peaks)
    order = found[np.argsort(-variance[found], kind="stable")][:MOST]
    result: Array = np.degrees(angles[order])
    return result


def tiled(points: Array, size: tuple[int, int], unit: float, low: Array, high: Array) -> Array:
    """The pattern of a picture (height, width) carried on over the box from ``low`` to ``high``, (n, 2).

    Within its picture it stays as it is; beyond, it repeats by two vectors at which it agrees with itself, or else by
    the sides of its picture, less what its margins are wider than they would be between neighbours. Where copies then
    leave more room than there is anywhere between points of the picture, since elements that its border cuts were not
    found, points are put in; not where a picture has margins that are as wide as distances between points.
    """
    edge = np.array(size[::-1]) - 0.5
    kept = points[((points >= low) & (points <= high)).all(axis=1)]
    if (low >= -0.5).all() and (high <= edge).all():
        return kept
    first, last = _filled(points, size, unit)
    sides = _periods(points, size, unit, last - first)
    corner = (first + last - sides.sum(axis=0)) / 2
    share = (points - corner) @ np.linalg.inv(sides)
    cell = points[((share >= 0) & (share < 1)).all(axis=1)]
    if len(cell) == 0:
        cell, sides = points, np.diag(last - first)
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [low[0], high[1]], [high[0], high[1]]])
    reach = (corners - corner) @ np.linalg.inv(sides)
    (left, top), (right, bottom) = np.floor(reach.min(axis=0)).astype(int), np.ceil(reach.max(axis=0)).astype(int)
    i, j = np.mgrid[left - 1 : right + 2, top - 1 : bottom + 2].reshape(2, -1)
    found = (np.stack([i, j], axis=1) @ sides)[:, None] + cell
    found = found.reshape(-1, 2)
    found = found[((found >= low) & (found <= high)).all(axis=1)]
    found = found[((found < first) | (found > last)).any(axis=1)]
    joined = apart(np.concatenate([kept, found]), 0.4 * unit)
    margins = np.stack([points.min(axis=0) + 0.5, edge - points.max(axis=0)])
    return joined if margins.max() > unit else _without_gaps(joined, ROOM * _widest(points, unit), low, high)


def _widest(points: Array, unit: float) -> float:
    """How far nearly all places between points, in the box around these, are from the nearest one at most."""
    from scipy.spatial import cKDTree

    places = _grid(points.min(axis=0), points.max(axis=0), unit / GRID)
    return float(np.quantile(np.asarray(cKDTree(points).query(places)[0]), NEARLY_ALL))


def _without_gaps(points: Array, widest: float, low: Array, high: Array) -> Array:
    """The points, and one in each place of a box that is farther than `widest` from all, the farthest first."""
    from scipy.spatial import cKDTree

    if len(points) == 0 or (high - low).min() <= 2 * widest:
        return points
    places = _grid(low + widest, high - widest, widest / GRID)  # beyond the box there may be others
    away = np.asarray(cKDTree(points).query(places)[0])
    added = []
    while away.max() > widest:
        added.append(places[away.argmax()])
        away = np.minimum(away, np.hypot(*(places - added[-1]).T))
    return np.concatenate([points, added]) if added else points


def _grid(low: Array, high: Array, step: float) -> Array:
    """Places (n, 2) of a box, about a step apart."""
    counts = np.maximum(np.ceil((high - low) / step), 1).astype(int) + 1
    axes = [np.linspace(first, last, count) for first, last, count in zip(low, high, counts, strict=True)]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


def apart(points: Array, distance: float) -> Array:
    """The points but those that are nearer than a distance to an earlier one that stays."""
    from scipy.spatial import cKDTree

    stays = np.ones(len(points), bool)
    if len(points) > 1:
        for first, second in sorted(cKDTree(points).query_pairs(distance)):
            stays[second] &= not stays[first]
    result: Array = points[stays]
    return result


def _filled(points: Array, size: tuple[int, int], unit: float) -> tuple[Array, Array]:
    """First and last corner (x, y) of the part of a picture that a pattern fills: half a distance around its points.

    No more than one ``unit`` is taken off a side: a wider margin belongs to the pattern.
    """
    around = max(1.0, float(np.median(distances(points)))) / 2
    edge = np.array(size[::-1]) - 0.5
    first = np.clip(points.min(axis=0) - around, -0.5, unit - 0.5)
    return first, np.clip(points.max(axis=0) + around, edge - unit, edge)


def _periods(points: Array, size: tuple[int, int], unit: float, sides: Array) -> Array:
    """Two vectors (2, 2) by which the pattern repeats, half the given sides long at least; by default these."""
    result = np.diag(sides)
    if len(points) < 2 * LEAST_SHARED:
        return result
    shifts = (points[None] - points[:, None]).reshape(-1, 2)
    for axis in (0, 1):
        along, across = shifts[:, axis], np.abs(shifts[:, 1 - axis])
        side = result[axis, axis]
        chosen = shifts[(along >= 0.5 * side) & (along <= side) & (across <= 0.6 * unit)]
        best = FITS * unit
        for shift in np.unique(chosen.round(1), axis=0):
            misfit = _misfit(points, shift, size)
            if misfit < best - 1e-9:
                best = misfit
                result[axis] = shift
    return result


def _misfit(points: Array, shift: Array, size: tuple[int, int]) -> float:
    """Mean distance of shifted points to the nearest others, both ways, where the pictures overlap."""
    from scipy.spatial import cKDTree

    last = np.array(size[::-1]) - 1
    tree = cKDTree(points)
    distances = []
    for move in (shift, -shift):
        moved = points + move
        moved = moved[((moved >= 0) & (moved <= last)).all(axis=1)]
        distances.append(tree.query(moved)[0])
    together = np.concatenate(distances)
    return float(together.mean()) if len(together) >= LEAST_SHARED else np.inf
