"""Kernels that tell pieces apart: parts of a map of shifts that hang together and have one shift."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.jit import kernel

FIRST, AREA, TOP, BOTTOM, LEFT, RIGHT = range(6)
"""Columns of what is known of a piece: its first place (flat index), area, and the box around it (ends behind it)."""


@njit
def root(parents, place):
    """The first place of the part that a place belongs to, as far as it is known; shortens the way to it."""
    while parents[place] != place:
        parents[place] = parents[parents[place]]
        place = parents[place]
    return place


@kernel("const i4[:,:,:], i4[:,:], i8[:,:], i8[:]")
def label_pieces(pieces, labels, found, count):
    """Number the pieces of a map of shifts (rows, columns, 2) in the order of their first places, row by row.

    Written: ``labels`` (rows, columns), the first ``count[0]`` rows of ``found`` (n, 6), see :data:`FIRST`, and
    ``count`` (1,).
    """
    rows, columns = labels.shape
    numbers, parents = labels.reshape(-1), np.empty(rows * columns, np.int64)
    for row in range(rows):
        for column in range(columns):
            here = row * columns + column
            parents[here] = here
            y, x = pieces[row, column, 0], pieces[row, column, 1]
            if column > 0 and pieces[row, column - 1, 0] == y and pieces[row, column - 1, 1] == x:
                parents[here] = parents[here - 1]
            if row > 0 and pieces[row - 1, column, 0] == y and pieces[row - 1, column, 1] == x:
                one, other = root(parents, here), root(parents, here - columns)
                parents[max(one, other)] = parents[here] = min(one, other)
    number = 0
    for row in range(rows):
        for column in range(columns):
            here = row * columns + column
            first = parents[here] = parents[parents[here]]  # the way of all before it has been shortened to one step
            if first == here:
                numbers[here] = number
                found[number, FIRST], found[number, AREA] = here, 0
                found[number, TOP], found[number, BOTTOM] = row, row
                found[number, LEFT], found[number, RIGHT] = column, column
                number += 1
            numbers[here] = numbers[first]
            piece = found[numbers[first]]
            piece[AREA] += 1
            piece[BOTTOM] = row + 1
            piece[LEFT] = min(piece[LEFT], column)
            piece[RIGHT] = max(piece[RIGHT], column + 1)
    count[0] = number


@kernel("const i4[:,:,:], const u1[:,:], i8, const u1[:,:], i4[:,:,:], i8, i8")
def settle(pieces, settled, side, usable, source, first, stop):
    """Let the pixels of settled blocks show what their block's piece shows, for rows ``first <= y < stop``.

    ``pieces`` (rows, columns, 2) are the shifts of blocks of ``side`` x ``side`` pixels. Pixels of ``source`` (h, w, 2)
    stay where they are known (negative), the block is not ``settled`` (rows, columns), or what its piece would show is
    outside the exemplar or not ``usable`` (eh, ew).
    """
    for y in range(first, stop):
        down = y // side
        for right in range(settled.shape[1]):
            row = y + pieces[down, right, 0]
            if not settled[down, right] or row < 0 or row >= usable.shape[0]:
                continue
            for x in range(right * side, min((right + 1) * side, source.shape[1])):
                column = x + pieces[down, right, 1]
                if source[y, x, 0] >= 0 and 0 <= column < usable.shape[1] and usable[row, column]:
                    source[y, x, 0] = row
                    source[y, x, 1] = column
