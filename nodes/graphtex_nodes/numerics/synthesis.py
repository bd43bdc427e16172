"""Texture optimisation over a pyramid (Kwatra et al. 2005; Kopf et al. 2007; Dong et al. 2008, section 4)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.guidance import random_blocks
from graphtex_nodes.numerics.histogram import Histograms, usage
from graphtex_nodes.numerics.levels import Stage
from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.pyramid import level_size, pyramid
from graphtex_nodes.numerics.search import EXACT_LIMIT, exact_cost, search_exact, search_warm
from graphtex_nodes.numerics.voting import robust_weights, vote_mean, vote_source, window_falloff
from graphtex_nodes.numerics.windows import Basis, Grid, principal_basis

Array = NDArray[np.float32]
Field = NDArray[np.int32]


@dataclass(frozen=True)
class Settings:
    """How to synthesise.

    Attributes
    ----------
    exponent
        Power r of a window's distance in the energy.
    histogram
        Gain of histogram matching, 0 = none.
    evenness
        What an exemplar window that is used twice as often as wanted is charged, in mean squared distances.
    variance
        Share of the windows' variance that principal components keep.
    detail
        How far components of colour are evened, 0 (not at all) to 1 (whitened).
    passes
        PatchMatch passes of an iteration.
    falloff
        How much the middle of a window weighs more than its border: exp(-falloff) at the middle of a side.
    """

    exponent: float = 0.8
    histogram: float = 8.0
    evenness: float = 1.0
    variance: float = 0.95
    detail: float = 0.3
    passes: int = 2
    falloff: float = 1.0


@dataclass(frozen=True)
class Problem:
    """What to synthesise.

    Attributes
    ----------
    exemplar
        Colours (h, w, c).
    size
        Height and width of the output.
    guide
        One more channel of the exemplar (h, w), already weighted, or None.
    target
        The guide's value for each output pixel, or None: the guide is then synthesised like a colour.
    hold
        Whether the output's guide stays at ``target``; if not, ``target`` only rules the start.
    importance
        How much of each exemplar pixel the output should hold (h, w), mean 1; None = all alike.
    """

    exemplar: Array
    size: tuple[int, int]
    guide: Array | None = None
    target: Array | None = None
    hold: bool = True
    importance: Array | None = None

    @property
    def voted(self) -> int:
        """How many channels the vote fills."""
        held = self.hold and self.target is not None
        return int(self.exemplar.shape[2]) + (self.guide is not None and not held)


@dataclass(frozen=True)
class Result:
    """What a synthesis ends with.

    Attributes
    ----------
    image
        Weighted mean of the last vote (h, w, c), with the guide's channel where there is one.
    source
        Row and column of the exemplar for each pixel, int32 (h, w, 2).
    energy
        Mean over windows of (mean squared difference of a pixel) ** (r / 2) at the last search.
    """

    image: Array
    source: Field
    energy: float


@dataclass(frozen=True)
class _Level:
    """The exemplar and the canvas on one level with one window."""

    exemplar: Array
    canvas: Array
    voted: int
    grid: Grid
    basis: Basis
    features: Array
    wanted: Array
    histograms: Histograms
    falloff: Array


@dataclass(frozen=True)
class _Match:
    """A source for each window, its weight in the vote, and the mean squared distance."""

    field: Field
    weights: Array
    mean: float
    energy: float


def synthesise(
    problem: Problem, plan: Sequence[Stage], settings: Settings, rng: np.random.Generator, work: Work
) -> Result:
    """Fill the output from coarse to fine: start, then search and vote in turn on each stage of the plan.

    The result depends on the arguments alone, never on ``work`` and its threads.
    """
    levels = plan[0].level + 1
    colours = problem.exemplar
    images = pyramid(colours if problem.guide is None else np.dstack([colours, problem.guide]), levels)
    targets = [None] * levels if problem.target is None else pyramid(problem.target, levels)
    importance = np.ones(colours.shape[:2], np.float32) if problem.importance is None else problem.importance
    importances = pyramid(importance, levels)
    seed = int(rng.integers(2**63))
    total = sum(stage.iterations * 4.0**-stage.level for stage in plan)
    done = 0.0
    before: tuple[Field, Grid, int] | None = None
    for number, stage in enumerate(plan):
        at = stage.level
        margin = border(plan, at)
        level = _open(problem, settings, stage, margin, images[at], targets[at], importances[at], work)
        if before is None:
            field = _start(level, targets[at] is not None, rng)
        else:
            factor = 1 << (before[2] - at)
            shift = factor * border(plan, before[2]) - margin
            field = transfer(before[0], before[1], level.grid, factor, level.features.shape[:2], shift)
        match = _Match(field, np.ones(field.shape[:2], np.float32), 0.0, 0.0)
        _vote(level, match, 0.0, work)
        for iteration in range(stage.iterations):
            draw = int(np.random.SeedSequence([seed, number, iteration]).generate_state(1, np.uint64)[0])
            match = _search(level, match, settings, draw, number == iteration == 0, work)
            _vote(level, match, settings.histogram, work)
            done += 4.0**-at / total
            work.progress(min(1.0, done), f"level {levels - at} of {levels}")
        before = match.field, level.grid, at
    source = vote_source(
        match.field, match.weights, level.exemplar, level.falloff, level.grid.step, level.canvas, work
    )  # fmt: skip
    height, width = problem.size
    return Result(
        np.ascontiguousarray(level.canvas[:height, :width]),
        np.ascontiguousarray(source[:height, :width]),
        match.energy,
    )


def _open(
    problem: Problem, settings: Settings, stage: Stage, margin: int, exemplar: Array, target: Array | None,
    importance: Array, work: Work,
) -> _Level:  # fmt: skip
    """Prepare a level: components of the exemplar's windows, and an empty canvas with the target in its guide."""
    height, width = (level_size(side, stage.level) + 2 * margin for side in problem.size)
    grid = Grid.covering(height, width, stage.window, max(1, stage.window // 4))
    colours, channels = problem.exemplar.shape[2], exemplar.shape[2]
    canvas = np.zeros((*grid.canvas, channels), np.float32)
    if target is not None:
        more = ((margin, grid.canvas[0] - height + margin), (margin, grid.canvas[1] - width + margin))
        canvas[..., colours] = np.pad(target, more, mode="edge")
    groups = [(slice(0, colours), settings.detail)]
    if channels > colours:
        groups.append((slice(colours, channels), 0.0))
    basis = principal_basis(exemplar, stage.window, groups, settings.variance, work)
    features = basis.project(exemplar, 1, work)
    return _Level(
        exemplar=exemplar,
        canvas=canvas,
        voted=problem.voted,
        grid=grid,
        basis=basis,
        features=features,
        wanted=np.maximum(_centres(importance, stage.window), 1e-3),
        histograms=Histograms(exemplar[..., : problem.voted], importance),
        falloff=window_falloff(stage.window, settings.falloff),
    )


def _centres(values: Array, window: int) -> Array:
    """Values (h, w, ...) at the centres of all windows."""
    low, high = (window - 1) // 2, window // 2
    return values[low : values.shape[0] - high, low : values.shape[1] - high]


def _start(level: _Level, guided: bool, rng: np.random.Generator) -> Field:
    """Random blocks as large as a window; with a target, of the scale that it asks for."""
    grid = level.grid
    shape = level.features.shape[:2]
    block = max(1, grid.window // grid.step)
    present = wanted = None
    if guided:
        present = _centres(level.exemplar[..., -1], grid.window)
        wanted = _centres(level.canvas[..., -1], grid.window)[:: grid.step, :: grid.step]
    return random_blocks((grid.rows, grid.columns), (shape[0], shape[1]), block, grid.step, rng, wanted, present)


def _search(level: _Level, before: _Match, settings: Settings, seed: int, first: bool, work: Work) -> _Match:
    """Find the nearest exemplar window for each window of the canvas, and its weight (equation 6)."""
    windows = level.basis.project(level.canvas, level.grid.step, work)
    shape = level.features.shape[:2]
    charge = np.zeros(shape, np.float32)
    if settings.evenness > 0 and before.mean > 0:
        surplus = usage(before.field, (shape[0], shape[1]), level.grid.window // 2) / level.wanted - 1
        charge = np.maximum(0, surplus) * np.float32(settings.evenness * before.mean)
    if first or exact_cost(windows, level.features) <= EXACT_LIMIT:
        field, costs = search_exact(windows, level.features, charge, work)
    else:
        field, costs = search_warm(
            windows, level.features, charge, before.field,
            step=level.grid.step, seed=seed, passes=settings.passes, work=work,
        )  # fmt: skip
    squared = np.maximum(costs - charge[field[..., 0], field[..., 1]], 0)
    energy = np.mean((squared / level.grid.window**2) ** (settings.exponent / 2), dtype=np.float64)
    weights = robust_weights(squared, settings.exponent)
    return _Match(field, weights, float(np.mean(squared, dtype=np.float64)), float(energy))


def _vote(level: _Level, match: _Match, gain: float, work: Work) -> None:
    """Fill the canvas with the weighted mean of what the windows propose (equations 7 and 8)."""
    pixel_weights = level.histograms.pixel_weights(level.canvas, gain)
    vote_mean(
        match.field, match.weights, level.exemplar, pixel_weights, level.falloff, level.grid.step, level.canvas,
        level.voted, work,
    )  # fmt: skip


def border(plan: Sequence[Stage], level: int) -> int:
    """Pixels that the canvas of a level reaches over the output on each side: its largest window; 0 on the finest.

    A pixel at the output's border lies at the border of all its windows, so without this its sources would lie near
    the same border of the exemplar. On coarse levels, where a window is half the exemplar, plain synthesis would then
    repeat the exemplar's layout, and with it a trend of texel sizes that it should not know of.
    """
    return 0 if level == 0 else max(stage.window for stage in plan if stage.level == level)


def transfer(field: Field, old: Grid, new: Grid, factor: int, shape: tuple[int, ...], shift: int = 0) -> Field:
    """The field of another grid over the same canvas, or over one ``factor`` times as fine.

    The new canvas begins ``shift`` of its pixels inside the old one.
    Each new window takes the source of the old window with the nearest centre, shifted by the distance of their
    corners; sources are moved into ``shape``, rows and columns of the exemplar's windows.
    """
    places = []
    for count, size in ((new.rows, old.rows), (new.columns, old.columns)):
        corner = np.arange(count) * new.step + shift
        centre = (corner + new.window / 2) / factor - old.window / 2
        nearest = np.clip(np.rint(centre / old.step), 0, size - 1).astype(np.int64)
        places.append((nearest, corner - factor * nearest * old.step))
    (rows, down), (columns, right) = places
    result = factor * field[np.ix_(rows, columns)].astype(np.int64)
    result[..., 0] += down[:, None]
    result[..., 1] += right[None, :]
    return np.clip(result, 0, np.array(shape) - 1).astype(np.int32)
