"""Where the output lies on the canvas of a level, what the canvas holds around it, and how sources get to the next."""

from dataclasses import dataclass
from math import gcd
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.pyramid import level_size
from graphtex_nodes.numerics.windows import Grid


@dataclass(frozen=True)
class Frame:
    """The canvas of a level: the output with a margin, which repeats the other side where the output wraps around.

    Attributes
    ----------
    size
        Height and width of the output on this level.
    grid
        The windows on the canvas.
    margins
        Pixels of the canvas above the output and on its left.
    periods
        Pixels after which rows and columns repeat; 0 where they do not. On coarse levels a period may exceed the
        output by less than a step of the grid, on the finest it is the output's side.
    """

    size: tuple[int, int]
    grid: Grid
    margins: tuple[int, int]
    periods: tuple[int, int]

    @staticmethod
    def of(size: tuple[int, int], level: int, window: int, margin: int, wrap: tuple[bool, bool]) -> "Frame":
        """The canvas for an output of this size on the finest level; ``margin`` holds where it does not wrap."""
        step = max(1, window // 4)
        if level == 0 and any(wrap):
            common = gcd(*(side for side, around in zip(size, wrap, strict=True) if around))
            step = max(number for number in range(1, step + 1) if common % number == 0)
        height, width = (level_size(side, level) for side in size)
        periods, margins, sides = [], [], []
        for side, around in zip((height, width), wrap, strict=True):
            period = -(-side // step) * step if around else 0
            border = -(-window // step) * step if around else margin
            periods.append(period)
            margins.append(border)
            sides.append((period or side) + 2 * border)
        grid = Grid.covering(sides[0], sides[1], window, step)
        return Frame((height, width), grid, (margins[0], margins[1]), (periods[0], periods[1]))

    def _pixels(self, axis: int) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
        """The output's pixel for each of the canvas, the nearest outside; and which lie on the output."""
        place = np.arange(self.grid.canvas[axis]) - self.margins[axis]
        if self.periods[axis]:
            place = place % self.periods[axis]
            return np.minimum(place, self.size[axis] - 1), np.ones(place.size, bool)
        return np.clip(place, 0, self.size[axis] - 1), (place >= 0) & (place < self.size[axis])

    def spread(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values (h, w, ...) of the output's pixels on the canvas: border pixels repeat where it does not wrap."""
        return values[np.ix_(self._pixels(0)[0], self._pixels(1)[0])]

    def inside(self) -> NDArray[np.bool_]:
        """Canvas pixels that show the output, wrapped around or not."""
        return np.outer(self._pixels(0)[1], self._pixels(1)[1])

    def crop(self, values: NDArray[Any]) -> NDArray[Any]:
        """The output's part of a canvas."""
        (top, left), (height, width) = self.margins, self.size
        return np.ascontiguousarray(values[top : top + height, left : left + width])

    def shown(self) -> tuple[slice, slice]:
        """Rows and columns of the windows whose centres lie on the output."""
        rows, columns = (
            [max(0, -((self.grid.window - 2 * end) // (2 * self.grid.step))) for end in (margin, margin + side)]
            for margin, side in zip(self.margins, self.size, strict=True)
        )
        return slice(*rows), slice(*columns)

    def wrap_canvas(self, canvas: NDArray[Any]) -> None:
        """Make margins of a canvas repeat the other side."""
        self._wrap(canvas, self.margins, self.periods)

    def wrap_windows(self, values: NDArray[Any]) -> None:
        """Make values of windows, such as a field, repeat likewise."""
        (top, left), (down, right) = self.margins, self.periods
        step = self.grid.step
        self._wrap(values, (top // step, left // step), (down // step, right // step))

    @staticmethod
    def _wrap(values: NDArray[Any], margins: tuple[int, int], periods: tuple[int, int]) -> None:
        for axis in (0, 1):
            if periods[axis]:
                place = (np.arange(values.shape[axis]) - margins[axis]) % periods[axis] + margins[axis]
                values[...] = values.take(place, axis)


def whole_windows(mask: NDArray[np.bool_], window: int, step: int = 1) -> NDArray[np.bool_]:
    """Which windows, at multiples of ``step``, hold True pixels of a mask (h, w) only."""
    whole: NDArray[np.bool_] = window_counts(mask, window)[::step, ::step] == window * window
    return whole


def window_counts(mask: NDArray[np.bool_], window: int) -> NDArray[np.int64]:
    """How many True pixels of a mask (h, w) each window holds."""
    total = np.zeros((mask.shape[0] + 1, mask.shape[1] + 1), np.int64)
    np.cumsum(np.cumsum(mask, axis=0), axis=1, out=total[1:, 1:])
    counts: NDArray[np.int64] = (
        total[window:, window:] - total[:-window, window:] - total[window:, :-window] + total[:-window, :-window]
    )
    return counts


def nearest_places(allowed: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Row and column (h, w, 2) of the nearest True place for each place."""
    from scipy.ndimage import distance_transform_edt

    nearest = distance_transform_edt(~allowed, return_distances=False, return_indices=True)
    return np.ascontiguousarray(np.moveaxis(nearest, 0, -1), np.int32)


def transfer(
    field: NDArray[np.int32], old: Frame, new: Frame, factor: int, shape: tuple[int, ...],
    rims: tuple[int, int] = (0, 0),
) -> NDArray[np.int32]:  # fmt: skip
    """The field of another grid over the same canvas, or over one ``factor`` times as fine.

    Each new window takes the source of the old window with the nearest centre, shifted by the distance of their
    corners; sources are moved into ``shape``, rows and columns of the exemplar's windows. Where the output wraps around
    and periods do not fit, places are stretched from period to period, so that there is no jump at the border.

    Old and new sources count from the corner of the exemplar's rim on their level, so many pixels wide (``rims``).
    """
    places = []
    for axis, (count, size) in enumerate(
        ((new.grid.rows, old.grid.rows), (new.grid.columns, old.grid.columns))
    ):  # fmt: skip
        stretch = new.periods[axis] / old.periods[axis] if old.periods[axis] else factor
        centre = np.arange(count) * new.grid.step + new.grid.window / 2 - new.margins[axis]
        corner = centre / stretch - old.grid.window / 2 + old.margins[axis]
        nearest = np.clip(np.rint(corner / old.grid.step), 0, size - 1).astype(np.int64)
        middle = nearest * old.grid.step + old.grid.window / 2 - old.margins[axis]
        apart = centre - stretch * middle + (factor * old.grid.window - new.grid.window) / 2
        places.append((nearest, np.rint(apart).astype(np.int32)))
    (rows, down), (columns, right) = places
    result = field.take(rows, 0).take(columns, 1)
    result -= np.int32(rims[0])
    result *= np.int32(factor)
    result += np.int32(rims[1])
    for axis, more in enumerate((down[:, None], right)):
        part = result[..., axis]
        part += more
        np.clip(part, 0, shape[axis] - 1, out=part)
    return result


def replayed(
    source: NDArray[np.int32], factor: int, size: tuple[int, int], shape: tuple[int, ...]
) -> NDArray[np.int32]:
    """Source map (h, w, 2) of ``size`` from one of a level ``factor`` times as coarse; sources are inside ``shape``.

    Each pixel becomes the square of pixels of the exemplar that it stands for.
    """
    if factor == 1:
        return source
    result = np.empty((*size, 2), np.int32)
    for axis in (0, 1):
        coarse = (factor * source[..., axis]).repeat(factor, axis=0).repeat(factor, axis=1)[: size[0], : size[1]]
        place = np.arange(size[axis], dtype=np.int32) % factor
        np.minimum(coarse + (place[:, None] if axis == 0 else place), shape[axis] - 1, out=result[..., axis])
    return result
