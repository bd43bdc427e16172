"""Thin features whose density tells the size of texels (Dong, Zhou & Paul 2008, section 3.1; Wu & Yu 2004)."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, node
from graphtex_nodes.numerics.principal import principal_channels
from graphtex_nodes.numerics.pyramid import halve
from graphtex_nodes.numerics.strokes import Strokes, stroke_weights

Array = NDArray[Any]
Method = Literal["canny", "ridges", "contrast", "scribbles"]
Polarity = Literal["both", "bright", "dark"]

USUAL: dict[Method, float] = {"canny": 1.9, "ridges": 0.15, "contrast": 0.3}
"""Threshold 1 of each method, in standard deviations of a colour component."""
FAINTEST = 0.05  # variance of a colour component over that of the largest; less shows noise
LARGEST = 2048  # pixels of the longer side of a picture in which features are sought
SMALLEST = 128  # pixels of the shorter side that are left at least when a picture is halved for its softness
LEAST_SHARE = 0.1  # of pixels on ridges: 0.1 to 0.9 in most sharp photographs, below 0.05 in those enlarged threefold
FLAT = 1e-6  # standard deviation of a component that is rounding
MOST = 3  # components; more would fill a mask
FINE = 0.8  # sigma that tells whether there is detail as fine as pixels
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
    sigma: Annotated[float, Field(gt=0, le=32, description="smoothing before anything else, pixels")] = FINE,
    threshold: Annotated[float, Field(gt=0, description="how strong a feature must be, 1 suits most pictures")] = 1.0,
    polarity: Annotated[Polarity, Field(description="bright or dark lines and spots, or both")] = "both",
    neighbourhood: Annotated[float, Field(gt=0, description="method contrast: radius to compare with, pixels")] = 8.0,
    halvings: Annotated[
        int | None, Field(ge=0, le=8, description="how often the picture is halved first; none: by the picture")
    ] = None,
    strokes: Annotated[Strokes, Field(description="method scribbles: on features, and with label other beside")] = NONE,
    ctx: Context = QUIET,
) -> Mask:
    """Mask of thin features: lines one pixel wide, so that there are fewer of them where texels are larger.

    Filled regions would not do: the share of a picture that stones cover is the same for small and large stones, but
    the length of their outlines is not. That is what `FeatureScale` relies on.

    Parameters
    ----------
    image
        (h, w, c) of any number of channels. Features are sought in each of the first three principal components of its
        colours (of those with 5 % of the first one's variance), so that flowers of all colours show on grass; the last
        of two or four channels is taken for alpha and not seen.
    method
        ``canny``: edges (Canny 1986), strong ones and the weak ones of half the threshold that continue them.
        ``ridges``: centre lines of lines (mortar, gaps, blades), where the Hessian's larger eigenvalue stands out.
        ``contrast``: outlines of what differs from the mean of its neighbourhood.
        ``scribbles``: centre lines of what has the colours that strokes or samples show.
    sigma
        Standard deviation of the Gaussian, for ridges about half the width of a line, in pixels after the halvings.
        Grain finer than this is passed over: raise it for photographs in which only the near texels show grain.
    threshold
        Relative to a value for each method that was found to suit most pictures, in standard deviations of a
        component: 1.9 for canny's gradient (change over two pixels), 0.15 for the curvature of ridges (times sigma²),
        0.3 for the difference of contrast. For scribbles the ratio of likelihoods, feature over the rest.
    halvings
        Features are sought in the picture halved so often (which takes little memory too), and the mask is that one
        magnified. Without a value, as often as makes the longer side 2048 pixels at most, and on while ridges of
        threshold 1 cover less than 10 % of the picture, which then shows no detail as fine as its pixels, down to 128
        pixels. So a large soft photograph gives about the mask of a small sharp one.
    polarity
        Which ridges or spots. An edge has a bright and a dark side, so canny takes ``both`` only, and so do scribbles.
    strokes, samples
        Where features are: strokes without a label or with ``feature``, and pixels of the mask. Strokes with the label
        ``other`` show what is none; without these, all that is not shown. Either side is a normal distribution of
        colours. A mask that is finished needs none of this: give it to `FeatureScale` as it is.

    Returns
    -------
    Mask
        (h, w), True on features: lines of one pixel, or of 2 ** halvings. All False (with a warning) if there are none.

    Raises
    ------
    ValueError
        A polarity with canny or scribbles; scribbles without a pixel, or on all pixels, or with an unknown label.

    Notes
    -----
    On rendered planes (pebbles, flowers, bricks, cloth at slants of 45 to 60) the rank correlation of the scale that
    `FeatureScale` makes of it with the truth was 0.96 or better for ridges. With the first component alone it was as
    low as 0.87 for flowers over grass: that tells white flowers from grass, but not red ones. For canny it was 0.95 or
    better but for flowers (0.77). Rippled sand defeats all: its grain is finer than what is left of it far away.
    """
    if method in ("canny", "scribbles") and polarity != "both":
        raise ValueError(f"polarity: method {method} knows no sides, expected 'both', got {polarity!r}")
    small, count = _sharp(image) if halvings is None else (_halved(image, halvings), halvings)
    factor = 1 << count
    ctx.progress(0.3, f"features of {small.shape[1]} x {small.shape[0]} pixels")
    if method == "scribbles":
        mask = _coloured(small, *_shown(image.shape, strokes, samples, factor), sigma, threshold)
    else:
        components = principal_channels(small, FAINTEST)[:MOST]
        if components[0].std() < FLAT:
            ctx.warn("the picture is flat: it has no features")
            return np.zeros(image.shape[:2], bool)
        mask = np.zeros(small.shape[:2], bool)
        for component in components:
            grey = component / (component.std() * USUAL[method] * threshold)  # a feature's strength is 1 or more now
            if method == "canny":
                mask |= _edges(grey, sigma)
            elif method == "ridges":
                mask |= _ridges(grey, sigma, polarity)
            else:
                mask |= _outlines(grey, sigma, polarity, neighbourhood)
    if not mask.any():
        ctx.warn("no features found: a lower threshold, more halvings, another sigma or method may find some")
    return mask.repeat(factor, axis=0).repeat(factor, axis=1)[: image.shape[0], : image.shape[1]]


def _halved(image: Array, count: int) -> Array:
    """The picture halved so often."""
    for _ in range(count):
        image = halve(image)
    return image


def _sharp(image: Array) -> tuple[Array, int]:
    """A picture halved until it has detail as fine as its pixels, and how often; where it never has, the best."""
    count = 0
    while max(image.shape[:2]) > LARGEST:
        image, count = halve(image), count + 1
    share, best = _ridge_share(image), (image, count)
    while share < LEAST_SHARE and min(image.shape[:2]) >= 2 * SMALLEST:
        image, count = halve(image), count + 1
        if (found := _ridge_share(image)) > share:
            share, best = found, (image, count)
    return best


def _ridge_share(image: Array) -> float:
    """Share of a picture's pixels whose curvature is that of ridges, by the component with most of them."""
    shares = [0.0]
    for component in principal_channels(image, FAINTEST)[:MOST]:
        if (spread := component.std()) >= FLAT:
            strengths = _ridge_strengths(component / (spread * USUAL["ridges"]), FINE)
            shares.append(float(np.mean(np.maximum(*strengths) > 1)))
    return max(shares)


def _edges(grey: Array, sigma: float) -> Array:
    from skimage.feature import canny

    # skimage's Sobel is a mean, half the difference of neighbours two apart
    edges: Array = canny(grey, sigma, 0.5, 1.0, mode="nearest")
    return edges


def _ridges(grey: Array, sigma: float, polarity: Polarity) -> Array:
    from skimage.morphology import skeletonize

    mask = np.zeros(grey.shape, bool)
    for side, strength in zip(("dark", "bright"), _ridge_strengths(grey, sigma), strict=True):
        if polarity in (side, "both"):
            mask |= skeletonize(strength > 1)
    return mask


def _ridge_strengths(grey: Array, sigma: float) -> tuple[Array, Array]:
    """How much each pixel curves as a dark and as a bright line does."""
    from scipy.ndimage import gaussian_filter

    yy, xy, xx = (gaussian_filter(grey, sigma, order=o, mode="nearest") * sigma**2 for o in ((2, 0), (1, 1), (0, 2)))
    middle, spread = (yy + xx) / 2, np.hypot((yy - xx) / 2, xy)
    # a line curves in one direction only: the larger eigenvalue less what curves the other way
    return middle + spread - np.maximum(spread - middle, 0), spread - middle - np.maximum(middle + spread, 0)


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


def _shown(shape: tuple[int, ...], strokes: Strokes, samples: Array | None, factor: int) -> tuple[Array, Array]:
    """Pixels of the shrunk picture that are shown as features and as others, where any of theirs is."""
    height, width = shape[:2]
    strokes = strokes.read()
    unknown = {line.label for line in strokes.lines} - {"", "feature", "other"}
    if unknown:
        raise ValueError(f"strokes: expected labels 'feature' and 'other', or none, got {min(unknown)!r}")
    drawn, beside = (
        np.max([stroke_weights(strokes, width, height, label=label) for label in labels], axis=0) >= 0.5
        for labels in (("", "feature"), ("other",))
    )
    shown = _any_of(drawn if samples is None else drawn | samples, factor)
    other: Array = _any_of(beside, factor) & ~shown
    other = other if other.any() else ~shown
    if not shown.any() or not other.any():
        raise ValueError(
            f"strokes: expected strokes or samples on features, and some pixels without, got {int(shown.sum())} of "
            f"{shown.size} pixels shown"
        )
    return shown, other


def _any_of(mask: Array, factor: int) -> Array:
    """Where any of factor x factor pixels is True."""
    padded = np.pad(mask, [(0, -side % factor) for side in mask.shape])
    blocks = padded.reshape(padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    return np.asarray(blocks.any(axis=(1, 3)))


def _coloured(image: Array, shown: Array, other: Array, sigma: float, threshold: float) -> Array:
    """Middle lines of what is more likely of the shown colours than of the other ones."""
    from scipy.ndimage import gaussian_filter
    from skimage.morphology import skeletonize

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
