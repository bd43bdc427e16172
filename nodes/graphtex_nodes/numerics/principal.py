"""One channel that shows most of what a picture shows."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def principal_channel(image: Array) -> Array:
    """Values (h, w), float64, mean 0, along the direction of largest variance of the colours; brighter is larger."""
    colours = image.astype(np.float64)
    colours = colours - colours.mean(axis=(0, 1))  # filters that should ignore a constant do so but for rounding
    if colours.shape[2] == 1:
        only: Array = colours[..., 0]
        return only
    # einsum adds in one order, whatever the number of threads: a mask must not depend on it
    covariance = np.einsum("hwc,hwd->cd", colours, colours, optimize=False)
    axis = np.linalg.eigh(covariance)[1][:, -1]
    axis = axis if axis.sum() >= 0 else -axis
    result: Array = np.einsum("hwc,c->hw", colours, axis, optimize=False)
    return result
