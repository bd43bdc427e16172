"""Kernels of the warp: triangular solves and drawing of triangles."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel


@kernel("const i4[:], const i4[:], const f8[:], const f8[:], f8[:,:]", fastmath={"contract", "reassoc", "nsz"})
def solve(starts, rows, values, pivots, x):
    """Solve L D L' x = b in place for all rows of ``x`` (m, n).

    Columns in a row that have the same entries below the last of them, as a factor has many of, are taken together:
    what they add to these entries, or read of them, is gathered into one run of numbers first.
    """
    sides, count = x.shape
    ends = np.empty(count, np.int32)
    blocks = 0
    longest = 0
    for j in range(count):
        own = rows[starts[j] + 1 : starts[j + 1]]
        longest = max(longest, len(own))
        same = j + 1 < count and len(own) == starts[j + 2] - starts[j + 1]
        if same:
            beyond = rows[starts[j + 1] : starts[j + 2]]
            different = 0
            for k in range(len(own)):
                different += own[k] != beyond[k]
            same = different == 0
        if not same:
            ends[blocks] = j + 1
            blocks += 1
    run = np.empty(longest)
    for block in range(blocks):
        first = ends[block - 1] if block > 0 else 0
        stop = ends[block]
        below = rows[starts[stop - 1] + 1 : starts[stop]]
        added = run[: len(below)]
        for side in range(sides):
            solution = x[side]
            added[:] = 0.0
            for j in range(first, stop):
                value = solution[j]
                start = starts[j] + 1
                for i in range(j + 1, stop):
                    solution[i] -= values[start + i - j - 1] * value
                column = values[start + stop - j - 1 : starts[j + 1]]
                for k in range(len(added)):
                    added[k] += column[k] * value
            for k in range(len(added)):
                solution[below[k]] -= added[k]
    for block in range(blocks - 1, -1, -1):
        first = ends[block - 1] if block > 0 else 0
        stop = ends[block]
        below = rows[starts[stop - 1] + 1 : starts[stop]]
        known = run[: len(below)]
        for side in range(sides):
            solution = x[side]
            for k in range(len(known)):
                known[k] = solution[below[k]]
            for j in range(stop - 1, first - 1, -1):
                total = 0.0
                start = starts[j] + 1
                for i in range(j + 1, stop):
                    total += values[start + i - j - 1] * solution[i]
                column = values[start + stop - j - 1 : starts[j + 1]]
                for k in range(len(known)):
                    total += column[k] * known[k]
                solution[j] = solution[j] / pivots[j] - total


@kernel("const f4[:,:,:], const u1[:,:], const f4[:,:], const i4[:,:], f8, f8, f4[:,:], f4[:,:,:], i8, i8")
def rasterize(places, kept, weight, bodies, longest, parting, best, coordinates, first, stop):
    """Draw the triangles of a warped pixel grid into the rows ``first <= row < stop``.

    ``places`` (h, w, 2) is where each vertex (x, y) goes, ``kept`` (h, w) which vertices take part, ``weight`` (h, w)
    what decides where triangles overlap, and ``longest`` the largest squared edge, or ``parting`` between vertices of
    different ``bodies`` (h, w), -1 = none. ``coordinates`` (rows, columns, 2) receives the vertex coordinates (x, y) of
    each drawn pixel, ``best`` (rows, columns) its triangle's weight.
    """
    height, width = kept.shape
    for i in range(height - 1):
        for j in range(width - 1):
            for half in range(2):
                # the two triangles share the diagonal from upper right to lower left
                ai, aj = (i, j) if half == 0 else (i + 1, j + 1)
                bi, bj = i, j + 1
                ci, cj = i + 1, j
                if not (kept[ai, aj] and kept[bi, bj] and kept[ci, cj]):
                    continue
                ax, ay = float(places[ai, aj, 0]), float(places[ai, aj, 1])
                bx, by = float(places[bi, bj, 0]), float(places[bi, bj, 1])
                cx, cy = float(places[ci, cj, 0]), float(places[ci, cj, 1])
                low = max(first, int(np.ceil(min(ay, by, cy))))
                high = min(stop - 1, int(np.floor(max(ay, by, cy))))
                if low > high:
                    continue
                one, two, three = bodies[ai, aj], bodies[bi, bj], bodies[ci, cj]
                most = max(one, two, three)
                joint = (0 <= one < most) or (0 <= two < most) or (0 <= three < most)
                edges = max(
                    (ax - bx) ** 2 + (ay - by) ** 2, (bx - cx) ** 2 + (by - cy) ** 2, (cx - ax) ** 2 + (cy - ay) ** 2
                )
                if edges > (parting if joint else longest):
                    continue
                area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
                if area == 0.0:
                    continue
                rank = weight[ai, aj] + weight[bi, bj] + weight[ci, cj]
                if (area < 0.0) != (half == 1):
                    rank -= np.float32(0.5)
                left = max(0, int(np.ceil(min(ax, bx, cx))))
                right = min(best.shape[1] - 1, int(np.floor(max(ax, bx, cx))))
                for row in range(low, high + 1):
                    for column in range(left, right + 1):
                        if rank <= best[row, column]:
                            continue
                        second = ((column - ax) * (cy - ay) - (cx - ax) * (row - ay)) / area
                        third = ((bx - ax) * (row - ay) - (column - ax) * (by - ay)) / area
                        share = 1.0 - second - third
                        if share < -1e-9 or second < -1e-9 or third < -1e-9:
                            continue
                        best[row, column] = rank
                        coordinates[row, column, 0] = share * aj + second * bj + third * cj
                        coordinates[row, column, 1] = share * ai + second * bi + third * ci
