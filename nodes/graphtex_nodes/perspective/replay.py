"""Replays a synthesis: its source map applied to other maps of the same exemplars."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, SourceMap, node
from graphtex_nodes.numerics import seam_neighbours
from graphtex_nodes.numerics.materials import MapKind, renormalised, require_stack
from graphtex_nodes.numerics.sources import Look, continued

Array = NDArray[Any]

BAND = 1 << 18  # pixels at a time


@node
def replay(
    source: Annotated[SourceMap, Axes("h w six")],
    maps: list[Image],
    known: Annotated[Mask, Axes("h w")] | None = None,
    *,
    factor: Annotated[
        float, Field(gt=0, le=16, description="how many pixels of the maps make one of the exemplars, along a side")
    ] = 1.0,
    vote: Annotated[
        Literal["discrete", "blend"], Field(description="discrete: pure copies; blend: pieces fade into each other")
    ] = "discrete",
    kinds: Annotated[
        list[MapKind], Field(max_length=16, description="what the channels are, as for StackMaps; none: no normals")
    ] = [],  # noqa: B006 (parameters are copied)
    ctx: Context = QUIET,
) -> Image:
    """Make of other maps of the exemplars what a synthesis made of the exemplars.

    So a synthesis of small colour pictures serves normals, heights and larger versions of them, which then agree with
    each other: the maps of an exemplar are copied from the places that the source map names.

    Parameters
    ----------
    source
        (h, w, 6), as Optimize gives it. Mirrored, turned and resampled sources are shown so.
    maps
        A map of each exemplar, in the order of their indices. Pixels that Optimize was told are known have the index
        behind the last exemplar: for them give a map of the start picture, last.
    known
        Those pixels: what they show fades into nothing.
    factor
        Maps of four times the exemplars' sides, with ``factor: 4``, give an output of four times the sides.
    vote
        ``discrete`` repeats a discrete vote to the bit; ``blend`` repeats a blended one but for rounding (colours
        beside known pixels, that were bent to meet them, and exemplars that were not wholly usable apart).
    kinds
        Normals are turned with their sources and made unit vectors again where they are off by more than 1 %.

    Returns
    -------
    Image
        (h * factor, w * factor, c), rounded.

    Raises
    ------
    ValueError
        There are too few maps, their channels differ, or a map is too small for the places that the source map names.

    Examples
    --------
    >>> source = np.zeros((1, 2, 6), np.float32)
    >>> source[0, :, 2] = [2, 0]  # columns
    >>> replay(source, [np.float32([[[0], [0.5], [1]]])])[..., 0]
    array([[1., 0.]], dtype=float32)
    """
    _require_maps(source, maps, factor)
    channels = maps[0].shape[2]
    for number, picture in enumerate(maps):
        require_stack(f"maps[{number}]", picture, kinds, ctx.warn)
    looks = [Look(picture, kinds) for picture in maps]
    height, width = (max(1, round(side * factor)) for side in source.shape[:2])
    result = np.empty((height, width, channels), np.float32)
    columns, right = _pixels(0, width, source.shape[1], factor)
    free = np.ones(source.shape[:2], bool) if known is None else ~known
    mixed = seam_neighbours.near_seams(source, free) if vote == "blend" else np.zeros(source.shape[:2], bool)
    rows_at_once = max(1, BAND // width)
    for first in range(0, height, rows_at_once):
        rows, down = _pixels(first, min(height, first + rows_at_once), source.shape[0], factor)
        band = result[first : first + len(rows)]
        offsets = [part.ravel() for part in np.broadcast_arrays(down[:, None], right)]
        copied = _look(looks, source[np.ix_(rows, columns)].reshape(-1, 6), offsets, factor)
        band[...] = copied.reshape(band.shape)
        y, x = np.nonzero(mixed[np.ix_(rows, columns)])
        if len(y):
            place, parent = np.unique(rows[y] * source.shape[1] + columns[x], return_inverse=True)
            around = seam_neighbours.around(source, free, *np.divmod(place, source.shape[1]))
            band[y, x] = renormalised(_mixture(looks, around, parent, [down[y], right[x]], factor), kinds)
        ctx.progress(min(1.0, (first + len(rows)) / height), "copying")
    return result


def _require_maps(source: Array, maps: list[Array], factor: float) -> None:
    index = source[..., 0]
    if (index != np.rint(index)).any() or index.min() < 0:
        raise ValueError("source: expected whole indices of exemplars from 0 on in its first channel")
    most = int(index.max())
    if most >= len(maps):
        raise ValueError(
            f"maps: the source map names exemplar {most}, so at least {most + 1} are needed, got {len(maps)}"
            " (known pixels of a synthesis have the index behind the last exemplar)"
        )
    for number, picture in enumerate(maps):
        if picture.shape[2] != maps[0].shape[2]:
            raise ValueError(
                f"maps[{number}]: expected {maps[0].shape[2]} channels as maps[0] has, got {picture.shape[2]}"
            )
        own = source[index == number]
        for axis, side in ((1, "row"), (2, "column")):
            last = np.rint(own[:, axis].max(initial=0))
            if (last + 1) * factor - 0.5 > picture.shape[axis - 1] or own[:, axis].min(initial=0) < 0:
                raise ValueError(
                    f"maps[{number}]: the source map names {side}s from {own[:, axis].min():g} to "
                    f"{own[:, axis].max():g} of exemplar {number}, too many for shape {picture.shape} with "
                    f"factor {factor:g}"
                )


def _pixels(first: int, stop: int, count: int, factor: float) -> tuple[Array, Array]:
    """For pixels of the output, along an axis: the pixel of the source map, and how far from its middle they lie."""
    place = (np.arange(first, stop) + 0.5) / factor - 0.5
    nearest = np.clip(np.rint(place - 1e-9), 0, count - 1).astype(np.intp)
    return nearest, place - nearest


def _look(looks: list[Look], points: Array, offset: list[Array], factor: float) -> Array:
    """Values (n, c) at an offset (down, right) in output pixels from points (n, 6) of a source map."""
    places = continued(points, *offset)
    points = points.astype(np.float64)
    if factor != 1:
        places = (places + 0.5) * factor - 0.5
        whole = np.rint(places)
        places = np.where(np.abs(places - whole) < 1e-6, whole, places)
    points[:, 1:3] = places
    result = np.empty((len(points), looks[0].exemplar.shape[2]), np.float32)
    for number, look in enumerate(looks):
        own = points[:, 0] == number
        if own.any():
            result[own] = look.at(points[own])
    return result


def _mixture(
    looks: list[Look], around: seam_neighbours.Around, parent: Array, offset: list[Array], factor: float
) -> Array:
    """Weighted mean (n, c) of what the pieces around show, each continued up to the pixels.

    Pixels lie at an ``offset`` (down, right) from pixels of the source map, whose numbers in ``around`` are their
    ``parent``.
    """
    apart = [part[:, None] - seam_neighbours.OFFSETS[:, axis] for axis, part in enumerate(offset)]
    weights = np.exp(-2 * (apart[0] ** 2 + apart[1] ** 2) / seam_neighbours.RADIUS**2)
    shapes = np.array([look.exemplar.shape[:2] for look in looks]) / factor
    total = np.zeros((len(parent), looks[0].exemplar.shape[2]))
    sums = np.zeros((len(parent), 1))
    for number in range(len(seam_neighbours.OFFSETS)):
        chosen = np.flatnonzero(around.first[parent, number] == number)
        points = around.points[parent[chosen], number]
        inside = np.ones(len(chosen), bool)
        if number > 0:  # a pixel's own piece shows its border if need be
            places = continued(points, *(part[chosen] for part in offset))
            inside = ((places > -0.5) & (places < shapes[points[:, 0].astype(np.intp)] - 0.5)).all(axis=1)
        chosen, points = chosen[inside], points[inside]
        if len(chosen):
            alike = around.first[parent[chosen]] == number
            weight = (weights[chosen] * alike).sum(axis=1, keepdims=True)
            total[chosen] += weight * _look(looks, points, [part[chosen] for part in offset], factor)
            sums[chosen] += weight
    mean: Array = (total / sums).astype(np.float32)
    return mean
