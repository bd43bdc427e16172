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


@njit
def sum_lines(shown, down, reach, lines):
    """Write sums (b, n) of what is shown (a, b, n) at most ``reach`` tiles above or below row ``down`` of tiles."""
    for right in range(lines.shape[0]):
        for k in range(lines.shape[1]):
            lines[right, k] = 0
        for other in range(max(0, down - reach), min(shown.shape[0], down + reach + 1)):
            for k in range(lines.shape[1]):
                lines[right, k] += shown[other, right, k]


@kernel("const i4[:,:,:], i8, i4[:,:,:,:]")
def count_shown(field, cell, counts):
    """Add to ``counts`` (a, b, i, j) how often windows in each of a x b tiles show each of i x j cells.

    ``field`` (rows, columns, 2) are sources, a cell has ``cell`` x ``cell`` of them.
    """
    rows, columns = field.shape[0], field.shape[1]
    for row in range(rows):
        shown = counts[row * counts.shape[0] // rows]
        for column in range(columns):
            down, right = field[row, column, 0] // cell, field[row, column, 1] // cell
            shown[column * counts.shape[1] // columns, down, right] += 1


@kernel("const i4[:,:,:,:], i8, f4[:,:,:,:]")
def copies_around(counts, reach, copies):
    """How often each cell of the exemplar is shown around each tile of the output, averaged over 3 x 3 cells.

    ``counts`` (a, b, i, j) are those of :func:`count_shown`. Written: ``copies`` (a, b, i, j), how often tiles at most
    ``reach`` tiles away show each cell, but for the tile itself and the eight around it.
    """
    down_tiles, right_tiles, down_cells, right_cells = counts.shape
    cells = down_cells * right_cells
    shown, found = counts.reshape(down_tiles, right_tiles, cells), copies.reshape(down_tiles, right_tiles, cells)
    lines = np.zeros((right_tiles, cells), np.int32)  # copies in the tiles above and below one, itself among them
    near = np.zeros((right_tiles, cells), np.int32)
    total = np.zeros(cells, np.int32)
    smooth = np.empty((down_cells, right_cells), np.float32)
    turned, both = np.empty((right_cells, down_cells), np.float32), np.empty((right_cells, down_cells), np.float32)
    sums = np.empty(max(down_cells, right_cells))
    for down in range(down_tiles):
        sum_lines(shown, down, reach, lines)
        sum_lines(shown, down, 1, near)
        for right in range(right_tiles):
            for k in range(cells):
                total[k] = 0
            for other in range(max(0, right - reach), min(right_tiles, right + reach + 1)):
                for k in range(cells):
                    total[k] += lines[other, k]
            for other in range(max(0, right - 1), min(right_tiles, right + 2)):
                for k in range(cells):
                    total[k] -= near[other, k]
            for k in range(cells):
                found[down, right, k] = max(0, total[k])
            result = copies[down, right]
            mean_of_three(result, sums, smooth)
            for row in range(down_cells):
                for column in range(right_cells):
                    turned[column, row] = smooth[row, column]
            mean_of_three(turned, sums, both)
            for row in range(down_cells):
                for column in range(right_cells):
                    result[row, column] = both[column, row]
