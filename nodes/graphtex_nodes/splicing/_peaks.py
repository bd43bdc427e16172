"""Places of a similarity map that stand out, thinned so that each element is found once."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

LEAST_SCORE = 0.4
HIGHEST_FLOOR = 0.7
FAINT = 0.15  # scores that cannot be elements and would only blur the two groups of the rest


def local_maxima(scores: Array, reach: int) -> tuple[Array, Array]:
    """Points (n, 2) where a map (h, w) is largest within `reach` pixels and above 0, and their scores, falling.

    Points are placed between pixels by a parabola through each maximum and its neighbours.
    """
    from scipy.ndimage import maximum_filter

    highest = maximum_filter(scores, size=2 * reach + 1, mode="nearest")
    row, column = np.nonzero((scores == highest) & (scores > 0))
    order = np.lexsort((column, row, -scores[row, column]))
    row, column = row[order], column[order]
    padded = np.pad(scores, 1, mode="edge")
    offsets = []
    for before, after in (
        (padded[row + 1, column], padded[row + 1, column + 2]),
        (padded[row, column + 1], padded[row + 2, column + 1]),
    ):
        bend = before - 2 * scores[row, column] + after
        usable = (bend < -1e-9) & (np.minimum(before, after) > -1)
        offsets.append(np.where(usable, 0.5 * (before - after) / np.where(usable, bend, 1), 0).clip(-0.5, 0.5))
    height, width = scores.shape
    x, y = (column + offsets[0]).clip(0, width - 1), (row + offsets[1]).clip(0, height - 1)
    return np.stack([x, y], axis=1).astype(np.float64), scores[row, column]


def suppress(points: Array, sizes: Array, angles: Array, radius: float) -> Array:
    """Indices of those points, the first being the strongest, that no stronger one is too near to.

    A point removes the weaker ones in its ellipse: `radius` times its sizes (n, 2), turned by its angle in degrees.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    alive = np.ones(len(points), bool)
    kept = []
    for index in range(len(points)):
        if not alive[index]:
            continue
        kept.append(index)
        near = np.array(tree.query_ball_point(points[index], radius * sizes[index].max()), np.intp)
        apart = points[near] - points[index]
        cos, sin = np.cos(np.radians(angles[index])), np.sin(np.radians(angles[index]))
        along, across = apart[:, 0] * cos + apart[:, 1] * sin, apart[:, 1] * cos - apart[:, 0] * sin
        alive[near[np.hypot(along / sizes[index, 0], across / sizes[index, 1]) < radius]] = False
    return np.array(kept, np.intp)


def cover(points: Array, shape: tuple[int, int], reach: Array, share: float) -> int:
    """How many points, in order, it takes to cover a share of the picture with boxes reaching (x, y) around them."""
    removed = np.zeros(shape, bool)
    for count, (x, y) in enumerate(points):
        top, left = (max(0, int(np.ceil(place - far))) for place, far in ((y, reach[1]), (x, reach[0])))
        removed[top : int(y + reach[1]) + 1, left : int(x + reach[0]) + 1] = True
        if np.count_nonzero(removed) >= share * removed.size:
            return count + 1
    return len(points)


def score_floor(scores: Array) -> float:
    """Least score of an element: what parts the scores best in two groups (Otsu 1979), from 0.4 to 0.7."""
    scores = np.sort(scores[scores > FAINT])[::-1]
    if len(scores) < 2:
        return LEAST_SCORE
    count = np.arange(1, len(scores))
    sums = np.cumsum(scores)[:-1]
    upper, lower = sums / count, (scores.sum() - sums) / (len(scores) - count)
    best = int(np.argmax(count * (len(scores) - count) * (upper - lower) ** 2))
    return float(np.clip((scores[best] + scores[best + 1]) / 2, LEAST_SCORE, HIGHEST_FLOOR))
