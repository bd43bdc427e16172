"""Kernels that fill a hole patch by patch."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel

BLOCK = 128
"""Neighbouring patches that are compared at a time."""
ROUND = 8
"""Pixels of a patch between two looks at whether any of a block can still be the best."""


@kernel("const f4[:,:,:], const u1[:,:], const f4[:,:], i8, f4[:,:], i8, i8, i8, i8", fastmath={"contract"})
def prioritise(planes, filled, confidence, radius, priority, top, bottom, left, right):
    """Priority of the pixels of a box (Criminisi et al. 2004, eq. 1 to 3); -1 for those that are not on the front.

    ``planes`` (c, h, w) are colours, ``filled`` (h, w) tells where they hold. The front are pixels yet to fill beside
    filled ones. Written are the mean confidence of the patch of the given ``radius``, unfilled pixels counting 0, times
    the data term: the largest gradient of a filled pixel in the patch, turned by a right angle, along the front's
    normal, which is the gradient of ``filled`` by Sobel's operator.
    """
    channels, height, width = planes.shape
    for y in range(top, bottom):
        for x in range(left, right):
            priority[y, x] = -1
            if filled[y, x]:
                continue
            beside = (y > 0 and filled[y - 1, x]) or (y + 1 < height and filled[y + 1, x])
            beside = beside or (x > 0 and filled[y, x - 1]) or (x + 1 < width and filled[y, x + 1])
            if not beside:
                continue
            total = np.float32(0)
            strongest = np.float32(0)
            slope_y = np.float32(0)
            slope_x = np.float32(0)
            low_y, high_y = max(0, y - radius), min(height, y + radius + 1)
            low_x, high_x = max(0, x - radius), min(width, x + radius + 1)
            for py in range(low_y, high_y):
                for px in range(low_x, high_x):
                    if not filled[py, px]:
                        continue
                    total += confidence[py, px]
                    up = py - 1 if py > 0 and filled[py - 1, px] else py
                    down = py + 1 if py + 1 < height and filled[py + 1, px] else py
                    before = px - 1 if px > 0 and filled[py, px - 1] else px
                    after = px + 1 if px + 1 < width and filled[py, px + 1] else px
                    for c in range(channels):
                        dy = (planes[c, down, px] - planes[c, up, px]) / max(1, down - up)
                        dx = (planes[c, py, after] - planes[c, py, before]) / max(1, after - before)
                        if dy * dy + dx * dx > strongest:
                            strongest = dy * dy + dx * dx
                            slope_y = dy
                            slope_x = dx
            normal_y = np.float32(0)
            normal_x = np.float32(0)
            for down in range(-1, 2):
                for across in range(-1, 2):
                    # over the picture's border the region goes on as it is
                    if filled[min(max(y + down, 0), height - 1), min(max(x + across, 0), width - 1)]:
                        normal_y += down * (2 - abs(across))
                        normal_x += across * (2 - abs(down))
            length = np.sqrt(normal_y * normal_y + normal_x * normal_x)
            data = abs(slope_x * normal_y - slope_y * normal_x) / length if length > 0 else np.float32(0)
            mean = total / ((high_y - low_y) * (high_x - low_x))
            priority[y, x] = mean * (data + np.float32(1e-3))


@kernel(
    "const f4[:,:,:], const u1[:,:], const i4[:,:], const f4[:,:], i8, i8, i8, f4[:], i4[:], i8, i8",
    fastmath={"contract", "nnan"},
)
def search_patch(planes, allowed, offsets, wanted, radius, y, x, costs, columns, first, stop):
    """Best centre of a source patch in each row: least sum of squared differences, of equals the nearest to (y, x).

    ``planes`` (c, h, w) are colours, ``allowed`` (h, w) the centres, none nearer to the border than ``radius``.
    ``offsets`` (n, 2) are the patch's known pixels relative to its centre and ``wanted`` (n, c) their colours.
    Written are ``costs`` and ``columns`` of the rows; a row that cannot beat an earlier one of the same call keeps an
    infinite cost. Sums are added in one order, so costs do not depend on the call.
    """
    width = planes.shape[2]
    totals = np.empty(BLOCK, np.float32)
    best = np.float32(np.inf)
    best_apart = np.int64(0)
    for row in range(first, stop):
        costs[row] = np.inf
        for start in range(radius, width - radius, BLOCK):
            count = min(BLOCK, width - radius - start)
            useful = False
            for k in range(count):
                totals[k] = 0 if allowed[row, start + k] else np.inf
                useful = useful or allowed[row, start + k] != 0
            if not useful:
                continue
            for n in range(offsets.shape[0]):
                for c in range(planes.shape[0]):
                    shift = start + offsets[n, 1]
                    line = planes[c, row + offsets[n, 0], shift : shift + count]
                    value = wanted[n, c]
                    for k in range(count):
                        difference = line[k] - value
                        totals[k] += difference * difference
                if n % ROUND == ROUND - 1:
                    least = np.float32(np.inf)
                    for k in range(count):
                        least = min(least, totals[k])
                    if least > best:
                        useful = False
                        break
            if not useful:
                continue
            for k in range(count):
                if totals[k] > best or totals[k] == np.inf:
                    continue
                apart = (row - y) ** 2 + (start + k - x) ** 2
                if totals[k] < best or apart < best_apart:
                    best = totals[k]
                    best_apart = apart
                    costs[row] = best
                    columns[row] = start + k
