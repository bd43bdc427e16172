"""A scale map for a picture of another size."""

import numpy as np
from numpy.typing import NDArray

from graphtex import ScaleMap, node
from graphtex_nodes.perspective._sizes import Pixels


@node
def resize_scale(scale: ScaleMap, *, width: Pixels, height: Pixels) -> ScaleMap:
    """Stretch a scale map to another size; values stay as they are.

    This makes the target of a larger synthesis from the exemplar's map (section 4 of Dong, Zhou & Paul 2008): the same
    range of scales over more pixels. Borders are aligned: the first and last row and column of the result are those of
    the map, values between are interpolated linearly. So a plane's map resized is that plane's map at the new size. A
    side of one pixel takes the map's middle.

    Parameters
    ----------
    scale
        (h, w).
    width, height
        Size of the result.

    Returns
    -------
    ScaleMap
        (height, width), within the range of the map.

    Examples
    --------
    >>> resize_scale(np.array([[0.5, 1.5]], np.float32), width=5, height=2)
    array([[0.5 , 0.75, 1.  , 1.25, 1.5 ],
           [0.5 , 0.75, 1.  , 1.25, 1.5 ]], dtype=float32)
    """
    rows = _interpolated(scale.astype(np.float64), height)
    result = np.ascontiguousarray(_interpolated(rows.T, width).T, np.float32)
    return np.clip(result, scale.min(), scale.max())  # rounding must not leave the range


def _interpolated(values: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Values at `count` places from the first row to the last, (count, columns)."""
    last = len(values) - 1
    place = np.linspace(0, last, count) if count > 1 else np.array([last / 2])
    before = np.minimum(place.astype(np.intp), max(last - 1, 0))
    share = (place - before)[:, None]
    result: NDArray[np.float64] = values[before] * (1 - share) + values[np.minimum(before + 1, last)] * share
    return result
