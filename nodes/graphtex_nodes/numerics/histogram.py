"""Histogram matching by re-weighting (Kopf et al. 2007; Dong et al. 2008, equation 8), and even use of the exemplar."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

BINS = 16


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
        seen = exemplar[counted].reshape(-1, exemplar.shape[2])
        flat = exemplar.reshape(-1, exemplar.shape[2])
        self.low = seen.min(axis=0)
        spread = seen.max(axis=0) - self.low
        self.used = [c for c in range(flat.shape[1]) if spread[c] > 0]
        self.per_unit = np.where(spread > 0, BINS / np.where(spread > 0, spread, 1), 0).astype(np.float32)
        self.shape = exemplar.shape[:2]
        self.bins = {c: self._bin(flat[:, c], c) for c in self.used}
        weight = importance.ravel().astype(np.float64)
        self.wanted = {c: np.bincount(self.bins[c], weight, BINS) / weight.sum() for c in self.used}

    def _bin(self, values: Array, channel: int) -> NDArray[np.intp]:
        position = (values - self.low[channel]) * self.per_unit[channel]
        bins: NDArray[np.intp] = np.clip(position.astype(np.intp), 0, BINS - 1)
        return bins

    def pixel_weights(self, image: Array, gain: float, counted: NDArray[np.bool_] | None = None) -> Array:
        """Weight (h, w) of each pixel of the exemplar, 1 where its bins are not over-full in ``image``.

        Of the image only the ``counted`` pixels (h, w) count; None = all.
        """
        image = image.reshape(-1, image.shape[2]) if counted is None else image[counted]
        surplus = np.ones(self.shape[0] * self.shape[1], np.float64)
        if gain > 0:
            for channel in self.used:
                found = np.bincount(self._bin(image[:, channel], channel), minlength=BINS)
                share = found / found.sum()
                wanted = self.wanted[channel]
                excess = np.maximum(0, (share - wanted) / (wanted + 1 / (8 * BINS)))
                surplus += gain * excess[self.bins[channel]]
        return (1 / surplus).reshape(self.shape).astype(np.float32)


def usage(
    field: NDArray[np.int32], shape: tuple[int, int], radius: int, allowed: NDArray[np.bool_] | None = None
) -> Array:
    """How often each exemplar window is used, relative to the mean, averaged over a box of 2 radius + 1 windows.

    ``field`` (..., 2) holds rows and columns below ``shape``. Of windows that are not ``allowed`` (h, w) none counts.
    """
    counts = np.bincount((field[..., 0] * shape[1] + field[..., 1]).ravel(), minlength=shape[0] * shape[1])
    used = counts.reshape(shape) / max(1, counts.sum())
    if allowed is None:
        return box_mean(used * counts.size, radius)
    around = box_mean(allowed.astype(np.float64), radius)
    relative = box_mean(used * np.count_nonzero(allowed), radius) / np.where(around > 0, around, 1)
    return relative.astype(np.float32)


def box_mean(values: NDArray[np.float64], radius: int) -> Array:
    """Mean over the part of a (2 radius + 1)-box that lies inside the array (h, w)."""
    for axis in (0, 1):
        size = values.shape[axis]
        total = np.cumsum(values, axis=axis)
        total = np.concatenate([np.zeros_like(total.take([0], axis)), total], axis=axis)
        low = np.maximum(np.arange(size) - radius, 0)
        high = np.minimum(np.arange(size) + radius + 1, size)
        lengths = np.expand_dims(high - low, 1 - axis)
        values = (total.take(high, axis) - total.take(low, axis)) / lengths
    return values.astype(np.float32)
