"""Kernel that counts copies of the same part of an exemplar around each part of an output."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.jit import kernel


@njit
def mean_of_three(values, sums, out):
    """Running means of three along the first axis of values (n, m), whose ends repeat; ``sums`` (m,) is scratch."""
    count = values.shape[0]
    for column in range(values.shape[1]):
        sums[column] = 2.0 * values[0, column] + values[min(1, count - 1), column]
        out[0, column] = sums[column] / 3.0
    for row in range(1, count):
        new, old = values[min(row + 1, count - 1)], values[max(row - 2, 0)]
        for column in range(values.shape[1]):
            sums[column] += np.float64(new[column]) - np.float64(old[column])
            out[row, column] = sums[column] / 3.0


@kernel("const i4[:,:,:], i8, i8, i4[:,:,:,:], f4[:,:,:,:]")
def copies_around(field, reach, cell, counts, copies):
    """How often each cell of the exemplar is shown around each tile of the output, averaged over 3 x 3 cells.

    ``field`` (rows, columns, 2) are sources, a cell has ``cell`` x ``cell`` of them. Written: ``counts`` (a, b, i, j),
    how often windows in each of a x b tiles show each of i x j cells, and ``copies`` (a, b, i, j), how often those at
    most ``reach`` tiles away do, but for the tile itself and the eight around it.
    """
    rows, columns = field.shape[0], field.shape[1]
    down_tiles, right_tiles, down_cells, right_cells = counts.shape
    counts[:] = 0
    for row in range(rows):
        for column in range(columns):
            y, x = field[row, column, 0] // cell, field[row, column, 1] // cell
            counts[row * down_tiles // rows, column * right_tiles // columns, y, x] += 1
    lines = np.empty((right_tiles, down_cells, right_cells), np.int32)  # copies in tiles above and below, not beside
    wide = np.empty((down_cells, right_cells), np.int32)
    smooth = np.empty((down_cells, right_cells), np.float32)
    turned, both = np.empty((right_cells, down_cells), np.float32), np.empty((right_cells, down_cells), np.float32)
    sums = np.empty(max(down_cells, right_cells))
    for down in range(down_tiles):
        lines[:] = 0
        for other in range(max(0, down - reach), min(down_tiles, down + reach + 1)):
            lines += counts[other]
        wide[:] = 0
        for right in range(min(reach, right_tiles)):
            wide += lines[right]
        for right in range(right_tiles):
            if right + reach < right_tiles:
                wide += lines[right + reach]
            if right - reach - 1 >= 0:
                wide -= lines[right - reach - 1]
            result = copies[down, right]
            result[:] = wide
            for other in range(max(0, down - 1), min(down_tiles, down + 2)):
                for beside in range(max(0, right - 1), min(right_tiles, right + 2)):
                    result -= counts[other, beside]
            result[:] = np.maximum(result, np.float32(0))
            mean_of_three(result, sums, smooth)
            turned[:] = smooth.T
            mean_of_three(turned, sums, both)
            result[:] = both.T
