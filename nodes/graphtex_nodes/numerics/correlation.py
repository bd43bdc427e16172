"""Normalised cross-correlation of a template with every place of a picture of several channels."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

LEAST_OVERLAP = 0.25  # share of a template that must lie in the picture
LEAST_CONTRAST = 0.2  # share of a template's variance that must lie there
FLAT = 1e-4  # of the picture's variance: windows below it hold no structure, only rounding


class Correlator:
    """A picture (h, w, c) that templates up to `reach` = (rows, columns) are looked for in.

    One coefficient for all channels together (Padfield 2012 for the border: only pixels in the picture count),

    .. math:: \\gamma = \\frac{\\sum_{c,p} (I_c - \\bar I_c) (T_c - \\bar T_c)}
              {\\sqrt{\\sum_{c,p} (I_c - \\bar I_c)^2 \\sum_{c,p} (T_c - \\bar T_c)^2}}.
    """

    def __init__(self, image: Array, reach: tuple[int, int], threads: int = 1) -> None:
        from scipy.fft import next_fast_len, rfft2

        self.height, self.width, self.channels = image.shape
        self.threads = threads
        self.shape = tuple(
            next_fast_len(side + more, real=True) for side, more in zip(image.shape, reach, strict=False)
        )
        centred = np.moveaxis(image - image.mean(axis=(0, 1), dtype=np.float64), -1, 0).astype(np.float64)
        self.least = FLAT * float((centred**2).mean(axis=(1, 2)).sum())
        self._channels = rfft2(centred, self.shape, workers=threads)
        self._squares = rfft2((centred**2).sum(axis=0), self.shape, workers=threads)
        self._windows: dict[bytes, tuple[Array, Array]] = {}

    def correlate(self, template: Array, mask: Array) -> Array:
        """Coefficients (h, w) in [-1, 1] of a template (rows, columns, c), both odd, centred on each pixel.

        Only pixels of the template where `mask` (rows, columns) is True count. Where too little of it lies in the
        picture the coefficient is -1, where the picture is flat 0.
        """
        from scipy.fft import rfft2

        weights = mask.astype(np.float64)
        values = np.moveaxis(template, -1, 0).astype(np.float64)
        values = (values - (values * weights).sum(axis=(1, 2), keepdims=True) / weights.sum()) * weights
        sums, energy = self._window_sums(weights)
        spectrum = np.conj(rfft2(values, self.shape, workers=self.threads))
        product = self._back((self._channels * spectrum).sum(axis=0), mask.shape)
        count, squares = self._overlaps(np.stack([weights, (values**2).sum(axis=0)]))
        whole = float((values**2).sum())
        inside = np.maximum(count, 0.5)
        parts = self._overlaps(values)
        above = product - (sums * parts).sum(axis=0) / inside
        of_picture = energy - (sums**2).sum(axis=0) / inside
        of_template = squares - (parts**2).sum(axis=0) / inside
        seen = (of_picture > self.least * inside) & (of_template > 1e-12 * max(whole, 1e-300))
        scores = np.zeros((self.height, self.width))
        scores[seen] = np.clip(above[seen] / np.sqrt(of_picture[seen] * of_template[seen]), -1, 1)
        scores[(count < LEAST_OVERLAP * weights.sum()) | (of_template < LEAST_CONTRAST * whole)] = -1
        return scores

    def _window_sums(self, weights: Array) -> tuple[Array, Array]:
        """Sums of each channel and of the squares below the mask, centred on each pixel."""
        from scipy.fft import rfft2

        key = repr(weights.shape).encode() + weights.astype(bool).tobytes()
        if key not in self._windows:
            spectrum = np.conj(rfft2(weights, self.shape, workers=self.threads))
            sums = np.stack([self._back(channel * spectrum, weights.shape) for channel in self._channels])
            self._windows = {key: (sums, self._back(self._squares * spectrum, weights.shape))}
        return self._windows[key]

    def _back(self, spectrum: Array, size: tuple[int, ...]) -> Array:
        """Correlation from its spectrum, moved so that it belongs to the template's middle."""
        from scipy.fft import irfft2

        full = irfft2(spectrum, self.shape, workers=self.threads)
        moved = np.roll(full, (size[0] // 2, size[1] // 2), axis=(0, 1))
        result: Array = moved[: self.height, : self.width]
        return result

    def _overlaps(self, values: Array) -> Array:
        """Sums (k, h, w) of a template's values (k, rows, columns) over what of it lies in the picture."""
        table = np.zeros((len(values), values.shape[1] + 1, values.shape[2] + 1))
        np.cumsum(np.cumsum(values, axis=1), axis=2, out=table[:, 1:, 1:])
        top, bottom = _covered(self.height, values.shape[1])
        left, right = _covered(self.width, values.shape[2])
        rows = table[:, bottom] - table[:, top]
        result: Array = rows[:, :, right] - rows[:, :, left]
        return result


def _covered(size: int, window: int) -> tuple[Array, Array]:
    """First and last (exclusive) row of a window centred on each of `size` rows that lies within them."""
    place = np.arange(size)
    half = window // 2
    return np.maximum(half - place, 0), np.minimum(window, size - place + half)
