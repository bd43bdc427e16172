"""Normals of a height map."""

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import Image, node
from graphtex_nodes.numerics.materials import UP

Array = NDArray[np.float32]
Sides = Annotated[
    Literal["none", "both", "x", "y"],
    Field(description="sides over which the surface continues: x the left and right ones, y the upper and lower ones"),
]


@node
def normals_from_height(
    height: Image,
    *,
    relief: Annotated[float, Field(ge=0, le=4096, description="pixels that a height of 1 stands above one of 0")] = 8.0,
    kind: Annotated[
        Literal["normal", "normal-down"], Field(description="whether the second component points up or down")
    ] = "normal",
    tileable: Sides = "none",
) -> Image:
    r"""Unit normals of the surface :math:`z = relief \cdot h(x, y)`, encoded as (n + 1) / 2.

    .. math:: n \propto (-\partial z / \partial x, -\partial z / \partial y, 1)

    with x to the right and y up (down for ``normal-down``), by Sobel's operator, whose smoothing across the derivative
    keeps steps of single pixels from turning into noise.

    Parameters
    ----------
    height
        (h, w, 1), usually in [0, 1].

    Returns
    -------
    Image
        (h, w, 3), the map that StackMaps calls a normal. (0.5, 0.5, 1) where the surface is level.

    Raises
    ------
    ValueError
        The height has more than one channel.

    Examples
    --------
    >>> slope = np.arange(4, dtype=np.float32).reshape(1, 4, 1)  # 1 in 1, uphill to the right: 45 degrees
    >>> (normals_from_height(slope, relief=1.0)[0, 1] * 2 - 1).round(3)
    array([-0.707,  0.   ,  0.707], dtype=float32)
    """
    if height.shape[2] != 1:
        raise ValueError(f"height: expected one channel, got shape {height.shape}; Grey makes one of several")
    padded = height[..., 0].astype(np.float64) * relief
    for axis, around in enumerate((tileable in ("y", "both"), tileable in ("x", "both"))):
        width = [(0, 0), (0, 0)]
        width[axis] = (1, 1)
        padded = np.pad(padded, width, mode="wrap") if around else _extended(padded, axis)
    right = _smoothed(padded[:, 2:] - padded[:, :-2], 0) / 2
    down = _smoothed(padded[2:] - padded[:-2], 1) / 2
    normal = np.stack([-right, down * UP[kind], np.ones_like(right)], axis=-1)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return ((normal + 1) / 2).astype(np.float32)


def _extended(values: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """One more row before the first and after the last, as if the slope went on."""
    size = values.shape[axis]
    first, second = values.take([0], axis), values.take([min(1, size - 1)], axis)
    last, before = values.take([size - 1], axis), values.take([max(0, size - 2)], axis)
    return np.concatenate([2 * first - second, values, 2 * last - before], axis)


def _smoothed(values: NDArray[np.float64], axis: int) -> NDArray[np.float64]:
    """Mean of three along an axis with weights 1, 2, 1; two fewer."""
    size = values.shape[axis]
    low, middle, high = (values.take(np.arange(start, size - 2 + start), axis) for start in range(3))
    mean: NDArray[np.float64] = (low + 2 * middle + high) / 4
    return mean
