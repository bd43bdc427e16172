"""Completeness: parts of an exemplar that an output lacks are put where they fit best."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.evenness import Homes, squares
from graphtex_nodes.numerics.frames import window_counts

Array = NDArray[np.float32]
Field = NDArray[np.int32]
Flags = NDArray[np.bool_]

ENOUGH = 0.9
"""Share of an exemplar's places that an output shows at least; where all are alike about as many are shown anyway."""
PARTS = 4
"""How many parts lie along the exemplar's smaller side: large enough to hold what makes a place rare."""
LACKING = 0.3
"""Least share of a part that the output lacks."""
LOST = 0.5
"""What it costs, in variances of the exemplar's windows, to copy over the only window that shows its place; others
cost the less the more there are."""
SEEN = 8
"""Components of windows that are compared."""


def completed(
    field: Field, look: Callable[[], Array], features: Array, *, step: int, inside: tuple[slice, slice],
    allowed: Flags | None, homes: Homes | None = None,
) -> Field:  # fmt: skip
    """Sources (rows, columns, 2) of an output that show most of the exemplar, as Kaspar et al. (2015) ask for.

    Optimisation alone does not get there: what is rare looks like nothing that the output shows, so no window asks for
    it, however cheap it is; at the exemplar's border, and where a picture is alike nowhere, as a landscape, whole parts
    get lost. Departure: instead of a charge, squares of a quarter of the exemplar that are not shown, those that lack
    most before others, are copied over the output where they fit best and take nothing away that is not shown
    elsewhere. The searches of finer levels join them to what is around.

    Parameters
    ----------
    field
        Sources of the output's windows.
    look
        What gives the coordinates of the output's windows (rows, columns, k); only called if something is lacking.
    features
        Coordinates of the exemplar's windows (h, w, k), the main ones first.
    step
        Distance of neighbouring windows of the output in pixels.
    inside
        Rows and columns of the windows that count, and that may be copied over.
    allowed
        Exemplar windows (h, w) that may be used; None = all.
    homes
        Number of the place that each of them shows (h, w); None = each shows another.
    """
    numbers = squares((features.shape[0], features.shape[1]), step) if homes is None else homes
    own, places = features[::step, ::step, :SEEN], numbers[::step, ::step]
    may = np.ones(places.shape, bool) if allowed is None else allowed[::step, ::step]
    least = ENOUGH * np.count_nonzero(may)
    scale = float(own[may].var(axis=0, dtype=np.float64).sum())
    field = field.copy()
    output = field[inside]
    seen: Array | None = None
    side = min(min(places.shape) // PARTS, *output.shape[:2])
    tried = ~may
    while side > 1 and scale > 0:
        chosen = numbers[output[..., 0], output[..., 1]]
        counts = np.bincount(chosen.ravel(), minlength=int(numbers.max()) + 1)
        lacking = (counts[places] == 0) & may
        if np.count_nonzero(may & ~lacking) >= least:
            break
        lacks = window_counts(lacking & ~tried, side)
        top, left = np.unravel_index(int(lacks.argmax()), lacks.shape)
        part = slice(top, top + side), slice(left, left + side)
        if lacks[top, left] < LACKING * side**2:
            break
        tried[part] = True
        times = counts[chosen]
        seen = look()[inside][..., :SEEN].copy() if seen is None else seen
        row, column = _best_place(seen, own[part], may[part], (LOST * scale / times).astype(np.float32))
        there = slice(row, row + side), slice(column, column + side)
        if np.count_nonzero(times[there] == 1) >= lacks[top, left]:
            break
        put = may[part]
        output[there][put] = (np.argwhere(put) + np.array([top, left])) * step
        seen[there][put] = own[part][put]
    return field


def _best_place(windows: Array, part: Array, may: Flags, more: Array) -> tuple[int, int]:
    """Row and column at which a part (n, n, k), where it ``may`` be shown, differs least from windows (h, w, k).

    Besides, each of these costs ``more`` (h, w).
    """
    from scipy.fft import irfft2, next_fast_len, rfft2

    layers = np.concatenate([windows, ((windows**2).sum(axis=2) + more)[..., None]], axis=2)
    pattern = np.concatenate([-2 * part, np.ones((*may.shape, 1), np.float32)], axis=2) * may[..., None]
    padded = [next_fast_len(side, real=True) for side in more.shape]
    spectra = [rfft2(np.moveaxis(each, 2, 0), padded) for each in (layers, pattern)]
    rows, columns = (side - own + 1 for side, own in zip(more.shape, may.shape, strict=True))
    cost = irfft2((spectra[0] * spectra[1].conj()).sum(axis=0), padded)[:rows, :columns]
    row, column = np.unravel_index(int(cost.argmin()), cost.shape)
    return int(row), int(column)
