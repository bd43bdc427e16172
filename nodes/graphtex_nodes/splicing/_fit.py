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
        # no more of the canvas is looked at than pieces that cover one pixel reach
        self.padded = [
            next_fast_len(side + min(side, whole) - 1, real=True) for side, whole in zip(self.piece, size, strict=True)
        ]
        self.spectra = np.conj(self._transform(_layers(-2 * piece, _energy(piece))))

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
        corner = [max(0, place - side + 1) for place, side in zip(wanted, self.piece, strict=True)]
        top, left = (slice(first, place + side) for first, place, side in zip(corner, wanted, self.piece, strict=True))
        canvas, known = canvas[top, left], known[top, left]
        shifts = [
            np.arange(place - side + 1, place + 1) - first
            for first, place, side in zip(corner, wanted, self.piece, strict=True)
        ]
        covered = [_covered(*each) for each in zip(shifts, self.piece, known.shape, strict=True)]
        spectrum = np.zeros(self.spectra.shape[1:], self.spectra.dtype)
        for ours, theirs in zip(self._transform(_layers(canvas, known)), self.spectra, strict=True):
            spectrum += ours * theirs
        shared = _sums(known, *covered)
        difference = self._inverse(spectrum)[np.ix_(*shifts)] + _sums(_energy(canvas), *covered)
        rows, columns = (last - first for first, last in covered)
        added = np.multiply.outer(rows, columns) - shared
        least = overlap * self.piece[0] * self.piece[1]
        allowed = shared >= min(least, float(shared.max()))
        allowed &= added >= gain * float(added[allowed].max())
        score = np.where(allowed, np.maximum(difference, 0) / np.maximum(shared, 1), np.inf)
        row, column = np.unravel_index(int(score.argmin()), score.shape)
        return int(shifts[0][row]) + corner[0], int(shifts[1][column]) + corner[1]

    def _transform(self, layers: Array) -> Array:
        from scipy.fft import rfft2

        result: Array = rfft2(layers, self.padded)
        return result

    def _inverse(self, spectrum: Array) -> Array:
        """Correlation at shifts of 0 and more; negative ones count from the end."""
        from scipy.fft import irfft2

        result: Array = irfft2(spectrum, self.padded)
        return result


def _layers(picture: Array, last: Array) -> Array:
    """A picture's channels and one more, (c + 1, h, w), float32."""
    result = np.empty((picture.shape[2] + 1, *last.shape), np.float32)
    result[:-1] = np.moveaxis(picture, 2, 0)
    result[-1] = last
    return result


def _energy(picture: Array) -> Array:
    """Sums of the squares of a picture's (h, w, c) channels."""
    result: Array = np.einsum("ijc,ijc->ij", picture, picture)
    return result


def _covered(shifts: Array, piece: int, side: int) -> tuple[Array, Array]:
    """First row or column, and the one after the last, that a piece covers of a canvas at each of some shifts."""
    return np.clip(shifts, 0, side), np.clip(shifts + piece, 0, side)


def _sums(values: Array, rows: tuple[Array, Array], columns: tuple[Array, Array]) -> Array:
    """Sums of values (h, w) from each first to the row and column before each last."""
    total = np.zeros((values.shape[0] + 1, values.shape[1] + 1), np.int64 if values.dtype == bool else np.float64)
    np.cumsum(values, axis=0, out=total[1:, 1:])
    np.cumsum(total[1:, 1:], axis=1, out=total[1:, 1:])
    (top, bottom), (left, right) = rows, columns
    result: Array = total[np.ix_(bottom, right)] - total[np.ix_(top, right)] - total[np.ix_(bottom, left)]
    result += total[np.ix_(top, left)]
    return result
