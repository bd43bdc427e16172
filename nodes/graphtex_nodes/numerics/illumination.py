"""Slow changes of light over a picture."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

DARKEST = 0.02  # of full light: below it a logarithm would follow noise
WHOLE = (slice(None), slice(None))


def evenly_lit(image: Array) -> Array:
    """A picture (h, w, c) without its slow changes of brightness, float32.

    The logarithm of brightness is fitted by a polynomial of degree two over the picture, by least squares, and taken
    off: ramps and the dark corners of a lens go, elements stay. The mean logarithm is kept.
    """
    return without_trend(image, light_trend(image))


def log_brightness(image: Array) -> Array:
    """Logarithm (h, w) of the mean of a picture's channels, float64."""
    result: Array = np.log(np.maximum(image.mean(axis=2, dtype=np.float64), DARKEST))
    return result


def light_trend(image: Array, elements: Array | None = None) -> Array:
    """Weights (5,) of the polynomial's terms x, y, x², x y and y², over coordinates from -1 to 1 less their means.

    Where it is known what lies in elements (h, w), these may be brighter or darker than the rest all over: one bright
    element in the middle of a picture is not taken for light there.
    """
    bright = log_brightness(image)
    terms = _terms(bright.shape, WHOLE)
    if elements is not None:
        terms = [*terms, elements - elements.mean()]
    gram = np.array([[(a * b).sum() for b in terms] for a in terms])
    if np.trace(gram) <= 0:
        return np.zeros(5)
    side = np.array([(term * bright).sum() for term in terms])
    weights: Array = np.linalg.solve(gram + 1e-9 * np.trace(gram) * np.eye(len(terms)), side)
    return weights[:5]


def without_trend(
    image: Array, weights: Array, shape: tuple[int, ...] | None = None, window: tuple[slice, slice] = WHOLE
) -> Array:
    """A picture, or that window of one of a larger shape, with a trend of light taken off, float32."""
    terms = _terms(image.shape[:2] if shape is None else shape, window)
    trend = sum(weight * term for weight, term in zip(weights, terms, strict=True))
    even: Array = (image / np.exp(trend)[..., None]).astype(np.float32)
    return even


def _terms(shape: tuple[int, ...], window: tuple[slice, slice]) -> list[Array]:
    """The polynomial's terms at the pixels of a window, each of mean 0 over the whole picture."""
    lines = []
    for side, part in zip(shape[:2], window, strict=True):
        place = np.linspace(-1, 1, side)
        place = place - place.mean()
        square = place * place
        lines += [place[part], (square - square.mean())[part]]
    y, yy, x, xx = lines[0][:, None], lines[1][:, None], lines[2][None], lines[3][None]
    size = (y.shape[0], x.shape[1])
    return [np.broadcast_to(term, size) for term in (x, y, xx, x * y, yy)]
