"""Colours in CIE L*a*b*, in which distances are about as large as they look."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
"""Linear sRGB to CIE XYZ (IEC 61966-2-1)."""
WHITE = XYZ.sum(axis=1)
"""D65, the white of sRGB."""
DARK, SLOPE = 216 / 24389, 24389 / 27
"""Below ``DARK`` lightness is linear with this slope."""


def lab_of(colours: Array) -> Array:
    """L*, a*, b* (float32, L* of 0 to 100) of sRGB-encoded colours (h, w, 3); values outside [0, 1] are clipped.

    >>> lab_of(np.ones((1, 1, 3), np.float32)).round(3).tolist()
    [[[100.0, 0.0, 0.0]]]
    """
    encoded = np.clip(colours.astype(np.float64), 0, 1)
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    xyz = np.einsum("hwc,dc->hwd", linear, XYZ / WHITE[:, None], optimize=False)
    x, y, z = np.moveaxis(np.where(xyz > DARK, np.cbrt(xyz), (SLOPE * xyz + 16) / 116), -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1).astype(np.float32)
