"""Few channels that show most of what a picture shows."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def principal_channels(image: Array, least: float) -> Array:
    """Principal components of the colours, (n, h, w), float64, mean 0, the largest variance first; brighter is larger.

    Components of less than `least` times the largest variance are left out. The last of two or of four channels is
    taken for alpha, which is no colour.
    """
    colours = (image[..., :-1] if image.shape[2] in (2, 4) else image).astype(np.float64)
    colours = colours - colours.mean(axis=(0, 1))  # filters that should ignore a constant do so but for rounding
    if colours.shape[2] == 1:
        only: Array = colours[..., 0][None]
        return only
    # einsum adds in one order, whatever the number of threads: a mask must not depend on it
    covariance = np.einsum("hwc,hwd->cd", colours, colours, optimize=False)
    variances, axes = np.linalg.eigh(covariance)
    kept = axes.T[::-1][variances[::-1] >= least * variances[-1]]
    kept = np.where(kept.sum(axis=1, keepdims=True) >= 0, kept, -kept)
    result: Array = np.einsum("hwc,nc->nhw", colours, kept, optimize=False)
    return result
