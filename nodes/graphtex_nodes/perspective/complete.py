"""Completion of holes in textured surfaces seen in perspective (Dong, Zhou & Paul 2008, section 5, Fig. 14)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, Rng, ScaleMap, SourceMap, node
from graphtex_nodes.perspective._parameters import SYNTHESIS_KERNELS, Kinds

Array = NDArray[Any]
Box = tuple[slice, slice]

LEAST_REACH = 64  # pixels around a small hole
PIECES = ("spline_kernels", "join_kernels")
BLOCK = 16  # pixels; parts of a hole that are four or more such blocks apart are filled each on its own


class Completion(NamedTuple):
    """The completed picture, the scale map that guided it, and where each pixel comes from."""

    image: Image
    scale: ScaleMap
    source: SourceMap


@node
def complete(
    photo: Annotated[Image, Axes("h w c")],
    hole: Annotated[Mask, Axes("h w")],
    scale: Annotated[ScaleMap, Axes("h w")] | None = None,
    source: Annotated[Mask, Axes("h w")] | None = None,
    *,
    continuation: Annotated[
        Literal["plane", "harmonic", "given"],
        Field(description="scale in the hole: on a plane, smooth from its border, or as the map has it"),
    ] = "plane",
    surroundings: Annotated[
        int, Field(ge=0, le=16384, description="pixels around the hole to take from; 0 = as far as the hole is wide")
    ] = 0,
    method: Annotated[
        Literal["pieces", "windows"],
        Field(description="large pieces moved over the plane, or windows as in the paper's synthesis"),
    ] = "pieces",
    scale_weight: Annotated[
        float, Field(ge=0, le=10, description="windows: deviation of the scale over that of the colours; 0 = no scale")
    ] = 1.25,
    iterations: Annotated[int, Field(ge=1, le=50, description="windows: twice the iterations on the finest level")] = 4,
    histogram: Annotated[
        float, Field(ge=0, le=100, description="windows: strength of histogram matching; 0 = none")
    ] = 0.0,
    evenness: Annotated[float, Field(ge=0, le=100, description="windows: charge for overused parts; 0 = none")] = 0.0,
    kinds: Kinds = [],  # noqa: B006 (parameters are copied)
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Completion:
    r"""Fill a hole with texture from around it whose elements have the size that the perspective asks for.

    The scale map is recovered from what surrounds the hole and continued into it; the rest of the photo is the
    exemplar. With ``windows`` it fills the hole as in the paper: `Optimize`'s synthesis with its scale channel, whose
    windows agree with what is known around, then a screened Poisson correction of the seams.

    With ``pieces`` (the default) the photo is moved over the plane that the scale map describes: where scale S is
    linear in the picture, points (x / S, y / S) differ from those of the plane by an affine map only, so that adding a
    constant to them moves texture to where it belongs, at its right size and with its right convergence. Moves that fit
    what is known along the hole's border are found by Fourier transforms, plain shifts that keep the scale among them;
    a minimum cut chooses which of them fills which pixel, rather with what looks like the surroundings near by than
    with lone objects, and gradients are joined. Order over larger distances (courses of bricks, weaves) survives, which
    windows break. What no move reaches is filled by windows.

    Parameters
    ----------
    photo
        (h, w, c). Pixels in the hole are not read.
    hole
        (h, w), True where to fill. Any shape and any number of parts, also at the border.
    scale
        Texel scale of the photo, as `FeatureScale` or `ScaleFromAngles` give it. Without one it is measured in what is
        known of the surroundings: the plane on which their texture is the same everywhere, as `EstimateAngles` finds
        it, flat if there is none; with ``harmonic`` by the density of features (`FeatureMask`, equation 1).
    source
        (h, w), True where texture may be taken from. Without it from the surroundings of the hole.
    continuation
        ``plane`` fits one to the scale outside the hole, with Tukey's biweight against what does not lie on it;
        ``harmonic`` spans a membrane over the hole; ``given`` trusts the map inside the hole too.
    scale_weight
        With ``pieces`` only whether it is 0: then the photo is shifted without regard to scale. With ``windows`` less
        than 1 lets colours win over a scale in large holes: at 0.75 elements there are off by 10 %, at 1.25 by 5 %.
    kinds
        What the channels of stacked material maps are: all are filled from the same places. Colours are bent to meet
        along seams and the hole's border, heights too where outlines are torn, and other maps stay as they are copied;
        normals in the hole are unit vectors.

    Returns
    -------
    Completion
        ``image`` equals the photo bit by bit outside the hole. ``scale`` (h, w) is 1 far from the hole where none was
        given. ``source`` has the row and column in the photo of each pixel, outside the hole its own, and log2 of how
        much a piece was enlarged.

    Raises
    ------
    ValueError
        The hole is everything, nothing is left to take from, ``given`` has no map, or kinds do not add up to the
        photo's channels.

    Notes
    -----
    Only a box around each part of the hole is looked at, so large photos take no longer than small ones. The photo's
    histogram is not matched by default: a hole need not have the colours of all that surrounds it.

    Texture is put in holes of a few pixels' width and more. Sprinkled pixels are told by their neighbours: with a half
    or a fifth of all missing, plain interpolation, such as scikit-image's ``inpaint_biharmonic``, comes about twice as
    near.

    Examples
    --------
    >>> stripes = np.tile(np.float32([0, 0, 1, 1]), (24, 6))[..., None]
    >>> hole = np.zeros((24, 24), bool)
    >>> hole[8:13, 8:13] = True
    >>> bool(np.abs(complete(stripes, hole).image - stripes).max() < 0.01)
    True
    """
    from graphtex_nodes.numerics.jit import announce
    from graphtex_nodes.numerics.materials import bending, renormalised, require_stack
    from graphtex_nodes.numerics.parallel import Portion
    from graphtex_nodes.numerics.request import require_moderate
    from graphtex_nodes.numerics.sources import own_places

    require_moderate("photo", photo)
    if not hole.any():
        ctx.warn("hole: nothing is marked, so the photo stays as it is")
    if hole.all():
        raise ValueError(f"hole: expected some pixels outside it, got all of shape {hole.shape}")
    require_stack("photo", photo[~hole], kinds, ctx.warn)
    if continuation == "given" and scale is None:
        raise ValueError("scale: expected a map to take as given, got none")
    usable = ~hole if source is None else source & ~hole
    if hole.any() and not usable.any():
        raise ValueError(f"source: expected some pixels outside the hole, got none in shape {hole.shape}")

    announce(ctx, *(PIECES if method == "pieces" else SYNTHESIS_KERNELS))
    from graphtex_nodes.numerics.problem import Settings
    from graphtex_nodes.perspective._canvas import Canvas

    scales = np.ones(hole.shape, np.float32) if scale is None else scale.copy()
    canvas = Canvas(photo.copy(), own_places(hole.shape), scales, hole, usable, bending(kinds, photo.shape[2]))
    plan = iterations, Settings(histogram=histogram, evenness=evenness)
    parts = _parts(hole)
    for number, part in enumerate(parts):
        work = Portion(ctx, number / len(parts), 1 / len(parts))
        box = _around(part, surroundings)
        taken = box if source is None else _around(usable, 1)
        if not usable[taken].any():
            taken = slice(0, hole.shape[0]), slice(0, hole.shape[1])
        sight = _union(_around(part, surroundings, times=2), taken)
        if scale is None:
            canvas.measure_scale(part, sight, continuation == "harmonic", work)
        elif continuation != "given":
            canvas.continue_scale(sight, continuation == "harmonic", work)
        rest = part
        if method == "pieces":
            rest = canvas.put_pieces(part, sight, scale_weight > 0, work)
        if rest.any():
            announce(ctx, *SYNTHESIS_KERNELS)
            canvas.put_windows(part, rest, box, taken, scale_weight, plan, rng, work)
    canvas.image[hole] = renormalised(canvas.image[hole], kinds)
    return Completion(canvas.image, canvas.scales, canvas.places)


def _parts(hole: Array) -> list[Array]:
    """Parts of a hole that are far from each other, as masks of their own."""
    from scipy.ndimage import binary_dilation, label

    if not hole.any():
        return []
    padded = np.pad(hole, [(0, -side % BLOCK) for side in hole.shape])
    blocks = np.asarray(padded.reshape(-(-hole.shape[0] // BLOCK), BLOCK, -1, BLOCK).any(axis=(1, 3)))
    square = np.ones((3, 3), bool)
    numbers, count = label(binary_dilation(blocks, square, iterations=2), square)
    numbers = numbers.repeat(BLOCK, axis=0).repeat(BLOCK, axis=1)[: hole.shape[0], : hole.shape[1]]
    return [hole & (numbers == number) for number in range(1, count + 1)]


def _around(mask: Array, reach: int, times: int = 1) -> Box:
    """Bounding box of a mask with ``reach`` pixels around it, or as many ``times`` as it is wide."""
    sides = []
    for axis in (0, 1):
        inside = np.flatnonzero(mask.any(axis=1 - axis))
        sides.append((int(inside[0]), int(inside[-1]) + 1))
    more = reach or times * max(LEAST_REACH, *(stop - first for first, stop in sides))
    top, left = (
        slice(max(0, first - more), min(count, stop + more))
        for (first, stop), count in zip(sides, mask.shape, strict=True)
    )
    return top, left


def _union(first: Box, second: Box) -> Box:
    rows, columns = (
        slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(first, second, strict=True)
    )  # fmt: skip
    return rows, columns
