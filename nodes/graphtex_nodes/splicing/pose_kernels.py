"""Kernels that lay elements where they match best."""

# mypy: allow-untyped-defs

import numpy as np
from numba import njit

from graphtex_nodes.numerics.jit import kernel


@njit
def match(image, wanted, u, v, faint, x, y, angle, log_scale):
    """Correlation coefficient of an element's samples with the wanted ones (k, c), over those in the picture.

    Places u, v (k,) are turned by the angle in degrees. A contrast below ``faint`` times the wanted one counts less.
    """
    height, width, channels = image.shape
    scale = np.exp(log_scale)
    cos, sin = scale * np.cos(np.radians(angle)), scale * np.sin(np.radians(angle))
    product, ours, theirs = 0.0, 0.0, 0.0
    for channel in range(channels):
        count, a, b, aa, bb, ab = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(u.shape[0]):
            column, row = x + cos * u[k] - sin * v[k], y + sin * u[k] + cos * v[k]
            if row < -0.5 or row > height - 0.5 or column < -0.5 or column > width - 0.5:
                continue
            row, column = min(max(row, 0.0), height - 1.0), min(max(column, 0.0), width - 1.0)
            top, left = int(row), int(column)
            bottom, right = min(top + 1, height - 1), min(left + 1, width - 1)
            down, across = row - top, column - left
            upper = (1 - across) * image[top, left, channel] + across * image[top, right, channel]
            lower = (1 - across) * image[bottom, left, channel] + across * image[bottom, right, channel]
            seen, other = (1 - down) * upper + down * lower, wanted[k, channel]
            count += 1
            a += seen
            b += other
            aa += seen * seen
            bb += other * other
            ab += seen * other
        if count > 0:
            product += ab - a * b / count
            ours += aa - a * a / count
            theirs += bb - b * b / count
    if ours * theirs <= 1e-12:
        return 0.0
    return product / np.sqrt(ours * theirs) * min(np.sqrt(ours / max(theirs, 1e-12)) / faint, 1.0)


@kernel(
    "const f4[:,:,:], const f8[:,:], const f8[:], const f8[:], f8, const f8[:], const f8[:], i8, f8[:,:], f8[:], i8, i8"
)
def climb(image, wanted, u, v, faint, lengths, farthest, halvings, values, scores, first, stop):
    """Move poses to better neighbours until none is, with steps that are halved, and write what they score.

    Each row of ``values`` is x, y, angle and logarithm of the scale. None moves farther than ``farthest`` from 0.
    """
    for number in range(first, stop):
        pose = values[number]
        best = match(image, wanted, u, v, faint, pose[0], pose[1], pose[2], pose[3])
        for halving in range(halvings):
            for _ in range(2):
                better = False
                for axis in range(4):
                    for way in (-1.0, 1.0):
                        before = pose[axis]
                        pose[axis] = before + way * lengths[axis] / 2.0**halving
                        if abs(pose[axis]) > max(farthest[axis], abs(before)):
                            pose[axis] = before
                            continue
                        score = match(image, wanted, u, v, faint, pose[0], pose[1], pose[2], pose[3])
                        if score > best + 1e-9:
                            best, better = score, True
                        else:
                            pose[axis] = before
                if not better:
                    break
        scores[number] = best
