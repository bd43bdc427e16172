"""The elements of a wall one by one: their outlines, and the joints around them."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.splicing._polygons import around, evenly, moments, normals
from graphtex_nodes.splicing.texton_labels import texton_labels

Array = NDArray[Any]

CORNERS = 48
BITE, WHISKER = 0.3, 0.15
"""Radius of the discs that close and open an element, over that of one with its area."""
SMOOTH = 0.7
LEAST = 4
"""Elements that a wall is laid of at least: copies of fewer would show."""
STEP, FARTHEST = 0.125, 24.0
"""Pixels by which joints are followed, and how far at most."""
SOLID, SIZES = 0.85, 4.0
"""An element fills so much of its convex hull, and has so many times the usual area or less of it at most."""
SHARP = 0.86
"""What opening with a disc of radius 1 takes from four right angles: 4 - pi."""


class Blocks(NamedTuple):
    """Elements (n) of a wall that the picture shows with the joint around them, and that are not ragged.

    ``outlines`` and ``outward`` (n, CORNERS, 2) are corners and unit normals there, ``reach`` (n, CORNERS) how far, in
    pixels, the middle of the joint is. ``forms`` (n, 2, 2) are covariances of elements with the joint around them.
    ``joint`` is half the usual width of joints, ``round`` the radius of corners and ``radius`` the elements', as of
    discs of their area.
    """

    outlines: Array
    outward: Array
    reach: Array
    forms: Array
    joint: float
    round: float
    radius: float


def blocks(mask: Array, points: Array) -> Blocks | None:
    """The elements of a wall with a mask (h, w) and centres (n, 2); None if few are as they should be."""
    numbered = _numbered(mask, points)
    found = list(_bodies(numbered, len(points)))
    if len(found) < LEAST:
        return None
    owners = np.array([owner for owner, *_ in found])
    outlines = np.stack([evenly(outline, CORNERS) for _, outline, _ in found])
    outward = np.stack([normals(outline) for outline in outlines])
    reach = _reach(outlines, outward, owners, numbered)
    # the middle half: corners, and pockets where several joints meet, are not what is usual
    joint = float(np.sort(reach.ravel())[reach.size // 4 : -(reach.size // 4)].mean())
    laid = outlines + joint * outward
    # of others, the picture does not show the joint all around
    whole = ((laid >= -0.5) & (laid <= np.array(mask.shape[::-1]) - 0.5)).all(axis=(1, 2))
    if np.count_nonzero(whole) < LEAST:
        return None
    forms = np.stack([moments(outline).covariance for outline in laid[whole]])
    radius = float(np.sqrt(np.median([moments(outline).area for outline in outlines]) / np.pi))
    corners = float(np.median([corner for *_, corner in found])) * radius
    reach = np.minimum(reach, 2 * joint)
    return Blocks(outlines[whole], outward[whole], reach[whole], forms, joint, corners, radius)


def shape(covariance: Array) -> Array:
    """Size and elongation (3,) of something with a covariance (2, 2): of two, the distance of their logarithms.

    >>> shape(np.diag([1.0, 1.0])).round(2) + 0.0, shape(np.diag([np.e, 1.0])).round(2)
    (array([0., 0., 0.]), array([0.71, 0.71, 0.  ]))
    """
    (a, b), (_, c) = covariance
    middle, apart = (a + c) / 2, np.hypot((a - c) / 2, b)
    larger, smaller = np.log(middle + apart), np.log(max(middle - apart, 1e-9))
    turn = (larger - smaller) / max(apart, 1e-9)
    result: Array = np.array([larger + smaller, turn * (a - c) / 2, turn * b]) / np.sqrt(2)
    return result


def _numbered(mask: Array, points: Array) -> Array:
    """Number of each pixel's element (h, w); parts without a texton have numbers of their own, joints -1."""
    from scipy.ndimage import label

    labels = texton_labels(mask, points)
    others = label(mask & (labels < 0))[0]
    return np.where(others > 0, len(points) + others, labels)


def _bodies(numbered: Array, count: int) -> Iterator[tuple[int, Array, float]]:
    """Number, outline, and radius of corners (over the element's own) of each whole one of so many elements."""
    from scipy.ndimage import distance_transform_edt, find_objects, gaussian_filter
    from scipy.spatial import ConvexHull

    row, column = distance_transform_edt(numbered < 0, return_distances=False, return_indices=True)
    cells = numbered[row, column]
    sizes = np.bincount(numbered[numbered >= 0], minlength=count)[:count]
    usual = float(np.median(sizes[sizes > 0])) if sizes.any() else 0.0
    for number, part in enumerate(find_objects(numbered + 1, count)):
        inside = part is not None and all(
            side.start > 0 and side.stop < end for side, end in zip(part, numbered.shape, strict=True)
        )
        if not inside or not usual / SIZES <= sizes[number] <= usual * SIZES:
            continue
        radius = float(np.sqrt(sizes[number] / np.pi))
        more = int(np.ceil(BITE * radius)) + 2
        window = tuple(slice(max(0, side.start - more), side.stop + more) for side in part)
        corner = np.array([window[1].start, window[0].start])
        body = _mended(numbered[window] == number, cells[window] == number, radius)
        outline = around(gaussian_filter(body.astype(np.float64), SMOOTH) - 0.5, corner)
        if outline is not None and moments(outline).area > SOLID * ConvexHull(outline).volume:
            yield number, outline, _corner(body) / radius


def _mended(element: Array, cell: Array, radius: float) -> Array:
    """An element (h, w) without bites and whiskers, within its cell."""
    from scipy.ndimage import binary_fill_holes, label

    more = int(np.ceil(BITE * radius)) + 1
    closed = _grown(_grown(np.pad(element, more), BITE * radius), -BITE * radius)[more:-more, more:-more]
    closed = binary_fill_holes(closed) & cell
    opened = _grown(_grown(closed, -WHISKER * radius), WHISKER * radius)
    parts = label(opened if opened.any() else closed)[0]
    mended: Array = parts == np.bincount(parts[parts > 0]).argmax()
    return mended


def _grown(element: Array, radius: float) -> Array:
    """An element (h, w) dilated by a disc, or eroded if its radius is negative."""
    from scipy.ndimage import distance_transform_edt

    if radius < 0:
        return np.asarray(distance_transform_edt(element) > -radius)
    return np.asarray(distance_transform_edt(~element) <= radius)


def _corner(body: Array) -> float:
    """Radius that the corners of an element (h, w) would have if it had four, by what an opening takes from it."""
    from scipy.ndimage import distance_transform_edt

    padded = np.pad(body, 1)
    radius = float(distance_transform_edt(padded).max()) / 2
    taken = np.count_nonzero(padded & ~_grown(_grown(padded, -radius), radius))
    return float(np.sqrt(max(radius**2 - taken / SHARP, 0.0)))


def _reach(outlines: Array, outward: Array, owners: Array, numbered: Array) -> Array:
    """Half the way (n, CORNERS) from an outline to another element."""
    steps = np.arange(STEP / 2, FARTHEST, STEP)  # not on borders of pixels
    places = np.rint(outlines[:, :, None] + outward[:, :, None] * steps[:, None]).astype(np.intp)
    last = np.array(numbered.shape[::-1]) - 1
    x, y = np.moveaxis(np.clip(places, 0, last), -1, 0)
    free = ((places >= 0) & (places <= last)).all(axis=-1)
    free &= (numbered[y, x] < 0) | (numbered[y, x] == owners[:, None, None])
    count = np.where(free.all(axis=2), len(steps), free.argmin(axis=2))
    return np.maximum(count, 1) * STEP / 2
