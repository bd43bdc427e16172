"""How much larger elements are here than there: by the shift between spectra, to which all detail adds."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

BANDS = 8
ACROSS, RECEDING = 128, 96  # pixels of a window along and across lines of equal scale
STEP = 0.04  # of log frequency
BLUR = 2  # steps by which spectra are smoothed
LOWEST = {False: 3.0, True: 2.0}  # cycles in a window; fewer are the window's own or light's
HIGHEST = 0.3  # cycles a pixel; more is noise of the camera and of JPEG
FARTHEST = 1.6  # shift that is tried
SHARED = 0.6  # of a spectrum, that must lie within the one which it is compared with


@dataclass(frozen=True)
class _Spectra:
    """Log power (bands, frequencies) at log frequencies, and the log size that each band should have."""

    axis: Array
    power: Array
    size: Array


def relative_slope(
    image: Array, target: Array, exemplar: Array, exemplar_scale: Array, *, receding: bool = False
) -> float:
    """Slope of log size of elements against the size they should have, over the same slope of the exemplar.

    The exemplar's bands, each shifted by its scale, give one common spectrum on a log axis; in any band of any picture
    the shift at which that agrees best with the band's spectrum is its log size. Where a centroid of the spectrum
    differs by a half between parts of one photograph, these shifts differ by a twentieth. An exemplar of 256 pixels,
    which gives the common spectrum, leaves an error of up to a tenth of the slope.

    Parameters
    ----------
    image, target
        (h, w, c) and the scale (h, w) that it should have, which changes downwards or upwards only.
    exemplar, exemplar_scale
        The same of the picture that it is made from.
    receding
        Compare along columns, in which sizes go as the scale squared, and not along rows.
    """
    own = _spectra(exemplar, exemplar_scale, receding)
    common = _common(own)
    return _slope(_spectra(image, target, receding), common) / _slope(own, common)


def _frequencies(receding: bool) -> Array:
    span = RECEDING if receding else ACROSS
    return np.arange(np.log(LOWEST[receding] / span), np.log(HIGHEST), STEP)


def _spectra(image: Array, scale: Array, receding: bool) -> _Spectra:
    """Spectra of bands of rows: along each row in windows, or of windows as high as the band."""
    line = np.log(scale.mean(axis=1, dtype=np.float64))
    height = RECEDING if receding else len(line) // BANDS
    power, sizes = [], []
    for top in np.linspace(0, len(line) - height, BANDS).astype(int):
        band = image[top : top + height].astype(np.float64)
        if receding:
            weights = np.hanning(height + 2)[1:-1]
            windows = [band.transpose(1, 0, 2)]
        else:
            weights = np.ones(height)
            starts = range(0, band.shape[1] - ACROSS + 1, ACROSS // 2)
            windows = [band[:, start : start + ACROSS] for start in starts]
        power.append(_log_power(windows, receding))
        sizes.append((2 if receding else 1) * np.average(line[top : top + height], weights=weights))
    return _Spectra(_frequencies(receding), np.array(power), np.array(sizes))


def _log_power(windows: list[Array], receding: bool) -> Array:
    """Log power times frequency of windows (lines, samples, channels), at `_frequencies`."""
    count = windows[0].shape[1]
    taper = np.hanning(count + 2)[1:-1, None]
    total = np.zeros(2 * count + 1)
    for window in windows:
        even = (window - (window * taper).sum(axis=1, keepdims=True) / taper.sum()) * taper
        total += (np.abs(np.fft.rfft(even, 4 * count, axis=1)) ** 2).sum(axis=(0, 2))
    frequency = np.exp(_frequencies(receding))
    power = np.interp(frequency, np.fft.rfftfreq(4 * count), total) * frequency
    reach = 3 * BLUR
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / BLUR) ** 2)
    smooth = np.convolve(np.pad(power, reach, mode="edge"), kernel / kernel.sum(), "valid")
    return np.asarray(np.log(smooth + 1e-9 * smooth.max()))


def _common(own: _Spectra) -> tuple[Array, Array]:
    """Log frequencies on the plane and the mean of the bands' spectra there, each with a gain of its own."""
    grid = np.arange(own.axis[0] + own.size.min(), own.axis[-1] + own.size.max(), STEP)
    shifted = np.array([_at(grid - size, own.axis, power) for size, power in zip(own.size, own.power, strict=True)])
    known = np.isfinite(shifted)
    levels, count = np.where(known, shifted, 0), known.sum(axis=0)
    gains = np.zeros((len(shifted), 1))
    for _ in range(20):
        mean = (levels - gains * known).sum(axis=0) / np.maximum(count, 1)
        gains = ((levels - mean) * known).sum(axis=1, keepdims=True) / known.sum(axis=1, keepdims=True)
    mean[count == 0] = np.nan
    return grid, mean


def _slope(spectra: _Spectra, common: tuple[Array, Array]) -> float:
    found = np.array([_shift(spectra.axis, power, common) for power in spectra.power])
    wanted = spectra.size - spectra.size.mean()
    return float((wanted * found).sum() / (wanted**2).sum())


def _shift(axis: Array, power: Array, common: tuple[Array, Array]) -> float:
    """Log size at which a spectrum agrees best with the common one."""
    best = (np.inf, 0.0)
    for shift in np.arange(-FARTHEST, FARTHEST, STEP / 2):
        apart = power - _at(axis + shift, *common)
        known = np.isfinite(apart)
        if known.mean() >= SHARED:
            best = min(best, (float(apart[known].var()), float(shift)))
    return best[1]


def _at(places: Array, axis: Array, values: Array) -> Array:
    """Values at places of an axis, NaN beyond its ends."""
    return np.asarray(np.interp(places, axis, values, left=np.nan, right=np.nan))
