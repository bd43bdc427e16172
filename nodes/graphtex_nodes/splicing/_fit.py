"""Where a picture fits best on what is there of a larger one."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Fit:
    """Mean squared differences of a piece (h, w, c) and a canvas (rows, columns, c) at all shifts, by FFT."""

    def __init__(self, piece: Array, size: tuple[int, int]) -> None:
        from scipy.fft import next_fast_len

        self.piece, self.size = piece.shape[:2], size
        self.padded = [next_fast_len(side + part - 1, real=True) for side, part in zip(size, self.piece, strict=True)]
        self.channels = self._transform(piece)
        self.squares = self._transform(_energy(piece))

    def best(
        self, canvas: Array, known: Array, wanted: tuple[int, int], overlap: float, gain: float
    ) -> tuple[int, int]:
        """Shift (row, column) at which the piece covers a wanted pixel and agrees best with the known pixels.

        Parameters
        ----------
        canvas, known
            What is there, (rows, columns, c), 0 where it is not known (rows, columns).
        overlap
            Least share of the piece on known pixels; less if no shift has so much.
        gain
            Least share of the most pixels that any such shift adds.
        """
        weights = known.astype(np.float32)
        both = self._transform(weights) * np.conj(self.squares)
        both -= 2 * np.einsum("ijc,ijc->ij", self._transform(canvas), np.conj(self.channels))
        shifts = [np.arange(place - side + 1, place + 1) for place, side in zip(wanted, self.piece, strict=True)]
        at = np.ix_(*shifts)
        shared = _sums(weights, self.piece, shifts)
        difference = self._inverse(both)[at] + _sums(_energy(canvas), self.piece, shifts)
        added = _sums(1 - weights, self.piece, shifts)
        least = overlap * self.piece[0] * self.piece[1]
        allowed = shared >= min(least, float(shared.max()))
        allowed &= added >= gain * float(added[allowed].max())
        score = np.where(allowed, np.maximum(difference, 0) / np.maximum(shared, 1), np.inf)
        row, column = np.unravel_index(int(score.argmin()), score.shape)
        return int(shifts[0][row]), int(shifts[1][column])

    def _transform(self, array: Array) -> Array:
        from scipy.fft import rfft2

        result: Array = rfft2(array.astype(np.float32, copy=False), self.padded, axes=(0, 1))
        return result

    def _inverse(self, spectrum: Array) -> Array:
        """Correlation at shifts of 0 and more; negative ones count from the end."""
        from scipy.fft import irfft2

        result: Array = irfft2(spectrum, self.padded, axes=(0, 1))
        return result


def _energy(picture: Array) -> Array:
    """Sums of the squares of a picture's (h, w, c) channels."""
    result: Array = np.einsum("ijc,ijc->ij", picture, picture)
    return result


def _sums(values: Array, piece: tuple[int, ...], shifts: list[Array]) -> Array:
    """Sums of values over a piece's rectangle at each of some row and column shifts."""
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1))
    np.cumsum(np.cumsum(values, axis=0), axis=1, out=total[1:, 1:])
    (top, left), (bottom, right) = (
        [np.clip(shift + more, 0, side) for shift, more, side in zip(shifts, extra, values.shape, strict=True)]
        for extra in ((0, 0), piece)
    )
    result: Array = total[np.ix_(bottom, right)] - total[np.ix_(top, right)] - total[np.ix_(bottom, left)]
    return result + total[np.ix_(top, left)]
