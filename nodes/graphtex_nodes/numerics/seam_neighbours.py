"""Pieces of a synthesis that meet near a pixel, told from its source map."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.sources import ANGLE, COLUMN, INDEX, LOG, MIRRORED, ROW, continued
from graphtex_nodes.numerics.structure import outlines

Array = NDArray[Any]
Flags = NDArray[np.bool_]

RADIUS = 2
"""Pixels of the output over which pieces fade into each other."""
REACH = range(-RADIUS, RADIUS + 1)
OFFSETS = np.array(sorted(((y, x) for y in REACH for x in REACH), key=lambda place: abs(place[0]) + abs(place[1])))
"""Rows and columns (n, 2) from a pixel to those whose pieces fade into it, its own place first."""
BENT = (16.0, 8.0)
"""Pixels over which colours are bent to meet, in grain and in elements with outlines: on plain ground beside them light
that comes from far shows."""
VIEW = [INDEX, LOG, ANGLE, MIRRORED]
SAME = 0.01
"""Pixels of an exemplar within which two continuations of a piece agree: rounding makes them differ."""


@dataclass(frozen=True)
class Contrast:
    """What of exemplars decides how their pieces meet, in a synthesis and in its replay alike.

    Attributes
    ----------
    variance
        Sum of the variances of the channels; 1 where nothing varies.
    outlines
        0 for grain, 1 for elements with outlines, see :func:`structure.outlines`.
    limits
        Least and largest values (c,) of the channels.
    """

    variance: float
    outlines: float
    limits: tuple[Array, Array]

    @staticmethod
    def of(pictures: Sequence[Array], usable: Flags | None = None, size: int = 1) -> "Contrast":
        """That of pictures (h, w, c) together, of which squares of ``size`` pixels a side make a pixel of a synthesis.

        ``usable`` (h, w), if it is given, is that of an only picture.
        """
        shown = slice(None) if usable is None else usable
        seen = [
            np.concatenate([picture[..., channel][shown].ravel() for picture in pictures])
            for channel in range(pictures[0].shape[2])
        ]
        variance = sum(float(np.var(values, dtype=np.float64)) for values in seen)
        limits = np.array([values.min() for values in seen]), np.array([values.max() for values in seen])
        return Contrast(variance or 1.0, outlines(pictures, usable, size), limits)

    @property
    def sharpness(self) -> float:
        """One over the squared difference from which on pieces do not fade into each other.

        In elements with outlines it is that of any two pixels in the mean: such pieces are better cut, while faded they
        would leave ghosts. Grain hides what is faded, and shows cuts.
        """
        return self.outlines / (2 * max(self.variance, float(np.finfo(np.float32).tiny)))

    @property
    def reach(self) -> float:
        """Pixels of a synthesis over which colours are bent to meet."""
        return float(BENT[0] ** (1 - self.outlines) * BENT[1] ** self.outlines)


@dataclass(frozen=True)
class Around:
    """What is around some pixels.

    Attributes
    ----------
    points
        Points of a source map (k, n, 6): what each of the pixels around shows where it is continued up to the pixel.
    first
        Number (k, n) of the first of those around that shows the same, -1 where there is none to show.
    """

    points: Array
    first: NDArray[np.int8]


def around(source: Array, free: Flags, rows: Array, columns: Array, wrap: tuple[bool, bool] = (False, False)) -> Around:
    """What is around pixels of a source map (h, w, 6) at given rows and columns (k,); only ``free`` pixels show.

    A map that wraps around goes on over its borders.
    """
    count = len(OFFSETS)
    points = np.zeros((len(rows), count, 6))
    first = np.full((len(rows), count), -1, np.int8)
    for number, (down, right) in enumerate(OFFSETS):
        y, x = rows + down, columns + right
        y, x = (
            np.where(over, place % side, place) for place, side, over in zip((y, x), source.shape, wrap, strict=False)
        )
        inside = (y >= 0) & (y < source.shape[0]) & (x >= 0) & (x < source.shape[1])
        inside[inside] = free[y[inside], x[inside]]
        found = source[y[inside], x[inside]]
        points[inside, number] = found
        points[inside, number, ROW : COLUMN + 1] = continued(found, -down, -right)
        for other in range(number):
            rest = np.flatnonzero(inside & (first[:, number] < 0) & (first[:, other] == other))
            alike = _alike(points[rest, number], points[rest, other])
            first[rest[alike], number] = other
        first[inside & (first[:, number] < 0), number] = number
    return Around(points, first)


def near_seams(source: Array, free: Flags, wrap: tuple[bool, bool] = (False, False)) -> Flags:
    """Which ``free`` pixels (h, w) of a source map lie near others that show another piece.

    A map that wraps around goes on over its borders.
    """
    mixed = np.zeros(source.shape[:2], bool)
    for down, right in OFFSETS[1:]:
        view = np.roll(source, (-down, -right), (0, 1))
        other = view.astype(np.float64)
        there = np.roll(free, (-down, -right), (0, 1))
        for axis, shift in enumerate((down, right)):
            if shift and not wrap[axis]:
                beyond = slice(None, -shift) if shift < 0 else slice(-shift, None)
                there[(slice(None), beyond) if axis else beyond] = False
        other[..., ROW : COLUMN + 1] = continued(view, -down, -right)
        mixed |= ~_alike(other, source) & there
    return mixed & free


def _alike(one: Array, other: Array) -> Flags:
    """Whether points of source maps (..., 6) show the same."""
    near = (np.abs(one[..., ROW : COLUMN + 1] - other[..., ROW : COLUMN + 1]) < SAME).all(axis=-1)
    alike: Flags = near & (one[..., VIEW] == other[..., VIEW]).all(axis=-1)
    return alike
