"""Kernels that find what the steps between faded pieces lack, and add a correction."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.jit import kernel


@njit(forceinline=True)
def weigh(lack, channels, limit, bends):
    """Multiply the missing steps of a row by their weights."""
    for start in range(0, lack.shape[0], channels):
        squared = np.float32(0)
        for c in range(channels):
            squared += lack[start + c] * lack[start + c]
        if squared > 0:
            weight = np.exp(-squared / limit)
            for c in range(channels):
                if bends[c] < 2:
                    lack[start + c] *= weight * bends[c]


@kernel("const f4[:,:], const f4[:,:,:], f4, const u1[:], u1, u1, f4[:,:,:], i8, i8")
def missing_steps(image, steps, limit, bends, around_y, around_x, missing, first, stop):
    """How much a pixel lacks, summed over its four neighbours, for the differences to them to be the wanted ``steps``.

    Arrays are as in ``seam_kernels.fade_seams``; ``missing`` is (channels, h, w). What a step lacks counts exp(-its
    squared length / ``limit``); in channels whose ``bends`` is 2 it counts whole, in those where it is 0 nothing. An
    image that wraps around goes on over its borders.
    """
    channels, height, width = missing.shape
    size = width * channels
    above = np.zeros(size, np.float32)  # what the steps to a row lack
    beside = np.zeros(size + channels, np.float32)  # and those to a pixel and to the one behind it, along a row
    for y in range(first - 1, stop):
        if y >= first:
            for index in range(size - channels):
                beside[channels + index] = steps[1, y, index] - (image[y, index + channels] - image[y, index])
            if around_x:
                for c in range(channels):
                    last = size - channels + c
                    beside[c] = beside[size + c] = steps[1, y, last] - (image[y, c] - image[y, last])
            weigh(beside, channels, limit, bends)
            for c in range(channels):
                for x in range(width):
                    place = x * channels + c
                    missing[c, y, x] = above[place] + beside[place] - beside[place + channels]
        if 0 <= y < height - 1 or around_y:
            row, below = y % height, (y + 1) % height
            for index in range(size):
                above[index] = steps[0, row, index] - (image[below, index] - image[row, index])
            weigh(above, channels, limit, bends)
        else:
            above[:] = 0
        if y >= first:
            for c in range(channels):
                for x in range(width):
                    missing[c, y, x] -= above[x * channels + c]


@kernel("f4[:,:], const f4[:,:,:], const f4[:], const f4[:], i8, i8")
def correct(image, correction, low, high, first, stop):
    """Add a correction (channels, h, w) to an image (h, w * channels), and keep it between ``low`` and ``high``."""
    channels = correction.shape[0]
    for y in range(first, stop):
        for x in range(correction.shape[2]):
            for c in range(channels):
                value = image[y, x * channels + c] + correction[c, y, x]
                image[y, x * channels + c] = min(max(value, low[c]), high[c])
