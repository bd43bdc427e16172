"""What a synthesis has on a level before it searches: the exemplar's windows, and a canvas with what is known."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import evenness, lattice
from graphtex_nodes.numerics.evenness import Homes
from graphtex_nodes.numerics.frames import Frame, nearest_places, whole_windows
from graphtex_nodes.numerics.guidance import random_blocks
from graphtex_nodes.numerics.histogram import Histograms
from graphtex_nodes.numerics.lattice import Repeats
from graphtex_nodes.numerics.levels import Stage, coarse_repeats, rim
from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.problem import Array, Field, Flags, Given, Problem, Settings
from graphtex_nodes.numerics.transport import Market
from graphtex_nodes.numerics.voting import weighted_pixels, window_falloff
from graphtex_nodes.numerics.windows import DIRECTIONS, Basis, principal_basis

FADING = 0.25
"""Windows' sides over which the weight of what is not known yet falls to 1/e of that beside known pixels."""
LEAST = 0.05
"""Least such weight."""
HARDLY = np.float32(1e-4)
"""What a pixel of the exemplar's rim counts in a vote: enough where there is no other."""
QUICK = 2e10
"""Multiply-adds for all windows of an exemplar that take some tenths of a second."""


@dataclass(frozen=True)
class Windows:
    """The exemplar's windows on a level.

    Attributes
    ----------
    exemplar, rim
        The exemplar (h, w, c) with a rim so many pixels wide, where it is mirrored.
    basis, features
        Their components, and their coordinates (h, w, k).
    histograms
        Those of the exemplar's pixels.
    relief
        What share of a charge each pays (h, w).
    share
        How often each should be used (h, w), relative to the mean.
    allowed, nearest
        Those that may be used (h, w), and the nearest of them (h, w, 2) for each; None where all may.
    market
        What prices are found from; None where there are none.
    variance, grain
        Total variance of the coordinates where copies are charged for being close together, else 0, and whether the
        exemplar is grain: see :func:`evenness.crowd`.
    homes
        Number of the place that each shows (h, w) where some show the same; else None.
    """

    exemplar: Array
    rim: int
    basis: Basis
    features: Array
    histograms: Histograms
    relief: Array
    share: Array
    allowed: Flags | None
    nearest: Field | None
    market: Market | None
    variance: float
    grain: float
    homes: Homes | None = None


@dataclass(frozen=True)
class Level:
    """The exemplar's windows and the canvas on one level with one window.

    ``wanted`` are the windows that look for a source, ``known`` the canvas pixels that stay, ``trust`` how much windows
    count beside them; None where nothing is known.
    """

    windows: Windows
    canvas: Array
    voted: int
    frame: Frame
    falloff: Array
    wanted: Flags | None
    known: Flags | None
    trust: Array | None

    def weighted(self, gain: float) -> Array:
        """The exemplar's pixels with weights in a vote, by what the canvas holds too much of (equation 8).

        Those of the rim serve where nothing else is proposed.
        """
        counted = None if self.known is None or self.known.all() else ~self.known
        weights = self.windows.histograms.pixel_weights(self.canvas, gain, counted)
        if self.windows.rim:
            for lines in (weights, weights.T):
                lines[: self.windows.rim] *= HARDLY
                lines[-self.windows.rim :] *= HARDLY
        return weighted_pixels(self.windows.exemplar[..., : self.voted], weights)


def exemplar_windows(
    problem: Problem, settings: Settings, stage: Stage, step: int, given: Given, work: Work
) -> Windows:
    """The exemplar's windows on a level where those of the canvas lie ``step`` pixels apart.

    They are without coordinates where no iteration looks for any, as what was found before is copied.
    """
    window, width = stage.window, rim(stage.window, given.usable, given.grain)
    exemplar = np.pad(given.exemplar, ((width,) * 2, (width,) * 2, (0, 0)), "symmetric") if width else given.exemplar
    colours, channels = problem.exemplar.shape[2], exemplar.shape[2]
    counted = slice(None) if given.usable is None else given.usable
    histograms = Histograms(exemplar[..., : problem.voted], np.pad(given.importance, width), counted)
    allowed = None if given.usable is None else whole_windows(given.usable, window)
    nearest = None if allowed is None else nearest_places(allowed)
    share = np.maximum(centres(np.pad(given.importance, width, "symmetric"), window), 1e-3)
    if stage.iterations == 0:
        basis = Basis(window, np.zeros((0, 0), np.float32), np.zeros(0, np.float32))
        features = np.zeros((*share.shape, 0), np.float32)
        ones = np.ones_like(share)
        return Windows(exemplar, width, basis, features, histograms, ones, share, allowed, nearest, None, 0, 0)
    groups = [(slice(0, channels if settings.joint else colours), settings.detail)]
    if channels > colours and not settings.joint:
        groups.append((slice(colours, channels), 0.0))
    weights = [*(settings.weights or [1.0] * colours), *[1.0] * (channels - colours)]
    basis = principal_basis(exemplar, window, groups, settings.variance, work, allowed, weights, settings.directions)
    features = basis.project(exemplar, 1, work, allowed)
    market, variance = None, 0.0
    if given.known is None:
        market = evenness.places(features, share, evenness=settings.evenness, step=step, allowed=allowed)
        if evenness.crowded(share, evenness=settings.evenness, allowed=allowed):
            variance = float(features.var(axis=(0, 1), dtype=np.float64).sum())
    relief = evenness.local_relief(exemplar[..., :colours], window)
    homes = None
    if problem.origin is not None:
        homes = evenness.homes(problem.origin, (share.shape[0], share.shape[1]), window, stage.level, width)
    return Windows(
        exemplar, width, basis, features, histograms, relief, share, allowed, nearest, market, variance, given.grain,
        homes,
    )  # fmt: skip


def quick(stage: Stage, given: Given) -> bool:
    """Whether :func:`exemplar_windows` takes some tenths of a second at most."""
    return given.exemplar.size * stage.window**2 * DIRECTIONS <= QUICK


def open_level(
    problem: Problem, settings: Settings, stage: Stage, frame: Frame, given: Given, windows: Windows
) -> Level:  # fmt: skip
    """A level with a canvas that shows what is known of the output."""
    window = stage.window
    colours, channels = problem.exemplar.shape[2], given.exemplar.shape[2]
    canvas = np.zeros((*frame.grid.canvas, channels), np.float32)
    if given.target is not None:
        canvas[..., colours:] = frame.spread(given.target)
    known = wanted = trust = None
    if given.start is not None:
        canvas[..., :colours] = frame.spread(given.start)
    if given.known is not None:
        known = frame.spread(given.known) & frame.inside()
        wanted = ~whole_windows(known, window, frame.grid.step)
        trust = _trust(known, window)[:: frame.grid.step, :: frame.grid.step]
    falloff = window_falloff(window, settings.falloff)
    return Level(windows, canvas, problem.voted, frame, falloff, wanted, known, trust)


def repeated(problem: Problem, images: Sequence[Given]) -> Repeats | None:
    """After how many pixels of the coarsest level the exemplar repeats itself.

    None where it does not, and where something else rules what is where, or parts of it must not be shown.
    """
    if problem.usable is not None or not problem.free:
        return None
    return coarse_repeats([level.exemplar[..., : problem.exemplar.shape[2]] for level in images])


def first_field(level: Level, colours: int, rng: np.random.Generator) -> Field:
    """Random blocks as large as a window; with a guide behind so many colours, 0 = none, such as it asks for."""
    grid = level.frame.grid
    shape = level.windows.share.shape
    block = max(1, grid.window // grid.step)
    present = wanted = None
    if colours:
        present = centres(level.windows.exemplar[..., colours:], grid.window)
        wanted = centres(level.canvas[..., colours:], grid.window)[:: grid.step, :: grid.step]
    return random_blocks((grid.rows, grid.columns), (shape[0], shape[1]), block, grid.step, rng, wanted, present)


def in_step(level: Level, field: Field, shifts: NDArray[np.float64]) -> Field:
    """Sources moved to the nearest that are in step, where the exemplar repeats itself after ``shifts`` (2, 2).

    Else each piece would begin a lattice of its own, and where two of them meet there would be a fault.
    """
    frame, rim = level.frame, level.windows.rim
    rows, columns = (
        np.arange(count) * frame.grid.step - margin
        for count, margin in zip((frame.grid.rows, frame.grid.columns), frame.margins, strict=True)
    )
    corners = np.stack(np.meshgrid(rows, columns, indexing="ij"), axis=-1)
    limits = np.full(2, -rim), np.array(level.windows.share.shape) - 1 - rim
    there = lattice.stretched(shifts, frame.periods)
    found = lattice.in_step(field - rim, corners, limits, shifts, there) + np.int32(rim)
    frame.wrap_windows(found)
    return found


def centres(values: Any, window: int) -> Any:
    """Values (h, w, ...) at the centres of all windows."""
    low, high = (window - 1) // 2, window // 2
    return values[low : values.shape[0] - high, low : values.shape[1] - high]


def _trust(known: Flags, window: int) -> Array:
    """How much windows count in the vote: less the farther their centres are from known pixels (Wexler et al. 2007)."""
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        return np.ones_like(centres(known, window), np.float32)
    trust = np.exp(-distance_transform_edt(~known) / (FADING * window))
    result: Array = centres(np.maximum(trust, LEAST).astype(np.float32), window)
    return result
