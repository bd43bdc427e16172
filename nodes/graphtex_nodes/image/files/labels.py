"""Distinct colours for labels."""

import numpy as np
from numpy.typing import NDArray

_GOLDEN = 0.6180339887498949  # consecutive labels get hues far apart, however many there are


Doubles = NDArray[np.float64]


def hsv_to_rgb(hue: Doubles, saturation: Doubles, value: Doubles) -> Doubles:
    """RGB (..., 3) in [0, 1]; `hue` in turns, of any size."""
    sector = (np.array([5.0, 3.0, 1.0]) + hue[..., None] * 6) % 6
    ramp = np.clip(np.minimum(sector, 4 - sector), 0, 1)
    rgb: Doubles = value[..., None] * (1 - saturation[..., None] * ramp)
    return rgb


def palette(labels: NDArray[np.integer]) -> NDArray[np.uint8]:
    """Colours (..., 3) of labels: a hue of its own for each from 0 on, in three tones; below 0 dark grey.

    >>> palette(np.array([-1, 0]))
    array([[ 64,  64,  64],
           [217,  65,  65]], dtype=uint8)
    """
    labels = np.asarray(labels, np.int64)
    tone = labels % 3
    saturation, value = np.array([0.7, 0.45, 0.9])[tone], np.array([0.85, 0.95, 0.6])[tone]
    rgb = hsv_to_rgb((labels * _GOLDEN % 1.0).astype(np.float64), saturation, value)
    return np.where(labels[..., None] < 0, 64, np.rint(rgb * 255)).astype(np.uint8)
