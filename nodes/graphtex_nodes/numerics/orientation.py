"""In which direction the lines and grain of a picture run, by its structure tensor."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def structure(image: Array, sigma: float, window: float) -> tuple[Array, Array, Array]:
    r"""Direction of lines and how clear it is.

    The structure tensor is the mean over a Gaussian window, and over channels, of the outer product of the gradient g,

    .. math:: J = \langle g g^T \rangle,\quad \theta = \tfrac{1}{2} \operatorname{atan2}(2 J_{xy}, J_{xx} - J_{yy}) + 90

    which is the direction of least change.

    Parameters
    ----------
    image
        (h, w, c).
    sigma, window
        Standard deviations in pixels of the Gaussian derivatives and of the window; a window of 0 is the whole picture.

    Returns
    -------
    angles
        (h, w), degrees clockwise from right, in [0, 180).
    clear, energy
        (h, w): difference and sum of the tensor's eigenvalues; they are equal where all lines are parallel.
    """
    from scipy.ndimage import gaussian_filter

    tensor = np.zeros((3, *image.shape[:2]))
    for channel in np.moveaxis(np.asarray(image, np.float64), -1, 0):
        right, down = (gaussian_filter(channel, sigma, order=order, mode="nearest") for order in ((0, 1), (1, 0)))
        tensor += right * right, down * down, right * down
    if window > 0:
        tensor = np.stack([gaussian_filter(part, window, mode="nearest") for part in tensor])
    else:
        tensor = np.broadcast_to(tensor.mean(axis=(1, 2), keepdims=True), tensor.shape)
    across, along = tensor[0] - tensor[1], 2 * tensor[2]
    angles: Array = (np.degrees(np.arctan2(along, across)) / 2 + 90) % 180
    return angles, np.hypot(across, along), tensor[0] + tensor[1]


def orientation_error(image: Array, angles: Array, *, sigma: float = 1.5, window: float = 6.0) -> float:
    """Mean difference (degrees, 0 to 90) of the direction of a picture's lines from that asked for (h, w).

    Places count by how clear their direction is. 45 where directions have nothing to do with each other.
    """
    found, weights, _ = structure(image, sigma, window)
    apart = np.abs((found - angles + 90) % 180 - 90)
    return float((apart * weights).sum() / weights.sum()) if weights.sum() > 0 else 45.0
