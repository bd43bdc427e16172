"""Image pyramids by halving, for any size.

Pixel i of a level covers pixels 2i and 2i + 1 of the next finer one, so a source position on a coarse level is twice
itself on the finer one: source maps can be carried up exactly.
"""

import numpy as np
from numpy.typing import NDArray

_TAPS = np.array([1, 3, 3, 1], np.float32) / 8
_BAND = 64  # rows that are halved at once: large pictures need little more memory than the result


def half_size(size: int) -> int:
    """Pixels of the next coarser level."""
    return (size + 1) // 2


def level_size(size: int, level: int) -> int:
    """Pixels along a side of ``size`` pixels after ``level`` halvings."""
    for _ in range(level):
        size = half_size(size)
    return size


def _halved_rows(array: NDArray[np.float32], first: int, last: int) -> NDArray[np.float32]:
    """Rows ``first`` to ``last`` of the half-size array; one row stays."""
    if array.shape[0] == 1:
        return array
    near = array[np.clip(np.arange(2 * first - 1, 2 * last + 1), 0, array.shape[0] - 1)]
    total = np.zeros((last - first, *array.shape[1:]), np.float32)
    for tap, weight in enumerate(_TAPS):
        total += weight * near[tap : tap + 2 * (last - first) - 1 : 2]
    return total


def halve(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Half-size image: binomial filter (1, 3, 3, 1) / 8 along rows and columns, border pixels repeated.

    Parameters
    ----------
    image
        Shape (h, w) or (h, w, c).

    Returns
    -------
    NDArray
        Shape ((h + 1) // 2, (w + 1) // 2) or that and c. A side of one pixel stays.

    Examples
    --------
    >>> halve(np.array([[0, 0, 8, 8]], np.float32))
    array([[1., 7.]], dtype=float32)
    """
    image = np.asarray(image, np.float32)
    height, width = (half_size(side) for side in image.shape[:2])
    result = np.empty((height, width, *image.shape[2:]), np.float32)
    for first in range(0, height, _BAND):
        last = min(first + _BAND, height)
        rows = np.swapaxes(_halved_rows(image, first, last), 0, 1)
        result[first:last] = np.swapaxes(_halved_rows(rows, 0, width), 0, 1)
    return result


def pyramid(image: NDArray[np.float32], levels: int) -> list[NDArray[np.float32]]:
    """The image and its halvings: ``levels`` images, the finest first."""
    result = [np.ascontiguousarray(image, np.float32)]
    for _ in range(levels - 1):
        result.append(halve(result[-1]))
    return result


def masked_pyramid(
    image: NDArray[np.float32], mask: NDArray[np.bool_], levels: int
) -> tuple[list[NDArray[np.float32]], list[NDArray[np.bool_]]]:
    """Pyramid of the True pixels of a mask (h, w) alone, and on each level the pixels that are mostly made of them.

    Values are means over the True pixels under the filter, 0 where there is none.
    """
    weight = mask.astype(np.float32)
    sums = image * (weight if image.ndim == 2 else weight[..., None])
    values: list[NDArray[np.float32]] = []
    masks: list[NDArray[np.bool_]] = []
    for weights, total in zip(pyramid(weight, levels), pyramid(sums, levels), strict=True):
        divisor = np.where(weights > 0, weights, np.float32(1))
        divisor = divisor if image.ndim == 2 else divisor[..., None]
        values.append((total / divisor).astype(np.float32))
        masks.append(weights > 0.5)
    return values, masks
