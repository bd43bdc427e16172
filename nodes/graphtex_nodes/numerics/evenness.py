"""Even use of an exemplar: what its windows are charged so that none is used much more often than wanted."""

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.transport import MOST_PLACES, prices
from graphtex_nodes.numerics.window_mean import window_mean

Array = NDArray[np.float32]
Field = NDArray[np.int32]
Flags = NDArray[np.bool_]

CROWDED = 0.05
"""What a window pays for each copy around, in variances of the exemplar's windows times the evenness."""
MOST_CROWDED = 4096
"""Exemplar windows up to which a level is no fine one: those keep what is where."""
SMOOTH = 1 / 3
"""Mean squared difference of a window's neighbouring pixels, in that of all, below which it counts as smooth."""


def standing(
    windows: Array, features: Array, share: Array, crowd: Array | None, *, evenness: float, step: int,
    allowed: Flags | None, work: Work,
) -> Array:  # fmt: skip
    """Cost of each exemplar window (a, b, h, w) beside its distance, for windows in each of a x b tiles of the output.

    Where the exemplar has few windows, on coarse levels, these are prices at which windows share all of them. So parts
    of the exemplar keep their share of the output, which finer levels do not change much. Besides, what :func:`crowd`
    charges. All this hardly changes from one turn to the next: see :func:`lasting`.

    Parameters
    ----------
    windows, features
        Coordinates of the windows that look for a source (rows, columns, k), and of the exemplar's (h, w, k).
    share
        How often each exemplar window should be used (h, w), relative to the mean.
    crowd
        What is charged besides (a, b, h, w); None = nothing.
    evenness
        Firmness of prices in variances of ``features``.
    step
        Distance of neighbouring windows: of a lattice they may need but some places of each step x step, so these share
        a price.
    allowed
        Exemplar windows (h, w) that may be used; None = all.
    """
    height, width = features.shape[:2]
    result = np.zeros((height, width), np.float32)
    if evenness > 0 and _count(share, allowed) <= MOST_PLACES:
        may = np.ones((height, width), bool) if allowed is None else allowed
        rows, columns = np.nonzero(may)
        cells = np.unique(rows // step * width + columns // step, return_inverse=True)[1]
        result[may] = prices(windows.reshape(-1, windows.shape[2]), features[may], share[may], evenness, work, cells)
    return result[None, None] if crowd is None else crowd + result


def crowd(
    field: Field, features: Array, share: Array, relief: Array, *, evenness: float, step: int, allowed: Flags | None
) -> Array | None:  # fmt: skip
    """What exemplar windows cost more where they are shown near by: (a, b, h, w), in each of a x b tiles of the output.

    None on fine levels, where all is arranged, and where some places are wanted more than others: those that a guide
    asks for in one part of the output are few, and must repeat.

    Parameters
    ----------
    field
        The sources found last (rows, columns, 2).
    relief
        Share (h, w) of the charge that a window pays: see :func:`local_relief`.
    features, share, evenness, step, allowed
        See :func:`standing`.
    """
    if evenness <= 0 or _count(share, allowed) > MOST_CROWDED or np.ptp(share) > 0:
        return None
    height, width = features.shape[:2]
    variance = features.var(axis=(0, 1), dtype=np.float64).sum()
    copies, cell = crowding(field, (height, width), step)
    copies *= relief[::cell, ::cell] * np.float32(CROWDED * evenness * variance)
    charges: Array = copies.take(np.arange(height) // cell, 2).take(np.arange(width) // cell, 3)
    return charges


def lasting(share: Array, allowed: Flags | None) -> int:
    """Turns for which a standing charge lasts: fewer where it holds prices than where it tells of crowding alone."""
    return 2 if _count(share, allowed) <= MOST_PLACES else 4


def _count(share: Array, allowed: Flags | None) -> int:
    """How many exemplar windows may be used."""
    return share.size if allowed is None else int(np.count_nonzero(allowed))


def charge(
    share: Array, relief: Array, field: Field, mean: float, *, evenness: float, radius: int, allowed: Flags | None,
    wanted: Flags | None,
) -> Array | None:  # fmt: skip
    """What each exemplar window (h, w) costs for being used more often than wanted; None where it has a price instead.

    Parameters
    ----------
    share, relief, field, allowed
        See :func:`crowd`.
    mean
        Mean squared distance of the sources found last, 0 if none were.
    evenness
        What a window that is used twice as often as wanted pays in mean squared distances.
    radius
        Windows around one that count as the same place.
    wanted
        Output windows (rows, columns) that look for a source, if not all do: then there are no prices.
    """
    if evenness <= 0 or mean <= 0 or (wanted is None and _count(share, allowed) <= MOST_PLACES):
        return None
    used = usage(field if wanted is None else field[wanted], share.shape, radius, allowed)
    result: Array = np.maximum(0, used / share - 1) * relief * np.float32(evenness * mean)
    return result


def crowding(field: Field, shape: tuple[int, int], step: int) -> tuple[Array, int]:
    """How many other copies of each cell of the exemplar are shown around each of a x b tiles of the output.

    Those count that are at most half the exemplar away, but not the nearest: a tile and the eight around it are the
    place itself. Without a charge for them copies meet as chance has it: the eye finds those that are close together.

    Parameters
    ----------
    field
        Sources (rows, columns, 2) of the output's windows.
    shape
        Rows and columns of the exemplar's windows.
    step
        Distance of neighbouring windows of the output in pixels.

    Returns
    -------
    copies, cell
        float32 (a, b, h / cell, w / cell), both rounded up, and the side of a cell in windows of the exemplar. Cells
        are smaller than tiles, and neighbouring ones share what they are shown: they hold the same elements.
    """
    from scipy.ndimage import uniform_filter

    reach = min(shape) / 2 / step
    tile = max(1, round(reach / 3))
    cell = step * max(1, tile // 2)
    sides = [-(-side // tile) for side in field.shape[:2]]
    cells = [-(-side // cell) for side in shape]
    rows, columns = (np.arange(side) * count // side for side, count in zip(field.shape[:2], sides, strict=True))
    place = (rows[:, None] * sides[1] + columns) * cells[0] + field[..., 0] // cell
    place = place * cells[1] + field[..., 1] // cell
    counts = np.bincount(place.ravel(), minlength=int(np.prod(sides + cells))).reshape(*sides, *cells).astype(np.int32)
    others = _around(counts, round(reach / tile)) - _around(counts, 1)
    copies = uniform_filter(np.maximum(others, 0).astype(np.float32), (1, 1, 3, 3), mode="nearest")
    return copies * np.float32((step / cell) ** 2), cell


def _around(counts: NDArray[np.int32], radius: int) -> NDArray[np.int32]:
    """Sums (a, b, ...) over the tiles at most ``radius`` away each way."""
    for axis in (0, 1):
        lines = counts.swapaxes(0, axis)
        total = lines.copy()
        for shift in range(1, min(radius, len(lines) - 1) + 1):
            total[shift:] += lines[:-shift]
            total[:-shift] += lines[shift:]
        counts = total.swapaxes(0, axis)
    return counts


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
