"""How many elements of a synthesis are whole, told from its source map and the true places of the exemplar's."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from graphtex_nodes.numerics.plane import seen_plane

Array = NDArray[Any]

INSIDE = 0.75  # of the way to the next centre is in between: nearer pixels belong to an element's core
REACH = 0.6  # of the distance between centres that a core has at most
WHOLE = 0.9  # of its core that a whole element shows


def cores(exemplar: Any, slant: float, tilt: float, field_of_view: float, aspect: float = 1.0) -> Array:
    """Number of the element whose core each pixel (h, w) of a generated exemplar belongs to, -1 in between.

    A core is what is much nearer to its element's centre than to any other, on the plane; elements are ``aspect`` times
    as wide as high.
    """
    height, width = exemplar.scale.shape
    plane = seen_plane(width, height, slant, tilt, field_of_view)

    def upright(x: Array, y: Array) -> Array:
        """Plane coordinates, turned back so that elements lie as in the picture."""
        across, along = plane.to_plane(*plane.rotate(x, y))
        sin, cos = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
        return np.stack([across * cos + along * sin, aspect * (along * cos - across * sin)], axis=-1)

    y, x = np.mgrid[:height, :width].astype(np.float64)
    tree = cKDTree(upright(*exemplar.centres.T))
    near, index = (np.asarray(part) for part in tree.query(upright(x.ravel(), y.ravel()), k=2))
    apart = np.median(np.asarray(tree.query(tree.data, k=2)[0])[:, 1])
    inside = (near[:, 0] < INSIDE * near[:, 1]) & (near[:, 0] < REACH * apart)
    return np.where(inside, index[:, 0], -1).reshape(height, width)


def cut_share(source: Array, elements: Array) -> float:
    """Share of the pixels in elements' cores that belong to elements of which less than 90 % is there.

    Parameters
    ----------
    source
        Row and column (h, w, 2) of one exemplar that each pixel shows. An element shown at one shift is one element,
        however it is cut.
    elements
        Number of the element that each exemplar pixel belongs to, -1 for none. Of one at the output's border, or the
        exemplar's, only what can be seen counts.
    """
    height, width = source.shape[:2]
    rows, columns = (source[..., axis].astype(np.int64) for axis in (0, 1))
    shown = elements[rows, columns]
    places = np.argwhere(shown >= 0)
    shifts = np.stack([rows, columns], axis=-1)[shown >= 0] - places
    keys = np.column_stack([shown[shown >= 0], shifts])
    found, seen = np.unique(keys, axis=0, return_counts=True)
    expected = np.zeros(len(found), np.int64)
    for number in range(int(elements.max()) + 1):
        own = np.argwhere(elements == number)
        there = found[:, 0] == number
        low, high = found[there, 1:], found[there, 1:] + (height, width)
        expected[there] = ((own >= low[:, None]) & (own < high[:, None])).all(axis=-1).sum(axis=1)
    return float(seen[seen < WHOLE * expected].sum() / seen.sum())
