"""Kernels that move seams between copied pieces to where they show least, and soften what is left of them."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.cut_kernels import copied, seam, unlike
from graphtex_nodes.numerics.jit import kernel


@kernel("const i4[:,:,:], u1[:,:], i8, i8")
def mark_seams(source, flags, first, stop):
    """Flag (h, w) the pixels of which one of the four neighbours belongs to another piece."""
    height, width = source.shape[0], source.shape[1]
    for y in range(first, stop):
        here = source[y]
        above = source[max(0, y - 1)]
        below = source[min(height - 1, y + 1)]
        up, down = int(y > 0), int(y < height - 1)
        line = flags[y]
        for x in range(width):
            line[x] = (
                (above[x, 0] ^ (here[x, 0] - up))
                | (above[x, 1] ^ here[x, 1])
                | (below[x, 0] ^ (here[x, 0] + down))
                | (below[x, 1] ^ here[x, 1])
            ) != 0
        for x in range(width - 1):
            apart = ((here[x + 1, 0] ^ here[x, 0]) | (here[x + 1, 1] ^ (here[x, 1] + 1))) != 0
            line[x] |= apart
            line[x + 1] |= apart


@kernel(
    "const f4[:,:,:], const u1[:,:], const f4[:,:,:], i4[:,:,:], u1[:,:], const f4[:], f4, f4, i8, i8, i8",
    fastmath={"contract"},
)
def move_seams(exemplar, usable, image, source, changed, pull, join, busy, parity, first, stop):
    """Let each pixel of one chequerboard colour take over the piece of one of its four neighbours if that costs less.

    The cost of a source is its squared difference from ``image``, with weights ``pull`` (c,), plus that of a seam to
    each neighbour of another piece.
    Neighbours have the other colour of the chequerboard: nothing that is read is written in the same pass.
    A negative source marks a known pixel, which stays as ``image`` has it: beside it a piece pays for how its own
    continuation differs there. Only pixels are looked at that ``changed`` (h, w) marks: those with a neighbour that
    moved since they were looked at last.
    """
    even = np.ones(exemplar.shape[2], np.float32)
    height, width = source.shape[0], source.shape[1]
    for y in range(first, stop):
        for x in range((y + parity) % 2, width, 2):
            if not changed[y, x]:
                continue
            changed[y, x] = 0
            here_y = source[y, x, 0]
            here_x = source[y, x, 1]
            if here_y < 0:
                continue
            best = np.float32(-1)
            best_y = here_y
            best_x = here_x
            for choice in range(5):
                cy = here_y
                cx = here_x
                if choice > 0:
                    down = (choice == 1) - (choice == 2)
                    right = (choice == 3) - (choice == 4)
                    if y + down < 0 or y + down >= height or x + right < 0 or x + right >= width:
                        continue
                    if source[y + down, x + right, 0] < 0:
                        continue
                    cy = source[y + down, x + right, 0] - down
                    cx = source[y + down, x + right, 1] - right
                    if cy == here_y and cx == here_x:
                        continue
                    if not copied(usable, cy, cx):
                        continue
                cost = unlike(exemplar, usable, image, y, x, cy, cx, pull)
                for side in range(4):
                    down = (side == 0) - (side == 1)
                    right = (side == 2) - (side == 3)
                    if y + down < 0 or y + down >= height or x + right < 0 or x + right >= width:
                        continue
                    ny = source[y + down, x + right, 0]
                    nx = source[y + down, x + right, 1]
                    if ny < 0:
                        ey, ex = cy + down, cx + right
                        cost += join + 2 * unlike(exemplar, usable, image, y + down, x + right, ey, ex, even)
                    elif ny != cy + down or nx != cx + right:
                        ny, nx = ny - down - y, nx - right - x
                        cost += seam(exemplar, usable, y, x, down, right, cy - y, cx - x, ny, nx, join, busy)
                if choice == 0 or cost < best:
                    best = cost
                    best_y = cy
                    best_x = cx
            if best_y == here_y and best_x == here_x:
                continue
            source[y, x, 0] = best_y
            source[y, x, 1] = best_x
            for side in range(4):
                down = (side == 0) - (side == 1)
                right = (side == 2) - (side == 3)
                if 0 <= y + down < height and 0 <= x + right < width:
                    changed[y + down, x + right] = 1


RADIUS = 2
"""Pixels over which pieces fade into each other: ``seam_neighbours.RADIUS``, here for loops of known length."""
NOTHING = np.int64(-(2**63))
"""Number of no piece: outside, and where pixels are known."""


@njit
def number_pieces(source, y, line):
    """Write a number for the piece that each pixel of row y shows: its shifts down and right to the exemplar.

    ``line`` is longer than the row, on both sides as much.
    """
    line[:] = NOTHING
    if 0 <= y < source.shape[0]:
        margin = (line.shape[0] - source.shape[1]) // 2
        for x in range(source.shape[1]):
            if source[y, x, 0] >= 0:
                line[margin + x] = (np.int64(source[y, x, 0] - y) << 32) | (np.int64(source[y, x, 1] - x) & 0xFFFFFFFF)


@njit
def add_flags(flags, line):
    """Set in a line the flags that are set in another."""
    for x in range(flags.shape[0]):
        line[x] |= flags[x]


@kernel(
    "const f4[:,:], const u1[:,:], const i4[:,:,:], const u1[:,:], const f4[:,:], f4, f4[:,:], f4[:,:,:], i8, i8",
    fastmath={"contract"},
)
def fade_seams(exemplar, usable, source, seams, falloff, sharpness, image, steps, first, stop):
    """Mix the pieces that meet near a pixel, each continued up to it; inside a piece the exemplar's pixels are copied.

    ``exemplar`` and ``image`` have the channels of each pixel side by side in their rows, ``falloff`` are
    the weights of the pixels around, up to :data:`RADIUS` away, ``seams`` (h, w) the pixels beside a seam.
    Unlike a blur, this keeps the detail of each piece. Pieces that cannot be continued up to the pixel are left out,
    and weights of what differs from its own piece are multiplied by (1 - ``sharpness`` * squared difference)^2, down to
    nothing.
    Known pixels, whose source is negative, become 0.
    ``steps`` (2, h, w * channels) become the same means of the pieces' own differences to the pixel below and to the
    right, 0 where no piece goes on; (0, h, w * channels) if they are not wanted.
    """
    height, width = source.shape[0], source.shape[1]
    channels = image.shape[1] // width
    axes = steps.shape[0]
    radius = RADIUS
    side = 2 * radius + 1
    near = np.zeros(width + 2 * radius, np.uint8)
    close = np.zeros(width, np.uint8)
    lines = np.empty((side, width + 2 * radius), np.int64)  # of rows y - radius to y + radius, in the order of ``rows``
    rows = np.empty(side, np.int64)
    pieces = np.empty(falloff.size, np.int64)
    support = np.empty(falloff.size, np.float32)
    totals = np.empty(3, np.float32)  # support of the steps down and right, and of the pixel
    for y in range(first - radius, first + radius):
        number_pieces(source, y, lines[y % side])
    for y in range(first, stop):
        number_pieces(source, y + radius, lines[(y + radius) % side])
        for down in range(side):
            rows[down] = (y + down - radius) % side
        # another piece in the square around a pixel has a seam one pixel nearer, unless it holds but a corner
        near[:] = 0
        for line in range(max(0, y - radius + 1), min(height, y + radius)):
            add_flags(seams[line], near[radius:])
        close[:] = 0
        for shift in range(1, 2 * radius):
            add_flags(near[shift : shift + width], close)
        near[:] = 0
        for line in (y - radius, y + radius):
            if 0 <= line < height:
                add_flags(seams[line], near[radius:])
        for shift in (0, 2 * radius):
            add_flags(near[shift : shift + width], close)
        x = 0
        while x < width:
            start = x * channels
            row, column = source[y, x, 0], source[y, x, 1]
            if row < 0:
                image[y, start : start + channels] = 0
                steps[:, y, start : start + channels] = 0
                x += 1
                continue
            if not close[x]:
                while x < width and not close[x]:
                    x += 1
                for index in range(x * channels - start):
                    image[y, start + index] = exemplar[row, column * channels + index]
                if axes == 0:
                    continue
                below = min(row + 1, exemplar.shape[0] - 1)
                inner = (x - (x == width)) * channels  # behind the last column a piece need not go on
                for index in range(x * channels - start):
                    steps[0, y, start + index] = (
                        exemplar[below, column * channels + index] - exemplar[row, column * channels + index]
                    )
                for index in range(inner - start):
                    steps[1, y, start + index] = (
                        exemplar[row, (column + 1) * channels + index] - exemplar[row, column * channels + index]
                    )
                for index in range(inner, x * channels):
                    steps[1, y, index] = 0
                continue
            count = 1
            index = 0
            last = pieces[0] = lines[rows[radius], x + radius]
            weight = np.float32(0)
            for down in range(side):
                line = rows[down]
                for right in range(side):
                    piece = lines[line, x + right]
                    if piece != last:
                        if piece == NOTHING:
                            continue
                        support[index] = weight
                        index = 0
                        while index < count and pieces[index] != piece:
                            index += 1
                        if index == count:
                            pieces[count] = piece
                            support[count] = 0
                            count += 1
                        last = piece
                        weight = support[index]
                    weight += falloff[down, right]
            support[index] = weight
            used = 0
            totals[:] = 0
            image[y, start : start + channels] = 0
            steps[:, y, start : start + channels] = 0
            for index in range(count):
                ey = y + (pieces[index] >> 32)
                ex = x + np.int64(np.int32(pieces[index] & 0xFFFFFFFF))
                if not copied(usable, ey, ex):
                    continue
                if index > 0 and sharpness > 0:
                    apart = np.float32(0)
                    for c in range(channels):
                        difference = exemplar[ey, ex * channels + c] - exemplar[row, column * channels + c]
                        apart += difference * difference
                    share = np.float32(1) - sharpness * apart
                    if share <= 0:
                        continue
                    support[index] *= share * share
                used += 1
                totals[2] += support[index]
                for c in range(channels):
                    image[y, start + c] += support[index] * exemplar[ey, ex * channels + c]
                for axis in range(axes):
                    ny, nx = ey + 1 - axis, ex + axis
                    if copied(usable, ny, nx):
                        totals[axis] += support[index]
                        for c in range(channels):
                            step = exemplar[ny, nx * channels + c] - exemplar[ey, ex * channels + c]
                            steps[axis, y, start + c] += support[index] * step
            for c in range(channels):
                if used == 1:  # its own piece alone: a copy, without rounding
                    image[y, start + c] = exemplar[row, column * channels + c]
                else:
                    image[y, start + c] /= totals[2]
            for axis in range(axes):
                if totals[axis] > 0:
                    for c in range(channels):
                        steps[axis, y, start + c] /= totals[axis]
            x += 1
