"""Closed outlines (n, 2): x and y of corners in order, the last joined to the first."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

NEAR = 1e-6


class Moments(NamedTuple):
    """Area (positive if the corners run clockwise, y down), centre (2,), and covariance (2, 2) of what is inside."""

    area: float
    centre: Array
    covariance: Array


def moments(outline: Array) -> Moments:
    """Moments of what an outline encloses, by Green's theorem.

    >>> square = np.array([[0.0, 0], [6, 0], [6, 6], [0, 6]])
    >>> moments(square)
    Moments(area=36.0, centre=array([3., 3.]), covariance=array([[3., 0.],
           [0., 3.]]))
    """
    origin = outline.mean(axis=0)
    here = outline - origin
    there = np.roll(here, -1, axis=0)
    cross = here[:, 0] * there[:, 1] - there[:, 0] * here[:, 1]
    area = cross.sum() / 2
    both = here + there
    centre = (both * cross[:, None]).sum(axis=0) / (6 * area)
    x, y = (here**2 + here * there + there**2).T
    mixed = (both[:, 0] * both[:, 1] + here[:, 0] * here[:, 1] + there[:, 0] * there[:, 1]) * cross
    xx, yy, xy = (x * cross).sum() / 12, (y * cross).sum() / 12, mixed.sum() / 24
    second = np.array([[xx, xy], [xy, yy]]) / area
    return Moments(float(area), origin + centre, second - np.outer(centre, centre))


def around(field: Array, corner: Array) -> Array | None:
    """The longest outline, clockwise, around what is positive in a field (h, w); None without any.

    The field's first pixel is at ``corner`` (x, y), and beyond its border nothing is positive.
    """
    from skimage.measure import find_contours

    padded = np.pad(field, 1, constant_values=min(float(field.min()), -1.0))
    found = find_contours(padded, 0.0)
    longest = max(found, key=len, default=np.empty((0, 2)))[:-1, ::-1] - 1 + corner
    if len(longest) < 4:
        return None
    area = moments(longest).area
    return None if abs(area) < 1 else longest if area > 0 else longest[::-1]


def evenly(outline: Array, count: int) -> Array:
    """So many corners at equal distances along an outline, the first one kept."""
    closed = np.concatenate([outline, outline[:1]])
    along = np.concatenate([[0.0], np.hypot(*np.diff(closed, axis=0).T).cumsum()])
    wanted = np.arange(count) * along[-1] / count
    return np.stack([np.interp(wanted, along, closed[:, axis]) for axis in (0, 1)], axis=1)


def normals(outline: Array) -> Array:
    """Unit vectors (n, 2) that point outwards at the corners of a clockwise outline."""
    x, y = (np.roll(outline, -1, axis=0) - np.roll(outline, 1, axis=0)).T
    outward = np.stack([y, -x], axis=1)
    result: Array = outward / np.maximum(np.hypot(*outward.T), NEAR)[:, None]
    return result


def mean_value_coordinates(points: Array, outline: Array) -> Array:
    """Weights (m, n) of the corners that reproduce each point, smooth and of sum 1 (Floater 2003).

    >>> mean_value_coordinates(np.array([[1.0, 1.0]]), np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]]))
    array([[0.25, 0.25, 0.25, 0.25]])
    """
    here = outline - points[:, None]
    there = np.roll(here, -1, axis=1)
    length = np.hypot(here[..., 0], here[..., 1])
    cross = here[..., 0] * there[..., 1] - here[..., 1] * there[..., 0]
    cross = np.where(np.abs(cross) < NEAR, NEAR, cross)
    half = (length * np.roll(length, -1, axis=1) - (here * there).sum(axis=2)) / cross
    weights = (np.roll(half, 1, axis=1) + half) / np.maximum(length, NEAR)
    result: Array = weights / weights.sum(axis=1, keepdims=True)
    return result
