"""A texture with all that a splice needs of it alone: made once, it serves every arrangement."""

from typing import Annotated, NamedTuple

from pydantic import Field

from graphtex import QUIET, Context, Image, Texture, node, struct_type, view
from graphtex_nodes.image.views import Bytes, view_texture
from graphtex_nodes.splicing.extend_texture import extend_texture
from graphtex_nodes.splicing.factor_warp import factor_warp
from graphtex_nodes.splicing.neighbour_sets import NeighbourSets, neighbour_sets
from graphtex_nodes.splicing.values import Extension, Factor

LARGEST_WINDOW = 256
"""Side of the window that a larger texture gets by itself: the factor of a 512 x 512 window would take 6 GB."""


@struct_type("a texture prepared for splicing")
class PreparedTexture(NamedTuple):
    """A texture, and what depends on it alone: its extension, the factors of its warp, and its similar pixels."""

    texture: Texture
    extension: Extension
    factor_x: Factor
    factor_y: Factor
    sets: NeighbourSets


@view(PreparedTexture)
def view_prepared(value: PreparedTexture) -> Bytes:
    """The texture's picture with its foreground and points."""
    return view_texture(value.texture)


class PreparedParts(NamedTuple):
    """The parts of a prepared texture, and the window of its picture that splices fill."""

    image: Image
    texture: Texture
    extension: Extension
    factor_x: Factor
    factor_y: Factor
    sets: NeighbourSets


Side = Annotated[int, Field(ge=0, le=4096, description="pixels of a splice; 0 = as the texture, at most 256")]
Kept = Annotated[int, Field(ge=0, le=4096, description="pixels of a splice; 0 = as it was prepared for")]


@node
def prepare_texture(texture: Texture, *, width: Side = 0, height: Side = 0, ctx: Context = QUIET) -> PreparedTexture:
    """Make what splices of a texture share (Liu et al. 2009, section 5): extension, factors and similar pixels.

    It is what `ExtendTexture`, `FactorWarp` and `NeighbourSets` make with their defaults.

    Parameters
    ----------
    width, height
        The window that arrangements fill.

    Raises
    ------
    ValueError
        The texture's parts do not fit together, it has no texton in the window, or the window is too large.
    """
    if not len(texture.points):
        raise ValueError("texture: expected at least one texton, got none")
    sides = [min(side, LARGEST_WINDOW) for side in texture.mask.shape]
    extension = extend_texture(texture, width=width or sides[1], height=height or sides[0], ctx=ctx)
    if not len(extension.points):
        rows, columns = texture.mask.shape
        raise ValueError(
            f"texture: expected textons in and around the window, got none of {len(texture.points)} for the middle "
            f"{extension.width} x {extension.height} pixels of {columns} x {rows}: shrink the picture, take a larger "
            f"window, or give more points"
        )
    factors = factor_warp(extension, ctx=ctx)
    return PreparedTexture(texture, extension, factors.x, factors.y, neighbour_sets(texture, ctx=ctx))


@node
def split_prepared(
    prepared: PreparedTexture, *, width: Kept = 0, height: Kept = 0, ctx: Context = QUIET
) -> PreparedParts:
    """Take a prepared texture apart; for a window of another size it is prepared anew first.

    Raises
    ------
    ValueError
        The window is too large.
    """
    own = prepared.extension
    size = width or own.width, height or own.height
    if size != (own.width, own.height):
        prepared = prepare_texture(prepared.texture, width=size[0], height=size[1], ctx=ctx)
    window = prepared.extension
    rows = slice(window.top, window.top + window.height)
    return PreparedParts(window.image[rows, window.left : window.left + window.width], *prepared)
