"""What of a picture stays the same when an element turns under a fixed lamp."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

SMOOTH = 1.0  # pixels
DARK = 0.05  # what a colour's share is steadied with where there is next to no light
COLOURFUL = 0.015  # standard deviation of the shares from which a picture's colours tell its elements


def unlit(image: Array) -> Array:
    """Features (h, w, k), float32, each of standard deviation 1, of a picture (h, w, c).

    Shading falls on the same side of all elements, however they are turned, so matching colours would turn an element
    to fit its shading. In colour pictures the features are each channel's share of the light and how steeply the shares
    change; in others the brightness and its steepness are all there is.
    """
    from scipy.ndimage import gaussian_filter1d

    smooth = image.astype(np.float64)
    for axis in (0, 1):
        smooth = gaussian_filter1d(smooth, SMOOTH, axis=axis, mode="mirror")
    features = smooth
    if image.shape[2] >= 3:
        shares = light_shares(smooth)
        if is_colourful(shares):
            features = shares
    steepness = np.sqrt(squared_change(features))
    found = np.concatenate([features, steepness[..., None]], axis=2)
    scaled: Array = (found / np.maximum(found.std(axis=(0, 1)), 1e-6)).astype(np.float32)
    return scaled


def squared_change(image: Array) -> Array:
    """How steeply a picture (h, w, c) changes where it is smoothed a little: squares, (h, w), all channels together."""
    from scipy.ndimage import gaussian_gradient_magnitude

    return np.asarray(sum(gaussian_gradient_magnitude(channel, SMOOTH) ** 2 for channel in np.moveaxis(image, -1, 0)))


def light_shares(image: Array) -> Array:
    """Share of the light that each of the first three channels has: (h, w, 3), the same in light and in shade."""
    light = np.clip(image[..., :3], 0, None)
    shares: Array = light / (light.sum(axis=2, keepdims=True) + DARK)
    return shares


def is_colourful(shares: Array) -> bool:
    """Whether shares of the light vary enough to tell elements."""
    return bool(shares.std(axis=(0, 1)).max() > COLOURFUL)
