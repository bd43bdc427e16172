"""Kernels that look for the nearest exemplar window."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.jit import kernel


@njit(forceinline=True)
def mixed(value):
    """SplitMix64's finaliser: 64 well-mixed bits of 64 bits."""
    value = (value ^ (value >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    value = (value ^ (value >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return value ^ (value >> np.uint64(31))


@njit(forceinline=True, fastmath={"contract", "reassoc", "nsz"})
def distance(first, second):
    """Squared distance of two vectors."""
    total = np.float32(0)
    for k in range(first.shape[0]):
        difference = first[k] - second[k]
        total += difference * difference
    return total


@njit
def charged(own, shared, cells, y, x):
    """What an exemplar window costs beside its distance; without fast mathematics: always the same sum."""
    return own[y, x] + shared[cells[y], cells[x]]


@kernel(
    "const f4[:,:,:], const f4[:,:,:], const i4[:,:], const f4[:,:], const f4[:,:,:,:], const i4[:], const u1[:,:], "
    "i4[:,:,:], f4[:,:], i8, i8",
    fastmath={"contract", "reassoc", "nsz"},
)
def search_listed(windows, exemplar, places, own, shared, cells, wanted, field, distances, first, stop):
    """Best of the listed exemplar windows for each window: brute force. The first of equals wins.

    ``windows`` (rows, columns, k) and ``exemplar`` (h, w, k) are coordinates, ``places`` (n, 2) rows and columns of the
    exemplar. Added to the squared distance are ``own`` (h, w) and ``shared`` (a, b, i, j), of the exemplar's cells, in
    each of a x b tiles of the windows another; ``cells`` are the numbers of the cells along its rows and columns.
    Written: ``field`` and squared ``distances`` of the ``wanted`` windows (rows, columns).
    """
    for row in range(first, stop):
        down_tile = row * shared.shape[0] // windows.shape[0]
        for column in range(windows.shape[1]):
            if not wanted[row, column]:
                continue
            tile = shared[down_tile, column * shared.shape[1] // windows.shape[1]]
            best = np.float32(np.inf)
            for index in range(places.shape[0]):
                y = places[index, 0]
                x = places[index, 1]
                cost = charged(own, tile, cells, y, x) + distance(windows[row, column], exemplar[y, x])
                if cost < best:
                    best = cost
                    field[row, column, 0] = y
                    field[row, column, 1] = x
            uncharged = best - charged(own, tile, cells, field[row, column, 0], field[row, column, 1])
            distances[row, column] = max(np.float32(0), uncharged)


@kernel(
    "const f4[:,:,:], const f4[:,:,:], const f4[:,:], const f4[:,:,:,:], const i4[:], const u1[:,:], const i4[:,:,:], "
    "i4[:,:,:], f4[:,:], i8, i8, i8, u8, i8, i8",
    fastmath={"contract", "reassoc", "nsz"},
)
def search_near(
    windows, exemplar, own, shared, cells, wanted, before, field, distances, step, jump, reach, seed, first, stop
):
    """One pass of PatchMatch in Jacobi form: reads the field ``before``, writes ``field``; the order does not matter.

    Candidates are the window's own source, the sources of the eight windows ``jump`` grid places away, shifted back,
    and random places around the best, in squares whose half side falls from ``reach`` by quarters. Random numbers are
    hashed from the seed and the place. A window whose ``own`` charge (see :func:`search_listed`) is infinite is never
    chosen. Windows that are not ``wanted`` (rows, columns) keep their source.
    """
    height, width = exemplar.shape[0], exemplar.shape[1]
    rows, columns = before.shape[0], before.shape[1]
    for row in range(first, stop):
        down_tile = row * shared.shape[0] // rows
        for column in range(columns):
            y = before[row, column, 0]
            x = before[row, column, 1]
            field[row, column, 0] = y
            field[row, column, 1] = x
            if not wanted[row, column]:
                continue
            window = windows[row, column]
            tile = shared[down_tile, column * shared.shape[1] // columns]
            best = charged(own, tile, cells, y, x) + distance(window, exemplar[y, x])
            for down in range(-1, 2):
                for right in range(-1, 2):
                    other_row = row + down * jump
                    other_column = column + right * jump
                    if other_row < 0 or other_row >= rows or other_column < 0 or other_column >= columns:
                        continue
                    cy = before[other_row, other_column, 0] - down * jump * step
                    cx = before[other_row, other_column, 1] - right * jump * step
                    if cy < 0 or cy >= height or cx < 0 or cx >= width or (cy == y and cx == x):
                        continue
                    cost = charged(own, tile, cells, cy, cx)
                    if cost < best:
                        cost += distance(window, exemplar[cy, cx])
                        if cost < best:
                            best = cost
                            y = cy
                            x = cx
            state = mixed(seed + np.uint64(row * columns + column) * np.uint64(0x9E3779B97F4A7C15))
            radius = reach
            while radius >= 1:
                state = mixed(state + np.uint64(0x9E3779B97F4A7C15))
                low = max(0, y - radius)
                cy = low + np.int64((state & np.uint64(0xFFFFFFFF)) % np.uint64(min(height - 1, y + radius) - low + 1))
                low = max(0, x - radius)
                cx = low + np.int64((state >> np.uint64(32)) % np.uint64(min(width - 1, x + radius) - low + 1))
                cost = charged(own, tile, cells, cy, cx)
                if cost < best:
                    cost += distance(window, exemplar[cy, cx])
                    if cost < best:
                        best = cost
                        y = cy
                        x = cx
                radius //= 4
            field[row, column, 0] = y
            field[row, column, 1] = x
            distances[row, column] = max(np.float32(0), best - charged(own, tile, cells, y, x))
