"""Size of what repeats in a texture."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

LARGEST = 256
"""Autocorrelation is measured on at most this many pixels a side: a larger picture's middle is enough."""


def dominant_period(image: Array, strength: float = 0.3) -> float:
    """Distance in pixels at which an image (h, w, c) repeats itself; 0 when it does not.

    It is the distance of a local maximum of the autocorrelation (channels summed, a plane subtracted, each lag divided
    by its overlap) that reaches ``strength``: the nearest of those within a fifth of the highest. Lags up to a third of
    each side count.

    Examples
    --------
    >>> wave = np.sin(np.arange(60, dtype=np.float32) * 2 * np.pi / 12)
    >>> round(dominant_period(np.outer(wave, wave)[..., None]), 2)  # the nearest repeat is 6 down and 6 to the right
    8.49
    """
    height, width = (min(LARGEST, side) for side in image.shape[:2])
    if min(height, width) < 6:
        return 0.0
    top, left = (image.shape[0] - height) // 2, (image.shape[1] - width) // 2
    part = image[top : top + height, left : left + width].astype(np.float64)
    down = np.linspace(-1, 1, height)[:, None, None]
    right = np.linspace(-1, 1, width)[None, :, None]
    for slope in (down, right):
        part = part - slope * (part * slope).mean(axis=(0, 1)) / (slope * slope).mean()
    part = part - part.mean(axis=(0, 1))
    shape = (2 * height, 2 * width)
    power = (np.abs(np.fft.rfft2(part, shape, axes=(0, 1))) ** 2).sum(axis=2)
    raw = np.fft.irfft2(power, shape)
    if raw[0, 0] <= 1e-12 * part.size:
        return 0.0
    lag_y, lag_x = height // 3, width // 3
    rows = np.arange(-lag_y - 1, lag_y + 2)
    columns = np.arange(-lag_x - 1, lag_x + 2)
    overlap = np.outer(height - np.abs(rows), width - np.abs(columns))
    lags = raw[np.ix_(rows, columns)] / overlap * (height * width / raw[0, 0])
    inner = lags[1:-1, 1:-1]
    peak = inner >= strength
    for y in range(3):
        for x in range(3):
            if (y, x) != (1, 1):
                peak &= inner >= lags[y : y + inner.shape[0], x : x + inner.shape[1]]
    distance = np.hypot(*np.meshgrid(rows[1:-1], columns[1:-1], indexing="ij"))
    peak &= distance > 2
    if not peak.any():
        return 0.0
    return float(distance[peak & (inner >= 0.8 * inner[peak].max())].min())
