"""Elements that were found beside those that a generated texture is known to have."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.image.exemplars.textons import Textons
from graphtex_nodes.splicing._templates import Example

Array = NDArray[Any]

UNLIKE = 0.25  # of the logarithm of areas: elements are of another kind


def agreement(points: Array, made: Textons, size: float) -> tuple[float, Array, Array]:
    """F1 of points, and which of them are which true elements.

    A point is right within a quarter of the elements' size (pixels). Elements whose centre is nearer than that to the
    border may be found or not. Returns the F1, and indices of the points that are right and of the elements they show.

    >>> from graphtex_nodes import textons
    >>> made = textons(width=96, height=96, size=20.0, rng=1)
    >>> agreement(made.centres[::-1], made, 20.0)[0]
    1.0
    """
    from scipy.optimize import linear_sum_assignment

    last, margin = np.array(made.mask.shape[::-1]) - 1, size / 4
    edge, found_edge = (np.asarray(((p < margin) | (p > last - margin)).any(axis=1)) for p in (made.centres, points))
    apart = np.hypot(*(points[:, None] - made.centres[None]).transpose(2, 0, 1))
    which, true = linear_sum_assignment(np.minimum(apart, size))
    right = np.asarray(apart[which, true] < margin)
    which, true = which[right], true[right]
    hits = float((~edge[true]).sum())
    wrong = float((~np.delete(edge, true)).sum()) + float((~np.delete(found_edge, which)).sum())
    return 2 * hits / max(2 * hits + wrong, 1.0), which, true


def central(made: Textons, unlike: int | None = None) -> tuple[int, Example]:
    """Number of the element nearest to the picture's middle, of another size than that of number ``unlike``, and it."""
    areas = np.array([np.count_nonzero(made.labels == i + 1) for i in range(len(made.centres))])
    middle = (np.array(made.mask.shape[::-1]) - 1) / 2
    order = np.argsort(np.hypot(*(made.centres - middle).T))
    index = next(int(i) for i in order if unlike is None or abs(np.log(areas[i] / areas[unlike])) > UNLIKE)
    y, x = np.nonzero(made.labels == index + 1)
    at = made.centres[index]
    return index, Example(x=at[0], y=at[1], width=np.ptp(x) + 1.0, height=np.ptp(y) + 1.0)
