"""Shifts under which a picture repeats itself: cells of a lattice, or rows."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.structure import autocorrelation, peaks

Array = NDArray[np.float64]

TIMES = 4
"""How often at least a picture shows what is a repeat of all, and not by chance."""
REGULAR = 0.75
"""Mean autocorrelation at its points from which a lattice counts: pavings and cloth have 0.8 to 0.95, walls 0.45."""
ROWS, SHARE = 0.4, 0.15
"""The same for the means of rows: walls have 0.4 to 0.9; and what share of the variance these must hold."""
ALIKE = 0.8
"""Share of the highest peak that makes one a repeat of all, and not of a part."""
BETWEEN = 0.8
"""Most that the autocorrelation may have on the way to a repeat, in that of the repeat."""
ACROSS = 0.5
"""Sine of the least angle between the two shifts of a lattice."""
FAR = 0.15
"""Distance of a peak from where a lattice would have it, in its shorter shift, up to which it is the same."""
FARTHEST = 8
"""Multiples of a shift at which peaks are looked for."""
FREE = 16
"""Shifts that an axis without a period is long, where another has one."""
WHOLE = 0.5
"""How much a place between pixels counts beside one beyond the exemplar."""
BESIDE = 2
"""Cells on each side that are looked at for a place inside an exemplar."""
RESOLVED = 4.25
"""Coarse pixels that a period must have: with less, pieces in step hardly fit better than others."""
KEPT = 9.0
"""Pixels of a period up to which sources that were found are put in step: with more they stay so by themselves."""
SMOOTH = 0.25
"""Deviation of the Gaussian that smoothes a picture before, in coarse pixels."""


class Repeats(NamedTuple):
    """Two shifts (2, 2), as rows and columns, of which all whole multiples show a picture again.

    Of a lattice of cells these are its sides. A wall is alike from row to row only, or one of boards from column to
    column: then one shift leads there, and the other a single pixel along the rows. ``period`` is the shorter side of a
    cell, or the distance of rows; ``cells`` tells which.
    """

    shifts: Array
    period: float
    cells: bool

    def enlarged(self, factor: float) -> "Repeats":
        """Those of the picture made so many times as large."""
        return Repeats(self.shifts * factor, self.period * factor, self.cells)


def repeats(picture: NDArray[np.float32], coarse: int) -> Repeats | None:
    """Shifts under which a picture (h, w, c) repeats itself; None where it does not, or less than four times.

    Parameters
    ----------
    coarse
        Side in pixels of the coarse ones for which shifts are wanted: smaller things that repeat do not count, and of
        what repeats after less than :data:`RESOLVED` of them nothing is told.

    Examples
    --------
    >>> wave = np.cos(np.arange(60, dtype=np.float32) * 2 * np.pi / 12)
    >>> repeats(np.add.outer(wave, wave)[..., None], 1).shifts.round().astype(int).tolist()
    [[0, 12], [12, 0]]
    """
    least = RESOLVED * coarse
    if min(picture.shape[:2]) < TIMES * least:
        return None
    lags, rows, columns = autocorrelation(picture, SMOOTH * coarse)
    shifts = _cells(lags, rows, columns)
    cells = shifts is not None
    if shifts is not None:
        lengths = np.hypot(*shifts.T)
        period, longest = float(lengths.min()), float(lengths.max())
    else:
        periods = [_period(lags.mean(axis=1 - axis, dtype=np.float64)) for axis in (0, 1)]
        axis = int(periods[1][1] > periods[0][1])
        period = longest = periods[axis][0]
        shifts = np.diag([period, 1.0] if axis == 0 else [1.0, period])
    enough = least <= period and longest <= min(picture.shape[:2]) / TIMES
    return Repeats(shifts, period, cells) if enough else None


def _cells(lags: NDArray[np.float32], rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array | None:
    """The two shortest shifts of an autocorrelation's highest peaks, or None."""
    y, x = np.nonzero(peaks(lags))
    shifts, heights = np.stack([rows[1 + y], columns[1 + x]], axis=-1), lags[1 + y, 1 + x]
    length = np.hypot(*shifts.T)
    chosen = (shifts[:, 0] > 0) | ((shifts[:, 0] == 0) & (shifts[:, 1] > 0))
    # along a stripe all shifts are alike, and none is a repeat
    half = shifts // 2 + np.array(lags.shape) // 2
    chosen &= lags[half[:, 0], half[:, 1]] <= BETWEEN * heights
    if not chosen.any():
        return None
    chosen &= heights >= ALIKE * heights[chosen].max()
    order = np.argsort(length[chosen], kind="stable")
    shifts, length = shifts[chosen][order], length[chosen][order]
    area = np.abs(shifts[0, 0] * shifts[:, 1] - shifts[0, 1] * shifts[:, 0])
    others = np.flatnonzero(area > ACROSS * length[0] * length)
    if others.size == 0:
        return None
    basis, height = _fitted(shifts[[0, others[0]]], lags)
    return basis if height >= REGULAR else None


def _fitted(basis: NDArray[np.intp], lags: NDArray[np.float32]) -> tuple[Array, float]:
    """Shifts (2, 2) that fit the peaks near all of their multiples best, and the mean height of these."""
    middle = np.array(lags.shape) // 2
    reach = max(1, int(FAR * np.hypot(*basis[0])))
    count = min(FARTHEST, int(middle.max() // np.hypot(*basis[0])) + 1)
    multiples, places, heights = [], [], []
    for multiple in np.ndindex(2 * count + 1, 2 * count + 1):
        steps = np.array(multiple) - count
        corner = middle + steps @ basis - reach
        if tuple(steps) <= (0, 0) or (corner < 0).any() or (corner + 2 * reach >= lags.shape).any():
            continue
        around = lags[corner[0] : corner[0] + 2 * reach + 1, corner[1] : corner[1] + 2 * reach + 1]
        places.append(corner - middle + np.unravel_index(int(around.argmax()), around.shape))
        heights.append(max(0.0, float(around.max())))
        multiples.append(steps)
    if not multiples:
        return basis.astype(np.float64), 0.0
    normal = np.einsum("k,ki,kj->ij", heights, multiples, multiples)
    if np.linalg.matrix_rank(normal) < 2:
        return basis.astype(np.float64), 0.0
    fitted = np.linalg.solve(normal, np.einsum("k,ki,kj->ij", heights, multiples, places))
    return fitted, float(np.mean(heights))


def _period(profile: Array) -> tuple[float, float]:
    """Period of rows and their share of the variance by the autocorrelation's mean (n,) at each distance; or zeros."""
    ahead = profile[profile.size // 2 :]
    share = float(ahead[0])
    if share < SHARE:
        return 0.0, 0.0
    ahead = ahead / share
    tops = 1 + np.flatnonzero((ahead[1:-1] >= ahead[:-2]) & (ahead[1:-1] > ahead[2:]) & (ahead[1:-1] >= ROWS))
    for first in tops:
        reach = max(1, int(FAR * first))
        numbers = np.arange(1, (ahead.size - 1 - reach) // first + 1)
        around = [ahead[number * first - reach : number * first + reach + 1] for number in numbers]
        heights = np.array([each.max() for each in around])
        if numbers.size and heights.mean() >= ROWS:
            places = numbers * first - reach + [int(each.argmax()) for each in around]
            weights = np.maximum(heights, 0)
            return float((weights * numbers * places).sum() / (weights * numbers**2).sum()), share
    return 0.0, 0.0


def stretched(basis: Array, periods: tuple[float, float]) -> Array:
    """The shifts (2, 2) stretched so that whole multiples of them lead along each axis to its period (0 = it has none).

    They stay as they are where that would change one of them by more than :data:`FAR` of its length.
    """
    lengths = np.array([period or FREE * float(np.abs(basis).max()) for period in periods])
    multiples = np.rint(np.diag(lengths) @ np.linalg.inv(basis))
    if np.linalg.matrix_rank(multiples) < 2:
        return basis
    ends = multiples @ basis
    for axis, period in enumerate(periods):
        if period:
            ends[axis] = period * np.eye(2)[axis]
    fitting: Array = np.linalg.solve(multiples, ends)
    change = np.hypot(*(fitting - basis).T) / np.hypot(*basis.T)
    return fitting if (change <= FAR).all() else basis


def in_step(
    places: NDArray[np.int32], corners: NDArray[np.intp], limits: tuple[Any, Any], own: Array, there: Array
) -> NDArray[np.int32]:
    """Places (..., 2) of an exemplar that stand in their cell as ``corners`` (..., 2) of the output do in theirs.

    Of those near by it is one in the exemplar, hardly between pixels, and as near as can be.

    Parameters
    ----------
    limits
        Least and largest row and column (2,) of a place.
    own, there
        Shifts (2, 2) under which the exemplar repeats itself, and those of the output.
    """
    low, high = (np.asarray(limit) for limit in limits)
    places = np.clip(places, low, high)
    phase = _times(corners, np.linalg.inv(there))
    multiples = np.rint(_times(places, np.linalg.inv(own)) - phase)
    best = np.zeros(places.shape)
    least = np.full(places.shape[:-1], np.inf)
    for more in np.ndindex(2 * BESIDE + 1, 2 * BESIDE + 1):
        found = _times(phase + multiples + np.array(more) - BESIDE, own)
        beyond = np.maximum(0, low - found) + np.maximum(0, found - high)
        between = np.abs(found - np.rint(found))
        cost = (np.abs(found - places) + (high - low).max() * (beyond + WHOLE * between)).sum(axis=-1)
        nearer = cost < least
        least[nearer] = cost[nearer]
        best[nearer] = found[nearer]
    return np.clip(np.rint(best), low, high).astype(np.int32)


def _times(points: NDArray[Any], matrix: NDArray[Any]) -> Array:
    """Points (..., 2) times a matrix (2, 2), without BLAS, whose bits may change with the number of threads."""
    result: Array = np.einsum("...i,ij->...j", points, matrix)
    return result
