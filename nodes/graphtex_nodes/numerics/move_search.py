"""Search for moves over a plane after which a picture fits what is known around a hole (He & Sun 2012, over planes)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work, for_each
from graphtex_nodes.numerics.plane_moves import Move, Slope

Array = NDArray[Any]

OVERLAP = 8
"""Pixels around the hole over which pieces must agree with what is known."""
RADII = 8, 40
"""Least and most pixels of the discs around them: about as far as the hole's middle is from its border."""
NARROW = 12
"""Pixels of further discs where those are larger: what fits there need not reach far, but meets the border well."""
FEWEST = 16
"""Known pixels that an anchor needs."""
APART = 3
"""Pixels between two moves."""
FARTHEST, NEAREST = 0.4, 2.5
"""Scales relative to the hole's middle between which the plane is searched."""
ENLARGED, REDUCED = 1.0, 0.25
"""What a move costs that shows its source twice, or half, as large, in units of its own mismatch: it blurs."""
UNLIKE = 3.0
"""What a shift costs that takes texture of twice or half the scale as it is, likewise."""
HIDDEN = 0.3
"""Share of the hole around an anchor for which a move may have no source."""
OUTSIDE = -(1 << 20)
"""In place of a shift that leads out of the picture."""
SEEN = 0.95
"""Share of the known pixels around an anchor for which a move must have a source."""
STEPS = 500
"""Elementary steps for each pixel of a sheet that finding the moves of an anchor takes: ten transforms."""
SHORTEST = 3
"""Pixels: moves shorter than this only smear the border."""


@dataclass(frozen=True)
class Level:
    """A picture (h, w, c) of some size, what may be copied and what is to fill (h, w)."""

    picture: Array
    usable: Array
    hole: Array

    @property
    def region(self) -> Array:
        """The hole and the known pixels around it that pieces must agree with."""
        from scipy.ndimage import binary_dilation

        return np.asarray(binary_dilation(self.hole, np.ones((3, 3), bool), iterations=OVERLAP))


@dataclass(frozen=True)
class Sheet:
    """A plane's picture laid flat on a grid of (v, u) with pixels as large as those at the slope's place.

    ``colours`` (h, w, c) are 0 where not ``known`` (h, w); ``usable`` (h, w) may be copied; ``hole`` (h, w); ``scale``
    (h, w) relative to the place; ``corner`` are v, u of the first pixel.
    """

    colours: Array
    known: Array
    usable: Array
    hole: Array
    scale: Array
    corner: tuple[int, int]


def laid_flat(slope: Slope, level: Level) -> Sheet:
    """The sheet of a picture, as far as it is not much smaller or larger than at the slope's place."""
    from scipy.ndimage import map_coordinates

    colours, usable, hole = level.picture, level.usable, level.hole
    rows, columns = (np.asarray(each) for each in np.indices(hole.shape))
    scale = slope.scale(rows, columns)
    if slope.flat:
        known = ~hole
        corner = (-round(slope.row), -round(slope.column))
        return Sheet(np.where(known[..., None], colours, 0), known, usable, hole, scale, corner)
    near = (scale > FARTHEST) & (scale < NEAREST)
    v, u = slope.to_plane(rows[near], columns[near])
    low_v, low_u = int(np.floor(v.min())), int(np.floor(u.min()))
    v, u = np.mgrid[low_v : int(np.ceil(v.max())) + 1, low_u : int(np.ceil(u.max())) + 1].astype(np.float64)
    there = 1 - slope.down * v - slope.right * u
    seen = (there > 1 / NEAREST) & (there < 1 / FARTHEST)
    rows, columns = slope.to_picture(np.where(seen, v, 0), np.where(seen, u, 0))
    height, width = hole.shape
    seen &= (rows >= 0) & (rows <= height - 1) & (columns >= 0) & (columns <= width - 1)
    nearest = np.rint(rows).clip(0, height - 1).astype(np.intp), np.rint(columns).clip(0, width - 1).astype(np.intp)
    known = seen & ~hole[nearest]
    places = np.stack([rows, columns])
    found = [map_coordinates(channel, places, order=1, mode="nearest") for channel in np.moveaxis(colours, -1, 0)]
    return Sheet(
        np.where(known[..., None], np.stack(found, axis=-1), 0), known, seen & usable[nearest], seen & hole[nearest],
        1 / np.where(seen, there, 1), (low_v, low_u),
    )  # fmt: skip


def anchors(sheet: Sheet, most: int) -> list[tuple[Array, int]]:
    """Places along the border of the hole, spread evenly: discs around them as masks, and their radius.

    The first is a band along all of the border instead, with radius 0. Then come less than ``most`` discs about as wide
    as the hole and, where these are not narrow themselves, as many narrow ones.
    """
    from scipy.ndimage import binary_erosion, distance_transform_edt

    border = np.argwhere(sheet.hole & ~binary_erosion(sheet.hole, border_value=1))
    if not len(border):
        return []
    depth = float(distance_transform_edt(np.pad(sheet.hole, 1)).max())
    radius = int(np.clip(depth, *RADII))
    places = [(np.asarray(distance_transform_edt(~sheet.hole) <= radius / 2), 0)]
    y, x = np.ogrid[: sheet.hole.shape[0], : sheet.hole.shape[1]]
    for reach in (radius, NARROW) if radius > NARROW else (radius,):
        for row, column in _spread_out(border, reach, most - 1):
            places.append(((y - row) ** 2 + (x - column) ** 2 <= reach**2, reach))
    return places


def _spread_out(points: Array, apart: float, most: int) -> Array:
    """At most so many of the points (n, 2), each the farthest from those before it, and none nearer than ``apart``."""
    away = np.full(len(points), np.inf)
    chosen = [0]
    while len(chosen) < most:
        away = np.minimum(away, np.hypot(*(points - points[chosen[-1]]).T))
        if away.max() < apart:
            break
        chosen.append(int(np.argmax(away)))
    result: Array = points[chosen]
    return result


def _shifts(used: Array, period: int) -> Array:
    """The shift that each term of a cyclic correlation stands for: those that leave used places inside; or OUTSIDE."""
    first, last = np.flatnonzero(used)[[0, -1]]
    shift = np.arange(period)
    shift = np.where(shift < used.size - last, shift, shift - period)
    return np.where(shift >= -first, shift, OUTSIDE)


@dataclass(frozen=True)
class Fit:
    """A move and how it was found.

    Attributes
    ----------
    cost
        Mean squared mismatch with what is known around the anchor, penalties included.
    anchor
        Number of the anchor; 0 is the whole border.
    row, column, radius
        The anchor's disc in the picture; radius 0: all of the border.
    distortion
        How much log2 of the scale differs over the length of a plain shift; 0 of moves over the plane.
    """

    cost: float
    move: Move
    anchor: int
    row: float
    column: float
    radius: float
    distortion: float = 0.0

    def distorted(self, steepness: float) -> "Fit":
        """The fit of a plain shift on a plane whose log2 of scale changes so much for each pixel."""
        length = float(np.hypot(self.move.down, self.move.right))
        return replace(self, distortion=steepness * length) if self.move.slope.flat else self


@dataclass(frozen=True)
class _Spectra:
    """Fourier transforms of a sheet, padded to a ``shape``: what is usable, its squares, channels, and log scale."""

    shape: tuple[int, int]
    usable: Array
    squares: Array
    colours: list[Array]
    logs: Array | None


def fits(
    slope: Slope, sheet: Sheet, places: Sequence[tuple[Array, int]], log_scale: Array | None, best: int, work: Work
) -> list[Fit]:
    """The ``best`` moves of each of the anchors, by Fourier transforms: all shifts of the sheet at a time.

    Parameters
    ----------
    log_scale
        log2 of the texel scale (h, w) for a flat slope: shifts should keep it. None: they need not.
    """
    from scipy.fft import next_fast_len, rfft2

    height, width = (next_fast_len(side, real=True) for side in sheet.hole.shape)

    def transform(values: Array) -> Array:
        return rfft2(values.astype(np.float32), (height, width))

    # what all colours have in common would cost single precision its digits
    middle = sheet.colours[sheet.usable].mean(axis=0, dtype=np.float64)
    sheet = replace(sheet, colours=(sheet.colours - middle).astype(np.float32))
    colours = np.moveaxis(np.where(sheet.usable[..., None], sheet.colours, 0), -1, 0)
    spectra = _Spectra(
        (height, width),
        transform(sheet.usable),
        transform((colours**2).sum(axis=0)),
        [transform(channel) for channel in colours],
        None if log_scale is None else transform(np.where(sheet.usable, log_scale, 0)),
    )
    found: list[list[Fit]] = [[] for _ in places]

    def search(number: int) -> None:
        found[number] = _best_moves(slope, sheet, spectra, number, places[number], log_scale, best)

    for_each(search, len(places), STEPS * float(height * width), work)
    return [fit for each in found for fit in each]


def _conjugate(values: Array, top: int, shape: tuple[int, int]) -> Array:
    """Conjugate transform of values in the rows from ``top`` on, 0 elsewhere: other rows need no transform."""
    from scipy.fft import fft, rfft

    spectrum = np.zeros((shape[0], shape[1] // 2 + 1), np.complex64)
    spectrum[top : top + len(values)] = rfft(values.astype(np.float32), shape[1])
    spectrum = fft(spectrum, axis=0, overwrite_x=True)
    result: Array = np.conj(spectrum, out=spectrum)
    return result


def _best_moves(
    slope: Slope, sheet: Sheet, spectra: _Spectra, number: int, place: tuple[Array, int], log_scale: Array | None,
    best: int,
) -> list[Fit]:  # fmt: skip
    """The ``best`` moves of one anchor."""
    from scipy.fft import irfft2

    (anchor, radius), shape = place, spectra.shape
    used = np.flatnonzero(anchor.any(axis=1))
    top, box = int(used[0]), slice(used[0], used[-1] + 1)
    seen, hidden = anchor[box] & sheet.known[box], anchor[box] & sheet.hole[box]
    count, missing = int(seen.sum()), int(hidden.sum())
    if count < FEWEST:
        return []
    mask, wanted = _conjugate(seen, top, shape), np.moveaxis(np.where(seen[..., None], sheet.colours[box], 0), -1, 0)
    cost = mask * spectra.squares
    cost += _conjugate((wanted**2).sum(axis=0), top, shape) * spectra.usable
    cross = np.zeros_like(cost)
    for one, other in zip(wanted, spectra.colours, strict=True):
        cross += _conjugate(one, top, shape) * other
    cost -= 2 * cross
    here = np.maximum(irfft2(mask * spectra.usable, shape), 1)
    cost = np.maximum(irfft2(cost, shape) / here, 0)
    covered = irfft2(_conjugate(hidden, top, shape) * spectra.usable, shape)
    down, right = (_shifts(np.asarray(anchor.any(axis=1 - axis)), shape[axis]) for axis in (0, 1))
    valid = np.outer(down != OUTSIDE, right != OUTSIDE)
    valid &= (here > SEEN * count) & (covered > (1 - HIDDEN) * missing)
    short = np.ix_(abs(down) < SHORTEST, abs(right) < SHORTEST)
    valid[short] &= down[short[0]] ** 2 + right[short[1]] ** 2 >= SHORTEST**2
    middle = (np.argwhere(hidden) + np.array([top, 0])).mean(axis=0) + sheet.corner
    if spectra.logs is not None and log_scale is not None:
        cost *= 1 + UNLIKE * abs(irfft2(mask * spectra.logs, shape) / here - log_scale[box][seen].mean())
    elif not slope.flat:
        there = 1 - slope.down * (middle[0] + down[:, None]) - slope.right * (middle[1] + right)
        enlarged = np.log2(np.maximum(there, 1e-3) / (1 - slope.down * middle[0] - slope.right * middle[1]))
        cost *= 1 + ENLARGED * np.maximum(enlarged, 0) + REDUCED * np.maximum(-enlarged, 0)
    row, column = (float(x) for x in slope.to_picture(*middle))
    cost[~valid] = np.inf
    found: list[Fit] = []
    for _ in range(best):
        at = np.unravel_index(int(np.argmin(cost)), cost.shape)
        if not np.isfinite(cost[at]):
            break
        move = Move(slope, int(down[at[0]]), int(right[at[1]]))
        found.append(Fit(float(cost[at]), move, number, row, column, radius))
        cost[np.ix_(abs(down - move.down) <= APART, abs(right - move.right) <= APART)] = np.inf
    return found
