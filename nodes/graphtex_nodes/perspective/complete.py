"""Completion of holes in textured surfaces seen in perspective (Dong, Zhou & Paul 2008, section 5, Fig. 14)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, Rng, ScaleMap, SourceMap, node

Array = NDArray[Any]
Box = tuple[slice, slice]

LEAST_REACH = 64  # pixels around a small hole
EDGE = 4  # pixels around the hole where it makes false features
TELLING = 0.2  # spread of log scale from which the scale counts fully
SEEN = 0.25  # share of a window that must be known for its density to count


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
    scale_weight: Annotated[
        float, Field(ge=0, le=10, description="standard deviation of the scale over that of the colours; 0 = plain")
    ] = 0.75,
    iterations: Annotated[int, Field(ge=1, le=50, description="iterations on the finest level")] = 4,
    histogram: Annotated[float, Field(ge=0, le=100, description="strength of histogram matching; 0 = none")] = 0.0,
    evenness: Annotated[float, Field(ge=0, le=100, description="charge for overused parts; 0 = none")] = 0.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Completion:
    """Fill a hole with texture from around it whose elements have the size that the perspective asks for.

    The scale map is recovered from what surrounds the hole and continued into it; the rest of the photo is the
    exemplar, and `Optimize`'s synthesis with its scale channel fills the hole, its windows agreeing with what is known
    around. Seams at the hole's border are then removed by a screened Poisson correction inside the hole.

    Parameters
    ----------
    photo
        (h, w, c). Pixels in the hole are not read.
    hole
        (h, w), True where to fill. Any shape and any number of parts, also at the border.
    scale
        Texel scale of the photo, as `FeatureScale` or `ScaleFromAngles` give it. Without one it is measured: density of
        features (`FeatureMask`, equation 1) in what is known of the surroundings, to which a plane is fitted, since the
        scale of a plane is linear in its picture.
    source
        (h, w), True where texture may be taken from. Without it from the surroundings of the hole.
    continuation
        ``plane`` fits one to the scale outside the hole, with Tukey's biweight against what does not lie on it;
        ``harmonic`` spans a membrane over the hole; ``given`` trusts the map inside the hole too.

    Returns
    -------
    Completion
        ``image`` equals the photo bit by bit outside the hole. ``scale`` (h, w) is 1 far from the hole where none was
        given. ``source`` has the row and column in the photo of each pixel, outside the hole its own.

    Raises
    ------
    ValueError
        The hole is everything, nothing is left to take from, or ``given`` has no map.

    Notes
    -----
    Only a box around the hole is synthesised, so large photos take no longer than small ones. The photo's histogram is
    not matched by default: a hole need not have the colours of all that surrounds it.

    Examples
    --------
    >>> stripes = np.tile(np.float32([0, 0, 1, 1]), (24, 6))[..., None]
    >>> hole = np.zeros((24, 24), bool)
    >>> hole[8:13, 8:13] = True
    >>> bool(np.abs(complete(stripes, hole).image - stripes).max() < 0.01)
    True
    """
    from graphtex_nodes.numerics.sources import own_places

    if hole.all():
        raise ValueError(f"hole: expected some pixels outside it, got all of shape {hole.shape}")
    if continuation == "given" and scale is None:
        raise ValueError("scale: expected a map to take as given, got none")
    if not hole.any():
        every = np.ones(hole.shape, np.float32)
        return Completion(photo.copy(), every if scale is None else scale.copy(), own_places(hole.shape))
    usable = ~hole if source is None else source & ~hole
    if not usable.any():
        raise ValueError(f"source: expected some pixels outside the hole, got none in shape {hole.shape}")

    from graphtex_nodes.numerics.jit import announce

    announce(ctx, "window_kernels", "search_kernels", "vote_kernels", "seam_kernels")
    from graphtex_nodes.numerics import levels, seams
    from graphtex_nodes.numerics.problem import Settings
    from graphtex_nodes.numerics.request import Scales, pose
    from graphtex_nodes.numerics.synthesis import synthesise

    box = _around(hole, surroundings)
    taken = box if source is None else _around(usable, 1)
    if not usable[taken].any():
        taken = (slice(None), slice(None))
    scales = _scales(photo, hole, scale, continuation, _union(box, taken), ctx)
    spread = float(np.std(np.log(scales[taken][usable[taken]]), dtype=np.float64))
    weight = 0.0 if spread < 1e-3 else scale_weight * min(1.0, spread / TELLING)
    problem = pose(
        photo[taken], (box[0].stop - box[0].start, box[1].stop - box[1].start),
        Scales(scales[taken], scales[box], weight, True), ctx,
        usable=usable[taken], start=photo[box], known=~hole[box],
    )  # fmt: skip
    plan = levels.plan(problem.exemplar, problem.usable, 0, (), iterations)
    result = synthesise(problem, plan, Settings(histogram=histogram, evenness=evenness), rng, ctx)
    filled, found = seams.finish(problem, result, fade=True, work=ctx)
    image, places, part = photo.copy(), own_places(hole.shape), hole[box]
    image[hole] = filled[part]
    places[hole, 1:3] = found[part] + np.array([taken[0].start or 0, taken[1].start or 0])
    return Completion(image, scales, places)


def _around(mask: Array, reach: int) -> Box:
    """Bounding box of a mask with ``reach`` pixels around it, or as many as it is wide."""
    sides = []
    for axis in (0, 1):
        inside = np.flatnonzero(mask.any(axis=1 - axis))
        sides.append((int(inside[0]), int(inside[-1]) + 1))
    more = reach or max(LEAST_REACH, *(stop - first for first, stop in sides))
    top, left = (
        slice(max(0, first - more), min(count, stop + more))
        for (first, stop), count in zip(sides, mask.shape, strict=True)
    )
    return top, left


def _union(first: Box, second: Box) -> Box:
    if first == second or second[0].start is None:
        return second
    rows, columns = (
        slice(min(a.start, b.start), max(a.stop, b.stop)) for a, b in zip(first, second, strict=True)
    )  # fmt: skip
    return rows, columns


def _scales(photo: Array, hole: Array, scale: Array | None, continuation: str, box: Box, ctx: Context) -> Array:
    """Scale map of the photo with values in the hole, measured in a box where none is given."""
    from graphtex_nodes.numerics.continuation import continued, fitted_plane

    if continuation == "given" and scale is not None:
        return scale
    result = np.ones(hole.shape, np.float32) if scale is None else scale.copy()
    part = hole[box]
    if scale is not None:
        found = continued(scale[box], ~part, continuation == "harmonic", ctx)
    else:
        measured, seen = _measured(photo[box], part)
        if not seen.any():
            return result
        if continuation == "plane":
            found = fitted_plane(measured, seen).astype(np.float32)
        else:
            found = continued(measured, seen, True, ctx)
    result[box] = np.clip(found, 1 / 8, 8)
    return result


def _measured(photo: Array, hole: Array) -> tuple[Array, Array]:
    """Scale by the density of features outside the hole (equation 1, bounded), and where enough is seen to tell."""
    from scipy.ndimage import binary_dilation

    from graphtex_nodes.perspective.feature_mask import feature_mask
    from graphtex_nodes.perspective.feature_scale import window_mean

    filled = np.where(hole[..., None], photo[~hole].mean(axis=0), photo).astype(np.float32)
    told: list[str] = []
    features = feature_mask(filled, ctx=Context(threads=1, on_warning=told.append))
    clear = ~binary_dilation(hole, iterations=EDGE)
    window = max(3, min(hole.shape) // 4)
    share = window_mean(clear.astype(np.float64), window)
    seen = ~hole & (share >= SEEN)
    if not (features & clear).any() or not seen.any():
        return np.ones(hole.shape), np.zeros(hole.shape, bool)
    density = window_mean((features & clear).astype(np.float64), window) / np.maximum(share, SEEN)
    middle = (density[seen].min() + density[seen].max()) / 2
    return 2 - density / middle, seen
