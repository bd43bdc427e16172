"""A texture's structure: what repeats in it, how far its pixels are related, and whether it has outlines."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.window_mean import block_mean

Array = NDArray[np.float32]

LARGEST = 256
"""Autocorrelation is measured on at most this many pixels a side: a larger picture's middle is enough."""
STRENGTH = 0.3
"""Autocorrelation that a repeat must reach."""
RELATED = 0.1
"""Root mean square of the autocorrelation at a distance from which on pixels count as related there."""

SMALL, LARGE = 1 / 64, 3 / 64
"""Reach in an exemplar's smaller side up to which its elements are so small that it is seen as grain, and from which
they are told by their outlines."""
GRAIN, OUTLINES = 5.0, 7.0
"""Kurtosis of the steps between neighbouring pixels up to which an exemplar is grain, and from which it has outlines.
Sand has 4, grass and stone 4 to 6, generated bricks and cloth 8, pebbles 12, coins 17."""


class Structure(NamedTuple):
    """Distances in pixels: at which an image repeats itself, and the longest at which its pixels are related."""

    period: float
    reach: float


def structure(image: Array) -> Structure:
    """Measure the structure of an image (h, w, c) by its autocorrelation.

    The channels' autocorrelations are summed, a plane subtracted before, and each lag divided by its overlap. Lags up
    to a third of each side count. ``period`` is the distance of a local maximum that reaches :data:`STRENGTH`: the
    nearest of those within a fifth of the highest; 0 when there is none. ``reach`` is the largest distance, in whole
    pixels, at which pixels are :data:`RELATED`.

    Examples
    --------
    >>> wave = np.sin(np.arange(60, dtype=np.float32) * 2 * np.pi / 12)
    >>> found = structure(np.outer(wave, wave)[..., None])
    >>> round(found.period, 2)  # the nearest repeat is 6 down and 6 to the right
    8.49
    >>> found.reach  # no lags beyond a third of 60 pixels are looked at
    19.0
    """
    if min(image.shape[:2]) < 6:
        return Structure(0.0, 0.0)
    lags, rows, columns = autocorrelation(image)
    inner = lags[1:-1, 1:-1]
    peak = peaks(lags)
    distance = np.hypot(*np.meshgrid(rows[1:-1], columns[1:-1], indexing="ij"))
    peak &= distance > 2
    period = float(distance[peak & (inner >= 0.8 * inner[peak].max())].min()) if peak.any() else 0.0
    ring = np.rint(distance).astype(np.intp)
    power = np.bincount(ring.ravel(), inner.ravel() ** 2) / np.maximum(np.bincount(ring.ravel()), 1)
    power = power[: min(rows[-1], columns[-1])]
    return Structure(period, float(np.flatnonzero(power >= RELATED**2).max(initial=0)))


def outlined(picture: Array, usable: NDArray[np.bool_] | None = None) -> float:
    """Whether a picture (h, w, c) is grain, 0, or has elements with outlines, 1: few steps are large, the rest small.

    Told by the kurtosis of the steps between neighbouring pixels that are both ``usable`` (h, w); None = all are.
    """
    return _share_of_outlines(_squared_steps(picture, usable, 1))


def outlines(pictures: Sequence[Array], usable: NDArray[np.bool_] | None = None, size: int = 1) -> float:
    """:func:`outlined` of pictures (h, w, c) together, told by steps between squares of 2 ``size`` pixels a side.

    Noise of single pixels hides outlines less there than between neighbours. Of a mirrored picture it is the same.
    ``usable`` (h, w), if it is given, is that of an only picture.
    """
    steps = []
    for picture in pictures:
        picture = block_mean(picture, size) if size > 1 else picture
        sums = picture[1:] + picture[:-1]
        whole = None if usable is None else usable[1:] & usable[:-1]
        whole = None if whole is None else whole[:, 1:] & whole[:, :-1]
        steps += _squared_steps(sums[:, 1:] + sums[:, :-1], whole, 2)
    return _share_of_outlines(steps)


def _squared_steps(picture: Array, usable: NDArray[np.bool_] | None, apart: int) -> list[Array]:
    """Squared differences (n,) of ``usable`` pixels (h, w) that are so many pixels ``apart``, down and to the right."""
    down, right = picture[apart:] - picture[:-apart], picture[:, apart:] - picture[:, :-apart]
    steps = [np.einsum("ijk,ijk->ij", step, step) for step in (down, right)]
    if usable is not None:
        steps = [steps[0][usable[apart:] & usable[:-apart]], steps[1][usable[:, apart:] & usable[:, :-apart]]]
    return [step.ravel() for step in steps]


def _share_of_outlines(steps: Sequence[Array]) -> float:
    """0 (grain) to 1 (outlines) by the kurtosis of squared steps."""
    squared = np.concatenate(steps).astype(np.float64)
    mean = float(squared.mean()) if squared.size else 0.0
    kurtosis = float((squared**2).mean()) / mean**2 if mean > 0 else 0.0
    return float(np.interp(kurtosis, (GRAIN, OUTLINES), (0, 1)))


def grain(picture: Array, usable: NDArray[np.bool_] | None = None) -> float:
    """Whether a picture (h, w, c) is grain, 1, or has elements, 0, that show where they are cut.

    Grain has no outlines, see :func:`outlined`, or elements that are small beside the picture. Their size is not looked
    at where some pixels are not ``usable`` (h, w).
    """
    plain = 1 - outlined(picture, usable)
    if plain == 1 or usable is not None:
        return plain
    return max(plain, float(np.interp(structure(picture).reach / min(picture.shape[:2]), (SMALL, LARGE), (1, 0))))


def peaks(lags: Array) -> NDArray[np.bool_]:
    """Local maxima of an autocorrelation (h, w) that reach :data:`STRENGTH`: (h - 2, w - 2), its border is left out."""
    inner = lags[1:-1, 1:-1]
    result = inner >= STRENGTH
    for y in range(3):
        for x in range(3):
            if (y, x) != (1, 1):
                result &= inner >= lags[y : y + inner.shape[0], x : x + inner.shape[1]]
    return result


def autocorrelation(image: Array, blur: float = 0.0) -> tuple[Array, NDArray[np.intp], NDArray[np.intp]]:
    """Autocorrelation, 1 without lag (all 0 for a plane), and the rows and columns of its lags.

    The image (h, w, c) is smoothed before by a Gaussian of deviation ``blur``. Its middle counts, up to
    :data:`LARGEST` pixels a side, and lags up to a third of that.
    """
    from scipy.fft import fftfreq, irfft2, next_fast_len, rfft2, rfftfreq

    height, width = (min(LARGEST, side) for side in image.shape[:2])
    top, left = (image.shape[0] - height) // 2, (image.shape[1] - width) // 2
    part = np.array(np.moveaxis(image[top : top + height, left : left + width], -1, 0), np.float32, order="C")
    part -= part.mean(axis=(1, 2), keepdims=True, dtype=np.float64).astype(np.float32)
    for axis, side in ((1, height), (2, width)):
        slope = np.linspace(-1, 1, side, dtype=np.float32)
        fit = (part.mean(axis=3 - axis, dtype=np.float64) * slope).mean(axis=1) / (slope * slope).mean()
        part -= (fit[:, None] * slope).astype(np.float32).reshape(-1, *(side if n == axis else 1 for n in (1, 2)))
    rows, columns = (np.arange(-(side // 3) - 1, side // 3 + 2) for side in (height, width))
    shape = tuple(next_fast_len(side + side // 3 + 1, real=True) for side in (height, width))
    waves = rfft2(part, shape, axes=(1, 2))
    power = (waves.real**2 + waves.imag**2).sum(axis=0)
    if blur > 0:
        squares = fftfreq(shape[0])[:, None] ** 2 + rfftfreq(shape[1]) ** 2
        power *= np.exp(-((2 * np.pi * blur) ** 2) * squares).astype(np.float32)
    raw = irfft2(power, shape)
    overlap = np.outer(height - np.abs(rows), width - np.abs(columns))
    if raw[0, 0] <= 1e-12 * part.size:
        return np.zeros(overlap.shape, np.float32), rows, columns
    lags: Array = raw[np.ix_(rows, columns)] / overlap * (height * width / raw[0, 0])
    return lags, rows, columns
