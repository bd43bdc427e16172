"""Rippled sand."""

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Rng, node
from graphtex_nodes.image.exemplars._paint import encoded, fractal, linear, noise, openness, scatter, shading, upright
from graphtex_nodes.image.exemplars._view import FieldOfView, Height, PlainExemplar, Slant, Tilt, Width, framed_plane
from graphtex_nodes.numerics.plane import Region, photograph

Array = NDArray[Any]

DRY, DAMP = (0.86, 0.74, 0.56), (0.62, 0.49, 0.35)
STEEPNESS = 0.14  # height of a ripple over its length


@node
def sand(
    *,
    width: Width = 256,
    height: Height = 256,
    size: Annotated[float, Field(ge=6, le=1024, description="distance of two ripples in pixels at scale 1")] = 32.0,
    grain: Annotated[float, Field(ge=0, le=1, description="how rough the grains make the surface")] = 0.5,
    slant: Slant = 0.0,
    tilt: Tilt = 0.0,
    field_of_view: FieldOfView = 45.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> PlainExemplar:
    """Wind ripples that fork and join, with a gentle and a steep side, under grains of several tones.

    Parameters
    ----------
    slant, tilt, field_of_view
        The plane's pose, as in ScaleFromAngles. Crests run level in the picture's middle.

    Returns
    -------
    image
        Shape (height, width, 3), sRGB-encoded in [0, 1].
    scale
        True relative texel scale; the largest and the smallest multiply to 1.

    Raises
    ------
    ValueError
        The horizon is in the picture, or scales would leave [1/8, 8].
    """
    plane = framed_plane(width, height, slant, tilt, field_of_view)
    keys = [int(key) for key in rng.integers(1 << 62, size=8)]

    def paint(region: Region) -> Array:
        ctx.check()
        return _ripples(region, size, grain, tilt, keys)

    return PlainExemplar(encoded(photograph(plane, paint)), plane.scale().astype(np.float32))


def _ripples(region: Region, size: float, grain: float, tilt: float, keys: list[int]) -> Array:
    """Linear light (rows, columns, 3)."""
    _, up = upright(region, tilt)
    bend = 1.1 * noise(region, 5.0 * size, keys[0]) + 0.45 * noise(region, 2.0 * size, keys[1])
    phase = (up / size).astype(np.float32) + bend + 0.10 * noise(region, 0.7 * size, keys[2])
    t = phase - np.floor(phase)
    # a gentle side over 0.68 of the length, a steep one over the rest, rounded at crest and trough
    saw = np.where(t < 0.68, t / 0.68, (1 - t) / 0.32)
    profile = saw * saw * (3 - 2 * saw)
    strength = 0.75 + 0.35 * noise(region, 3.0 * size, keys[3])
    dust = 0.6 * noise(region, 2.2, keys[4]) + 0.8 * noise(region, 1.1, keys[5])
    lumps = fractal(region, 0.25 * size, keys[6], 3)
    heights = size * (STEEPNESS * profile * strength + 0.010 * lumps) + 0.38 * grain * dust
    heights = heights.astype(np.float32)
    sun = shading(heights, region, tilt, elevation=33, reach=0.45 * size, softness=0.03 * size)
    sky = openness(heights, region, 0.2 * size, 0.6)
    light = sun[..., None] * np.array([0.72, 0.66, 0.56], np.float32)
    light = light + sky[..., None] * np.array([0.24, 0.27, 0.33], np.float32)
    damp = np.clip(0.55 - 0.75 * profile + 0.25 * lumps, 0, 1)[..., None] * np.float32(0.55)
    albedo = linear(DRY) * (1 - damp) + linear(DAMP) * damp
    result: Array = (
        albedo * (1 + grain * 0.30 * dust + 0.07 * lumps)[..., None] * _specks(region, grain, keys[7]) * light
    )
    return result


def _specks(region: Region, grain: float, key: int) -> Array:
    """Factor (rows, columns, 1) of single dark and light grains, 1.6 units wide."""
    if region.density < 0.4:  # smaller than a texel: nothing to see
        return np.ones((region.rows, region.columns, 1), np.float32)
    i = np.floor(region.v / 1.6).astype(np.int64)[:, None]
    j = np.floor(region.u / 1.6).astype(np.int64)[None, :]
    lot = scatter(i, j, key)
    factor = 1 - grain * (0.7 * np.clip((lot - 0.955) * 30, 0, 1) - 0.35 * np.clip((0.03 - lot) * 40, 0, 1))
    result: Array = factor[..., None].astype(np.float32)
    return result
