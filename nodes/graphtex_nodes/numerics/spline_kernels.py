"""Kernel that looks up a picture between its pixels."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.jit import kernel


@njit(forceinline=True)
def quintic(t, weights):
    """Weights of six neighbours for a place ``t`` of the way from the third to the fourth: B-splines of degree 5."""
    u = 1 - t
    weights[0] = u**5 / 120
    weights[1] = (26 + t * (-50 + t * (20 + t * (20 + t * (-20 + t * 5))))) / 120
    weights[2] = (66 + t * t * (-60 + t * t * (30 - t * 10))) / 120
    weights[3] = (66 + u * u * (-60 + u * u * (30 - u * 10))) / 120
    weights[4] = (26 + u * (-50 + u * (20 + u * (20 + u * (-20 + u * 5))))) / 120
    weights[5] = t**5 / 120


@njit(forceinline=True)
def mirrored(place, count):
    """A place (integer) brought between 0 and ``count`` by mirroring about the first and the last."""
    if count == 1:
        return 0
    place = abs(place) % (2 * count - 2)
    return min(place, 2 * count - 2 - place)


@kernel("const f4[:,:,:], const f8[:], const f8[:], f4[:,:]")
def look_up(splines, rows, columns, colours):
    """Colours (n, c) at rows and columns (n,) of a picture whose coefficients are ``splines`` (h, w, c)."""
    height, width, channels = splines.shape
    down, right = np.empty(6), np.empty(6)
    found = np.empty(channels)
    for number in range(rows.size):
        row, column = int(np.floor(rows[number])), int(np.floor(columns[number]))
        quintic(rows[number] - row, down)
        quintic(columns[number] - column, right)
        for c in range(channels):
            found[c] = 0
        for i in range(6):
            y = mirrored(row + i - 2, height)
            for j in range(6):
                x = mirrored(column + j - 2, width)
                weight = down[i] * right[j]
                for c in range(channels):
                    found[c] += weight * splines[y, x, c]
        for c in range(channels):
            colours[number, c] = found[c]
