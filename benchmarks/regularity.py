"""How far a picture keeps to the lattice or the rows of its exemplar, judged from the pictures alone."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.lattice import Repeats, repeats
from graphtex_nodes.numerics.pyramid import halve
from graphtex_nodes.numerics.structure import LARGEST, autocorrelation

Array = NDArray[Any]

COARSE = 4  # pixels: finer things that repeat, as threads, do not count
SLACK = 1  # pixels that a peak may lie beside its place


def order(image: Array, found: Repeats) -> float:
    """Mean autocorrelation of a picture (h, w, c) at multiples of the shifts under which its exemplar repeats itself.

    Those count that are up to a third of its sides long, so of a larger picture farther ones: one fault between them,
    and they do not agree. Of rows it is the mean over all shifts along them. 1 for a picture that repeats exactly.

    Examples
    --------
    >>> wave = np.cos(np.arange(120) * 2 * np.pi / 12).astype(np.float32)
    >>> rows = Repeats(np.diag([12.0, 1.0]), 12.0, False)
    >>> joined = np.concatenate([wave[:60], wave[6:66]])  # out of step by half a period
    >>> [round(order(np.tile(each[:, None, None], (1, 120, 1)), rows), 1) for each in (wave, joined)]
    [1.0, 0.5]
    """
    picture, shifts = image.astype(np.float32), found.shifts
    coarse = float(COARSE)
    while max(picture.shape[:2]) > LARGEST:
        picture, shifts, coarse = halve(picture), shifts / 2, coarse / 2
    lags = autocorrelation(picture, coarse / 4)[0]
    if not found.cells:
        axis = int(shifts[1, 1] > shifts[0, 0])
        profile = lags.mean(axis=1 - axis, dtype=np.float64)
        period, middle = shifts[axis, axis], profile.size // 2
        places = middle + np.rint(period * np.arange(1, (middle - SLACK) // period + 1)).astype(int)
        peaks = [profile[place - SLACK : place + SLACK + 1].max() for place in places]
        return float(np.mean(peaks))
    middle = np.array(lags.shape) // 2
    count = int(middle.max() // np.abs(shifts).max(axis=1).min()) + 1
    peaks = []
    for multiple in np.ndindex(2 * count + 1, 2 * count + 1):
        steps = np.array(multiple) - count
        y, x = middle + np.rint(steps @ shifts).astype(int)
        inside = SLACK <= y < lags.shape[0] - SLACK and SLACK <= x < lags.shape[1] - SLACK
        if steps.any() and inside:
            peaks.append(lags[y - SLACK : y + SLACK + 1, x - SLACK : x + SLACK + 1].max())
    return float(np.mean(peaks))


def regular(exemplar: Array) -> Repeats | None:
    """Shifts under which an exemplar repeats itself; None if it is not regular."""
    return repeats(np.ascontiguousarray(exemplar, np.float32), COARSE)
