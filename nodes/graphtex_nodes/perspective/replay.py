"""Replays a synthesis: its source map applied to other maps of the same exemplars."""

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, SourceMap, node
from graphtex_nodes.numerics.jit import announce
from graphtex_nodes.numerics.materials import MapKind, bending, renormalised, require_stack
from graphtex_nodes.numerics.sources import Look
from graphtex_nodes.perspective._parameters import Sides, around
from graphtex_nodes.perspective._shown import Shown

Array = NDArray[Any]
Flags = NDArray[np.bool_]

BAND = 1 << 18  # pixels at a time
LARGER = 1.7  # maps by more than that, compared to the places that a source map names, are doubted
PIECE = 32  # pixels a side up to which a source map may show one piece alone, which tells nothing of its exemplar


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
    tileable: Sides = "none",
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
        ``discrete`` repeats a discrete vote to the bit; ``blend`` repeats a blended one but for rounding (nearly where
        copies are turned or resampled, or not wholly usable; with known pixels nothing is bent to meet).
    tileable
        As in the synthesis: ``blend`` goes on over these sides.
    kinds
        Normals are turned with their sources and made unit vectors again where they are off by more than 1 %;
        heights meet without cliffs.

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
    _doubt_factor(source, maps, factor, ctx.warn)
    if vote == "blend":
        announce(ctx, "membrane_kernels")
    for number, picture in enumerate(maps):
        require_stack(f"maps[{number}]", picture, kinds, ctx.warn)
    free = np.ones(source.shape[:2], bool) if known is None else ~known
    shown = Shown(source, [Look(picture, kinds) for picture in maps], factor, free, around(tileable))
    height, width = shown.size
    result = np.empty((height, width, maps[0].shape[2]), np.float32)
    rows = max(1, BAND // width)
    bands = [slice(first, min(height, first + rows)) for first in range(0, height, rows)]
    for band in bands:
        result[band] = shown.copied(band)
        ctx.progress(band.stop / height * (1.0 if vote == "discrete" else 0.2), "copying")
    if vote == "blend":
        mixed = shown.near_seams()
        bends = bending(kinds, result.shape[2]) * np.uint8(known is None)
        if mixed.any():
            _fade(result, shown, mixed, bands, bends, ctx)
        result = renormalised(result, kinds)
    return result


def _fade(result: Array, shown: Shown, mixed: Flags, bands: list[slice], bends: Array, ctx: Context) -> None:
    """Let pieces fade into each other where they are ``mixed``, and bend them to meet as ``bends`` says."""
    from graphtex_nodes.numerics import membrane
    from graphtex_nodes.numerics.seam_neighbours import Contrast

    contrast = Contrast.of([look.exemplar for look in shown.looks], size=max(1, round(shown.factor)))
    beside = [mixed | np.roll(mixed, -1, axis) for axis in (0, 1)]  # there steps to a neighbour are not copies
    near = beside[0] | beside[1]
    own = np.empty((2, *result.shape), np.float32)
    for band in bands:
        values, steps = shown.faded(near, band, contrast.sharpness)
        result[band][mixed[band]] = values[mixed[band][near[band]]]
        own[:, band][:, near[band]] = steps
        ctx.progress(0.2 + 0.7 * band.stop / len(result), "fading")
    if not bends.any():
        return
    for axis, steps in enumerate(own):
        steps[~beside[axis]] = (np.roll(result, -1, axis) - result)[~beside[axis]]
    lack = membrane.missing(result, own, contrast.variance / shown.factor**2, bends, shown.wrap, ctx)
    membrane.level(result, lack, contrast.limits, contrast.reach * shown.factor, shown.wrap, ctx)
    ctx.progress(1.0, "levelling")


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


def _doubt_factor(source: Array, maps: list[Array], factor: float, warn: Callable[[str], None]) -> None:
    """Warn of maps so much larger than the exemplar that but a corner is shown: others, or by a factor not told."""
    if min(source.shape[:2]) <= PIECE:
        return
    for number, picture in enumerate(maps):
        own = source[source[..., 0] == number]
        if len(own):
            used = np.rint(own[:, 1:3].max(axis=0)) + 1
            larger = picture.shape[:2] / used
            if larger.min() > LARGER * factor and len(own) > used.prod() / 4:
                alike = larger.max() < 1.1 * larger.min()
                doubt = f"is factor {np.rint(larger.min()):g}?" if alike else "is it a map of that exemplar?"
                warn(
                    f"maps[{number}]: the source map names its first {used[0] * factor:g} of {picture.shape[0]} rows "
                    f"and {used[1] * factor:g} of {picture.shape[1]} columns; {doubt}"
                )
