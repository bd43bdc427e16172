"""Shifts at which a picture repeats itself."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

CLEAR = 0.6  # correlation with itself: lattices with jitter have 0.65, random arrangements up to 0.35
SHORTEST = 6  # pixels
LONGEST = 0.5  # of the picture's sides
COMPARED = 3  # shifts at which points are looked at
ABOUT_BEST = 0.9  # of the highest correlation: the shortest such shifts span a cell
SLANTED = 0.5  # sine of the least angle between them
RISE = 0.2  # above the least correlation on the way to a shift: stripes are alike all along, and have no period there
WAY = np.arange(1, 8) / 8  # where that is looked at
NEIGHBOURHOOD = 7  # pixels, in which a peak is the highest
SAME = 0.25  # of the distance of neighbours by which a point may be off


class Repeats(NamedTuple):
    """Shifts (k, 2), x and y in pixels, and the correlation (k,) of the picture with itself there, highest first.

    `likeness` (2 h - 1, 2 w - 1) is that correlation at all shifts.
    """

    shifts: Array
    correlations: Array
    likeness: Array


def repeats(image: Array) -> Repeats:
    """The shifts at which a picture (h, w, c) is most like itself; none of them where it is no lattice."""
    from scipy.ndimage import maximum_filter

    height, width = image.shape[:2]
    likeness = _likeness(image)
    down, across = np.nonzero((maximum_filter(likeness, NEIGHBOURHOOD) == likeness) & (likeness >= CLEAR))
    values = likeness[down, across]
    shifts = np.stack([across, down], axis=1) - np.array(likeness.shape[::-1]) // 2
    across, down = shifts.T
    # a shift and its opposite are the same
    chosen = ((down > 0) | ((down == 0) & (across > 0))) & (np.hypot(down, across) >= SHORTEST)
    chosen &= (down <= LONGEST * height) & (np.abs(across) <= LONGEST * width)
    chosen &= values - _lowest(likeness, np.zeros(2), shifts) >= RISE
    order = np.flatnonzero(chosen)
    order = order[np.argsort(-values[order], kind="stable")]
    return Repeats(shifts[order], values[order], likeness)


def cell(found: Repeats) -> tuple[float, float, float] | None:
    """Width and height of a box as large as what repeats, and how well that does; None where it repeats along a line.

    Of the two shortest shifts, their sum and their difference the shortest that is nearly a row or a column is one side
    of the box, so that rows or columns of boxes may be shifted against each other.
    """
    if not len(found.shifts):
        return None
    good = np.flatnonzero(found.correlations >= ABOUT_BEST * found.correlations[0])
    shifts = found.shifts[good].astype(np.float64)
    lengths = np.hypot(*shifts.T)
    first = int(lengths.argmin())
    areas = np.abs(shifts[:, 0] * shifts[first, 1] - shifts[:, 1] * shifts[first, 0])
    other = areas > SLANTED * lengths * lengths[first]
    # stripes repeat by any shift along them from a multiple of the first
    nearest = np.rint(shifts @ shifts[first] / lengths[first] ** 2)
    for beside in (-1, 0, 1):
        start = (nearest + beside)[:, None] * shifts[first]
        other &= found.correlations[good] - _lowest(found.likeness, start, shifts) >= RISE
    other = np.flatnonzero(other)
    if not len(other):
        return None
    second = int(other[lengths[other].argmin()])
    one, two = shifts[first], shifts[second]
    sides = np.abs(np.stack([one, two, one + two, one - two]))
    slant = (sides.min(axis=1) / sides.max(axis=1)).round(1)
    straight = sides[int(np.lexsort((sides.max(axis=1), slant))[0])]
    long = float(straight.max())
    across = float(areas[second]) / long
    width, height = (long, across) if straight[0] >= straight[1] else (across, long)
    return width, height, float(found.correlations[good[[first, second]]].mean())


def repeated_share(points: Array, found: Repeats, size: tuple[int, ...]) -> float:
    """Share of points (n, 2) in a picture (height, width) that meet others when all are shifted; 1 for no shift."""
    from scipy.spatial import cKDTree

    shifts = found.shifts[:COMPARED]
    if len(points) < 2 or not len(shifts):
        return 1.0
    tree = cKDTree(points)
    near = SAME * float(np.median(np.asarray(tree.query(points, k=[2])[0])))
    last = np.array(size[1::-1]) - 1
    moved = (points + np.concatenate([shifts, -shifts])[:, None]).reshape(-1, 2)
    moved = moved[((moved >= 0) & (moved <= last)).all(axis=1)]
    return float((np.asarray(tree.query(moved)[0]) <= near).mean()) if len(moved) else 1.0


def _lowest(likeness: Array, starts: Array, stops: Array) -> Array:
    """The least correlation on the way from shifts to others (k, 2)."""
    way = np.rint(starts[..., None, :] + (stops - starts)[:, None] * WAY[:, None]).astype(np.intp)
    last = np.array(likeness.shape[::-1]) - 1
    column, row = np.moveaxis(np.clip(way + last // 2, 0, last), -1, 0)
    lowest: Array = likeness[row, column].min(axis=1)
    return lowest


def _likeness(image: Array) -> Array:
    """Correlation of a picture and itself at all shifts (2 h - 1, 2 w - 1), 0 where less than a quarter overlaps."""
    from scipy.fft import irfft2, next_fast_len, rfft2

    height, width = image.shape[:2]
    padded = [next_fast_len(2 * side - 1, real=True) for side in (height, width)]
    values = image - image.mean(axis=(0, 1))
    squares = rfft2((values**2).sum(axis=2), padded)
    whole = rfft2(np.ones((height, width)), padded)
    spectrum = rfft2(values, padded, axes=(0, 1))
    shared, energy = (irfft2(each, padded) for each in (np.abs(whole) ** 2, squares * np.conj(whole)))
    other = irfft2(np.conj(squares) * whole, padded)
    product = irfft2((np.abs(spectrum) ** 2).sum(axis=2), padded)
    enough = (shared >= height * width / 4) & (energy > 1e-6) & (other > 1e-6)
    result = np.where(enough, product / np.sqrt(np.where(enough, energy * other, 1)), 0)
    rows, columns = (np.arange(1 - side, side) for side in (height, width))
    centred: Array = result[np.ix_(rows, columns)]
    return centred
