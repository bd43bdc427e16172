"""Kernels on windows of an image: covariance and projection."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel


@kernel("const f4[:,:], f8[:,:], i8, i8", fastmath={"contract"})
def add_products(samples, total, first, stop):
    """total += samples^T samples for the rows ``first <= row < stop`` of total (lower triangle)."""
    for row in range(first, stop):
        for index in range(samples.shape[0]):
            value = float(samples[index, row])
            for column in range(row + 1):
                total[row, column] += value * samples[index, column]


@kernel(
    "const f4[:,:], i8, i8, i8, const f4[:,:], const f4[:], const u1[:,:], f4[:,:,:], i8, i8",
    fastmath={"contract", "reassoc", "nsz"},
)
def project(image, channels, window, step, basis, offset, wanted, out, first, stop):
    """Coordinates of windows in a basis.

    ``image`` is (h, w * channels), ``basis`` (k, window * window * channels), ``offset`` (k): what to subtract, the
    coordinates of the mean. ``out`` (rows, columns, k): the window whose corner is at (step * row, step * column).
    Four windows and two directions at a time share each load, so k must be even. Fours of windows of which none is
    ``wanted`` (rows, columns) are left out.
    """
    span = window * channels
    size = window * span
    windows = np.zeros((4, size), np.float32)
    one, two, three, four = windows[0], windows[1], windows[2], windows[3]
    for row in range(first, stop):
        for column in range(0, out.shape[1], 4):
            count = min(4, out.shape[1] - column)
            if not np.any(wanted[row, column : column + count]):
                continue
            for number in range(count):
                start = (column + number) * step * channels
                for y in range(window):
                    for t in range(span):
                        windows[number, y * span + t] = image[row * step + y, start + t]
            for k in range(0, basis.shape[0], 2):
                left = basis[k]
                right = basis[k + 1]
                zero = np.float32(0)
                sums = (zero, zero, zero, zero, zero, zero, zero, zero)
                for t in range(size):
                    a = left[t]
                    b = right[t]
                    sums = (
                        sums[0] + one[t] * a,
                        sums[1] + two[t] * a,
                        sums[2] + three[t] * a,
                        sums[3] + four[t] * a,
                        sums[4] + one[t] * b,
                        sums[5] + two[t] * b,
                        sums[6] + three[t] * b,
                        sums[7] + four[t] * b,
                    )
                for number in range(count):
                    out[row, column + number, k] = sums[number] - offset[k]
                    out[row, column + number, k + 1] = sums[number + 4] - offset[k + 1]
