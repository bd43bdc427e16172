"""Kernels of entropic optimal transport."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel


@kernel("const f4[:,:], const f4[:,:], const f4[:], f4, f4[:,:], i8, i8")
def exponents(windows, columns, lengths, steepest, out, first, stop):
    """How much more each place costs a window than its cheapest one (n, m), negative, at most ``steepest`` of it.

    ``windows`` (n, k) are twice the coordinates, ``columns`` (k, m) those of the places and ``lengths`` (m,) their
    squared lengths. Sums run over k in order, so they do not depend on how many places are added to at once. Four
    coordinates at a time share each load of a sum.
    """
    for row in range(first, stop):
        line = out[row]
        line[:] = 0
        count = columns.shape[0]
        for k in range(0, count - 3, 4):
            a, b, c, d = windows[row, k], windows[row, k + 1], windows[row, k + 2], windows[row, k + 3]
            one, two, three, four = columns[k], columns[k + 1], columns[k + 2], columns[k + 3]
            for place in range(line.shape[0]):
                line[place] = (((line[place] + a * one[place]) + b * two[place]) + c * three[place]) + d * four[place]
        for k in range(count - count % 4, count):
            for place in range(line.shape[0]):
                line[place] += windows[row, k] * columns[k, place]
        least = np.float32(np.inf)
        for place in range(line.shape[0]):
            line[place] = lengths[place] - line[place]
            least = min(least, line[place])
        for place in range(line.shape[0]):
            line[place] = -min(line[place] - least, steepest)


@kernel("const f4[:,:], const i8[:], const f8[:], f8, i8, f8[:]", fastmath={"contract", "reassoc", "nsz"})
def balance(attraction, starts, wanted, damping, rounds, appeal):
    """Fixed-point iteration of relaxed entropic transport: write the ``appeal`` (g,) of groups of places.

    ``attraction`` (n, m) is that of the places on the windows, those of a group side by side from ``starts`` (g,) on;
    ``wanted`` (g,) are the shares of the groups, with sum 1.
    """
    count, groups = attraction.shape[0], starts.shape[0]
    pull = np.empty((count, groups))
    for row in range(count):
        for group in range(groups):
            total = 0.0
            for place in range(starts[group], starts[group + 1] if group + 1 < groups else attraction.shape[1]):
                total += attraction[row, place]
            pull[row, group] = total
    free = np.empty(groups)
    appeal[:] = 1
    for _ in range(rounds):
        free[:] = 0
        for row in range(count):
            line = pull[row]
            asked = 0.0
            for group in range(groups):
                asked += line[group] * appeal[group]
            share = 1 / (asked * count)
            for group in range(groups):
                free[group] += line[group] * share
        for group in range(groups):
            appeal[group] = (wanted[group] / free[group]) ** damping
