"""Even use of an exemplar: what its windows are charged so that none is used much more often than wanted."""

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.copies import crowding, shown, stretch
from graphtex_nodes.numerics.transport import MOST_PLACES, Market, market
from graphtex_nodes.numerics.window_mean import window_mean

Array = NDArray[np.float32]
Field = NDArray[np.int32]
Flags = NDArray[np.bool_]
Homes = NDArray[np.intp]

CROWDED = 0.05
"""What a window pays for each copy around, in variances of the exemplar's windows times the evenness."""
STRETCHED = 6.0
"""What a window pays that goes on with a piece of which all around at a distance is shown, in the same unit ..."""
LONG = 0.02
"""... and the mean share around of what goes on up to which none pays; from twice of it on all pay that much."""
MOST_CROWDED = 4096
"""Exemplar windows up to which a level is no fine one: those keep what is where."""
SMOOTH = 1 / 3
"""Mean squared difference of a window's neighbouring pixels, in that of all, below which it counts as smooth."""


def places(features: Array, share: Array, *, evenness: float, step: int, allowed: Flags | None) -> Market | None:
    """The exemplar's windows as places that have prices; None where they are too many, on fine levels.

    With prices windows share all of the exemplar's coarse levels. So its parts keep their share of the output, which
    finer levels do not change much.

    Parameters
    ----------
    features
        Coordinates of the exemplar's windows (h, w, k).
    share
        How often each exemplar window should be used (h, w), relative to the mean.
    evenness
        Firmness of prices in variances of ``features``.
    step
        Distance of neighbouring windows: of a lattice they may need but some places of each step x step, so these share
        a price.
    allowed
        Exemplar windows (h, w) that may be used; None = all.
    """
    if evenness <= 0 or _count(share, allowed) > MOST_PLACES:
        return None
    may = np.ones(share.shape, bool) if allowed is None else allowed
    cells = np.unique(squares((share.shape[0], share.shape[1]), step)[may], return_inverse=True)[1]
    return market(features[may], share[may], cells)


def squares(shape: tuple[int, int], side: int) -> Homes:
    """Number of the square of this side in which each of h x w windows lies."""
    rows, columns = (np.arange(count) // side for count in shape)
    numbers: Homes = rows[:, None] * (columns[-1] + 1) + columns
    return numbers


def crowded(share: Array, *, evenness: float, allowed: Flags | None) -> bool:
    """Whether copies are charged for being close together: see :func:`crowd`.

    Not on fine levels, where all is arranged, nor where some places are wanted more than others: those that a guide
    asks for in one part of the output are few, and must repeat.
    """
    return evenness > 0 and _count(share, allowed) <= MOST_CROWDED and not np.ptp(share) > 0


def crowd(
    field: Field, relief: Array, *, variance: float, evenness: float, step: int, grain: float
) -> tuple[Array, int]:  # fmt: skip
    """What cells of the exemplar cost more where they are shown near by, and the side of a cell.

    Where long copies are common in grain, so do those that go on with one, see :func:`stretch`: pieces then end before
    they repeat the arrangement of the exemplar as a whole. Elements with outlines would be cut by that.

    Parameters
    ----------
    field
        The sources found last (rows, columns, 2).
    relief
        Share (h, w) of the charge that each of the exemplar's windows pays: see :func:`local_relief`.
    variance
        Total variance of the exemplar's windows.
    evenness, step
        See :func:`places`.
    grain
        1 where the exemplar is grain, 0 where it has elements with outlines.

    Returns
    -------
    charge, cell
        float32 (a, b, h / cell, w / cell), both rounded up, in each of a x b tiles of the output.
    """
    found = shown(field, (relief.shape[0], relief.shape[1]), step)
    copies = crowding(found)
    if grain > 0:
        further, common = stretch(found)
        excess = grain * min(1.0, max(0.0, common / LONG - 1))
        # shorter pieces meet each other's copies more often
        copies = np.float32(1 + excess) * copies + np.float32(STRETCHED / CROWDED * excess) * further
    copies *= relief[:: found.cell, :: found.cell] * np.float32(CROWDED * evenness * variance)
    return copies, found.cell


def lasting(share: Array, allowed: Flags | None) -> int:
    """Turns for which prices and what :func:`crowd` charges last: they hardly change from one to the next.

    Fewer where there are prices than where crowding alone is charged.
    """
    return 2 if _count(share, allowed) <= MOST_PLACES else 4


def _count(share: Array, allowed: Flags | None) -> int:
    """How many exemplar windows may be used."""
    return share.size if allowed is None else int(np.count_nonzero(allowed))


def charge(
    share: Array, relief: Array, field: Field, mean: float, *, evenness: float, radius: int, step: int,
    allowed: Flags | None, wanted: Flags | None, homes: Homes | None = None,
) -> Array | None:  # fmt: skip
    """What each exemplar window (h, w) costs for being used more often than wanted; None where it has a price instead.

    Parameters
    ----------
    share, relief, field, allowed
        See :func:`places` and :func:`crowd`.
    mean
        Mean squared distance of the sources found last, 0 if none were.
    evenness
        What a window that is used twice as often as wanted pays in mean squared distances.
    radius
        Windows around one that count as the same place.
    step
        Distance of neighbouring windows of the output in pixels.
    wanted
        Output windows (rows, columns) that look for a source, if not all do: then there are no prices.
    homes
        See :func:`homes`: of windows that show the same place not one alone is charged, but all for their use together.

    However seldom windows of a large stock should be used, nothing is charged where a piece is copied once as it is:
    else all would flee from whatever they agree on, and nothing but smooth places would be left.
    """
    if evenness <= 0 or mean <= 0 or (wanted is None and _count(share, allowed) <= MOST_PLACES):
        return None
    chosen = field if wanted is None else field[wanted]
    used = usage(chosen, share.shape, radius, allowed)
    if wanted is None:
        side = 2 * radius + 1
        once = (-(-side // step) / side) ** 2 * _count(share, allowed) / field[..., 0].size
        share = np.maximum(share, np.float32(once))
    over = used / share
    if homes is not None:
        shown = np.bincount(homes[chosen[..., 0], chosen[..., 1]].ravel(), minlength=int(homes.max()) + 1) * step**2
        over = np.maximum(over, (shown / max(radius**2, shown.mean())).astype(np.float32)[homes])
    result: Array = np.maximum(0, over - 1) * relief * np.float32(evenness * mean)
    return result


def homes(origin: Array, shape: tuple[int, int], window: int, level: int, rim: int = 0) -> Homes:
    """Number of the place (h, w) that each window shows: squares of half its side, in pixels of its level.

    Parameters
    ----------
    origin
        Index, row and column (eh, ew, 3) of what each pixel of the exemplar shows on the finest level.
    shape, window, level
        Rows and columns of the exemplar's windows, their side, and the level whose pixels are 2 ** level wide.
    rim
        Pixels by which windows reach over the exemplar's border.
    """
    middles = [
        np.clip((np.arange(count) + window / 2 - rim) * 2**level, 0, most - 1).astype(np.intp)
        for count, most in zip(shape, origin.shape, strict=False)
    ]
    shown = origin[np.ix_(*middles)].astype(np.intp)
    shown[..., 1:] //= max(1, window // 2) << level
    high = shown.max(axis=(0, 1)) + 1
    numbers = (shown[..., 0] * high[1] + shown[..., 1]) * high[2] + shown[..., 2]
    return np.unique(numbers, return_inverse=True)[1].reshape(shape)


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
