"""Kernel of the refinement: k-coherent correction of source coordinates (Lefebvre & Hoppe 2005, 2006)."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel


@kernel(
    "i4[:,:,:], const u1[:,:], const f4[:,:,:], const i4[:,:], const f4[:,:], f4, i8, i8, i8, i8, i8",
    fastmath={"contract", "reassoc", "nsz"},
)
def correct(source, fixed, appearance, candidates, charge, stray, spacing, odd_row, odd_column, first, stop):
    """Give each pixel of a parity class the candidate that fits its neighbours best.

    ``source`` (rows, columns, 2), row and column in the exemplar, is changed where not ``fixed``, in the rows
    ``first <= row < stop`` of the class. Neighbours in the output are ``spacing`` pixels apart in the exemplar, whose
    ``appearance`` is (h, w, c); ``candidates`` (h * w, k) are flat indices of similar exemplar pixels, the first is the
    pixel itself. A candidate's cost is multiplied by ``charge`` (h, w), and by ``stray`` if it is no continuation.
    """
    rows, columns = fixed.shape
    height, width, channels = appearance.shape
    expected = np.zeros((4, channels), np.float32)
    counts = np.zeros(4, np.float32)
    for row in range(first, stop):
        if (row & 1) != odd_row:
            continue
        for column in range(odd_column, columns, 2):
            if fixed[row, column]:
                continue
            # what the neighbours expect at the four diagonals: the mean of the diagonal and the two beside it
            for corner in range(4):
                down, right = (corner >> 1) * 2 - 1, (corner & 1) * 2 - 1
                counts[corner] = 0
                expected[corner, :] = 0
                for part in range(3):
                    y, x = row + (down if part != 1 else 0), column + (right if part != 2 else 0)
                    if y < 0 or x < 0 or y >= rows or x >= columns:
                        continue
                    sy = source[y, x, 0] + (down * spacing if part == 1 else 0)
                    sx = source[y, x, 1] + (right * spacing if part == 2 else 0)
                    sy, sx = min(max(sy, 0), height - 1), min(max(sx, 0), width - 1)
                    counts[corner] += 1
                    for k in range(channels):
                        expected[corner, k] += appearance[sy, sx, k]
                if counts[corner] > 0:
                    for k in range(channels):
                        expected[corner, k] /= counts[corner]
            best = np.float32(np.inf)
            best_y, best_x = source[row, column, 0], source[row, column, 1]
            for down in range(-1, 2):
                for right in range(-1, 2):
                    y, x = row + down, column + right
                    if y < 0 or x < 0 or y >= rows or x >= columns:
                        continue
                    sy, sx = source[y, x, 0], source[y, x, 1]
                    for k in range(candidates.shape[1]):
                        place = candidates[sy * width + sx, k]
                        cy = place // width - down * spacing
                        cx = place % width - right * spacing
                        if cy < 0 or cx < 0 or cy >= height or cx >= width:
                            continue
                        factor = charge[cy, cx] * (stray if k > 0 else np.float32(1))
                        limit = best / factor
                        cost = np.float32(0)
                        for corner in range(4):
                            if counts[corner] == 0:
                                continue
                            ey = min(max(cy + ((corner >> 1) * 2 - 1) * spacing, 0), height - 1)
                            ex = min(max(cx + ((corner & 1) * 2 - 1) * spacing, 0), width - 1)
                            for c in range(channels):
                                difference = expected[corner, c] - appearance[ey, ex, c]
                                cost += difference * difference
                            if cost >= limit:
                                break
                        if cost < limit:
                            best = cost * factor
                            best_y, best_x = cy, cx
            source[row, column, 0] = best_y
            source[row, column, 1] = best_x
