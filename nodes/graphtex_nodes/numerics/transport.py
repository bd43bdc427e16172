"""Prices by which windows choose all parts of an exemplar as often as wanted (Gutierrez et al. 2017)."""

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work, for_rows

Array = NDArray[np.float32]

MOST_PLACES = 1024
"""Exemplar windows up to which prices are found."""
MOST_PAIRS = 150_000
"""Pairs of windows up to which all windows that look for a source are asked; of more, a regular part."""
SOFTNESS = 0.05
"""Differences of cost that windows hardly mind, as a share of the variance of the exemplar's windows."""
ROUNDS = 20
STEEPEST = 80.0
"""Differences in units of softness up to which costs are told apart: with larger ones numbers would be 0."""


def prices(
    windows: Array, places: Array, share: Array, firmness: float, work: Work, groups: NDArray[np.intp] | None = None
) -> Array:  # fmt: skip
    r"""Prices (m,) of exemplar windows under which each is chosen about as often as it should be.

    A window takes the place where squared distance plus price is lowest. The prices are the dual variables of optimal
    transport between windows and places, smoothed by entropy and relaxed by

    .. math:: \rho \sum_j u_j \log \frac{u_j}{s_j}

    for a place that is used with frequency u instead of the wanted s (Chizat et al. 2018); fixed-point iteration.
    Charges that grow with the last turn's use instead make all windows leave a place at once and return together.

    Parameters
    ----------
    windows
        Coordinates (n, k) of windows that look for a source.
    places
        Coordinates (m, k) of the exemplar's windows.
    share
        How often each place should be used (m,), any unit; positive.
    firmness
        :math:`\rho` in variances of ``places``; 0 = prices of 0.
    groups
        Number (m,) from 0 on of the group that each place belongs to: one price for all of it, and together they should
        be used as often as their shares say. None = each for itself.

    Returns
    -------
    float32, 0 where it is lowest.
    """
    variance = float(places.var(axis=0, dtype=np.float64).sum())
    if variance <= 0 or firmness <= 0:
        return np.zeros(len(places), np.float32)
    stride = -(-len(windows) * len(places) // MOST_PAIRS)
    members = np.arange(len(places)) if groups is None else groups
    order = np.argsort(members, kind="stable")
    unit = (SOFTNESS * variance) ** -0.5
    seen = (windows[(stride - 1) // 2 :: stride] * unit).astype(np.float32)
    known = (places[order] * unit).astype(np.float32)
    lengths, columns = (known**2).sum(axis=1), np.ascontiguousarray(known.T)
    starts = np.flatnonzero(np.diff(members[order], prepend=-1))
    kernel = np.empty((len(seen), len(starts)))

    def band(first: int, stop: int) -> None:
        # einsum, not matrix products: their bits may change with the number of threads
        cost = lengths - np.einsum("ik,kj->ij", 2 * seen[first:stop], columns)
        cost -= cost.min(axis=1, keepdims=True)
        np.add.reduceat(np.exp(-np.minimum(cost, STEEPEST)), starts, axis=1, dtype=np.float64, out=kernel[first:stop])

    for_rows(band, len(seen), known.size, work)
    wanted = np.add.reduceat(share[order], starts, dtype=np.float64)
    wanted /= wanted.sum()
    damping = firmness / (firmness + SOFTNESS)
    appeal = np.ones(len(wanted))
    for _ in range(ROUNDS):
        asked = np.einsum("ij,j->i", kernel, appeal)
        free = np.einsum("ij,i->j", kernel, 1 / asked) / len(seen)
        appeal = (wanted / free) ** damping
    found = -SOFTNESS * variance * np.log(appeal)[members]
    result: Array = (found - found.min()).astype(np.float32)
    return result
