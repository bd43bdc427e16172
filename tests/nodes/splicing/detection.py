"""How well elements that were found agree with those that were drawn."""

from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from graphtex_nodes.splicing._templates import Example


def central(made: Any, size: float, *, unlike: int | None = None) -> tuple[int, Example]:
    """The element nearest to the picture's middle (of another kind than `unlike`) as an example, with its number."""
    areas = np.array([np.count_nonzero(made.labels == i + 1) for i in range(len(made.centres))])
    middle = (np.array(made.mask.shape[::-1]) - 1) / 2
    for index in np.argsort(np.hypot(*(made.centres - middle).T)):
        if unlike is None or abs(np.log(areas[index] / areas[unlike])) > 0.25:
            break
    y, x = np.nonzero(made.labels == index + 1)
    at = made.centres[index]
    return int(index), Example(x=at[0], y=at[1], width=np.ptp(x) + 1.0, height=np.ptp(y) + 1.0)


def agreement(points: Any, made: Any, size: float) -> tuple[float, np.ndarray, np.ndarray]:
    """F1 of points, and which of them are which true elements.

    A point is right within a quarter of the size. Elements whose centre is nearer than that to the border may be found
    or not.
    """
    last = np.array(made.mask.shape[::-1]) - 1
    margin = size / 4
    edge, found_edge = (((p < margin) | (p > last - margin)).any(axis=1) for p in (made.centres, points))
    apart = np.hypot(*(points[:, None] - made.centres[None]).transpose(2, 0, 1))
    which, true = linear_sum_assignment(np.minimum(apart, size))
    right = apart[which, true] < margin
    which, true = which[right], true[right]
    hits = np.count_nonzero(~edge[true])
    missed = np.count_nonzero(~np.delete(edge, true))
    false = np.count_nonzero(~np.delete(found_edge, which))
    return 2 * hits / max(2 * hits + missed + false, 1), which, true
