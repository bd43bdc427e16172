"""The plane on which a picture's texture is the same everywhere: shape from texture by homogeneity."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.local_spectra import LocalSpectra, local_spectra, to_plane_frequencies
from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.plane import Plane
from graphtex_nodes.numerics.principal import principal_channels
from graphtex_nodes.numerics.window_mean import block_mean

Array = NDArray[Any]

SHORTEST = 48  # pixels: less holds no windows
LARGEST = 384  # pixels of the shorter side that are looked at
FAINTEST = 0.003  # variance of a colour component over that of the largest; less is noise
BINS = 12  # of direction, over half a turn
STEP = 0.15  # of log frequency between bins
GAIN = 0.25  # how far the contrast of windows may differ, as a standard deviation of log power
CAP = 4.0  # residuals of log power are cut here
MEMBERS = 3.0  # samples that a bin must have, for one to be compared with the others
ROUNDS = 2
NEAR_HORIZON = 0.02  # how much a plane's deviation counts more, the nearer its horizon comes to the picture
STEEPEST = 0.95  # loss of scale from the middle to the far corner
WORTH = 0.05  # of the deviation, that a plane saves which is more than chance
OUT_OF_REACH = 1 / 3  # of what a plane must save; finer searches make up for more
TELLING = 0.02  # standard deviation of log scale between windows; less is rounding
SHIFTS = np.linspace(-0.9, 0.9, 37)  # of log scale, tried for each window


@dataclass(frozen=True)
class Recession:
    """How a plane recedes: relative loss of scale for each pixel to the right and down, and how sure that is."""

    right: float
    down: float
    confidence: float


@dataclass(frozen=True)
class _Fit:
    """Windows brought onto a plane, and the spectrum that they have in common there."""

    cost: float
    common: Array
    first_row: int
    gains: Array
    scale: Array


def picture_recession(image: Array, usable: Array | None, work: Work, least: float = 0.0) -> Recession | None:
    """How the plane recedes that a picture (h, w, c) of at least :data:`SHORTEST` pixels a side shows where ``usable``.

    The search ends early, with no recession, where a confidence of ``least`` is far out of reach. None if too little is
    usable; no recession where there is no contrast.
    """
    factor = -(-min(image.shape[:2]) // LARGEST)
    colours = principal_channels(block_mean(image, factor, np.float64), FAINTEST)
    if colours[0].std() < 1e-6:
        return Recession(0.0, 0.0, 0.0)
    seen = None if usable is None else block_mean(usable[..., None], factor, np.float64)[..., 0] > 0.5
    # a few very bright or dark elements would be most of the power; what acts on single values keeps sizes
    soft = np.tanh(2 * colours / colours.std(axis=(1, 2), keepdims=True))
    soft = soft - soft.mean(axis=(1, 2), keepdims=True)
    found = receding_plane(soft / soft.std(axis=(1, 2), keepdims=True), seen, work, least)
    return found and Recession(found.right / factor, found.down / factor, found.confidence)


def receding_plane(channels: Array, usable: Array | None, work: Work, least: float = 0.0) -> Recession | None:
    """Find the plane on which local spectra are most alike; None if fewer than six windows can be compared.

    A texture that is homogeneous on a plane has one spectrum P there, whatever it is; at a place of the picture where
    the map to the plane has the Jacobian A, a window shows :math:`P(A^{-T} k) / |A|`. Only the right plane brings all
    windows onto one spectrum (as in Malik & Rosenholtz 1997, but with whole spectra over all windows at once instead of
    differences between neighbours). The deviation is the mean square of log power from the mean of its bin, cut at a
    cap, after a gain for each window. Foreshortening by the slant is a part of P, so elements need not be round.

    The picture has channels (n, h, w), each of mean 0 and variance 1. The search is a coarse grid, then Nelder & Mead's
    simplex. Then spectra are taken once more, from windows that are rectangles on the plane just found: with square
    windows of the picture, which hold more texels where these are small, the plane comes out too flat. More turns would
    add up what each has of noise.

    What varies at random lies on some plane too, though hardly better than on one seen head on. So the confidence is
    the share of scale's variance that the plane explains (see `_explained`), less where it saves little deviation.
    """
    from scipy.optimize import minimize

    height, width = channels.shape[1:]
    reach = max(height, width) / 2
    best = np.zeros(2)
    spectra: LocalSpectra | None = None

    def far_loss(loss: Array) -> float:
        return float((abs(loss[0]) * width + abs(loss[1]) * height) / (2 * reach))

    def plane_of(loss: Array) -> Plane | None:
        steepness = float(np.hypot(loss[0], loss[1])) / reach
        if far_loss(loss) > STEEPEST:
            return None
        return Plane(width, height, float(np.degrees(np.arctan2(loss[0], -loss[1]))), 1.0, 1.0, steepness)

    def cost(loss: Array) -> float:
        work.check()
        plane = plane_of(loss)
        assert spectra is not None
        if plane is None:
            return 1e3 * (1 + float(np.hypot(loss[0], loss[1])))
        return _fit(spectra, plane).cost * (1 - NEAR_HORIZON * float(np.log(1 - far_loss(loss) ** 2)))

    for turn in range(ROUNDS):
        work.progress(0.1 + 0.8 * turn / ROUNDS, "comparing windows")
        plane = plane_of(best)
        assert plane is not None
        found = local_spectra(channels, plane, usable, work)
        if found.count < 6:
            break  # too steep a plane leaves no windows: what was found before stays
        spectra = found
        if turn == 0:
            starts = _starts()
            costs = [cost(start) for start in starts]  # of the first of them nothing recedes
            best = starts[int(np.argmin(costs))]
            if 1 - min(costs) / costs[0] < OUT_OF_REACH * least * WORTH:
                return Recession(0.0, 0.0, 0.0)
        simplex = best + np.array([[0, 0], [0.06, 0], [0, 0.06]])
        best = minimize(
            cost, best, method="Nelder-Mead", options={"initial_simplex": simplex, "xatol": 3e-3, "fatol": 1e-5}
        ).x
    plane = plane_of(best)
    if spectra is None or plane is None:
        return None
    saved = 1 - cost(best) / cost(np.zeros(2))
    confidence = _explained(spectra, plane) * min(max(saved / WORTH, 0), 1)
    return Recession(float(best[0] / reach), float(best[1] / reach), confidence)


def _starts() -> list[Array]:
    """Return losses of scale (to the right, down) over half the longer side, from none to nearly all."""
    turns = np.radians(np.arange(0, 360, 20))
    starts = [np.zeros(2)]
    for loss in np.arange(0.12, 0.95, 0.12):
        starts += [loss * np.array([np.sin(turn), -np.cos(turn)]) for turn in turns]
    return starts


def _fit(spectra: LocalSpectra, plane: Plane) -> _Fit:
    """Deviation of the windows' spectra from one common spectrum on the plane."""
    radius, angle, scale = _on_plane(spectra, plane)
    power = spectra.power - 3 * np.log(scale)[spectra.window]
    first_row = int(np.floor(radius.min()))
    bins, shares, size = _bins(radius, angle, first_row, int(np.floor(radius.max())) - first_row + 2)
    members = np.bincount(bins.ravel(), shares.ravel(), size)
    counts = np.bincount(spectra.window, minlength=spectra.count)
    gains = np.zeros(spectra.count)
    for _ in range(4):
        level = power - gains[spectra.window]
        common = np.bincount(bins.ravel(), (shares * level).ravel(), size) / np.maximum(members, 1e-9)
        rest = power - (shares * common[bins]).sum(axis=0)
        gains = np.bincount(spectra.window, rest, spectra.count) / (counts + 2 / GAIN**2)
    # a sample is a part of the mean that it is compared with: as if it were left out
    company = (shares * members[bins]).sum(axis=0)
    own = np.minimum((shares**2).sum(axis=0) / np.maximum(company, 1e-9), 0.9)
    deviation = np.minimum(np.abs(rest - gains[spectra.window]) / (1 - own), CAP)
    compared = company > MEMBERS
    cost = float((deviation[compared] ** 2).mean()) if compared.any() else CAP**2
    return _Fit(cost + 0.02 * float((gains**2).mean()) / GAIN**2, common, first_row, gains, scale)


def _on_plane(spectra: LocalSpectra, plane: Plane) -> tuple[Array, Array, Array]:
    """Bin coordinates (log frequency, direction) of all samples on the plane, and the scale of each window."""
    across, along = plane.rotate(spectra.x, spectra.y)
    scale = plane.scale_at(along)
    sin, cos = np.sin(np.radians(plane.tilt)), np.cos(np.radians(plane.tilt))
    k_across, k_along = spectra.right * cos + spectra.down * sin, spectra.right * sin - spectra.down * cos
    u, v = to_plane_frequencies(plane, across[spectra.window], scale[spectra.window], k_across, k_along)
    return np.log(np.hypot(u, v)) / STEP, (np.arctan2(v, u) % np.pi) * (BINS / np.pi), scale


def _bins(radius: Array, angle: Array, first_row: int, rows: int) -> tuple[Array, Array, int]:
    """The four bins around each sample and its shares of them, (4, samples), and the number of bins."""
    row, column = np.floor(radius), np.floor(angle)
    down, right = radius - row, angle - column
    i, j = row.astype(np.intp) - first_row, column.astype(np.intp)
    bins = np.stack([(i + a).clip(0, rows - 1) * BINS + (j + b) % BINS for a in (0, 1) for b in (0, 1)])
    shares = np.stack([(down if a else 1 - down) * (right if b else 1 - right) for a in (0, 1) for b in (0, 1)])
    return bins, shares, rows * BINS


def _explained(spectra: LocalSpectra, plane: Plane) -> float:
    """Share of the variance of windows' log scale that lies on the plane.

    The rest is measured by the shift of log frequency with which each window agrees best with the common spectrum.
    """
    fit = _fit(spectra, plane)
    radius, angle, _ = _on_plane(spectra, plane)
    power = spectra.power - 3 * np.log(fit.scale)[spectra.window]
    rows = len(fit.common) // BINS
    counts = np.bincount(spectra.window, minlength=spectra.count)
    misfits = []
    for shift in SHIFTS:
        bins, shares, _ = _bins(radius + shift / STEP, angle, fit.first_row, rows)
        rest = power - 2 * shift - (shares * fit.common[bins]).sum(axis=0)
        gains = np.bincount(spectra.window, rest, spectra.count) / (counts + 2 / GAIN**2)
        deviation = np.minimum(np.abs(rest - gains[spectra.window]), CAP) ** 2
        misfits.append(np.bincount(spectra.window, deviation, spectra.count))
    beside = SHIFTS[np.argmin(np.array(misfits), axis=0)]
    on_plane = float(np.log(fit.scale).var())
    return on_plane / (on_plane + float((beside**2).mean()) + TELLING**2)
