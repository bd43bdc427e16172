"""Even use of an exemplar: what its windows are charged so that none is used much more often than wanted."""

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.transport import MOST_PLACES, prices
from graphtex_nodes.numerics.window_mean import window_mean

Array = NDArray[np.float32]
Field = NDArray[np.int32]
Flags = NDArray[np.bool_]

SMOOTH = 1 / 3
"""Mean squared difference of a window's neighbouring pixels, in that of all, below which it counts as smooth."""


def charge(
    windows: Array, features: Array, share: Array, relief: Array, field: Field, mean: float, *, evenness: float,
    step: int, radius: int, allowed: Flags | None, wanted: Flags | None, work: Work, kept: Array | None = None,
) -> Array:  # fmt: skip
    """Cost of each exemplar window (h, w) beside its distance.

    Where the exemplar has few windows, on coarse levels, it is a price at which windows share all of them. So parts of
    the exemplar keep their share of the output, which finer levels do not change much. There, and where only some
    ``wanted`` windows (rows, columns) look for a source, it rises with how often a place and those around were used.

    Parameters
    ----------
    windows, features
        Coordinates of the windows that look for a source (rows, columns, k), and of the exemplar's (h, w, k).
    share
        How often each exemplar window should be used (h, w), relative to the mean.
    relief
        Share (h, w) of the charge that a window pays: see :func:`local_relief`.
    field, mean
        The sources found last (rows, columns, 2) and their mean squared distance, 0 if none were.
    evenness
        What a window that is used twice as often as wanted pays in mean squared distances; firmness of prices in
        variances of ``features``.
    step
        Distance of neighbouring windows: of a lattice they may need but some places of each step x step, so these share
        a price.
    radius
        Windows around one that count as the same place.
    allowed
        Exemplar windows (h, w) that may be used; None = all.
    kept
        What the turn before charged. Where that was prices it stays: they hardly change in one turn. None = find anew.
    """
    height, width = features.shape[:2]
    result = np.zeros((height, width), np.float32)
    may = np.ones((height, width), bool) if allowed is None else allowed
    if evenness > 0 and wanted is None and np.count_nonzero(may) <= MOST_PLACES:
        if kept is not None:
            return kept
        rows, columns = np.nonzero(may)
        cells = np.unique(rows // step * width + columns // step, return_inverse=True)[1]
        result[may] = prices(windows.reshape(-1, windows.shape[2]), features[may], share[may], evenness, work, cells)
    elif evenness > 0 and mean > 0:
        used = usage(field if wanted is None else field[wanted], (height, width), radius, allowed)
        result = np.maximum(0, used / share - 1) * relief * np.float32(evenness * mean)
    return result


def local_relief(image: Array, window: int) -> Array:
    """What share of a charge the windows of an image (h, w, c) pay: 1, but less where they hardly differ from others.

    Windows are told from those one pixel beside them by the squared differences of neighbouring pixels. A window with
    less than a third of the mean of these pays as much less: distances are small there too, and a charge in mean
    distances would break up smooth areas into specks.
    """
    change = np.zeros(image.shape[:2])
    change[:-1] += (np.diff(image, axis=0) ** 2).sum(axis=2)
    change[:, :-1] += (np.diff(image, axis=1) ** 2).sum(axis=2)
    around = window_mean(change, window // 2 * 2 + 1).astype(np.float32)
    low, high = (window - 1) // 2, window // 2
    around = around[low : len(around) - high, low : around.shape[1] - high]
    mean = around.mean(dtype=np.float64)
    share: Array = np.minimum(1, around / (SMOOTH * mean)).astype(np.float32) if mean > 0 else np.ones_like(around)
    return share


def usage(
    field: NDArray[np.int32], shape: tuple[int, int], radius: int, allowed: NDArray[np.bool_] | None = None
) -> Array:
    """How often each exemplar window is used, relative to the mean, averaged over a box of 2 radius + 1 windows.

    ``field`` (..., 2) holds rows and columns below ``shape``. Of windows that are not ``allowed`` (h, w) none counts.
    """
    counts = np.bincount((field[..., 0] * shape[1] + field[..., 1]).ravel(), minlength=shape[0] * shape[1])
    used = counts.reshape(shape) / max(1, counts.sum())
    side = 2 * radius + 1
    if allowed is None:
        everywhere: Array = window_mean(used * counts.size, side).astype(np.float32)
        return everywhere
    around = window_mean(allowed, side).astype(np.float32)
    relative = window_mean(used * np.count_nonzero(allowed), side).astype(np.float32) / np.where(around > 0, around, 1)
    return relative.astype(np.float32)
