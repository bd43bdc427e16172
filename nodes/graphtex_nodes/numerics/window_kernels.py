"""Kernels on windows of an image: covariance and projection."""

# mypy: allow-untyped-defs

from graphtex_nodes.numerics.jit import kernel


@kernel("const f4[:,:], f8[:,:], i8, i8", fastmath={"contract"})
def add_products(samples, total, first, stop):
    """total += samples^T samples for the rows ``first <= row < stop`` of total (lower triangle)."""
    for row in range(first, stop):
        for index in range(samples.shape[0]):
            value = float(samples[index, row])
            for column in range(row + 1):
                total[row, column] += value * samples[index, column]


@kernel("const f4[:,:], i8, i8, i8, const f4[:,:], const f4[:], f4[:,:,:], i8, i8", fastmath={"contract"})
def project(image, channels, window, step, basis, offset, out, first, stop):
    """Coordinates of windows in a basis.

    ``image`` is (h, w * channels), ``basis`` (window * window * channels, k), ``offset`` (k): what to subtract, the
    coordinates of the mean. ``out`` (rows, columns, k): the window whose corner is at (step * row, step * column).
    """
    count = basis.shape[1]
    span = window * channels
    for row in range(first, stop):
        for column in range(out.shape[1]):
            place = out[row, column]
            for k in range(count):
                place[k] = -offset[k]
            start = column * step * channels
            for y in range(window):
                line = image[row * step + y]
                for t in range(span):
                    value = line[start + t]
                    direction = basis[y * span + t]
                    for k in range(count):
                        place[k] += value * direction[k]
