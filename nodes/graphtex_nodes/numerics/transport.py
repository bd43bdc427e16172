"""Prices by which windows choose all parts of an exemplar as often as wanted (Gutierrez et al. 2017)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import transport_kernels
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


@dataclass(frozen=True)
class Market:
    """Places of an exemplar that are to be used evenly, in the order of their groups.

    Attributes
    ----------
    variance
        Total variance of the places.
    columns, lengths
        Their coordinates (k, m) in units of softness, and squared lengths (m,).
    starts
        Where each group begins (g,).
    members
        Number of the group (m,) that each place belongs to, in the order in which they were given.
    wanted
        How often each group should be used (g,), with sum 1.
    """

    variance: float
    columns: Array
    lengths: Array
    starts: NDArray[np.int64]
    members: NDArray[np.intp]
    wanted: NDArray[np.float64]


def market(places: Array, share: Array, groups: NDArray[np.intp] | None = None) -> Market:
    """What prices of places are found from.

    Parameters
    ----------
    places
        Coordinates (m, k) of the exemplar's windows.
    share
        How often each place should be used (m,), any unit; positive.
    groups
        Number (m,) from 0 on of the group that each place belongs to: one price for all of it, and together they should
        be used as often as their shares say. None = each for itself.
    """
    variance = float(places.var(axis=0, dtype=np.float64).sum())
    members = np.arange(len(places)) if groups is None else groups
    order = np.argsort(members, kind="stable")
    known = (places[order] * _unit(variance)).astype(np.float32)
    starts = np.flatnonzero(np.diff(members[order], prepend=-1))
    wanted = np.add.reduceat(share[order], starts, dtype=np.float64)
    return Market(
        variance,
        np.ascontiguousarray(known.T),
        (known**2).sum(axis=1),
        starts.astype(np.int64),
        members,
        wanted / wanted.sum(),
    )


def prices(windows: Array, market: Market, firmness: float, work: Work) -> Array:
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
    market
        The exemplar's windows.
    firmness
        :math:`\rho` in variances of the places; 0 = prices of 0.

    Returns
    -------
    float32, 0 where it is lowest.
    """
    count = len(market.members)
    if market.variance <= 0 or firmness <= 0:
        return np.zeros(count, np.float32)
    stride = -(-len(windows) * count // MOST_PAIRS)
    seen = 2 * (windows[(stride - 1) // 2 :: stride] * _unit(market.variance)).astype(np.float32)
    attraction = np.empty((len(seen), count), np.float32)

    def band(first: int, stop: int) -> None:
        # not by a matrix product: its bits may change with the number of threads
        transport_kernels.exponents(seen, market.columns, market.lengths, STEEPEST, attraction, first, stop)
        np.exp(attraction[first:stop], out=attraction[first:stop])

    for_rows(band, len(seen), market.columns.size, work)
    appeal = np.empty(len(market.starts))
    damping = firmness / (firmness + SOFTNESS)
    transport_kernels.balance(attraction, market.starts, market.wanted, damping, ROUNDS, appeal)
    found = -SOFTNESS * market.variance * np.log(appeal)[market.members]
    result: Array = (found - found.min()).astype(np.float32)
    return result


def _unit(variance: float) -> float:
    """What coordinates are multiplied with to be in units of softness."""
    return float((SOFTNESS * variance) ** -0.5) if variance > 0 else 0.0
