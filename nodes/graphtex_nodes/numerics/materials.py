"""Kinds of material maps in the channels of a stack, and what turning a picture does to its normals."""

from collections.abc import Callable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

MapKind = Literal["colour", "colour+alpha", "normal", "normal-down", "height", "scalar"]
CHANNELS: dict[str, int] = {"colour": 3, "colour+alpha": 4, "normal": 3, "normal-down": 3, "height": 1, "scalar": 1}
UP = {"normal": 1.0, "normal-down": -1.0}
"""Kinds that are normals, and which way their second component points in the picture."""
OFF = 0.1
OUTWARDS = 0.4  # mean third component: 0.85 and more in maps of walls, cheese and wool, below 0.3 in most photographs
UNIT_WITHIN = 0.01  # rounding to 8 bits moves a normal's length by up to 0.7 %


def total_channels(kinds: Sequence[MapKind]) -> int:
    """Channels of a stack."""
    return sum(CHANNELS[kind] for kind in kinds)


def require_channels(kinds: Sequence[MapKind], count: int) -> None:
    """Raise ValueError unless the kinds add up to the channels of a picture."""
    if total_channels(kinds) != count:
        raise ValueError(f"kinds: {' + '.join(kinds)} are {total_channels(kinds)} channels, the picture has {count}")


def require_stack(name: str, stack: Array, kinds: Sequence[MapKind], warn: Callable[[str], None]) -> None:
    """Raise ValueError unless kinds, if there are some, fit a stack; warn of normals that seem to be none."""
    if kinds:
        require_channels(kinds, stack.shape[-1])
        doubt_normals(name, stack, kinds, warn)


def doubt_normals(name: str, stack: Array, kinds: Sequence[MapKind], warn: Callable[[str], None]) -> None:
    """Warn of maps of normals in a stack (h, w, c) that are colour, say.

    Normals of a tangent space are unit vectors and point out of the surface; blending and JPEG spare most of them.
    """
    for kind, channels in zip(kinds, map_slices(kinds), strict=True):
        if kind not in UP:
            continue
        normal = stack[..., channels].astype(np.float64) * 2 - 1
        off = float(np.mean(np.abs(np.sqrt((normal * normal).sum(axis=-1)) - 1) > OFF))
        outwards = float(normal[..., 2].mean())
        if off > 0.5:
            warn(f"{name}: {off:.0%} of its normals are longer or shorter than 1 by over {OFF:g}; is it a normal map?")
        elif outwards < OUTWARDS:
            warn(f"{name}: the third component of its normals is {outwards:.2f} in the mean; is it a normal map?")


def map_slices(kinds: Sequence[MapKind]) -> list[slice]:
    """Channels of each map of a stack."""
    ends = np.cumsum([CHANNELS[kind] for kind in kinds]).tolist()
    return [slice(end - CHANNELS[kind], end) for kind, end in zip(kinds, ends, strict=True)]


def bending(kinds: Sequence[MapKind], count: int) -> NDArray[np.uint8]:
    """How channels (count,) are bent where copied pieces meet: 0 not at all, 1 unless an outline is torn, 2 always.

    Light makes brightness and colour vary, so these may be bent; without kinds all channels count as such. Normals and
    scalars are measured: they stay as they were copied. A height is known but for a constant, and its normals tell of
    no cliff where two pieces meet: so it is the gradients that stay.
    """
    ways = {"height": 2, "colour": 1, "colour+alpha": 1}
    return np.array([ways.get(kind, 0) for kind in kinds for _ in range(CHANNELS[kind])] or [1] * count, np.uint8)


def unit_normals(encoded: Array) -> Array:
    """Normals (..., 3), encoded as (n + 1) / 2, made unit vectors; those within 1 % of it stay bit for bit."""
    normal = encoded.astype(np.float64) * 2 - 1
    length = np.sqrt((normal * normal).sum(axis=-1, keepdims=True))
    unit = np.where(length > 1e-6, normal / np.maximum(length, 1e-6), [0.0, 0.0, 1.0])
    return np.where(np.abs(length - 1) <= UNIT_WITHIN, encoded, (unit + 1) / 2).astype(np.float32)


def renormalised(stack: Array, kinds: Sequence[MapKind]) -> Array:
    """A stack (..., c) whose normals are unit vectors; itself without kinds."""
    if not UP.keys() & set(kinds):
        return stack
    result = stack.copy()
    for kind, channels in zip(kinds, map_slices(kinds), strict=True):
        if kind in UP:
            result[..., channels] = unit_normals(stack[..., channels])
    return result


def turn_normals(stack: Array, kinds: Sequence[MapKind], angle: float, mirrored: bool) -> None:
    """Turn the normals of a stack (..., c) as its picture is: mirrored right to left, then turned clockwise (degrees).

    A normal's first component points to the right; its second one up, or down for the kind ``normal-down``.
    """
    cos, sin = turn(angle)
    for kind, channels in zip(kinds, map_slices(kinds), strict=True):
        if kind not in UP or (angle == 0 and not mirrored):
            continue
        encoded = stack[..., channels]
        right, second = (encoded[..., axis].astype(np.float64) * 2 - 1 for axis in (0, 1))
        right, up = -right if mirrored else right, second * UP[kind]
        encoded[..., 0] = (right * cos + up * sin + 1) / 2
        encoded[..., 1] = ((up * cos - right * sin) * UP[kind] + 1) / 2


def turn(angle: float) -> tuple[float, float]:
    """Cosine and sine of an angle in degrees, exact at multiples of 90."""
    return round(float(np.cos(np.radians(angle))), 14), round(float(np.sin(np.radians(angle))), 14)
