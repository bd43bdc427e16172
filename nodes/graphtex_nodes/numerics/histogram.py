"""Histogram matching by re-weighting (Kopf et al. 2007; Dong et al. 2008, equation 8)."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

BINS = 16
SEEN_PIXELS = 65536
"""Pixels that tell an image's histogram; of one with three times as many only a part is looked at."""


class Histograms:
    """Histograms of an exemplar's channels, and the weights that pull a synthesis towards them.

    Equation 8 as printed compares whole windows' bins and frequencies that sum to 1, too small to act beside the 1 in
    its denominator. Here the bin is that of the pixel that is proposed, and the surplus of a bin is relative:

    .. math:: 1 + \\lambda \\sum_j \\max\\left(0, \\frac{H_{x,j}(b) - H_{e,j}(b)}{H_{e,j}(b) + 1 / (8 B)}\\right)

    with B bins a channel and the gain lambda.
    """

    def __init__(self, exemplar: Array, importance: Array, counted: NDArray[np.bool_] | slice = slice(None)) -> None:
        """``exemplar`` (h, w, c), ``importance`` (h, w): how much of each pixel the output should hold, mean 1.

        ``counted`` pixels (h, w) make the range of the bins; others should have importance 0.
        """
        channels = [np.ascontiguousarray(exemplar[..., c]) for c in range(exemplar.shape[2])]
        seen = [channel[counted] for channel in channels]
        self.low = np.array([values.min() for values in seen])
        spread = np.array([values.max() for values in seen]) - self.low
        self.used = np.flatnonzero(spread > 0).tolist()
        self.per_unit = np.where(spread > 0, BINS / np.where(spread > 0, spread, 1), 0).astype(np.float32)
        self.shape = exemplar.shape[:2]
        self.bins = {c: self._bin(channels[c].ravel(), c) for c in self.used}
        weight = importance.ravel().astype(np.float64)
        self.wanted = {c: np.bincount(self.bins[c], weight, BINS) / weight.sum() for c in self.used}

    def _bin(self, values: Array, channel: int) -> NDArray[np.intp]:
        position = (values - self.low[channel]) * self.per_unit[channel]
        bins: NDArray[np.intp] = np.clip(position, 0, BINS - 1, out=position).astype(np.intp)
        return bins

    def pixel_weights(self, image: Array, gain: float, counted: NDArray[np.bool_] | None = None) -> Array:
        """Weight (h, w) of each pixel of the exemplar, 1 where its bins are not over-full in ``image``.

        Of the image only the ``counted`` pixels (h, w) count; None = all. Of a large one a regular part does.
        """
        surplus = np.ones(self.shape[0] * self.shape[1], np.float32)
        if gain > 0:
            pixels = image.reshape(-1, image.shape[2]) if counted is None else image[counted]
            pixels = pixels[:: _spacing(len(pixels), image.shape[1])]
            for channel in self.used:
                found = np.bincount(self._bin(pixels[:, channel], channel), minlength=BINS)
                share = found / found.sum()
                wanted = self.wanted[channel]
                excess = np.maximum(0, (share - wanted) / (wanted + 1 / (8 * BINS)))
                surplus += (gain * excess).astype(np.float32)[self.bins[channel]]
        return np.reciprocal(surplus, out=surplus).reshape(self.shape)


def _spacing(pixels: int, width: int) -> int:
    """Distance of the pixels that count: odd and no divisor of the width, so that they run through all columns."""
    spacing = 2 * (pixels // (2 * SEEN_PIXELS)) + 1
    while spacing > 1 and width % spacing == 0:
        spacing += 2
    return spacing
