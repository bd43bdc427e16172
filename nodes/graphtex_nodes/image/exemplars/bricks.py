"""Bricks in running bond with mortar, seen at any slant and tilt."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Image, Points, Rng, ScaleMap, node
from graphtex_nodes.image.exemplars._paint import (
    encoded,
    fractal,
    linear,
    noise,
    openness,
    scatter_cells,
    shading,
    upright,
    visible_centres,
    visible_corners,
)
from graphtex_nodes.image.exemplars._view import FieldOfView, Height, Slant, Tilt, Width, framed_plane
from graphtex_nodes.numerics.plane import Plane, Region, photograph

Array = NDArray[Any]
Kind = Literal["wall", "paving"]

PROPORTION = {"wall": 0.36, "paving": 0.5}  # height of a course over the length of a brick
JOINT = {"wall": 0.050, "paving": 0.035}  # half a joint and what the edges vary, in brick lengths
PALETTES = {  # sRGB, dark to light
    "wall": ((0.36, 0.20, 0.17), (0.50, 0.25, 0.19), (0.60, 0.30, 0.22), (0.66, 0.37, 0.26), (0.71, 0.47, 0.35)),
    "paving": ((0.42, 0.42, 0.44), (0.52, 0.51, 0.50), (0.60, 0.57, 0.53), (0.67, 0.62, 0.55), (0.63, 0.54, 0.48)),
}
MORTAR = {"wall": (0.70, 0.67, 0.61), "paving": (0.36, 0.33, 0.28)}


HIGHEST = 0.075  # of a brick's face, in brick lengths above the mean depth of the mortar


class Masonry(NamedTuple):
    """A generated picture of bricks with its ground truth."""

    image: Image
    scale: ScaleMap
    centres: Points
    height: Image


@node
def bricks(
    *,
    width: Width = 256,
    height: Height = 256,
    size: Annotated[float, Field(ge=8, le=1024, description="length of a brick in pixels at scale 1")] = 48.0,
    kind: Annotated[Kind, Field(description="red bricks in light mortar, or grey pavers with sand between")] = "wall",
    slant: Slant = 0.0,
    tilt: Tilt = 0.0,
    field_of_view: FieldOfView = 45.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Masonry:
    """Bevelled bricks of several tones with chipped edges, in running bond; courses lie level in the picture.

    Parameters
    ----------
    slant, tilt, field_of_view
        The plane's pose, as in ScaleFromAngles: tilt 0 is a floor that recedes upwards, 90 a wall that recedes to the
        right.

    Returns
    -------
    image
        Shape (height, width, 3), sRGB-encoded in [0, 1].
    scale
        True relative texel scale; the largest and the smallest multiply to 1.
    centres
        Centres of the bricks inside the picture, (x, y), sorted from top to bottom.
    height
        Shape (height, width, 1): how far the surface stands out, 1 for 7.5 % of a brick's length.

    Raises
    ------
    ValueError
        The horizon is in the picture, or scales would leave [1/8, 8].
    """
    plane = framed_plane(width, height, slant, tilt, field_of_view)
    keys = [int(key) for key in rng.integers(1 << 62, size=8)]

    def paint(region: Region) -> Array:
        ctx.check()
        return _wall(region, size, kind, tilt, keys)

    picture = photograph(plane, paint)
    height_map = np.clip(picture[..., 3:], 0, 1).astype(np.float32)
    return Masonry(
        encoded(picture[..., :3]), plane.scale().astype(np.float32), _centres(plane, size, kind, tilt), height_map
    )


def _wall(region: Region, size: float, kind: Kind, tilt: float, keys: list[int]) -> Array:
    """Linear light and height in parts of the highest (rows, columns, 4)."""
    right, up = upright(region, tilt)
    course_height = PROPORTION[kind]
    right = (right / size).astype(np.float32) + 0.010 * noise(region, 0.35 * size, keys[0])
    up = (up / size).astype(np.float32) + 0.010 * noise(region, 0.35 * size, keys[1])
    course = np.floor(up / course_height)
    right = right + 0.5 * (course % 2)
    number = np.floor(right)
    i, j = course.astype(np.int64), number.astype(np.int64)
    lots = scatter_cells(i, j, [keys[2], keys[5], keys[6], keys[7], keys[6] + 1])
    # distances from the brick's middle, of a brick that is a little turned and moved
    x = right - number - 0.5 + 0.012 * (lots[1] - 0.5)
    y = up - (course + 0.5) * course_height + 0.012 * (lots[2] - 0.5)
    y = y + 0.025 * (lots[3] - 0.5) * x
    grain = fractal(region, 0.05 * size, keys[3], 3)
    mottle = fractal(region, 0.28 * size, keys[4], 3)
    depth = _depth_inside(x, y, course_height, kind) + 0.006 * grain + 0.010 * mottle
    inside = np.clip(depth / 0.012 + 0.5, 0, 1)
    bevel = np.clip(depth / 0.045, 0, 1)
    relief = 0.050 * inside * (0.35 + 0.65 * bevel * (2 - bevel))
    relief += inside * (0.0035 * mottle + 0.0030 * grain + 0.008 * (lots[2] - 0.5))
    relief += (1 - inside) * 0.0045 * fractal(region, 0.03 * size, keys[5] + 1, 2)
    heights = (relief * size).astype(np.float32)
    sun = shading(heights, region, tilt, elevation=44, reach=0.09 * size, softness=0.012 * size)
    sky = openness(heights, region, 0.05 * size, 1.6)
    light = sun[..., None] * np.array([0.82, 0.78, 0.70], np.float32)
    light = light + sky[..., None] * np.array([0.22, 0.25, 0.30], np.float32)
    palette = linear(PALETTES[kind])
    tone = lots[0] * (len(palette) - 1)
    below = tone.astype(np.intp)
    fired = (
        palette[below] + (palette[np.minimum(below + 1, len(palette) - 1)] - palette[below]) * (tone - below)[..., None]
    )
    burnt = np.clip((lots[4] - 0.93) * 30, 0, 0.55)  # a few bricks are nearly black
    shade = (1 - burnt) * (0.9 + 0.25 * lots[1]) * (1 + 0.22 * mottle + 0.20 * grain)
    mortar = linear(MORTAR[kind]) * (1 + 0.16 * grain + 0.12 * mottle)[..., None]
    albedo = fired * shade[..., None] * inside[..., None] + mortar * (1 - inside)[..., None]
    return np.concatenate([albedo * light, ((relief + 0.01) / HIGHEST)[..., None]], axis=2)


def _depth_inside(x: Array, y: Array, course_height: float, kind: Kind) -> Array:
    """Distance to the brick's outline, a rectangle with round corners, positive inside."""
    corner = 0.03
    dx = np.abs(x) - (0.5 - JOINT[kind] / 2 - corner)
    dy = np.abs(y) - (course_height / 2 - JOINT[kind] / 2 - corner)
    outside = np.hypot(np.maximum(dx, 0), np.maximum(dy, 0)) + np.minimum(np.maximum(dx, dy), 0)
    depth: Array = corner - outside
    return depth


def _centres(plane: Plane, size: float, kind: Kind, tilt: float) -> Array:
    """Array coordinates of the centres of all bricks in the picture."""
    sin, cos = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    u, v = visible_corners(plane).T
    right, up = u * cos + v * sin, v * cos - u * sin
    courses = np.arange(np.floor(up.min() / size / PROPORTION[kind]), np.ceil(up.max() / size / PROPORTION[kind]) + 1)
    numbers = np.arange(np.floor(right.min() / size) - 1, np.ceil(right.max() / size) + 2)
    course, number = (grid.ravel() for grid in np.meshgrid(courses, numbers, indexing="ij"))
    right = (number + 0.5 - 0.5 * (course % 2)) * size
    up = (course + 0.5) * PROPORTION[kind] * size
    return visible_centres(plane, np.stack([right * cos - up * sin, right * sin + up * cos], axis=1))
