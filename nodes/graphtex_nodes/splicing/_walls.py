"""Walls laid anew: a cell for each block, and the block drawn into it."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.splicing._blocks import CORNERS, SMOOTH, Blocks
from graphtex_nodes.splicing._polygons import around, evenly, mean_value_coordinates

Array = NDArray[Any]

RIVALS = 7
"""Nearest blocks of which one gets a pixel."""
FINER = 8
"""Points between corners of an outline to which pixels of joints are nearest."""
BESIDE = 3
"""Pixels around a cell that smoothing its border looks at."""
LEAST = 9
"""Pixels of a cell that are needed to tell its form."""


class Cells(NamedTuple):
    """Which place each pixel (h, w) belongs to, and how far, up to 1 pixel, it is from the border of its cell."""

    owner: Array
    depth: Array


def cells(places: Array, forms: Array, size: tuple[int, int]) -> Cells:
    """Divide a picture (height, width) among two or more places (n, 2), at each of which a block goes.

    A pixel belongs to the place whose block, as an ellipse of its ``forms`` (n, 2, 2), would have to grow least to
    reach it: an anisotropic Voronoi diagram (Labelle & Shewchuk 2003).
    """
    from scipy.spatial import cKDTree

    pixels = np.stack(np.meshgrid(np.arange(size[1]), np.arange(size[0])), axis=-1).reshape(-1, 2)
    a, b, c = forms[:, 0, 0], forms[:, 0, 1], forms[:, 1, 1]
    metric = np.stack([c, -2 * b, a], axis=1) / (a * c - b * b)[:, None]  # of the inverse
    near = np.asarray(cKDTree(places).query(pixels, k=[*range(1, min(RIVALS, len(places)) + 1)])[1]).T
    growth = np.stack([_growth(pixels - places[own], metric[own]) for own in near])
    first = growth.argmin(axis=0)[None]
    owner, least = np.take_along_axis(near, first, 0)[0], np.take_along_axis(growth, first, 0)[0]
    np.put_along_axis(growth, first, np.inf, 0)
    second = growth.argmin(axis=0)[None]
    rival, more = np.take_along_axis(near, second, 0)[0], np.take_along_axis(growth, second, 0)[0]
    # growth of the two is equal on the border, and their difference about linear there
    apart = [
        _growth(pixels + step - places[rival], metric[rival]) - _growth(pixels + step - places[owner], metric[owner])
        for step in ((0.5, 0), (-0.5, 0), (0, 0.5), (0, -0.5))
    ]
    slope = np.hypot(apart[0] - apart[1], apart[2] - apart[3])
    depth = np.minimum((more - least) / np.maximum(slope, 1e-6), 1.0)
    return Cells(owner.reshape(size), depth.reshape(size))


def _growth(offsets: Array, metric: Array) -> Array:
    """Offsets (m, 2) from middles in units of ellipses (m, 3)."""
    x, y = offsets.T
    xx, xy, yy = metric.T
    result: Array = np.sqrt(xx * x * x + xy * x * y + yy * y * y)
    return result


def turned(forms: Array, angles: Array, scales: Array) -> Array:
    """Covariances (n, 2, 2) of what is turned by angles (degrees, clockwise) and sized."""
    cos, sin = np.cos(np.radians(angles)), np.sin(np.radians(angles))
    turn = np.array([[cos, -sin], [sin, cos]]).transpose(2, 0, 1)
    result: Array = np.einsum("nij,njk,nlk->nil", turn, forms, turn) * scales[:, None, None] ** 2
    return result


def cell_forms(owner: Array, count: int) -> Array:
    """Covariances (count, 2, 2) of cells (h, w); the median's for those of hardly any pixels."""
    rows, columns = np.indices(owner.shape).reshape(2, -1)
    index = owner.ravel()
    size = np.maximum(np.bincount(index, minlength=count), 1)
    apart = [values - (np.bincount(index, values, count) / size)[index] for values in (columns, rows)]
    spread = [[np.bincount(index, one * other, count) / size for one in apart] for other in apart]
    forms: Array = np.array(spread).transpose(2, 0, 1) + np.eye(2) / 12
    large = size >= LEAST
    if large.any():
        forms[~large] = np.median(forms[large], axis=0)
    return forms


def drawn(
    divided: Cells, number: int, part: tuple[slice, slice], wanted: Array, kind: int, angle: float, blocks: Blocks
) -> tuple[Array, Array]:
    """For some pixels of a cell, in order, their places (m, 2) in the wall's picture, and which are not joint.

    The outline of the block, turned by an angle, is laid around what is left of the cell without half a joint along its
    border, with corners as round as the block's: its inside follows (mean value coordinates). In the joint, pixels as
    far from the outline as there are in the wall.
    """
    corner = np.array([part[1].start, part[0].start])
    field = _left(divided, number, part, blocks)
    outline = around(field, corner)
    rows, columns = np.nonzero(wanted)
    pixels = np.stack([columns, rows], axis=1) + corner
    own = blocks.outlines[kind]
    if outline is None:
        joint = own[0] + blocks.outward[kind, 0] * blocks.reach[kind, 0]
        return np.tile(joint, (len(pixels), 1)), np.zeros(len(pixels), bool)
    outline = evenly(outline, CORNERS)
    first = _start(own, outline, angle)
    own, outward, reach = (np.roll(each[kind], -first, axis=0) for each in blocks[:3])
    inside = field[rows, columns] > 0
    places = np.empty((len(pixels), 2))
    weights = mean_value_coordinates(pixels[inside], outline)
    places[inside] = np.einsum("mk,kd->md", weights, own)
    places[~inside] = _beside(pixels[~inside], outline, own, outward, reach, blocks.joint)
    return places, inside


def _left(divided: Cells, number: int, part: tuple[slice, slice], blocks: Blocks) -> Array:
    """Positive (h, w) in what is left of a cell for its block."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter

    wide = tuple(slice(max(0, side.start - BESIDE), side.stop + BESIDE) for side in part)
    before = [side.start - more.start for side, more in zip(part, wide, strict=True)]
    cell = divided.owner[wide] == number
    if cell.all():
        return np.ones(cell.shape)
    beyond = divided.depth[wide]
    distance, (row, column) = distance_transform_edt(cell, return_indices=True)
    depth = np.where(cell, distance - beyond[row, column], -beyond) - blocks.joint
    corner = min(blocks.round, depth.max() - 1)
    if corner > 0:
        core = depth > corner
        away, (row, column) = distance_transform_edt(~core, return_indices=True)
        depth = np.where(core, depth, depth[row, column] - away)
    field: Array = gaussian_filter(depth, SMOOTH)
    return field[tuple(slice(first, first + side.stop - side.start) for first, side in zip(before, part, strict=True))]


def _start(own: Array, outline: Array, angle: float) -> int:
    """Which corner of a block's outline, turned, is laid on the first one of another, so that they agree best."""
    one, other = ((each - each.mean(axis=0)) / each.std() for each in (own, outline))
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    one = np.stack([cos * one[:, 0] - sin * one[:, 1], sin * one[:, 0] + cos * one[:, 1]], axis=1)
    corners = np.arange(len(one))
    agreement = np.einsum("skd,kd->s", one[(corners[:, None] + corners) % len(one)], other)
    return int(agreement.argmax())


def _beside(pixels: Array, outline: Array, own: Array, outward: Array, reach: Array, joint: float) -> Array:
    """Places (m, 2) of pixels in the joint around an outline."""
    from scipy.spatial import cKDTree

    line, own, outward, reach = (_finer(each) for each in (outline, own, outward, reach))
    distance, nearest = cKDTree(line).query(pixels)
    share = np.minimum(1.0, np.asarray(distance) / joint)
    places: Array = own[nearest] + outward[nearest] * (reach[nearest] * share)[:, None]
    return places


def _finer(values: Array) -> Array:
    """Values (n, ...) at corners, and between them."""
    share = (np.arange(FINER) / FINER).reshape(1, -1, *[1] * (values.ndim - 1))
    between = values[:, None] * (1 - share) + np.roll(values, -1, axis=0)[:, None] * share
    result: Array = between.reshape(-1, *values.shape[1:])
    return result
