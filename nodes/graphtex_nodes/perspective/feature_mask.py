"""Thin features whose density tells the size of texels (Dong, Zhou & Paul 2008, section 3.1; Wu & Yu 2004)."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, node
from graphtex_nodes.numerics.principal import principal_channel
from graphtex_nodes.numerics.strokes import Strokes, stroke_weights

Array = NDArray[Any]
Method = Literal["canny", "ridges", "contrast", "scribbles"]
Polarity = Literal["both", "bright", "dark"]

USUAL: dict[Method, float] = {"canny": 1.9, "ridges": 0.175, "contrast": 0.3}
"""Threshold 1 of each method, in standard deviations of the picture."""
GRAIN = 0.01  # standard deviation that colours have at least, so that one dab is a sample
NONE = Strokes()


@node
def feature_mask(
    image: Annotated[Image, Axes("h w c")],
    samples: Annotated[Mask, Axes("h w")] | None = None,
    *,
    method: Annotated[
        Method, Field(description="edges, lines, outlines of what stands out, or colours shown by hand")
    ] = "ridges",
    sigma: Annotated[float, Field(gt=0, le=32, description="smoothing before anything else, pixels")] = 0.8,
    threshold: Annotated[float, Field(gt=0, description="how strong a feature must be, 1 suits most pictures")] = 1.0,
    polarity: Annotated[Polarity, Field(description="bright or dark lines and spots, or both")] = "both",
    neighbourhood: Annotated[float, Field(gt=0, description="method contrast: radius to compare with, pixels")] = 8.0,
    strokes: Annotated[Strokes, Field(description="method scribbles: on features, and with label other beside")] = NONE,
    ctx: Context = QUIET,
) -> Mask:
    """Mask of thin features: lines one pixel wide, so that there are fewer of them where texels are larger.

    Filled regions would not do: the share of a picture that stones cover is the same for small and large stones, but
    the length of their outlines is not. That is what `FeatureScale` relies on.

    Parameters
    ----------
    image
        (h, w, c) of any number of channels. Features are sought along the principal direction of its colours, which
        shows red on green as well as light on dark; the last of two or four channels is taken for alpha and not seen.
    method
        ``canny``: edges (Canny 1986), strong ones and the weak ones of half the threshold that continue them.
        ``ridges``: centre lines of lines (mortar, gaps, blades), where the Hessian's larger eigenvalue stands out.
        ``contrast``: outlines of what differs from the mean of its neighbourhood.
        ``scribbles``: centre lines of what has the colours that strokes or samples show.
    sigma
        Standard deviation of the Gaussian, for ridges about half the width of a line. Grain finer than this is passed
        over: raise it for large photographs in which only the near texels show grain.
    threshold
        Relative to a value for each method that was found to suit most pictures, in standard deviations of the picture:
        1.9 for canny's gradient (change over two pixels), 0.175 for the curvature of ridges (times sigma²), 0.3 for the
        difference of contrast. For scribbles the ratio of likelihoods, feature over the rest.
    polarity
        Which ridges or spots. An edge has a bright and a dark side, so canny takes ``both`` only, and so do scribbles.
    strokes, samples
        Where features are: strokes without a label or with ``feature``, and pixels of the mask. Strokes with the label
        ``other`` show what is none; without these, all that is not shown. Either side is a normal distribution of
        colours. A mask that is finished needs none of this: give it to `FeatureScale` as it is.

    Returns
    -------
    Mask
        (h, w), True on features. All False (with a warning) if there are none.

    Raises
    ------
    ValueError
        A polarity with canny or scribbles; scribbles without a pixel, or on all pixels, or with an unknown label.

    Notes
    -----
    On rendered planes (pebbles, flowers, bricks, pavers, cloth at slants of 45 to 60) the rank correlation of the scale
    that `FeatureScale` makes of it with the truth was 0.92 or better for ridges, and 0.93 or better for canny but for
    flowers over grass (0.6). Rippled sand defeats all three: its grain is finer than what is left of it far away.
    """
    if method in ("canny", "scribbles") and polarity != "both":
        raise ValueError(f"polarity: method {method} knows no sides, expected 'both', got {polarity!r}")
    if method == "scribbles":
        return _told(_coloured(image, strokes, samples, sigma, threshold), ctx)
    grey = principal_channel(image)
    contrast = float(grey.std())
    if contrast < 1e-6:
        ctx.warn("the picture is flat: it has no features")
        return np.zeros(grey.shape, bool)
    grey = grey / (contrast * USUAL[method] * threshold)  # a feature's strength is 1 or more now
    if method == "canny":
        mask = _edges(grey, sigma)
    elif method == "ridges":
        mask = _ridges(grey, sigma, polarity)
    else:
        mask = _outlines(grey, sigma, polarity, neighbourhood)
    return _told(mask, ctx)


def _told(mask: Array, ctx: Context) -> Array:
    """Return the mask, with a warning if it is empty."""
    if not mask.any():
        ctx.warn("no features found: a lower threshold, another sigma or method may find some")
    return mask


def _edges(grey: Array, sigma: float) -> Array:
    from skimage.feature import canny

    # skimage's Sobel is a mean, half the difference of neighbours two apart
    edges: Array = canny(grey, sigma, 0.5, 1.0, mode="nearest")
    return edges


def _ridges(grey: Array, sigma: float, polarity: Polarity) -> Array:
    from scipy.ndimage import gaussian_filter
    from skimage.morphology import skeletonize

    yy, xy, xx = (gaussian_filter(grey, sigma, order=o, mode="nearest") * sigma**2 for o in ((2, 0), (1, 1), (0, 2)))
    middle, spread = (yy + xx) / 2, np.hypot((yy - xx) / 2, xy)
    # a line curves in one direction only: the larger eigenvalue less what curves the other way
    dark = middle + spread - np.maximum(spread - middle, 0)
    bright = spread - middle - np.maximum(middle + spread, 0)
    mask = np.zeros(grey.shape, bool)
    for side, strength in (("dark", dark), ("bright", bright)):
        if polarity in (side, "both"):
            mask |= skeletonize(strength > 1)
    return mask


def _outlines(grey: Array, sigma: float, polarity: Polarity, neighbourhood: float) -> Array:
    from scipy.ndimage import binary_erosion, gaussian_filter

    smooth = gaussian_filter(grey, sigma, mode="nearest")
    apart = smooth - gaussian_filter(grey, neighbourhood, mode="nearest")
    mask = np.zeros(grey.shape, bool)
    for side, difference in (("bright", apart), ("dark", -apart)):
        if polarity in (side, "both"):
            spots = difference > 1
            mask |= spots & ~binary_erosion(spots, border_value=1)
    return mask


def _coloured(image: Array, strokes: Strokes, samples: Array | None, sigma: float, threshold: float) -> Array:
    from scipy.ndimage import gaussian_filter
    from skimage.morphology import skeletonize

    height, width = image.shape[:2]
    strokes = strokes.read()
    unknown = {line.label for line in strokes.lines} - {"", "feature", "other"}
    if unknown:
        raise ValueError(f"strokes: expected labels 'feature' and 'other', or none, got {min(unknown)!r}")
    shown, other = (
        np.max([stroke_weights(strokes, width, height, label=label) for label in labels], axis=0) >= 0.5
        for labels in (("", "feature"), ("other",))
    )
    if samples is not None:
        shown = shown | samples
    other = other & ~shown if (other & ~shown).any() else ~shown
    if not shown.any() or not other.any():
        raise ValueError(
            f"strokes: expected strokes or samples on features, and some pixels without, got {int(shown.sum())} of "
            f"{shown.size} pixels shown"
        )
    smooth = gaussian_filter(image.astype(np.float64), (sigma, sigma, 0), mode="nearest")
    likelier = _log_likelihood(smooth, shown) - _log_likelihood(smooth, other)
    mask: Array = skeletonize(likelier > np.log(threshold))
    return mask


def _log_likelihood(colours: Array, sampled: Array) -> Array:
    """Log density (h, w) of the normal distribution of the sampled colours, less a constant."""
    known = colours[sampled]
    away = colours - known.mean(axis=0)
    inside = away[sampled]
    covariance = np.einsum("nc,nd->cd", inside, inside, optimize=False) / len(inside)
    covariance += GRAIN**2 * np.eye(len(covariance))
    distance = np.einsum("hwc,cd,hwd->hw", away, np.linalg.inv(covariance), away, optimize=False)
    density: Array = -0.5 * (distance + np.linalg.slogdet(covariance)[1])
    return density
