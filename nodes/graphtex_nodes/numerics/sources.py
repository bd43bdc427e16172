"""Source maps: which exemplar pixel each output pixel was copied from, and what that tells of a synthesis."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

ROW, COLUMN = 1, 2
"""Columns of a source map; 0 is the exemplar's index, 3 to 5 are log2 of the resampling, angle and mirrored or not."""


def source_map(source: NDArray[np.integer]) -> Array:
    """Source map (h, w, 6) of plain copies from one exemplar, from rows and columns (h, w, 2)."""
    result = np.zeros((*source.shape[:2], 6), np.float32)
    result[..., ROW : COLUMN + 1] = source
    return result


def own_places(shape: tuple[int, ...]) -> Array:
    """Source map (h, w, 6) of a picture that nothing was done to."""
    return source_map(np.moveaxis(np.indices(shape), 0, -1))


def replay(source: Array, exemplar: Array) -> Array:
    """The picture that a source map (h, w, 6) of plain copies makes of an exemplar (eh, ew, c)."""
    rows = source[..., ROW].astype(np.intp)
    columns = source[..., COLUMN].astype(np.intp)
    return exemplar[rows, columns]


def coherence(source: NDArray) -> float:
    """Share of pairs of neighbouring pixels (right and down) whose sources (h, w, 2) are neighbours too.

    Pairs with a negative source, a known pixel, do not count. 1 where there is no pair.
    """
    rows, columns = source[..., 0], source[..., 1]
    right = (rows[:, 1:] == rows[:, :-1]) & (columns[:, 1:] == columns[:, :-1] + 1)
    down = (rows[1:] == rows[:-1] + 1) & (columns[1:] == columns[:-1])
    copied = rows >= 0
    right = right[copied[:, 1:] & copied[:, :-1]]
    down = down[copied[1:] & copied[:-1]]
    pairs = right.size + down.size
    return float((right.sum() + down.sum()) / pairs) if pairs else 1.0


def coverage(source: NDArray, shape: tuple[int, int], usable: NDArray[np.bool_] | None = None) -> float:
    """Share of the usable pixels of an exemplar that occur in the sources (..., 2); negative ones do not count.

    ``shape`` is the exemplar's; all its pixels are usable without a mask (h, w).
    """
    used = np.zeros(shape, bool)
    source = source[source[..., 0] >= 0]
    used[source[..., 0].astype(np.intp), source[..., 1].astype(np.intp)] = True
    return float(used.mean() if usable is None else used[usable].mean())
