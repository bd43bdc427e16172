"""Woven cloth: warp and weft yarns that pass over and under each other."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Rng, node
from graphtex_nodes.image.exemplars._paint import (
    encoded,
    fractal,
    linear,
    noise,
    openness,
    scatter_cells,
    shading,
    upright,
)
from graphtex_nodes.image.exemplars._view import FieldOfView, Height, PlainExemplar, Slant, Tilt, Width, framed_plane
from graphtex_nodes.numerics.plane import Region, photograph

Array = NDArray[Any]
Weave = Literal["plain", "twill", "basket"]
Colour = tuple[
    Annotated[float, Field(ge=0, le=1)], Annotated[float, Field(ge=0, le=1)], Annotated[float, Field(ge=0, le=1)]
]

TWIST = 2.6  # turns of a yarn's fibres over one crossing


@node
def woven_cloth(
    *,
    width: Width = 256,
    height: Height = 256,
    size: Annotated[float, Field(ge=4, le=512, description="distance of two yarns in pixels at scale 1")] = 14.0,
    weave: Annotated[Weave, Field(description="over one under one, two and two in steps, or pairs of yarns")] = "plain",
    warp: Annotated[Colour, Field(description="sRGB colour of the upright yarns")] = (0.24, 0.36, 0.49),
    weft: Annotated[Colour, Field(description="sRGB colour of the level yarns")] = (0.82, 0.74, 0.60),
    slant: Slant = 0.0,
    tilt: Tilt = 0.0,
    field_of_view: FieldOfView = 45.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> PlainExemplar:
    """Twisted yarns with their threads, shaded, slightly uneven in thickness, course and colour.

    Parameters
    ----------
    slant, tilt, field_of_view
        The plane's pose, as in ScaleFromAngles. Yarns stay upright and level in the picture's middle.

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
    dyes = linear([warp, weft])

    def paint(region: Region) -> Array:
        ctx.check()
        return _cloth(region, size, weave, dyes, tilt, keys)

    return PlainExemplar(encoded(photograph(plane, paint)), plane.scale().astype(np.float32))


def _cloth(region: Region, size: float, weave: Weave, dyes: Array, tilt: float, keys: list[int]) -> Array:
    """Linear light (rows, columns, 3)."""
    right, up = upright(region, tilt)
    x = (right / size).astype(np.float32) + 0.16 * fractal(region, 3.0 * size, keys[0], 2)
    y = (up / size).astype(np.float32) + 0.16 * fractal(region, 3.0 * size, keys[1], 2)
    warp_height, warp_thread = _yarn(x, y, weave, keys[2], upright_yarn=True)
    weft_height, weft_thread = _yarn(y, x, weave, keys[3], upright_yarn=False)
    on_top = warp_height > weft_height
    thread = np.where(on_top, warp_thread, weft_thread)
    fuzz = noise(region, 0.10 * size, keys[4])
    heights = np.maximum(np.maximum(warp_height, weft_height), np.float32(-0.7))
    bare = heights <= -0.7  # a hole between four yarns
    heights = ((0.55 * heights + 0.050 * thread + 0.02 * fuzz) * size).astype(np.float32)
    sun = shading(heights, region, tilt, elevation=46, reach=0.7 * size, softness=0.10 * size)
    sky = openness(heights, region, 0.28 * size, 0.9)
    light = sun[..., None] * np.array([0.80, 0.77, 0.70], np.float32)
    light = light + sky[..., None] * np.array([0.26, 0.28, 0.32], np.float32)
    yarn = np.where(on_top, np.floor(x), np.floor(y)).astype(np.int64)
    tone = 0.84 + 0.32 * scatter_cells(yarn, on_top.astype(np.int64), [keys[5]])[0]
    tone = tone * (1 + 0.10 * thread + 0.10 * fuzz + 0.10 * fractal(region, 2.0 * size, keys[6], 2))
    albedo = dyes[np.where(on_top, 0, 1)] * np.where(bare, 0.12, tone)[..., None]
    result: Array = albedo * light
    return result


def _yarn(across: Array, along: Array, weave: Weave, key: int, *, upright_yarn: bool) -> tuple[Array, Array]:
    """Height of the upright (or level) yarns, in yarn distances, and the relief of their twisted threads in [-1, 1]."""
    number = np.floor(across)
    place = 2 * (across - number) - 1  # -1 to 1 over the yarn's strip
    i = number.astype(np.int64)
    thick, turn = scatter_cells(i, np.zeros_like(i), [key, key + 1])
    thickness = 0.81 + 0.18 * thick
    round_top = 1 - (place / thickness) ** 2
    wave = _wave(i, along, weave, upright_yarn)
    body = np.sqrt(np.maximum(round_top, 0))
    height = np.where(round_top > 0, 0.55 * body - 0.40 + 0.50 * wave, -1)
    slope = np.arcsin(np.clip(place / thickness, -1, 1)) / np.pi
    thread = np.sin(2 * np.pi * (TWIST * along + 1.3 * slope + turn))
    return height.astype(np.float32), (thread * body).astype(np.float32)


def _wave(i: Array, along: Array, weave: Weave, upright_yarn: bool) -> Array:
    """How far a yarn is up (1) or down (-1) at each place of its course, smooth between crossings."""
    middle = along - 0.5
    before = np.floor(middle)
    t = middle - before
    blend = 0.5 - 0.5 * np.cos(np.pi * t)
    j = before.astype(np.int64)
    return _side(i, j, weave, upright_yarn) * (1 - blend) + _side(i, j + 1, weave, upright_yarn) * blend


def _side(yarn: Array, crossing: Array, weave: Weave, upright_yarn: bool) -> Array:
    """1 where the yarn is over the crossing one, else -1."""
    i, j = (yarn, crossing) if upright_yarn else (crossing, yarn)
    if weave == "plain":
        warp_over = ((i + j) & 1) == 0
    elif weave == "twill":
        warp_over = ((i + j) & 3) < 2
    else:
        warp_over = (((i >> 1) + (j >> 1)) & 1) == 0
    return np.where(warp_over == upright_yarn, np.float32(1), np.float32(-1))
