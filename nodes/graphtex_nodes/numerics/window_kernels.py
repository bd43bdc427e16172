"""Kernels on windows of an image: covariance and projection."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.jit import kernel


@kernel("const f4[:,:], f8[:,:], i8, i8", fastmath={"contract"})
def add_products(samples, total, first, stop):
    """total += samples^T samples for the rows ``first <= row < stop`` of total (lower triangle).

    Four samples at a time share each load of total: their number must be a multiple of four.
    """
    for row in range(first, stop):
        sums = total[row]
        for index in range(0, samples.shape[0], 4):
            one, two, three, four = samples[index], samples[index + 1], samples[index + 2], samples[index + 3]
            a, b, c, d = float(one[row]), float(two[row]), float(three[row]), float(four[row])
            for column in range(row + 1):
                sums[column] += a * one[column] + b * two[column] + c * three[column] + d * four[column]


@njit(forceinline=True, fastmath={"contract", "reassoc", "nsz"})
def dot(first, second):
    """Scalar product of two vectors."""
    total = 0.0
    for j in range(first.shape[0]):
        total += first[j] * second[j]
    return total


@kernel("const f8[:,:], f8[:,:], f8[:], i8", fastmath={"contract", "reassoc", "nsz"})
def iterate(covariance, rows, variances, rounds):
    """Orthogonal iteration: multiply rows by the covariance and make them orthonormal, some rounds long.

    ``rows`` (k, n) become the leading directions; ``variances`` (k) are written, those along them. Rows that vanish
    (modified Gram-Schmidt leaves next to nothing of them) become 0 with the variance 0.
    """
    count, size = rows.shape
    products = np.empty((count, size))
    lengths = np.empty(count)
    for number in range(rounds + 1):
        if number > 0:
            for k in range(count):
                for j in range(size):
                    rows[k, j] = products[k, j]
        # the last time twice: rounding left rows of unlike size a little aslant
        for _ in range(1 + (number == rounds)):
            for k in range(count):
                lengths[k] = dot(rows[k], rows[k])
            for k in range(count):
                row = rows[k]
                length = dot(row, row)
                factor = 1 / np.sqrt(length) if length > 1e-20 * lengths[k] else 0.0
                for j in range(size):
                    row[j] *= factor
                for later in range(k + 1, count):
                    other = rows[later]
                    common = dot(other, row)
                    for j in range(size):
                        other[j] -= common * row[j]
        for i in range(size):
            line = covariance[i]
            for k in range(0, count - 3, 4):
                one, two, three, four = rows[k], rows[k + 1], rows[k + 2], rows[k + 3]
                a = b = c = d = 0.0
                for j in range(size):
                    value = line[j]
                    a += value * one[j]
                    b += value * two[j]
                    c += value * three[j]
                    d += value * four[j]
                products[k, i], products[k + 1, i], products[k + 2, i], products[k + 3, i] = a, b, c, d
            for k in range(count - count % 4, count):
                products[k, i] = dot(line, rows[k])
    for k in range(count):
        variances[k] = dot(rows[k], products[k])


@kernel(
    "const f4[:,:], i8, i8, i8, i8, const f4[:,:], const f4[:], const u1[:,:], f4[:,:,:], i8, i8",
    fastmath={"contract", "reassoc", "nsz"},
)
def project(image, channels, window, spacing, step, basis, offset, wanted, out, first, stop):
    """Coordinates of windows in a basis.

    ``image`` is (h, w * channels), ``basis`` (k, window * window * channels), ``offset`` (k): what to subtract, the
    coordinates of the mean. ``out`` (rows, columns, k): the window whose corner is at (step * row, step * column).
    A window takes each ``spacing``-th pixel of each ``spacing``-th row; each row of the image holds such pixels side by
    side, first those from pixel 0 on, then those from pixel 1 on, and so forth.
    Four windows and two directions at a time share each load, so k must be even. Fours of windows of which none is
    ``wanted`` (rows, columns) are left out.
    """
    span = window * channels
    size = window * span
    across = image.shape[1] // spacing
    windows = np.zeros((4, size), np.float32)
    one, two, three, four = windows[0], windows[1], windows[2], windows[3]
    for row in range(first, stop):
        for column in range(0, out.shape[1], 4):
            count = min(4, out.shape[1] - column)
            if not np.any(wanted[row, column : column + count]):
                continue
            for number in range(count):
                place = (column + number) * step
                start = place % spacing * across + place // spacing * channels
                for y in range(window):
                    for t in range(span):
                        windows[number, y * span + t] = image[row * step + y * spacing, start + t]
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
