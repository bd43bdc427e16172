"""The vote: an image from the windows' sources, by iteratively re-weighted least squares."""

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import vote_kernels
from graphtex_nodes.numerics.parallel import Work, for_rows

Array = NDArray[np.float32]
Field = NDArray[np.int32]

FLOOR = 1e-3
"""Distances below this share of the mean distance weigh no more than it: a perfect window must not silence the rest."""


def robust_weights(costs: Array, exponent: float) -> Array:
    """Weights ||x - e||^(r - 2) of windows with the given squared distances (Dong et al. 2008, eq. 6), mean 1."""
    squared = np.maximum(costs, 0).astype(np.float64)
    mean = float(squared.mean())
    if mean <= 0:
        return np.ones_like(costs)
    weights = np.power(squared / mean + FLOOR, (exponent - 2) / 2)
    relative: Array = (weights / weights.mean()).astype(np.float32)
    return relative


def window_falloff(window: int, sharpness: float) -> Array:
    """Weights (n, n) of the places in a window: Gaussian around its centre, at the middle of a side exp(-sharpness)."""
    place = (np.arange(window) - (window - 1) / 2) / (window / 2)
    line = np.exp(-sharpness * place**2)
    return np.outer(line, line).astype(np.float32)


def weighted_pixels(exemplar: Array, weights: Array) -> Array:
    """Pixels of an exemplar (h, w, c) times their weights (h, w), with the weights as one more channel."""
    channels = exemplar.shape[2]
    weighted = np.empty((*weights.shape, channels + 1), np.float32)
    np.multiply(exemplar, weights[..., None], out=weighted[..., :channels])
    weighted[..., channels] = weights
    return weighted


def vote_mean(
    field: Field, weights: Array, weighted: Array, falloff: Array, step: int, image: Array, work: Work,
    known: NDArray[np.bool_] | None = None,
) -> None:  # fmt: skip
    """Write the weighted mean of what the covering windows propose into the first channels of ``image``.

    ``field`` (rows, columns, 2) and ``weights`` (rows, columns) belong to the windows, ``falloff`` (n, n) to the places
    in a window; ``weighted`` (h, w, channels + 1) are :func:`weighted_pixels`. Pixels that are ``known`` (h, w) stay;
    None = none.
    """
    flags = _flags(known, image)

    def band(first: int, stop: int) -> None:
        vote_kernels.vote_mean(field, weights, weighted, falloff, step, flags, image, first, stop)

    for_rows(band, image.shape[0], image.shape[1] * (len(falloff) / step) ** 2 * weighted.shape[2] / 4, work)


def vote_source(
    field: Field, weights: Array, exemplar: Array, falloff: Array, step: int, image: Array, work: Work,
    known: NDArray[np.bool_] | None = None, rim: int = 0,
) -> Field:  # fmt: skip
    """Row and column of one exemplar pixel for each pixel of ``image``: the source that most windows agree on.

    Both are -1 for ``known`` pixels (h, w); None = none are known. ``field`` counts from the corner of the ``exemplar``
    with its rim, whose pixels are not copied; the result without it.
    """
    source = np.full((*image.shape[:2], 2), -1, np.int32)
    flags = _flags(known, image)

    def band(first: int, stop: int) -> None:
        vote_kernels.vote_source(field, weights, exemplar, falloff, image, step, rim, flags, source, first, stop)

    for_rows(band, image.shape[0], image.shape[1] * (len(falloff) / step) ** 2 * 20, work)
    return source


def _flags(known: NDArray[np.bool_] | None, image: Array) -> NDArray[np.uint8]:
    return (np.zeros(image.shape[:2], bool) if known is None else np.ascontiguousarray(known)).view(np.uint8)
