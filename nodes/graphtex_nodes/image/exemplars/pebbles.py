"""Pebbles on the ground, seen at any slant and tilt."""

from functools import partial
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Rng, node
from graphtex_nodes.image.exemplars._paint import (
    encoded,
    fractal,
    lay,
    linear,
    openness,
    scattered_points,
    shading,
    visible_centres,
)
from graphtex_nodes.image.exemplars._view import Exemplar, FieldOfView, Height, Slant, Tilt, Width, framed_plane
from graphtex_nodes.numerics.plane import Plane, Region, photograph

Array = NDArray[Any]

PALETTE = (  # sRGB: slate, blue-grey, warm grey, sandstone, ochre, brown, red-brown, chalk
    (0.34, 0.36, 0.40), (0.47, 0.52, 0.57), (0.60, 0.57, 0.53), (0.74, 0.66, 0.54),
    (0.72, 0.55, 0.36), (0.47, 0.37, 0.30), (0.56, 0.36, 0.29), (0.86, 0.84, 0.79),
)  # fmt: skip
SHARES = (0.17, 0.16, 0.20, 0.15, 0.09, 0.10, 0.06, 0.07)
OUTLINE = 1.2  # how far a wavy outline reaches, in half axes


class Stones(NamedTuple):
    """Ellipsoidal stones: centres (n, 2), half axes (n, 2), angle, top, outline (n, 4), all in plane units."""

    centres: Array
    axes: Array
    angles: Array
    tops: Array
    outlines: Array


@node
def pebbles(
    *,
    width: Width = 256,
    height: Height = 256,
    size: Annotated[
        float, Field(ge=4, le=512, description="mean diameter of a pebble in pixels where the scale is 1")
    ] = 24.0,
    slant: Slant = 0.0,
    tilt: Tilt = 0.0,
    field_of_view: FieldOfView = 45.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Exemplar:
    """Lit pebbles of many colours on a plane, with the plane's true texel scale and the pebbles' centres.

    Pebbles are ellipsoids with wavy outlines on relaxed Voronoi cells, smaller ones and soil between them. They are
    painted on the plane: their relief hides nothing behind it, and every pebble shrinks exactly as the scale map says.

    Parameters
    ----------
    slant, tilt, field_of_view
        The plane's pose, as in ScaleFromAngles: tilt 0 makes pebbles shrink upwards, 90 to the right.

    Returns
    -------
    image
        Shape (height, width, 3), sRGB-encoded in [0, 1].
    scale
        True relative texel scale; the largest and the smallest multiply to 1. A pebble is `size` times as wide, across
        the tilt, in pixels; along the tilt the slant shortens it further.
    centres
        Centres of the large pebbles inside the picture, (x, y), sorted from top to bottom.

    Raises
    ------
    ValueError
        The horizon is in the picture, or scales would leave [1/8, 8].

    Examples
    --------
    >>> image, scale, centres = pebbles(width=64, height=48, slant=50.0)
    >>> image.shape, scale.shape, bool(scale[0, 0] < scale[-1, 0])
    ((48, 64, 3), (48, 64), True)
    """
    plane = framed_plane(width, height, slant, tilt, field_of_view)
    large, small = relaxed_stones(plane, size, rng), relaxed_stones(plane, 0.42 * size, rng)
    keys = [int(key) for key in rng.integers(1 << 62, size=3)]
    counts = [len(stones.centres) for stones in (small, large)]
    colours = np.concatenate([stone_colours(count, rng) for count in counts])
    stripes = np.concatenate([stone_stripes(count, rng) for count in counts])

    def paint(region: Region) -> Array:
        ctx.check()
        ground = np.float32(0.05 * size) * fractal(region, 0.3 * size, keys[0])
        owner = np.full(ground.shape, -1, np.int32)
        lay(small.centres, OUTLINE * small.axes[:, 0], partial(_rise, small), region, ground, owner)
        reach = OUTLINE * large.axes[:, 0]
        lay(large.centres, reach, partial(_rise, large), region, ground, owner, first=counts[0])
        return light_stones(ground, owner, region, size, tilt, colours, stripes, keys)

    picture = photograph(plane, paint)
    return Exemplar(encoded(picture), plane.scale().astype(np.float32), visible_centres(plane, large.centres))


def relaxed_stones(plane: Plane, size: float, rng: np.random.Generator) -> Stones:
    """Stones of mean diameter `size` that fill the plane: ellipses with the second moments of relaxed Voronoi cells."""
    from scipy.spatial import cKDTree

    points = scattered_points(plane, size, rng, margin=2 * size, jitter=1.5)
    samples = scattered_points(plane, size / 6, rng, margin=2 * size, jitter=1.0)
    count = len(points)
    for _ in range(2):
        cell = cKDTree(points).query(samples)[1]
        members = np.maximum(np.bincount(cell, minlength=count), 1)
        means = np.stack([np.bincount(cell, samples[:, k], count) for k in (0, 1)], axis=1) / members[:, None]
        points = np.where((np.bincount(cell, minlength=count) > 0)[:, None], means, points)
    apart = samples - points[cell]
    uu, uv, vv = (
        np.bincount(cell, weights, count) / members
        for weights in (apart[:, 0] ** 2, apart[:, 0] * apart[:, 1], apart[:, 1] ** 2)
    )
    angles = 0.5 * np.arctan2(2 * uv, uu - vv)
    spread = np.hypot((uu - vv) / 2, uv)
    middle = np.maximum((uu + vv) / 2, (0.15 * size) ** 2)
    spread = np.minimum(spread, 0.5 * middle)  # no stone longer than 1.7 times its width
    # an ellipse of half axes a has the second moment a² / 4
    axes = 2 * np.sqrt(np.stack([middle + spread, middle - spread], axis=1))
    axes = axes * (0.99 - 0.14 * rng.random((count, 1)) ** 2)
    tops = axes[:, 1] * rng.uniform(0.55, 0.8, count)
    return Stones(points, axes, angles, tops, rng.normal(0, 0.045, (count, 4)))


def _rise(stones: Stones, some: Array, du: Array, dv: Array) -> Array:
    """Heights (n, side, side) of stones over the ground; below it outside their outline."""
    axes, outlines = stones.axes.astype(np.float32), stones.outlines.astype(np.float32)
    cos = np.cos(stones.angles[some]).astype(np.float32)[:, None, None]
    sin = np.sin(stones.angles[some]).astype(np.float32)[:, None, None]
    along = (du[:, None, :] * cos + dv[:, :, None] * sin) / axes[some, 0, None, None]
    across = (dv[:, :, None] * cos - du[:, None, :] * sin) / axes[some, 1, None, None]
    aa, bb = along * along, across * across
    square = aa + bb + np.float32(1e-6)
    bumps = outlines[some, :, None, None]
    # the outline's radius: 1 + harmonics of the second and third order of the angle around the centre
    second = bumps[:, 0] * (aa - bb) + 2 * bumps[:, 1] * along * across
    third = (bumps[:, 2] * along * (aa - 3 * bb) + bumps[:, 3] * across * (3 * aa - bb)) / np.sqrt(square)
    radius = np.sqrt(square) / (1 + (second + third) / square)
    dome: Array = np.sqrt(np.maximum(1 - radius * radius * np.sqrt(radius), 0)) - 8 * np.maximum(radius - 1, 0)
    dome *= stones.tops[some].astype(np.float32)[:, None, None]
    return dome


def stone_colours(count: int, rng: np.random.Generator) -> Array:
    """Linear colours (count, 3) from the palette, each a little off."""
    colours = np.asarray(PALETTE)[rng.choice(len(PALETTE), count, p=SHARES)]
    value = rng.normal(1, 0.10, (count, 1))
    return linear(colours * value + rng.normal(0, 0.015, (count, 3)))


def stone_stripes(count: int, rng: np.random.Generator) -> Array:
    """Wave vector (2), phase and strength of each stone's veins; most stones have none."""
    angle, number = rng.uniform(0, 2 * np.pi, count), rng.uniform(9, 16, count)
    strength = np.where(rng.random(count) < 0.25, rng.uniform(0.1, 0.3, count), 0)
    return np.stack([np.cos(angle) * number, np.sin(angle) * number, rng.uniform(0, 6.3, count), strength], axis=1)


def light_stones(
    height: Array,
    owner: Array,
    region: Region,
    size: float,
    tilt: float,
    colours: Array,
    stripes: Array,
    keys: list[int],
) -> Array:
    """Linear light (rows, columns, 3) of the stones and the soil between them."""
    grain = fractal(region, 0.10 * size, keys[1], 3)
    mottle = fractal(region, 0.45 * size, keys[2], 2)
    soil = linear((0.30, 0.24, 0.18)).astype(np.float32)
    table = np.concatenate([colours, soil[None]]).astype(np.float32)  # owner -1 takes the last row
    vein = np.concatenate([stripes, np.zeros((1, 4))]).astype(np.float32)[owner]
    u, v = (region.u / size).astype(np.float32), (region.v / size).astype(np.float32)
    wave = np.sin(vein[..., 0] * u + vein[..., 1] * v[:, None] + vein[..., 2] + 2.5 * mottle)
    albedo = 1 + 0.16 * grain + 0.14 * mottle + vein[..., 3] * wave**3
    sun = shading(
        height + np.float32(0.008 * size) * grain, region, tilt, elevation=48, reach=0.8 * size, softness=0.05 * size
    )
    sky = openness(height, region, 0.16 * size, 0.75) * openness(height, region, 0.05 * size, 0.35)
    light: Array = sun[..., None] * np.array([0.80, 0.76, 0.68], np.float32)
    light = light + sky[..., None] * np.array([0.24, 0.27, 0.32], np.float32)
    light *= albedo[..., None]
    light *= table[owner]
    return light
