"""Flowers of several colours over grass, seen at any slant and tilt."""

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
    noise,
    openness,
    scattered_points,
    shading,
    visible_centres,
)
from graphtex_nodes.image.exemplars._view import Exemplar, FieldOfView, Height, Slant, Tilt, Width, framed_plane
from graphtex_nodes.numerics.plane import Plane, Region, photograph

Array = NDArray[Any]

PETALS = (  # sRGB: white, yellow, pink, magenta, violet, cornflower, poppy
    (0.96, 0.95, 0.92), (0.97, 0.83, 0.22), (0.94, 0.62, 0.74), (0.80, 0.26, 0.55),
    (0.55, 0.38, 0.78), (0.35, 0.47, 0.86), (0.86, 0.22, 0.16),
)  # fmt: skip
SHARES = (0.30, 0.18, 0.15, 0.09, 0.11, 0.09, 0.08)
GRASS = ((0.20, 0.34, 0.10), (0.30, 0.48, 0.14), (0.43, 0.58, 0.19), (0.60, 0.67, 0.30))  # sRGB, dark to light
EYE = 0.27  # radius of a flower's middle over its own


class Blades(NamedTuple):
    """Blades of grass: middle (n, 2), half length, half width, direction, bend, level, tone."""

    centres: Array
    lengths: Array
    widths: Array
    angles: Array
    bends: Array
    levels: Array
    tones: Array


class Blossoms(NamedTuple):
    """Flowers: centre (n, 2), radius, number of petals, turn, level, colours of petals and middle (n, 3)."""

    centres: Array
    radii: Array
    petals: Array
    angles: Array
    levels: Array
    colours: Array
    eyes: Array


@node
def flowers(
    *,
    width: Width = 256,
    height: Height = 256,
    size: Annotated[float, Field(ge=6, le=512, description="mean diameter of a flower in pixels at scale 1")] = 26.0,
    density: Annotated[float, Field(gt=0, le=1, description="how close flowers stand; 1 leaves little grass")] = 0.6,
    slant: Slant = 0.0,
    tilt: Tilt = 0.0,
    field_of_view: FieldOfView = 45.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Exemplar:
    """Flowers with five to nine petals, lit and with shadows, over blades of grass.

    Parameters
    ----------
    slant, tilt, field_of_view
        The plane's pose, as in ScaleFromAngles: tilt 0 makes flowers shrink upwards, 90 to the right. Flowers lie flat
        in the plane.

    Returns
    -------
    image
        Shape (height, width, 3), sRGB-encoded in [0, 1].
    scale
        True relative texel scale; the largest and the smallest multiply to 1.
    centres
        Centres of the flowers inside the picture, (x, y), sorted from top to bottom.

    Raises
    ------
    ValueError
        The horizon is in the picture, or scales would leave [1/8, 8].
    """
    plane = framed_plane(width, height, slant, tilt, field_of_view)
    blades = _grow_grass(plane, size, rng)
    blossoms = _plant(plane, size, density, rng)
    keys = [int(key) for key in rng.integers(1 << 62, size=4)]

    def paint(region: Region) -> Array:
        ctx.check()
        return _meadow(region, size, tilt, blades, blossoms, keys)

    picture = photograph(plane, paint)
    return Exemplar(encoded(picture), plane.scale().astype(np.float32), visible_centres(plane, blossoms.centres))


def _grow_grass(plane: Plane, size: float, rng: np.random.Generator) -> Blades:
    points = scattered_points(plane, 0.155 * size, rng, margin=size, jitter=1.6)
    count = len(points)
    # most blades point up the picture, which is turned by the tilt in the plane
    angles = np.pi / 2 + np.radians(plane.tilt) + rng.normal(0, 0.9, count)
    return Blades(
        centres=points,
        lengths=size * rng.uniform(0.22, 0.42, count),
        widths=size * rng.uniform(0.034, 0.058, count),
        angles=angles,
        bends=rng.normal(0, 0.30, count),
        levels=size * rng.uniform(0.0, 0.40, count),
        tones=np.clip(rng.normal(0.5, 0.22, count), 0, 1),
    )


def _plant(plane: Plane, size: float, density: float, rng: np.random.Generator) -> Blossoms:
    points = scattered_points(plane, 0.92 * size / np.sqrt(density), rng, margin=size, jitter=0.75)
    count = len(points)
    kind = rng.choice(len(PETALS), count, p=SHARES)
    colours = np.asarray(PETALS)[kind] * rng.normal(1, 0.05, (count, 1)) + rng.normal(0, 0.02, (count, 3))
    eyes = np.where((kind == 1)[:, None], (0.62, 0.36, 0.10), (0.93, 0.74, 0.16))
    eyes = np.where((kind == 6)[:, None], (0.16, 0.12, 0.14), eyes)
    return Blossoms(
        centres=points,
        radii=size * 0.5 * rng.uniform(0.78, 1.22, count),
        petals=np.array([6, 8, 5, 5, 5, 9, 5])[kind],
        angles=rng.uniform(0, 2 * np.pi, count),
        levels=size * rng.uniform(0.50, 0.75, count),
        colours=linear(colours),
        eyes=linear(eyes),
    )


def _meadow(region: Region, size: float, tilt: float, blades: Blades, blossoms: Blossoms, keys: list[int]) -> Array:
    """Linear light (rows, columns, 3)."""
    heights = np.float32(0.06 * size) * fractal(region, 0.4 * size, keys[0], 2) - np.float32(0.25 * size)
    owner = np.full(heights.shape, -1, np.int32)
    count = len(blades.centres)
    lay(blades.centres, blades.lengths * 1.1, lambda *of: _blade_rise(blades, *of), region, heights, owner)
    lay(
        blossoms.centres,
        blossoms.radii * 1.05,
        lambda *of: _petal_rise(blossoms, *of),
        region,
        heights,
        owner,
        first=count,
    )
    tones = linear(GRASS)
    place = np.append(blades.tones, 0.0)[np.where(owner < count, owner, -1)] * (len(tones) - 1)
    place = np.clip(place + 0.5 * noise(region, 2.5 * size, keys[1]), 0, len(tones) - 1.001)
    below = place.astype(np.intp)
    albedo = tones[below] + (tones[below + 1] - tones[below]) * (place - below)[..., None].astype(np.float32)
    albedo *= np.clip(0.40 + heights / (0.45 * size), 0.25, 1.15)[..., None]  # light does not reach down between blades
    blooming = owner >= count
    albedo[blooming] = _petal_colours(blossoms, region, blooming, owner[blooming] - count, size)
    sun = shading(heights, region, tilt, elevation=52, reach=0.7 * size, softness=0.12 * size)
    sky = openness(heights, region, 0.12 * size, 0.40)
    light = (0.35 + 0.65 * sun)[..., None] * np.array([0.86, 0.82, 0.72], np.float32)
    result: Array = albedo * (light * 0.85 + sky[..., None] * np.array([0.26, 0.29, 0.33], np.float32))
    return result


def _blade_rise(blades: Blades, some: Array, du: Array, dv: Array) -> Array:
    """Heights (n, side, side) of bent, tapering blades that rise towards their tips."""
    cos, sin, length, width, bend, level = (
        values[some].astype(np.float32)[:, None, None]
        for values in (
            np.cos(blades.angles),
            np.sin(blades.angles),
            blades.lengths,
            blades.widths,
            blades.bends,
            blades.levels,
        )
    )
    along = (du[:, None, :] * cos + dv[:, :, None] * sin) / length
    across = (dv[:, :, None] * cos - du[:, None, :] * sin) - bend * length * (along * along - 0.3)
    taper = width * (1 - 0.62 * along - 0.38 * along * along)
    room = 1 - np.abs(across) / np.maximum(taper, 1e-3)
    height = level + 0.22 * length * along + 1.1 * width * np.minimum(room, 0.6)
    return np.where((room > 0) & (np.abs(along) < 1), height, np.float32(-1e6))


def _petal_rise(blossoms: Blossoms, some: Array, du: Array, dv: Array) -> Array:
    """Heights (n, side, side) of flowers: petals that droop at their tips, and a dome in the middle."""
    radius = blossoms.radii[some].astype(np.float32)[:, None, None]
    distance, ridge, rim = _petal_shape(
        np.broadcast_to(du[:, None, :], (len(some), dv.shape[1], du.shape[1])) / radius,
        dv[:, :, None] / radius,
        blossoms.petals[some].astype(np.float32)[:, None, None],
        blossoms.angles[some].astype(np.float32)[:, None, None],
    )
    cup = 0.10 + 0.30 * distance - 0.34 * distance * distance + 0.09 * ridge
    dome = 0.16 + 0.20 * np.sqrt(np.maximum(1 - (distance / EYE) ** 2, 0))
    height = np.where(distance < EYE, dome, cup) * radius + blossoms.levels[some].astype(np.float32)[:, None, None]
    return np.where(distance < rim, height, np.float32(-1e6)).astype(np.float32)


def _petal_shape(u: Array, v: Array, petals: Array, angle: Array) -> tuple[Array, Array, Array]:
    """Distance from the middle, ridge of each petal (1 at its axis, 0 between two) and the outline's distance."""
    distance = np.sqrt(u * u + v * v)
    turn = np.abs(np.cos((np.arctan2(v, u) - angle) * petals / 2))
    return distance, np.sqrt(turn), 0.52 + 0.48 * turn**0.55


def _petal_colours(blossoms: Blossoms, region: Region, where: Array, number: Array, size: float) -> Array:
    """Linear colours (k, 3) of the texels `where` that belong to the flowers `number`."""
    row, column = np.nonzero(where)
    radius = blossoms.radii[number]
    u = ((region.u[column] - blossoms.centres[number, 0]) / radius).astype(np.float32)
    v = ((region.v[row] - blossoms.centres[number, 1]) / radius).astype(np.float32)
    distance, ridge, _ = _petal_shape(u, v, blossoms.petals[number], blossoms.angles[number])
    veins = np.sin(distance * 4 + np.arctan2(v, u) * blossoms.petals[number] * 5)
    shade = 0.62 + 0.42 * np.clip(distance, 0, 1) + 0.05 * veins * distance
    shade = shade * (0.66 + 0.40 * ridge)
    petals = blossoms.colours[number] * shade[:, None]
    seeds = 0.8 + 0.3 * np.sin(40 * u) * np.sin(40 * v)
    eyes = blossoms.eyes[number] * (seeds * (1.1 - 0.6 * (distance / EYE) ** 4))[:, None]
    result: Array = np.where((distance < EYE)[:, None], eyes, petals).astype(np.float32)
    return result
