"""Kernels that make pixels of the windows that cover them."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel


@kernel(
    "const i4[:,:,:], const f4[:,:], const f4[:,:,:], const f4[:,:], const f4[:,:], i8, const u1[:,:], f4[:,:,:], "
    "i8, i8, i8",
    fastmath={"contract"},
)
def vote_mean(field, weights, exemplar, pixel_weights, falloff, step, known, image, channels, first, stop):
    """Weighted mean of the exemplar pixels that the covering windows propose, for rows ``first <= y < stop``.

    The weight is that of the window (``weights``, as the field), times that of the exemplar's pixel
    (``pixel_weights``, as the exemplar), times that of the place in the window (``falloff``). Only the first
    ``channels`` channels of ``image`` are written, and of its pixels those that are not ``known``.
    """
    window = falloff.shape[0]
    rows, columns = field.shape[0], field.shape[1]
    for y in range(first, stop):
        row_low = max(0, (y - window + step) // step)
        row_high = min(rows - 1, y // step)
        for x in range(image.shape[1]):
            column_low = max(0, (x - window + step) // step)
            column_high = min(columns - 1, x // step)
            if known[y, x]:
                continue
            total = np.float32(0)
            for c in range(channels):
                image[y, x, c] = 0
            for row in range(row_low, row_high + 1):
                dy = y - row * step
                for column in range(column_low, column_high + 1):
                    dx = x - column * step
                    ey = field[row, column, 0] + dy
                    ex = field[row, column, 1] + dx
                    weight = weights[row, column] * pixel_weights[ey, ex] * falloff[dy, dx]
                    total += weight
                    for c in range(channels):
                        image[y, x, c] += weight * exemplar[ey, ex, c]
            for c in range(channels):
                image[y, x, c] /= total


@kernel(
    "const i4[:,:,:], const f4[:,:], const f4[:,:,:], const f4[:,:], const f4[:,:,:], i8, const u1[:,:], i4[:,:,:], "
    "i8, i8",
    fastmath={"contract"},
)
def vote_source(field, weights, exemplar, falloff, image, step, known, source, first, stop):
    """For each pixel the proposed source that most windows agree on, among equals the one nearest to ``image``.

    Votes are the product of ``weights`` and ``falloff``. Written: ``source`` (h, w, 2), rows and columns,
    for pixels that are not ``known``.
    """
    window = falloff.shape[0]
    rows, columns = field.shape[0], field.shape[1]
    span = (window + step - 1) // step
    proposal_y = np.empty(span * span, np.int64)
    proposal_x = np.empty(span * span, np.int64)
    support = np.empty(span * span, np.float32)
    for y in range(first, stop):
        row_low = max(0, (y - window + step) // step)
        row_high = min(rows - 1, y // step)
        for x in range(source.shape[1]):
            column_low = max(0, (x - window + step) // step)
            column_high = min(columns - 1, x // step)
            if known[y, x]:
                continue
            count = 0
            for row in range(row_low, row_high + 1):
                dy = y - row * step
                for column in range(column_low, column_high + 1):
                    dx = x - column * step
                    ey = field[row, column, 0] + dy
                    ex = field[row, column, 1] + dx
                    weight = weights[row, column] * falloff[dy, dx]
                    index = 0
                    while index < count and (proposal_y[index] != ey or proposal_x[index] != ex):
                        index += 1
                    if index == count:
                        proposal_y[count] = ey
                        proposal_x[count] = ex
                        support[count] = 0
                        count += 1
                    support[index] += weight
            best = np.float32(np.inf)
            for index in range(count):
                error = np.float32(0)
                for c in range(image.shape[2]):
                    difference = image[y, x, c] - exemplar[proposal_y[index], proposal_x[index], c]
                    error += difference * difference
                cost = error / support[index]
                if cost < best:
                    best = cost
                    source[y, x, 0] = proposal_y[index]
                    source[y, x, 1] = proposal_x[index]
