"""Nearest exemplar windows: exact, or PatchMatch from a good start."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import search_kernels
from graphtex_nodes.numerics.parallel import Work, for_rows

Array = NDArray[np.float32]
Field = NDArray[np.int32]
Flags = NDArray[np.bool_]

EXACT_LIMIT = 2e7
"""Multiply-adds up to which a search over all windows is done instead of PatchMatch (about 0.01 s)."""
LIST_LIMIT = 4e9
"""Multiply-adds of the first search of all; beyond that it sees a regular part of the exemplar's windows."""


@dataclass(frozen=True)
class Charge:
    """What exemplar windows cost beside their squared distance.

    Attributes
    ----------
    own
        Charge of each window (h, w); infinite where it must not be used.
    shared
        What all windows of a cell are charged besides (a, b, h / cell, w / cell), both rounded up, in each of a x b
        tiles of the windows that look for a source another; None = nothing.
    cell
        Side of a cell in windows.
    """

    own: Array
    shared: Array | None = None
    cell: int = 1

    def tables(self) -> tuple[Array, Array, NDArray[np.int32]]:
        """Both charges, and the numbers of the cells along rows and columns."""
        sides = np.arange(max(self.own.shape), dtype=np.int32)
        if self.shared is None:
            return self.own, np.zeros((1, 1, 1, 1), np.float32), np.zeros_like(sides)
        return self.own, self.shared, sides // np.int32(self.cell)


def exact_cost(windows: Array, exemplar: Array) -> float:
    """Multiply-adds of an exact search."""
    return float(windows[..., 0].size) * exemplar.size


def search_exact(
    windows: Array, exemplar: Array, charge: Charge, work: Work, wanted: Flags | None = None
) -> tuple[Field, Array]:
    """Best exemplar window for each window, by brute force.

    Parameters
    ----------
    windows
        Coordinates (rows, columns, k) of the windows that look for a source.
    exemplar
        Coordinates (h, w, k) of the exemplar's windows.
    charge
        Added to the squared distance.
    wanted
        Which windows look for a source (rows, columns); None = all. The distances of others are 0.

    Returns
    -------
    field, distances
        Row and column of the source, int32 (rows, columns, 2), and squared distance without charge (rows, columns).
    """
    rows, columns = windows.shape[:2]
    places = np.argwhere(np.isfinite(charge.own)).astype(np.int32)
    seen = exact_cost(windows, exemplar) * len(places) / charge.own.size
    stride = min(len(places), int(np.ceil(seen / LIST_LIMIT)))
    places = np.ascontiguousarray(places[(stride - 1) // 2 :: stride])
    field = np.zeros((rows, columns, 2), np.int32)
    distances = np.zeros((rows, columns), np.float32)
    flags, tables = _flags(wanted, distances), charge.tables()

    def band(first: int, stop: int) -> None:
        search_kernels.search_listed(windows, exemplar, places, *tables, flags, field, distances, first, stop)

    for_rows(band, rows, columns * len(places) * windows.shape[2] / 2, work)
    return field, distances


def search_warm(
    windows: Array, exemplar: Array, charge: Charge, field: Field, *, step: int, seed: int, passes: int, work: Work,
    wanted: Flags | None = None,
) -> tuple[Field, Array]:  # fmt: skip
    """PatchMatch (Barnes et al. 2009) from the given field; parameters as :func:`search_exact`.

    Departure: every window reads the field of the pass before (Jacobi) instead of its neighbours' new values, so the
    result does not depend on the order of the work. The distance over which good sources spread is made up for by jumps
    that halve from pass to pass. Squares of random places shrink by four instead of by two: from a good start that
    finds as much in half the time.
    """
    rows, columns = field.shape[:2]
    distances = np.zeros((rows, columns), np.float32)
    flags, tables = _flags(wanted, distances), charge.tables()
    seeds = np.random.SeedSequence(seed).generate_state(passes, np.uint64)
    reach = max(exemplar.shape[:2])
    for number in range(passes):
        before, field = field, np.empty_like(field)
        jump = 1 << (passes - 1 - number)

        def band(
            first: int,
            stop: int,
            before: Field = before,
            after: Field = field,
            seed: np.uint64 = seeds[number],
            jump: int = jump,
        ) -> None:
            search_kernels.search_near(
                windows, exemplar, *tables, flags, before, after, distances, step, jump, reach, seed, first, stop
            )

        for_rows(band, rows, columns * 20 * windows.shape[2], work)
    return field, distances


def _flags(wanted: Flags | None, distances: Array) -> NDArray[np.uint8]:
    return (np.ones(distances.shape, bool) if wanted is None else np.ascontiguousarray(wanted)).view(np.uint8)
