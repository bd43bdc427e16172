"""Editing scale maps by hand (Dong, Zhou & Paul 2008, section 3.3)."""

from typing import Annotated, Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from graphtex import QUIET, Context, Mask, ScaleMap, node
from graphtex_nodes.numerics.regions import Region, Whole, region_weights
from graphtex_nodes.numerics.strokes import Measured, Place

Array = NDArray[Any]
Factor = Annotated[float, Field(ge=1, le=64)]

SMALLEST, LARGEST = 1 / 8, 8.0
WIDE = 24  # pixels; from there on the transforms are faster, tenfold for a tenth of a large map
EVERYWHERE = Whole()


class _Plain(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Magnify(_Plain):
    """Multiply scales: larger texels."""

    do: Literal["magnify"] = "magnify"
    factor: Annotated[Factor, Field(description="scales are multiplied by this")]
    region: Region = EVERYWHERE


class Minify(_Plain):
    """Divide scales: smaller texels."""

    do: Literal["minify"] = "minify"
    factor: Annotated[Factor, Field(description="scales are divided by this")]
    region: Region = EVERYWHERE


class SetScale(_Plain):
    """Give all of the region one scale."""

    do: Literal["set"] = "set"
    value: Annotated[float, Field(ge=SMALLEST, le=LARGEST, description="the scale")]
    region: Region = EVERYWHERE


class Duplicate(Measured):
    """Copy scales from elsewhere in the map; units and size are those of the offset."""

    do: Literal["duplicate"] = "duplicate"
    offset: Annotated[Place, Field(description="x, y from where scales are put to where they are taken")]
    region: Region = EVERYWHERE


class Flatten(_Plain):
    """Weaken the variation about the region's mean."""

    do: Literal["flatten"] = "flatten"
    amount: Annotated[float, Field(ge=0, le=1, description="1 leaves no variation")] = 1
    region: Region = EVERYWHERE


class Exaggerate(_Plain):
    """Strengthen the variation about the region's mean."""

    do: Literal["exaggerate"] = "exaggerate"
    factor: Annotated[Factor, Field(description="log scale varies so many times as much")] = 2
    region: Region = EVERYWHERE


class Smooth(Measured):
    """Smooth by a Gaussian; units and size are those of sigma."""

    do: Literal["smooth"] = "smooth"
    sigma: Annotated[float, Field(gt=0, description="standard deviation of the Gaussian")]
    region: Region = EVERYWHERE


Edit: TypeAlias = Annotated[
    Magnify | Minify | SetScale | Duplicate | Flatten | Exaggerate | Smooth, Field(discriminator="do")
]


@node
def scale_edit(
    scale: ScaleMap,
    masks: list[Mask] | None = None,
    *,
    edits: Annotated[tuple[Edit, ...], Field(description="what is done, in this order; the last one can be undone")],
    ctx: Context = QUIET,
) -> ScaleMap:
    r"""Edit a scale map: magnify, minify, set, duplicate, flatten, exaggerate or smooth its values in regions.

    The paper lets its users paint on the map's grey picture, copy areas, and change the variation of an area (Fig. 7).
    Here each step is an entry of a list, so leaving out the last one undoes it. With L = ln S the logarithm of the map
    and w in [0, 1] how much a pixel belongs to the region, each edit blends what it wants into L:

    ============== ==============================================================================================
    ``magnify``    :math:`L + w \ln f`
    ``minify``     :math:`L - w \ln f`
    ``set``        :math:`L + w (\ln v - L)`
    ``duplicate``  :math:`L + w (L(p + d) - L)`, beyond the map's border the nearest value
    ``flatten``    :math:`m + (1 - w a) (L - m)`, m the mean of L over the region
    ``exaggerate`` :math:`m + (1 + w (f - 1)) (L - m)`
    ``smooth``     :math:`L + w (G_\sigma * L - L)`
    ============== ==============================================================================================

    Parameters
    ----------
    scale
        (h, w).
    masks
        Masks of the map's size, for regions of the kind ``mask``.
    edits
        Each has ``do``, the numbers that it needs, and a ``region``: ``{kind: whole}`` (the default), ``strokes``,
        ``polygon``, ``rectangle``, ``ellipse`` or ``mask``. Regions are given in pixels of the map, in pixels of a
        picture of another ``size``, or in relative units, and have a ``softness``.

    Returns
    -------
    ScaleMap
        (h, w). Clamped to [1/8, 8] after the last edit; a warning tells the share of pixels that this changed. Without
        edits, and outside all regions, the map as it was.

    Raises
    ------
    ValueError
        A region wants a mask that is not there or of another size, or a file that does not hold strokes; the message
        begins with the edit's place in the list.

    Notes
    -----
    The paper adds to and subtracts from grey values. Steps here are ratios, since twice and half as large are equally
    far from 1. Nothing is clamped in between: a later edit can bring back what an earlier one sent out of range.

    Examples
    --------
    >>> middle = {"kind": "rectangle", "corner": [0.5, -0.5], "opposite": [2.5, 0.5]}
    >>> scale_edit(np.ones((1, 4), np.float32), edits=[{"do": "magnify", "factor": 2, "region": middle}])
    array([[1., 2., 2., 1.]], dtype=float32)
    """
    height, width = scale.shape
    if not edits:
        return scale
    log_scale = np.log(scale.astype(np.float64))
    for number, edit in enumerate(edits):
        ctx.progress(number / len(edits), edit.do)
        try:
            weights = region_weights(edit.region, width, height, masks or ())
        except ValueError as error:
            raise ValueError(f"edits[{number}]: {error}") from error
        if not weights.any():
            ctx.warn(f"edits[{number}]: its region lies outside the map of {width} x {height} pixels: nothing changed")
            continue
        log_scale = log_scale + _change(edit, log_scale, weights, number, ctx)
    result = np.exp(log_scale)
    clamped = np.clip(result, SMALLEST, LARGEST)
    share = float(np.mean(np.abs(result - clamped) > 1e-6 * clamped))  # rounding is not worth a warning
    if share:
        ctx.warn(f"{share:.1%} of the scales left [1/8, 8] and were clamped")
    return clamped.astype(np.float32)


def _change(edit: Edit, log_scale: Array, weights: Array, number: int, ctx: Context) -> Array:
    """What an edit adds to the logarithm of the map (h, w)."""
    height, width = log_scale.shape
    if isinstance(edit, Magnify):
        return weights * float(np.log(edit.factor))
    if isinstance(edit, Minify):
        return weights * -float(np.log(edit.factor))
    if isinstance(edit, Flatten | Exaggerate):
        gain = -edit.amount if isinstance(edit, Flatten) else edit.factor - 1
        mean = (weights * log_scale).sum() / weights.sum()
        change: Array = weights * gain * (log_scale - mean)
        return change
    if isinstance(edit, SetScale):
        wanted = np.full_like(log_scale, np.log(edit.value))
    elif isinstance(edit, Smooth):
        # wider than the map, a Gaussian is a mean all the same, but takes far longer
        wanted = _smoothed(log_scale, min(edit.length(edit.sigma, width, height), float(max(width, height))))
    else:
        wanted = _duplicated(edit, log_scale, weights, number, ctx)
    blended: Array = weights * (wanted - log_scale)
    return blended


def _smoothed(log_scale: Array, sigma: float) -> Array:
    """Map smoothed by a Gaussian, the border's values beyond the border; a wide one by Fourier transforms."""
    from scipy.ndimage import gaussian_filter
    from scipy.signal import oaconvolve

    if sigma < WIDE:
        narrow: Array = gaussian_filter(log_scale, sigma, mode="nearest")
        return narrow
    reach = round(4 * sigma)
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    weights /= weights.sum()
    smooth = log_scale
    for axis in (0, 1):
        beyond = [(reach, reach) if axis == along else (0, 0) for along in (0, 1)]
        padded = np.pad(smooth, beyond, mode="edge")
        smooth = oaconvolve(padded, np.expand_dims(weights, 1 - axis), mode="valid", axes=axis)
    return smooth


def _duplicated(edit: Duplicate, log_scale: Array, weights: Array, number: int, ctx: Context) -> Array:
    """Map shifted by the edit's offset, interpolated linearly, the border's values beyond the border."""
    from scipy import ndimage

    height, width = log_scale.shape
    right, down = edit.shift(edit.offset, width, height)
    shifted: Array = ndimage.shift(log_scale, (-down, -right), order=1, mode="nearest")
    x, y = np.arange(width) + right, np.arange(height)[:, None] + down
    beyond = (x < -0.5) | (x > width - 0.5) | (y < -0.5) | (y > height - 0.5)
    if (beyond & (weights > 0)).any():
        share = float(weights[beyond].sum() / weights.sum())
        ctx.warn(f"edits[{number}]: {share:.0%} of what is duplicated lies outside the map: the border is taken there")
    return shifted
