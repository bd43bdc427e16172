"""Which pixels belong to which texton."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

RIM = 2
"""Pixels around an element that go with it: its edge is soft, and there is a little of its shadow."""


def with_rim(mask: Array) -> Array:
    """The mask (h, w) of elements and of the rims around them."""
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(mask, np.ones((2 * RIM + 1, 2 * RIM + 1), bool)))


def texton_labels(mask: Array, points: Array) -> Array:
    """Index of the texton of each foreground pixel, int32 (h, w); -1 in the background and in parts without a texton.

    A connected part that holds one texton is all of it. One that holds several is split where it is narrow: by a
    watershed from their centres over the distance to the background (Meyer 1994).

    >>> texton_labels(np.array([[True, True, True, False, True]]), np.array([[0.0, 0.0], [2.0, 0.0]]))
    array([[ 0,  0,  1, -1, -1]], dtype=int32)
    """
    from scipy.ndimage import distance_transform_edt, label
    from skimage.segmentation import watershed

    height, width = mask.shape
    parts, count = label(mask)
    labels = np.full(mask.shape, -1, np.int32)
    column = np.clip(np.rint(points[:, 0]).astype(np.int64), 0, width - 1)
    row = np.clip(np.rint(points[:, 1]).astype(np.int64), 0, height - 1)
    part = parts[row, column]
    held = np.bincount(part, minlength=count + 1)
    held[0] = 0
    owner = np.full(count + 1, -1, np.int32)
    owner[part] = np.arange(len(points))
    owner[held != 1] = -1
    labels[mask] = owner[parts[mask]]
    shared = held[parts] > 1
    if shared.any():
        centres = np.zeros(mask.shape, np.int32)
        centres[row, column] = np.arange(1, len(points) + 1)
        depth = distance_transform_edt(shared) if not shared.all() else np.zeros(mask.shape)
        basins = watershed(-depth, centres, mask=shared)
        labels[shared] = basins[shared] - 1
    return labels


def texton_reach(labels: Array, points: Array) -> float:
    """How far (pixels) elements reach from their centres; the largest of 20 do not count.

    >>> texton_reach(np.array([[-1, 0, 0, 0, -1]], np.int32), np.array([[1.0, 0.0]]))
    2.0
    """
    rows, columns = np.nonzero(labels >= 0)
    if len(rows) == 0:
        return 0.0
    index = labels[rows, columns]
    farthest = np.zeros(len(points))
    np.maximum.at(farthest, index, np.hypot(columns - points[index, 0], rows - points[index, 1]))
    return float(np.quantile(farthest, 0.95))
