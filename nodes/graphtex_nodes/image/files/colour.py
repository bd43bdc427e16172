"""Arithmetic on decoded pictures: sRGB's transfer function, alpha, orientation, and samples to floats and back."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Alpha = Literal["keep", "drop", "over-white", "over-black"]
Encoding = Literal["auto", "srgb", "linear", "raw"]


def encode_srgb(linear: NDArray[Any]) -> Floats:
    """Linear light to sRGB (IEC 61966-2-1). Below 0 it is mirrored and above 1 it goes on: nothing is clipped.

    >>> encode_srgb(np.array([0.0, 0.0031308, 0.2140411, 1.0])).round(4)
    array([0.    , 0.0404, 0.5   , 1.    ], dtype=float32)
    """
    size = np.abs(linear, dtype=np.float64)
    encoded = np.where(size <= 0.0031308, size * 12.92, 1.055 * np.power(size, 1 / 2.4) - 0.055)
    signed: Floats = np.copysign(encoded, linear).astype(np.float32)
    return signed


def decode_srgb(encoded: NDArray[Any]) -> Floats:
    """Invert `encode_srgb`."""
    size = np.abs(encoded, dtype=np.float64)
    linear = np.where(size <= 0.04045, size / 12.92, np.power((size + 0.055) / 1.055, 2.4))
    signed: Floats = np.copysign(linear, encoded).astype(np.float32)
    return signed


def to_floats(samples: NDArray[Any]) -> Floats:
    """Integers divided by the largest of their type (unsigned: [0, 1], signed: about [-1, 1]); floats as they are.

    >>> to_floats(np.array([0, 51, 255], np.uint8))
    array([0. , 0.2, 1. ], dtype=float32)
    """
    if samples.dtype.kind == "b":
        return samples.astype(np.float32)
    if samples.dtype.kind in "ui":
        if samples.dtype.itemsize <= 2:  # both fit float32: one rounding
            return samples.astype(np.float32) / np.float32(np.iinfo(samples.dtype).max)
        return (samples.astype(np.float64) / np.iinfo(samples.dtype).max).astype(np.float32)
    with np.errstate(over="ignore"):  # a double beyond float32 becomes inf, which the caller refuses
        return samples.astype(np.float32)


def to_samples(values: NDArray[Any], depth: Literal[8, 16, "half", "float"]) -> NDArray[Any]:
    """Floats to samples: 8 and 16 bit clip to [0, 1] and round to nearest; ValueError beyond the range of half.

    >>> to_samples(np.array([-1.0, 0.2, 7.0]), 8)
    array([  0,  51, 255], dtype=uint8)
    """
    if depth in (8, 16):
        largest = 255 if depth == 8 else 65535
        steps: NDArray[Any] = np.rint(np.clip(values, 0, 1).astype(np.float64) * largest)
        return steps.astype(np.uint8 if depth == 8 else np.uint16)
    if depth == "half":
        reach = float(np.abs(values).max(initial=0))
        if reach >= 65520:  # rounds to infinity
            raise ValueError(f"half holds numbers up to 65504, got {reach:g}: write depth: float")
        return values.astype(np.float16)
    return values.astype(np.float32)


def multiply_alpha(picture: Floats, colours: int, alpha: int) -> Floats:
    """Straight to premultiplied: the first `colours` channels times channel `alpha`."""
    result = picture.copy()
    result[..., :colours] *= picture[..., alpha : alpha + 1]
    return result


def divide_alpha(picture: Floats, colours: int, alpha: int) -> Floats:
    """Premultiplied to straight; where alpha is 0 the colour (light without cover) stays as it is."""
    cover = picture[..., alpha : alpha + 1]
    result = picture.copy()
    result[..., :colours] /= np.where(cover > 0, cover, 1)
    return result


def settle_alpha(picture: Floats, policy: Alpha, colours: int, alpha: int, *, premultiplied: bool = False) -> Floats:
    """Keep or drop channel `alpha`, or lay the picture over white or black (in encoded values, as browsers do)."""
    if policy == "keep" or alpha < 0:
        return picture
    rest = np.delete(picture, alpha, axis=2)
    if policy != "drop":
        cover = picture[..., alpha : alpha + 1]
        ground = np.float32(policy == "over-white")
        rest[..., :colours] = picture[..., :colours] * (1 if premultiplied else cover) + ground * (1 - cover)
    return rest


def upright(picture: NDArray[Any], orientation: int) -> NDArray[Any]:
    """Apply an EXIF orientation (1 to 8; others count as 1): 2 mirrors, 3 turns by 180, 6 by 90 clockwise, ..."""
    turned = {
        2: lambda a: a[:, ::-1],
        3: lambda a: a[::-1, ::-1],
        4: lambda a: a[::-1],
        5: lambda a: a.swapaxes(0, 1),
        6: lambda a: np.rot90(a, -1),
        7: lambda a: a[::-1, ::-1].swapaxes(0, 1),
        8: lambda a: np.rot90(a),
    }.get(orientation, lambda a: a)
    return np.ascontiguousarray(turned(picture))
