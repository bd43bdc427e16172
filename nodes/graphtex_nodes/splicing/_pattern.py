"""Point patterns: their spacing and their orientation."""

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
LEAST_SHARED = 4


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


def regularity(points: Array) -> float:
    """1 where all points are equally far from their nearest neighbour, less the more these distances vary."""
    nearest = distances(points)
    return float(1 / (1 + nearest.std() / max(nearest.mean(), 1e-9)))


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


def apart(points: Array, distance: float) -> Array:
    """The points but those that are nearer than a distance to an earlier one that stays."""
    from scipy.spatial import cKDTree

    stays = np.ones(len(points), bool)
    if len(points) > 1:
        for first, second in sorted(cKDTree(points).query_pairs(distance)):
            stays[second] &= not stays[first]
    result: Array = points[stays]
    return result
