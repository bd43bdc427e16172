"""Slow changes of light over a picture."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

DARKEST = 0.02  # of full light: below it a logarithm would follow noise


def evenly_lit(image: Array) -> Array:
    """A picture (h, w, c) without its slow changes of brightness, float32.

    The logarithm of brightness is fitted by a polynomial of degree two over the picture, by least squares, and taken
    off: ramps and the dark corners of a lens go, elements stay. The mean logarithm is kept.
    """
    height, width = image.shape[:2]
    bright = np.log(np.maximum(image.mean(axis=2, dtype=np.float64), DARKEST))
    y, x = np.linspace(-1, 1, height)[:, None], np.linspace(-1, 1, width)[None, :]
    terms = [np.broadcast_to(term, (height, width)) for term in (x, y, x * x, x * y, y * y)]
    terms = [term - term.mean() for term in terms]
    terms = [term for term in terms if np.ptp(term) > 1e-9]  # a line of pixels has none across it
    if not terms:
        return image.astype(np.float32)
    gram = np.array([[(a * b).sum() for b in terms] for a in terms])
    side = np.array([(term * bright).sum() for term in terms])
    weights = np.linalg.solve(gram + 1e-9 * np.trace(gram) * np.eye(len(terms)), side)
    trend = sum(weight * term for weight, term in zip(weights, terms, strict=True))
    even: Array = (image / np.exp(trend)[..., None]).astype(np.float32)
    return even
