"""The warped texture drawn triangle by triangle (Liu et al. 2009, section 4.2, fig. 6)."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Displacement, Image, Mask, SourceMap, node
from graphtex_nodes.numerics.jit import announce
from graphtex_nodes.numerics.parallel import for_rows
from graphtex_nodes.splicing._stiffness import RULES
from graphtex_nodes.splicing.tags import checked_tag
from graphtex_nodes.splicing.texton_labels import with_rim
from graphtex_nodes.splicing.values import Extension, Moves

Array = NDArray[Any]

PARTING = 2.0
"""The longest edge between elements that touch: farther, they part instead of being drawn out."""


class Drawing(NamedTuple):
    """The first picture of a splice, and what is still missing."""

    image: Image
    mask: Mask
    source: SourceMap
    holes: Mask


@node
def rasterize(
    elements: Extension,
    moves: Moves,
    warp: Displacement,
    *,
    longest: Annotated[
        float, Field(gt=0, le=64, description="triangles with a longer edge (pixels) are left out, a hole remains")
    ] = 4.0,
    surplus: Annotated[bool, Field(description="draw elements that were given no place, too")] = False,
    ctx: Context = QUIET,
) -> Drawing:
    """Draw the window of a warped texture: each pixel from the triangle of source pixels that covers it.

    The extension's pixel centres are vertices of triangles, two for each square of four. Where several warped triangles
    cover a pixel, the one whose vertices have the largest sum of rigid mask values counts; a triangle that the warp has
    turned over has half a vertex less. The coordinates within it are barycentric, colours bilinear.

    Parameters
    ----------
    elements, moves, warp
        An extension, where its textons go, and its displacement (h, w, 2).
    surplus
        Without, elements of the tag F=d that were given no place, or in which no texton was found, are not drawn, nor
        their rims.

    Returns
    -------
    image
        (height, width, c) of the window, 0 in holes.
    mask
        Foreground of it.
    source
        Row and column in the texture that was extended, between pixels too; -1 in holes.
    holes
        Pixels that no triangle covers.

    Raises
    ------
    ValueError
        The warp or the moves do not have the extension's size.
    """
    shape = elements.mask.shape
    if warp.shape[:2] != shape:
        raise ValueError(f"warp: expected shape {(*shape, 2)} as elements, got {warp.shape}")
    if len(moves.points) != len(elements.points):
        raise ValueError(f"moves: expected {len(elements.points)} textons as elements, got {len(moves.points)}")
    announce(ctx, "warp_kernels")
    from graphtex_nodes.splicing import warp_kernels

    tag = checked_tag(elements.tag, "elements.tag")
    rigid = elements.mask if RULES[tag].foreground else ~elements.mask
    kept = np.ones(shape, bool)
    if tag == "F=d" and not surplus:
        placed = np.append(moves.matched > 0, False)
        given = elements.mask & placed[elements.labels]
        kept = ~with_rim(elements.mask & ~given) | given
    height, width = elements.height, elements.width
    grid = np.moveaxis(np.mgrid[: shape[0], : shape[1]][::-1], 0, -1)
    places = np.ascontiguousarray(grid + warp - (elements.left, elements.top), np.float32)
    best = np.full((height, width), -1.0, np.float32)
    found = np.zeros((height, width, 2), np.float32)
    flags, weight = kept.view(np.uint8), rigid.astype(np.float32)
    bodies = elements.labels if tag == "F=d" else np.full(shape, -1, np.int32)
    parting = min(longest, PARTING) ** 2

    def band(first: int, stop: int) -> None:
        warp_kernels.rasterize(places, flags, weight, bodies, longest**2, parting, best, found, first, stop)

    for_rows(band, height, 40.0 * width, ctx)
    holes = best < 0
    image = sampled(elements.image, found)
    mask = sampled(elements.mask[..., None].astype(np.float32), found)[..., 0] > 0.5
    image[holes], mask[holes] = 0, False
    return Drawing(image, mask, _source(elements, found, holes), holes)


def sampled(image: Array, places: Array) -> Array:
    """Bilinear values at places (h, w, 2), x and y within the image."""
    height, width = image.shape[:2]
    left = np.minimum(places[..., 0].astype(np.int64), max(width - 2, 0))
    top = np.minimum(places[..., 1].astype(np.int64), max(height - 2, 0))
    right, bottom = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    across, down = (places[..., 0] - left)[..., None], (places[..., 1] - top)[..., None]
    upper = image[top, left] * (1 - across) + image[top, right] * across
    lower = image[bottom, left] * (1 - across) + image[bottom, right] * across
    result: Array = (upper * (1 - down) + lower * down).astype(np.float32)
    return result


def _source(elements: Extension, places: Array, holes: Array) -> Array:
    """Source map of places in the extension: those of the nearest pixel, carried on by the rest."""
    nearest = np.rint(places).astype(np.int64)
    source: Array = elements.source[nearest[..., 1], nearest[..., 0]].copy()
    source[..., 1:3] += (places - nearest)[..., ::-1]
    source[holes] = -1
    source[holes, 3:] = 0
    return source
