"""Kernels that make pixels of the windows that cover them."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel


@kernel(
    "const i4[:,:,:], const f4[:,:], const f4[:,:,:], const f4[:,:], i8, const u1[:,:], f4[:,:,:], i8, i8",
    fastmath={"contract"},
)
def vote_mean(field, weights, weighted, falloff, step, known, image, first, stop):
    """Weighted mean of the exemplar pixels that the covering windows propose, for rows ``first <= y < stop``.

    ``weighted`` (h, w, channels + 1) are the exemplar's pixels times their weights, and in the last channel the weights
    themselves: windows then add whole rows of memory to sums of a line of the image. Further factors are the weight of
    the window (``weights``, as the field) and that of the place in the window (``falloff``). The first ``channels``
    channels of ``image`` are written where it is not ``known``.
    """
    window = falloff.shape[0]
    rows, columns = field.shape[0], field.shape[1]
    width, depth = image.shape[1], weighted.shape[2]
    span = window * depth
    sums = np.empty(width * depth, np.float32)
    flat = weighted.reshape(weighted.shape[0], weighted.shape[1] * depth)
    line = np.empty(span, np.float32)
    unknown = np.zeros(width + 1, np.int64)
    for y in range(first, stop):
        for x in range(width):
            unknown[x + 1] = unknown[x] + (known[y, x] == 0)
        if unknown[width] == 0:
            continue
        sums[:] = 0
        for row in range(max(0, (y - window + step) // step), min(rows - 1, y // step) + 1):
            dy = y - row * step
            for t in range(span):
                line[t] = falloff[dy, t // depth]
            for column in range(columns):
                if unknown[column * step + window] == unknown[column * step]:
                    continue
                weight = weights[row, column]
                proposal = flat[field[row, column, 0] + dy, field[row, column, 1] * depth :]
                total = sums[column * step * depth :]
                for t in range(span):
                    total[t] += weight * line[t] * proposal[t]
        for x in range(width):
            if not known[y, x]:
                for c in range(depth - 1):
                    image[y, x, c] = sums[x * depth + c] / sums[x * depth + depth - 1]


@kernel(
    "const i4[:,:,:], const f4[:,:], const f4[:,:,:], const f4[:,:], const f4[:,:,:], i8, i8, const u1[:,:], "
    "i4[:,:,:], i8, i8",
    fastmath={"contract"},
)
def vote_source(field, weights, exemplar, falloff, image, step, rim, known, source, first, stop):
    """For each pixel the proposed source that most windows agree on, among equals the one nearest to ``image``.

    Votes are the product of ``weights`` and ``falloff``. Of the exemplar (h, w, c) the outer ``rim`` pixels are not
    copied; if nothing else is proposed, the pixel nearest to the last proposal is. Written: ``source`` (h, w, 2), rows
    and columns without the rim, for pixels that are not ``known``.
    """
    window = falloff.shape[0]
    rows, columns = field.shape[0], field.shape[1]
    last_y, last_x = exemplar.shape[0] - rim - 1, exemplar.shape[1] - rim - 1
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
                    if ey < rim or ex < rim or ey > last_y or ex > last_x:
                        if count > 0 or row < row_high or column < column_high:
                            continue
                        ey, ex = min(max(ey, rim), last_y), min(max(ex, rim), last_x)
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
                    source[y, x, 0] = proposal_y[index] - rim
                    source[y, x, 1] = proposal_x[index] - rim
