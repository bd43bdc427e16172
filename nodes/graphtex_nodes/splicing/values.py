"""Socket types that flow between the steps of a splice."""

from typing import Annotated, Any, NamedTuple, TypeAlias

from numpy.typing import NDArray

from graphtex import ArrayType, Image, LabelMap, Mask, Points, SourceMap, Vector, struct_type

Indices: TypeAlias = Annotated[NDArray[Any], ArrayType("Indices", "whole numbers, counted from 0", "int32", ("n",))]


@struct_type("a texture carried on beyond a window, so that every place in the window can get an element")
class Extension(NamedTuple):
    """A larger texture, where each of its pixels is in the picture it was made from, and the window that is wanted.

    `labels` tells which texton each pixel of the foreground belongs to, -1 the background and parts without a texton.
    `left` and `top` are the window's first column and row in `image`, `width` and `height` its size.
    """

    image: Image
    mask: Mask
    points: Points
    tag: str
    labels: LabelMap
    source: SourceMap
    left: int
    top: int
    width: int
    height: int


@struct_type("where each texton of an extension goes")
class Moves(NamedTuple):
    """For each texton of an extension its place before and after, both in the extension's pixels.

    `angles` (degrees, clockwise) and `scales` turn and size it about its place; `matched` is 1 for a texton that has
    been given a place of the arrangement and 0 for a surplus one, which follows its neighbours.
    """

    points: Points
    targets: Points
    angles: Vector
    scales: Vector
    matched: Vector


@struct_type("a sparse factorisation P A P' = L D L', solved as often as wanted")
class Factor(NamedTuple):
    """Factor of a symmetric positive definite matrix.

    Row i of the permuted matrix is row `order[i]` of A. Column j of L has the entries `starts[j]` to `starts[j + 1]` of
    `rows` and `values`; the first is 1, on the diagonal. `pivots` is the diagonal of D.
    """

    order: Indices
    starts: Indices
    rows: Indices
    values: Vector
    pivots: Vector
