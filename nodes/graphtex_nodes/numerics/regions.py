"""Regions of a picture as plain data: strokes, polygons, rectangles, ellipses, masks, with soft edges."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from graphtex_nodes.numerics.strokes import Measured, Place, Strokes, polyline_distance, soft_step, stroke_weights

Array = NDArray[Any]
Softness = Annotated[float, Field(ge=0, description="width of the soft edge; half of it lies outside")]
Radius = Annotated[float, Field(gt=0)]

SIDES = 180  # of the polygon that stands for an ellipse: off by 0.015 % of its radius


class Whole(BaseModel):
    """All of the picture."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: Literal["whole"] = "whole"


class Brushed(BaseModel):
    """What strokes cover."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: Literal["strokes"] = "strokes"
    strokes: Strokes
    label: Annotated[str | None, Field(description="only the strokes of this label; none: all")] = None


class Polygon(Measured):
    """The inside of a closed polygon; where it crosses itself, the even-odd rule holds."""

    kind: Literal["polygon"] = "polygon"
    points: Annotated[tuple[Place, ...], Field(min_length=3, description="x, y of the corners, in order")]
    softness: Softness = 0


class Rectangle(Measured):
    """An upright rectangle. In pixels, -0.5 is the picture's left edge."""

    kind: Literal["rectangle"] = "rectangle"
    corner: Annotated[Place, Field(description="x, y of one corner")]
    opposite: Annotated[Place, Field(description="x, y of the opposite corner")]
    softness: Softness = 0


class Ellipse(Measured):
    """An ellipse."""

    kind: Literal["ellipse"] = "ellipse"
    centre: Annotated[Place, Field(description="x, y of the middle")]
    radii: Annotated[tuple[Radius, Radius], Field(description="half axes, along x and y before it is turned")]
    angle: Annotated[float, Field(ge=-360, le=360, description="turned by, degrees clockwise")] = 0
    softness: Softness = 0


class Masked(BaseModel):
    """The True pixels of one of the masks that the node is given, which has the size of the picture."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    kind: Literal["mask"] = "mask"
    index: Annotated[int, Field(ge=0, description="which of the masks, counted from 0")] = 0
    softness: Annotated[float, Field(ge=0, description="width of the soft edge in pixels")] = 0


Region: TypeAlias = Annotated[
    Whole | Brushed | Polygon | Rectangle | Ellipse | Masked,
    Field(discriminator="kind", description="where it applies; without it, everywhere"),
]


def region_weights(region: Region, width: int, height: int, masks: Sequence[Array] = ()) -> Array:
    """How much each pixel belongs to a region: float64 (height, width) in [0, 1], all 0 if it lies outside.

    Raises
    ------
    ValueError
        A mask is not there or of another size, or a file of strokes cannot be read.
    """
    if isinstance(region, Whole):
        return np.ones((height, width))
    if isinstance(region, Brushed):
        return stroke_weights(region.strokes, width, height, label=region.label)
    if isinstance(region, Masked):
        return _mask_weights(region, width, height, masks)
    if isinstance(region, Polygon):
        points = np.array(region.points, np.float64)
    elif isinstance(region, Rectangle):
        (x0, y0), (x1, y1) = region.corner, region.opposite
        points = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], np.float64)
    else:
        return _ellipse_weights(region, width, height)
    softness = region.length(region.softness, width, height)
    return polygon_weights(region.places(points, width, height), width, height, softness)


def _ellipse_weights(region: Ellipse, width: int, height: int) -> Array:
    centre = region.places(np.array([region.centre], np.float64), width, height)
    turn = np.arange(SIDES) * (2 * np.pi / SIDES)
    x = region.length(region.radii[0], width, height) * np.cos(turn)
    y = region.length(region.radii[1], width, height) * np.sin(turn)
    cos, sin = np.cos(np.radians(region.angle)), np.sin(np.radians(region.angle))
    points = centre + np.stack([x * cos - y * sin, x * sin + y * cos], axis=1)
    return polygon_weights(points, width, height, region.length(region.softness, width, height))


def _mask_weights(region: Masked, width: int, height: int, masks: Sequence[Array]) -> Array:
    from scipy.ndimage import distance_transform_edt

    if region.index >= len(masks):
        raise ValueError(f"index: the region wants mask {region.index}, counted from 0, got {len(masks)} masks")
    mask = masks[region.index]
    if mask.shape != (height, width):
        raise ValueError(f"masks[{region.index}]: expected the map's size {(height, width)}, got {mask.shape}")
    if region.softness <= 1 or mask.all() or not mask.any():
        return mask.astype(np.float64)
    # the outline runs between pixels: half a pixel from the nearest centre on the other side
    inside = np.where(mask, distance_transform_edt(mask) - 0.5, 0.5 - distance_transform_edt(~mask))
    return soft_step(inside, region.softness)


def polygon_weights(points: Array, width: int, height: int, softness: float) -> Array:
    """How much each pixel lies inside a closed polygon (n, 2) of pixel coordinates, by its distance to the outline."""
    closed = np.concatenate([points, points[:1]])
    distance = polyline_distance(closed, width, height, reach=max(softness, 1) / 2)
    return soft_step(np.where(polygon_mask(closed, width, height), distance, -distance), softness)


def polygon_mask(closed: Array, width: int, height: int) -> Array:
    """Which pixel centres lie inside a polygon (its first point repeated at the end), by the even-odd rule."""
    crossings = np.zeros((height, width + 1), np.int64)
    for (x0, y0), (x1, y1) in pairwise(closed):
        first, last = (int(np.clip(np.ceil(y), 0, height)) for y in sorted((y0, y1)))
        rows = np.arange(first, last)
        if len(rows):
            x = x0 + (rows - y0) * ((x1 - x0) / (y1 - y0))
            crossings[rows, np.ceil(np.clip(x, 0, width)).astype(int)] += 1
    # a pixel is inside if an odd number of sides crosses its row to the right of it
    right: Array = crossings[:, ::-1].cumsum(axis=1)[:, -2::-1] % 2 == 1
    return right
