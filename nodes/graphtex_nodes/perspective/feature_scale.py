"""Texel scale from the density of a feature mask (Dong, Zhou & Paul 2008, section 3.1)."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, ScaleMap, node
from graphtex_nodes.numerics.guidance import resampled
from graphtex_nodes.numerics.window_mean import window_mean

Array = NDArray[Any]
Form = Literal["bounded", "inverse", "literal"]

SMALLEST, LARGEST = 1 / 8, 8.0
WORTH_A_WARNING = 0.05  # a few clamped pixels vanish in the smoothing
MOST = 512  # blocks along the longer side in which features are counted
FINEST = 12  # blocks along a window at least
THICK = 5  # pixels; lines of one and of two pixels are far below it, filled elements above
LEVELS = 1023  # the running median tells so many steps apart


@node
def feature_scale(
    mask: Annotated[Mask, Axes("h w")],
    image: Annotated[Image, Axes("h w c")] | None = None,
    *,
    form: Annotated[Form, Field(description="how density becomes scale")] = "bounded",
    window: Annotated[int | None, Field(ge=1, description="side of the window, pixels; none: by the picture")] = None,
    smoothing: Annotated[int | None, Field(ge=1, description="side of the smoothing; none: half the window")] = None,
    passes: Annotated[int, Field(ge=0, le=64, description="how often the map is smoothed")] = 2,
    alpha: Annotated[float, Field(ge=0, le=1, description="share of the mean, the rest is the median")] = 0.8,
    ctx: Context = QUIET,
) -> ScaleMap:
    r"""Relative texel scale of a picture from the density of thin features around each pixel.

    With a(p) the number of features in the n x n window around p, over the area of the window that lies in the picture,
    and :math:`a_{mid} = (a_{min} + a_{max}) / 2` (Eq. 1),

    ======== ============================ ========================================================================
    bounded  :math:`S = 2 - a / a_{mid}`  falls linearly, at most 2 (the default)
    inverse  :math:`S = a_{mid} / a`      follows large ranges of scale, but is restless where features are few
    literal  :math:`S = a / a_{mid}`      as printed: more features, larger texels; right for masks of filled gaps
    ======== ============================ ========================================================================

    which is then smoothed, `passes` times, by Eq. 2: :math:`S = \alpha S_{avg} + (1 - \alpha) S_{mid}`, mean and median
    of the smoothing window. At the border both take the part of their window that lies in the picture, so borders are
    not darker.

    Parameters
    ----------
    mask
        (h, w), True on thin features as `FeatureMask` finds them: their density must fall as texels grow. Filled
        elements do not do that, and a warning tells where features look filled.
    image
        The picture that the mask was drawn for, if it is to be made sure that they are of one size; no more of it is
        read.
    window
        The paper takes 32. It should hold several texels, even large ones. Without a value, a quarter of the picture's
        shorter side. An even window reaches one pixel further up and left than down and right.
    smoothing
        The paper takes 9, once. Without a value, half the window.

    Returns
    -------
    ScaleMap
        (h, w), clamped to [1/8, 8]; a warning reports the share of clamped pixels if it exceeds 5 %. 1 where the
        density is a_mid.

    Raises
    ------
    ValueError
        The mask is empty, or not as large as the image.

    Notes
    -----
    The paper's text gives the largest scale to the fewest features, its Eq. 1 the smallest. The text is meant.
    Masks of more than 512 pixels a side are counted in blocks (with at least twelve along a window), and the map is
    interpolated between their middles: it varies over windows, and would take minutes. The median is taken on 1023
    steps between the smallest and the largest value.

    Examples
    --------
    >>> mask = np.zeros((4, 12), bool)
    >>> mask[:, [0, 4, 6, 8, 10]] = True  # lines four columns apart, then two
    >>> feature_scale(mask, window=4, passes=0)[0, 2:10].round(2)
    array([1.33, 1.33, 1.33, 0.67, 0.67, 0.67, 0.67, 0.67], dtype=float32)
    """
    if not mask.any():
        raise ValueError(f"mask: expected some features (True), got an empty mask of shape {mask.shape}")
    if window is None:
        window = max(3, min(mask.shape) // 4)
    if smoothing is None:
        smoothing = max(3, window // 2)
    if form != "literal" and (thickness := _thickness(mask)) > max(THICK, window / 16):
        ctx.warn(
            f"mask: its features are filled, {thickness:.0f} pixels from side to side, and cover large elements "
            "and small ones alike: draw outlines, or take form literal if they are gaps"
        )
    step = _step(mask.shape, window, smoothing)
    density = window_mean(_shares(mask, step), max(1, round(window / step)))
    middle = (density.min() + density.max()) / 2
    if form == "bounded":
        scale = 2 - density / middle
    elif form == "inverse":
        scale = middle / np.maximum(density, middle / (2 * LARGEST))
    else:
        scale = density / middle
    clamped = np.clip(scale, SMALLEST, LARGEST)
    share = float(np.mean(clamped != scale))
    for done in range(passes):
        ctx.progress(done / passes, "smoothing")
        side = max(1, round(smoothing / step))
        clamped = alpha * window_mean(clamped, side) + (1 - alpha) * window_median(clamped, side)
    if share > WORTH_A_WARNING:
        ctx.warn(
            f"{share:.0%} of the scales lay outside [1/8, 8] and were clamped before smoothing: "
            "a larger window keeps more of them"
        )
    result: Array = np.clip(clamped, SMALLEST, LARGEST).astype(np.float32)
    if step > 1:
        result = resampled(result, (result.shape[0] * step, result.shape[1] * step))
    return result[: mask.shape[0], : mask.shape[1]].copy()


def _thickness(mask: Array) -> float:
    """Pixels from side to side of features: twice their area over the length of their border, at least 1."""
    inner = mask.copy()
    for axis in (0, 1):
        lines, kept = np.moveaxis(mask, axis, 0), np.moveaxis(inner, axis, 0)
        kept[1:] &= lines[:-1]
        kept[:-1] &= lines[1:]
    border = mask.sum() - inner.sum()
    return float(max(1.0, 2 * mask.sum() / max(border, 1) - 1))


def _step(shape: tuple[int, ...], window: int, smoothing: int) -> int:
    """Pixels of a mask along a side of the blocks that it is counted in."""
    return max(1, min(-(-max(shape) // MOST), window // FINEST, smoothing // FINEST))


def _shares(mask: Array, step: int) -> Array:
    """Share of features in blocks of step x step pixels (those that lie in the mask), float64."""
    starts = [np.arange(0, side, step) for side in mask.shape]
    counts = np.add.reduceat(np.add.reduceat(mask, starts[0], axis=0, dtype=np.float64), starts[1], axis=1)
    rows, columns = (np.minimum(step, side - start) for side, start in zip(mask.shape, starts, strict=True))
    shares: Array = counts / np.outer(rows, columns)
    return shares


def window_median(values: Array, side: int) -> Array:
    """Median over the part of a window that lies in the picture, to 1/1023 of the range of values."""
    from skimage.filters.rank import median

    low, high = values.min(), values.max()
    if high - low < 1e-9:
        return values
    steps = np.rint((values - low) * (LEVELS / (high - low))).astype(np.uint16)
    steps = median(steps, np.ones((side, side), np.uint8))
    medians: Array = low + steps * ((high - low) / LEVELS)
    return medians
