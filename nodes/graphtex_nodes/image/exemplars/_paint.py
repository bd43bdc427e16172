"""What the procedural exemplars share: noise and elements that are fixed to the plane, light, colour."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.plane import Plane, Region

Array = NDArray[Any]

BATCH = 200_000  # values worked on at once: what a cache holds
LIGHT = (-0.64, 0.77)  # where the light comes from in the picture (right, up): the upper left


def light_on_plane(tilt: float) -> tuple[float, float]:
    """Direction towards the light in plane coordinates (across, along), such that it stays at the upper left."""
    sin, cos = float(np.sin(np.radians(tilt))), float(np.cos(np.radians(tilt)))
    return LIGHT[0] * cos - LIGHT[1] * sin, LIGHT[0] * sin + LIGHT[1] * cos


def upright(region: Region, tilt: float) -> tuple[Array, Array]:
    """Plane coordinates (right, up) turned so that a pattern keeps its direction in the picture for any tilt."""
    sin, cos = np.sin(np.radians(tilt)), np.cos(np.radians(tilt))
    u, v = region.u[None, :], region.v[:, None]
    return u * cos + v * sin, v * cos - u * sin


def linear(colour: Any) -> Array:
    """Linear light of sRGB-like colours (a power of 2.2 is near enough for invented materials)."""
    return np.clip(np.asarray(colour, np.float32), 0, None) ** np.float32(2.2)


def encoded(light: Array) -> Array:
    """Float32 picture in [0, 1] of linear light."""
    return (np.clip(light, 0, 1) ** (1 / 2.2)).astype(np.float32)


def scatter(i: Array, j: Array, key: int) -> Array:
    """Uniform numbers in [0, 1), float32, that hang on the integers i, j (broadcast) and the key alone."""
    state = i.astype(np.int64).view(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    state = state ^ (j.astype(np.int64).view(np.uint64) * np.uint64(0xC2B2AE3D27D4EB4F) + np.uint64(key))
    for shift, factor in ((33, 0xFF51AFD7ED558CCD), (29, 0xC4CEB9FE1A85EC53)):
        state = (state ^ (state >> np.uint64(shift))) * np.uint64(factor)
    return ((state ^ (state >> np.uint64(32))) >> np.uint64(40)).astype(np.float32) / np.float32(1 << 24)


def scatter_cells(i: Array, j: Array, keys: list[int]) -> list[Array]:
    """`scatter` for each key where many places share a cell: i, j, integer arrays of one shape, span few cells."""
    first, other = int(i.min()), int(j.min())
    rows, columns = np.arange(first, int(i.max()) + 1)[:, None], np.arange(other, int(j.max()) + 1)[None, :]
    cell = (i - first) * columns.size + (j - other)
    return [scatter(rows, columns, key).ravel()[cell] for key in keys]


def noise(region: Region, cell: float, key: int, *, stretch: float = 1.0) -> Array:
    """Value noise in [-1, 1], float32 (rows, columns), on lattice cells of `cell` plane units (times `stretch` along).

    Cells below a texel fade to 0, the mean, which is what a camera would see of them.
    """
    strength = float(np.clip(2 * cell * region.density - 1, 0, 1))
    if strength == 0:
        return np.zeros((region.rows, region.columns), np.float32)
    axes = []
    for position, step in ((region.v, cell * stretch), (region.u, cell)):
        place = position / step
        below = np.floor(place)
        t = (place - below).astype(np.float32)
        axes.append((below.astype(np.int64), t * t * (3 - 2 * t)))
    (i, down), (j, right) = axes
    knots = 2 * scatter(np.arange(i[0], i[-1] + 2)[:, None], np.arange(j[0], j[-1] + 2)[None, :], key) - 1
    left, top = j - j[0], i - i[0]
    wide = knots[:, left] * (1 - right) + knots[:, left + 1] * right
    values: Array = wide[top] * (1 - down)[:, None] + wide[top + 1] * down[:, None]
    return values * np.float32(strength)


def fractal(region: Region, cell: float, key: int, octaves: int = 3, *, stretch: float = 1.0) -> Array:
    """Sum of octaves of `noise`, each half as large and half as strong; roughly in [-1, 1]."""
    total = noise(region, cell, key, stretch=stretch)
    for octave in range(1, octaves):
        total = total + noise(region, cell / 2**octave, key + octave, stretch=stretch) * np.float32(0.5**octave)
    return total * np.float32(0.7)


def visible_corners(plane: Plane) -> Array:
    """The picture's corners in plane coordinates, (4, 2) in order around."""
    x = np.array([-0.5, plane.width - 0.5, plane.width - 0.5, -0.5])
    y = np.array([-0.5, -0.5, plane.height - 0.5, plane.height - 0.5])
    return np.stack(plane.to_plane(*plane.rotate(x, y)), axis=1)


def scattered_points(plane: Plane, spacing: float, rng: np.random.Generator, *, margin: float, jitter: float) -> Array:
    """Points (n, 2) of a jittered hexagonal lattice on the visible part of the plane and `margin` units around it."""
    corners = visible_corners(plane)
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    step = np.array([spacing * np.sqrt(2 / np.sqrt(3)), spacing * np.sqrt(np.sqrt(3) / 2)])
    columns, rows = (int(n) + 2 for n in (high - low) / step)
    row, column = np.mgrid[:rows, :columns]
    points = np.stack([(column + 0.5 * (row % 2)) * step[0] + low[0], row * step[1] + low[1]], axis=-1).reshape(-1, 2)
    points = points + rng.uniform(-0.5, 0.5, points.shape) * step * jitter
    kept: Array = points[_inside(points, corners, margin)]
    return kept


def _inside(points: Array, corners: Array, margin: float) -> Array:
    """Which points lie in a convex quadrilateral or less than `margin` outside each of its sides."""
    middle = corners.mean(axis=0)
    kept: Array = np.ones(len(points), bool)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        normal = np.array([end[1] - start[1], start[0] - end[0]]) / np.hypot(*(end - start))
        if (middle - start) @ normal > 0:
            normal = -normal
        kept &= (points - start) @ normal <= margin
    return kept


def visible_centres(plane: Plane, points: Array) -> Array:
    """Array coordinates (n, 2) of those plane points that fall inside the picture, top to bottom, left to right."""
    with np.errstate(divide="ignore", invalid="ignore"):  # points behind the camera project anywhere and are dropped
        x, y = plane.to_picture(points[:, 0], points[:, 1])
    kept = (x >= 0) & (y >= 0) & (x <= plane.width - 1) & (y <= plane.height - 1)
    if plane.steepness:
        kept &= 1 + plane.steepness * plane.centre_scale * plane.foreshortening * points[:, 1] > 0
    centres: Array = np.stack([x[kept], y[kept]], axis=1)
    # rows of a regular pattern must not be shuffled by rounding
    return centres[np.lexsort((centres[:, 0], centres[:, 1].round(6)))]


def lay(
    centres: Array,
    reach: Array,
    rise: Callable[[Array, Array, Array], Array],
    region: Region,
    ground: Array,
    owner: Array,
    *,
    first: int = 0,
) -> None:
    """Lay elements on the ground: where one rises above it, `ground` takes its height and `owner` its number.

    Parameters
    ----------
    centres, reach
        Places (n, 2) and radii (n,) that hold the elements, plane units.
    rise
        `rise(some, du, dv)` gives heights (k, side, side) of the elements `some` (k,) at offsets du, dv (k, side) from
        their centres.
    ground, owner
        Arrays of the region, changed in place.
    first
        Number of the first element in `owner`.
    """
    near = (
        (centres[:, 0] > region.u[0] - reach)
        & (centres[:, 0] < region.u[-1] + reach)
        & (centres[:, 1] > region.v[0] - reach)
        & (centres[:, 1] < region.v[-1] + reach)
    )
    numbers = np.flatnonzero(near)
    if not len(numbers):
        return
    numbers = numbers[np.argsort(reach[numbers], kind="stable")]  # windows of one size at a time
    values = len(numbers) * (2 * reach[numbers].max() * region.density + 2) ** 2
    for some in np.array_split(numbers, max(1, min(len(numbers), int(values / BATCH)))):
        around = reach[some[-1]]
        side = int(np.ceil(2 * around * region.density)) + 1
        column = np.floor((centres[some, 0] - around - region.u0) * region.density).astype(int)
        row = np.floor((centres[some, 1] - around - region.v0) * region.density).astype(int)
        du = region.u0 + (column[:, None] + np.arange(side)) / region.density - centres[some, 0, None]
        dv = region.v0 + (row[:, None] + np.arange(side)) / region.density - centres[some, 1, None]
        heights = rise(some, du.astype(np.float32), dv.astype(np.float32))
        for number, i, j, patch in zip(some.tolist(), row.tolist(), column.tolist(), heights, strict=True):
            top, left, bottom, right = max(i, 0), max(j, 0), max(i + side, 0), max(j + side, 0)
            window = ground[top:bottom, left:right]
            inside = patch[top - i : top - i + window.shape[0], left - j : left - j + window.shape[1]]
            if inside.size and inside.shape == window.shape:
                higher = inside > window
                np.copyto(window, inside, where=higher)
                np.copyto(owner[top:bottom, left:right], first + number, where=higher)


def shading(height: Array, region: Region, tilt: float, *, elevation: float, reach: float, softness: float) -> Array:
    """Share of the lamp's light that each texel of a height field gets: Lambert's cosine times cast shadow.

    Height is in plane units; `elevation` is the lamp's in degrees; shadows are followed over `reach` units and fade
    over `softness` units of height. 1 is a flat texel in full light.
    """
    light_u, light_v = light_on_plane(tilt)
    sin, cos = np.float32(np.sin(np.radians(elevation))), np.float32(np.cos(np.radians(elevation)))
    slope_v, slope_u = np.gradient(height * np.float32(region.density))
    cosine = (sin - cos * (slope_u * np.float32(light_u) + slope_v * np.float32(light_v))) / np.sqrt(
        1 + slope_u**2 + slope_v**2
    )
    blocked = np.full_like(height, -np.inf)
    steps = max(2, min(10, int(reach * region.density)))
    for distance in np.linspace(reach / steps, reach, steps):
        shifted = _shifted(
            height, round(light_v * distance * region.density), round(light_u * distance * region.density)
        )
        np.maximum(blocked, shifted - np.float32(distance * sin / cos), out=blocked)
    shadow = np.clip((blocked - height) / np.float32(softness), 0, 1)
    lit: Array = np.clip(cosine / sin, 0, None) * (1 - shadow)
    return lit


def _shifted(values: Array, down: int, right: int) -> Array:
    """values[i + down, j + right], the border repeated."""
    rows = np.clip(np.arange(values.shape[0]) + down, 0, values.shape[0] - 1)
    columns = np.clip(np.arange(values.shape[1]) + right, 0, values.shape[1] - 1)
    return values[rows][:, columns]


def openness(height: Array, region: Region, radius: float, strength: float) -> Array:
    """Share of the sky's light that reaches each texel: falls where a texel lies deeper than its surroundings."""
    from scipy.ndimage import gaussian_filter

    depth = gaussian_filter(height, radius * region.density, mode="nearest", truncate=2.0) - height
    return np.clip(1 - np.float32(strength / radius) * depth, 0.15, 1.15)
