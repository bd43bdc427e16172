"""Means of a map over windows: running, or side by side."""

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

Array = NDArray[Any]


def window_mean(values: Array, side: int) -> Array:
    """Mean (h, w), float64, over the part of a window that lies in the map; it begins side // 2 before each pixel.

    >>> window_mean(np.array([[3.0, 0.0, 6.0]]), 3)
    array([[1.5, 3. , 3. ]])
    """
    height, width = values.shape
    before = side // 2
    summed = np.zeros((height + side, width + side))
    summed[before + 1 : before + 1 + height, before + 1 : before + 1 + width] = values
    for axis in (0, 1):
        np.cumsum(summed, axis=axis, out=summed)
    total = summed[side:, side:] - summed[:-side, side:] - summed[side:, :-side] + summed[:-side, :-side]
    rows, columns = (
        np.minimum(np.arange(size) - before + side, size) - np.maximum(np.arange(size) - before, 0)
        for size in (height, width)
    )
    mean: Array = total / np.outer(rows, columns)
    return mean


def block_mean(values: Array, side: int, dtype: DTypeLike | None = None) -> Array:
    """Means (h // side, w // side, c) of squares of values (h, w, c); what is left over below and beside is not used.

    ``dtype`` is what they are summed in, the values' own by itself.

    >>> block_mean(np.arange(10.0).reshape(2, 5, 1), 2)[..., 0]
    array([[3., 5.]])
    """
    rows, columns = (count // side for count in values.shape[:2])
    squares = values[: rows * side, : columns * side].reshape(rows, side, columns, side, values.shape[2])
    mean: Array = squares.mean(axis=(1, 3), dtype=dtype)
    return mean
