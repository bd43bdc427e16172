"""What seams between copied pieces cost, and kernels that state what it costs to let a piece grow."""

# mypy: allow-untyped-defs

from typing import Any

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

from graphtex_nodes.numerics.jit import kernel

OUTSIDE = np.float32(1e6)
"""Cost of a source that falls outside the exemplar: above any sum of squared colour differences in use."""


@njit(forceinline=True, fastmath={"contract"})
def copied(usable, y, x):
    """Whether an exemplar pixel is inside and may be copied."""
    return 0 <= y < usable.shape[0] and 0 <= x < usable.shape[1] and usable[y, x] != 0


@njit(forceinline=True, fastmath={"contract"})
def seam(exemplar, usable, y, x, down, right, one_y, one_x, other_y, other_x, join, busy):
    """Cost of a seam between pixel (y, x) of a piece and its neighbour, ``down`` and ``right``, of another piece.

    Pieces are shifts (rows, columns) from the output to the exemplar. The squared differences of both at both pixels
    count the less the more the colours change there anyway (Kwatra et al. 2003, section 3.1).
    """
    ay, ax, by, bx = y + one_y, x + one_x, y + other_y, x + other_x
    if not (copied(usable, ay, ax) and copied(usable, ay + down, ax + right)):
        return OUTSIDE
    if not (copied(usable, by, bx) and copied(usable, by + down, bx + right)):
        return OUTSIDE
    apart = np.float32(0)
    change = np.float32(0)
    for c in range(exemplar.shape[2]):
        a, b = exemplar[ay, ax, c], exemplar[by, bx, c]
        a_next, b_next = exemplar[ay + down, ax + right, c], exemplar[by + down, bx + right, c]
        apart += (a - b) * (a - b) + (a_next - b_next) * (a_next - b_next)
        change += (a - a_next) * (a - a_next) + (b - b_next) * (b - b_next)
    return join + apart * busy / (busy + change)


def _fused(typing_context, a, b, c):
    """``a * b + c``, rounded once."""

    def generate(context, builder, signature, arguments):
        return builder.fma(*arguments)

    return types.float32(types.float32, types.float32, types.float32), generate


fused: Any = intrinsic(_fused)


@njit(forceinline=True, fastmath={"contract"})
def both_seams(exemplar, usable, y, x, down, right, one_y, one_x, other_y, other_x, join, busy):
    """:func:`seam` of one piece and another, and of the other and the one: in the last bits these differ."""
    ay, ax, by, bx = y + one_y, x + one_x, y + other_y, x + other_x
    if not (copied(usable, ay, ax) and copied(usable, ay + down, ax + right)):
        return OUTSIDE, OUTSIDE
    if not (copied(usable, by, bx) and copied(usable, by + down, bx + right)):
        return OUTSIDE, OUTSIDE
    apart = np.float32(0)
    forth = np.float32(0)
    back = np.float32(0)
    for c in range(exemplar.shape[2]):
        a, b = exemplar[ay, ax, c], exemplar[by, bx, c]
        a_next, b_next = exemplar[ay + down, ax + right, c], exemplar[by + down, bx + right, c]
        first, then, one, other = a - b, a_next - b_next, a - a_next, b - b_next
        apart += fused(first, first, then * then)
        forth += fused(one, one, other * other)
        back += fused(other, other, one * one)
    return join + apart * busy / (busy + forth), join + apart * busy / (busy + back)


@njit(forceinline=True, fastmath={"contract"})
def unlike(exemplar, usable, image, y, x, ey, ex, weights):
    """Squared difference of an exemplar pixel from the image at (y, x), with ``weights`` (c,) of the channels."""
    if not copied(usable, ey, ex):
        return OUTSIDE
    total = np.float32(0)
    for c in range(exemplar.shape[2]):
        difference = image[y, x, c] - exemplar[ey, ex, c]
        total += weights[c] * difference * difference
    return total


@njit(fastmath={"contract"})
def inside_cost(exemplar, usable, image, known, side, step, row, column, shift_y, shift_x, pull, join, even):
    """Cost of a block that shows a piece: how unlike the image it is, and how it goes on in known pixels beside it."""
    height, width = known.shape
    total = np.float32(0)
    for y in range(row * side, min(height, (row + 1) * side), step):
        for x in range(column * side, min(width, (column + 1) * side), step):
            if known[y, x]:
                continue
            total += unlike(exemplar, usable, image, y, x, y + shift_y, x + shift_x, pull)
            for turn in range(4):
                ny, nx = y + (turn == 0) - (turn == 1), x + (turn == 2) - (turn == 3)
                if 0 <= ny < height and 0 <= nx < width and known[ny, nx]:
                    total += join + 2 * unlike(exemplar, usable, image, ny, nx, ny + shift_y, nx + shift_x, even)
    return total * step * step


@njit(fastmath={"contract"})
def border_cost(exemplar, usable, known, side, step, row, column, down, one_y, one_x, other_y, other_x, join, busy):
    """Cost of the seam between a block of one piece and the next one, below or on the right, of another."""
    total = np.float32(0)
    if one_y == other_y and one_x == other_x:
        return total
    right = 1 - down
    for k in range(0, side, step):
        y = (row + 1) * side - 1 if down else row * side + k
        x = column * side + k if down else (column + 1) * side - 1
        if y + down >= known.shape[0] or x + right >= known.shape[1] or known[y, x] or known[y + down, x + right]:
            continue
        total += seam(exemplar, usable, y, x, down, right, one_y, one_x, other_y, other_x, join, busy)
    return total * step


@njit(fastmath={"contract"})
def both_costs(exemplar, usable, known, side, step, row, column, down, one_y, one_x, other_y, other_x, join, busy):
    """:func:`border_cost` between one piece's block and the next of another, and between the other's and the one's."""
    forth = np.float32(0)
    back = np.float32(0)
    right = 1 - down
    for k in range(0, side, step):
        y = (row + 1) * side - 1 if down else row * side + k
        x = column * side + k if down else (column + 1) * side - 1
        if y + down >= known.shape[0] or x + right >= known.shape[1] or known[y, x] or known[y + down, x + right]:
            continue
        costs = both_seams(exemplar, usable, y, x, down, right, one_y, one_x, other_y, other_x, join, busy)
        forth += costs[0]
        back += costs[1]
    return forth * step, back * step


@njit(forceinline=True)
def open_block(pieces, free, box, row, column, piece_y, piece_x):
    """Whether a block is in the box (first and last row, first and last column) and the piece may take it over."""
    if row < box[0] or row >= box[1] or column < box[2] or column >= box[3] or not free[row, column]:
        return False
    return pieces[row, column, 0] != piece_y or pieces[row, column, 1] != piece_x


@kernel(
    "const f4[:,:,:], const u1[:,:], const f4[:,:,:], const u1[:,:], const i4[:,:,:], const u1[:,:], i8, i8, "
    "const i8[:], i8, i8, const f4[:], f4, f4, f4[:,:,:], f4[:,:,:], i8, i8",
    fastmath={"contract"},
)
def growth_costs(
    exemplar, usable, image, known, pieces, free, piece_y, piece_x, box, side, step, pull, join, busy,
    present, grown, first, stop,
):  # fmt: skip
    """What blocks of the rows ``first <= row < stop`` cost as they are, and if a piece grows over them.

    ``pieces`` (rows, columns, 2) are the shifts of blocks of ``side`` x ``side`` output pixels, of which each
    ``step``-th row and column is looked at, and ``pull`` (c,) weights of their differences from the image. Written for
    blocks of the box that are ``free`` (rows, columns), and for their neighbours as far as these concern them: in
    ``present`` (rows, columns, 3) costs of the block itself, of its border with the next one on its right and with the
    one below, as they are, where these were not known (negative) before; in ``grown`` (rows, columns, 5) the cost of
    the block if it shows the piece, then of both borders if only the other block does and if only this one does.
    """
    even = np.ones(exemplar.shape[2], np.float32)
    for row in range(first, stop):
        for column in range(max(0, box[2] - 1), box[3]):
            here_y, here_x = pieces[row, column, 0], pieces[row, column, 1]
            here = open_block(pieces, free, box, row, column, piece_y, piece_x)
            if here:
                for k in range(2):
                    if k == 0 and present[row, column, 0] >= 0:
                        continue
                    cost = inside_cost(
                        exemplar, usable, image, known, side, step, row, column,
                        piece_y if k else here_y, piece_x if k else here_x, pull, join, even,
                    )  # fmt: skip
                    if k == 0:
                        present[row, column, 0] = cost
                    else:
                        grown[row, column, 0] = cost
            for down in range(2):
                below, beside = row + down, column + 1 - down
                if below >= pieces.shape[0] or beside >= pieces.shape[1]:
                    continue
                there_y, there_x = pieces[below, beside, 0], pieces[below, beside, 1]
                there = open_block(pieces, free, box, below, beside, piece_y, piece_x)
                if not here and not there:
                    continue
                pair = here and there and here_y == there_y and here_x == there_x
                if pair:
                    grown[row, column, 1 + down], grown[row, column, 3 + down] = both_costs(
                        exemplar, usable, known, side, step, row, column, down,
                        here_y, here_x, piece_y, piece_x, join, busy,
                    )  # fmt: skip
                for k in range(1 if pair else 3):
                    if (
                        (k == 0 and present[row, column, 1 + down] >= 0)
                        or (k == 1 and not there)
                        or (k == 2 and not here)
                    ):
                        continue
                    cost = border_cost(
                        exemplar, usable, known, side, step, row, column, down,
                        piece_y if k == 2 else here_y, piece_x if k == 2 else here_x,
                        piece_y if k == 1 else there_y, piece_x if k == 1 else there_x, join, busy,
                    )  # fmt: skip
                    if k == 0:
                        present[row, column, 1 + down] = cost
                    else:
                        grown[row, column, 2 * k - 1 + down] = cost


@kernel(
    "const i4[:,:,:], const u1[:,:], i8, i8, const i8[:], const f4[:,:,:], const f4[:,:,:], i4[:,:], f8[:,:], "
    "i4[:,:], f8[:], i8[:]",
    fastmath={"contract"},
)
def growth_graph(pieces, free, piece_y, piece_x, box, present, grown, number, terms, ends, caps, counts):
    """State what :func:`growth_costs` found as a graph of the free blocks in the box.

    Written: ``number`` (rows, columns) of each block's node or -1, ``terms`` (n, 2) for being taken over and for
    staying, ``ends`` (m, 2) of the edges and their capacities ``caps`` from the first end to the second (Kolmogorov &
    Zabih 2004), and in ``counts`` (2,) how many nodes and edges there are.
    """
    nodes = edges = 0
    for row in range(box[0], box[1]):
        for column in range(box[2], box[3]):
            number[row, column] = -1
            if open_block(pieces, free, box, row, column, piece_y, piece_x):
                number[row, column] = nodes
                terms[nodes, 0] = grown[row, column, 0]
                terms[nodes, 1] = present[row, column, 0]
                nodes += 1
    for row in range(max(0, box[0] - 1), box[1]):
        for column in range(max(0, box[2] - 1), box[3]):
            for down in range(2):
                below, beside = row + down, column + 1 - down
                if below >= pieces.shape[0] or beside >= pieces.shape[1]:
                    continue
                here = number[row, column] if row >= box[0] and column >= box[2] else -1
                there = number[below, beside] if box[0] <= below < box[1] and box[2] <= beside < box[3] else -1
                if here < 0 and there < 0:
                    continue
                both = present[row, column, 1 + down]
                stays, grows = grown[row, column, 1 + down], grown[row, column, 3 + down]
                if there < 0:
                    terms[here, 0] += grows
                    terms[here, 1] += both
                elif here < 0:
                    terms[there, 0] += stays
                    terms[there, 1] += both
                else:
                    terms[here, 1] += both - grows
                    terms[there, 1] += grows
                    ends[edges, 0] = here
                    ends[edges, 1] = there
                    caps[edges] = max(np.float32(0), stays + grows - both)
                    edges += 1
    counts[0] = nodes
    counts[1] = edges
