"""Texture optimisation over a pyramid (Kwatra et al. 2005; Kopf et al. 2007; Dong et al. 2008, section 4)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from graphtex_nodes.numerics import evenness
from graphtex_nodes.numerics.frames import Frame, nearest_places, replayed, transfer, whole_windows
from graphtex_nodes.numerics.guidance import random_blocks
from graphtex_nodes.numerics.histogram import Histograms
from graphtex_nodes.numerics.levels import Stage, border
from graphtex_nodes.numerics.parallel import Alone, Work, aside
from graphtex_nodes.numerics.problem import Array, Field, Flags, Given, Problem, Result, Settings, pyramids
from graphtex_nodes.numerics.search import EXACT_LIMIT, exact_cost, search_exact, search_warm
from graphtex_nodes.numerics.voting import robust_weights, vote_mean, vote_source, weighted_pixels, window_falloff
from graphtex_nodes.numerics.windows import Basis, principal_basis

FADING = 0.25
"""Windows' sides over which the weight of what is not known yet falls to 1/e of that beside known pixels."""
LEAST = 0.05
"""Least such weight."""


@dataclass(frozen=True)
class _Windows:
    """What is known of the exemplar on a level: components of its windows, what share of a charge each pays (h, w)."""

    basis: Basis
    relief: Array
    histograms: Histograms


@dataclass(frozen=True)
class _Level:
    """The exemplar and the canvas on one level with one window.

    ``allowed`` are the exemplar's windows that may be used, ``nearest`` the nearest of them for each, ``wanted`` the
    windows that look for a source, ``known`` the canvas pixels that stay, ``trust`` how much windows count beside them;
    None where nothing is known, or everything usable.
    """

    exemplar: Array
    canvas: Array
    voted: int
    frame: Frame
    basis: Basis
    features: Array
    share: Array
    relief: Array
    histograms: Histograms
    falloff: Array
    allowed: Flags | None
    nearest: Field | None
    wanted: Flags | None
    known: Flags | None
    trust: Array | None

    def weighted(self, gain: float) -> Array:
        """The exemplar's pixels with weights in a vote, by what the canvas holds too much of (equation 8)."""
        counted = None if self.known is None or self.known.all() else ~self.known
        weights = self.histograms.pixel_weights(self.canvas, gain, counted)
        return weighted_pixels(self.exemplar[..., : self.voted], weights)


@dataclass(frozen=True)
class _Match:
    """A source for each window, its weight in the vote, the mean squared distance, and a charge that may stand."""

    field: Field
    weights: Array
    mean: float
    energy: float
    standing: Array | None = None


def synthesise(
    problem: Problem, plan: Sequence[Stage], settings: Settings, rng: np.random.Generator, work: Work
) -> Result:
    """Fill the output from coarse to fine: start, then search and vote in turn on each stage of the plan.

    The result depends on the arguments alone, never on ``work`` and its threads.
    """
    levels = plan[0].level + 1
    images = pyramids(problem, levels)
    seed = int(rng.integers(2**63))
    total = sum(stage.iterations * 4.0**-stage.level for stage in plan)
    done = 0.0
    energies: list[float] = []
    before: tuple[Field, Frame, int] | None = None
    coming: Callable[[], _Windows] = partial(_windows, problem, settings, plan[0], images[levels - 1], work)
    for number, stage in enumerate(plan):
        if before is not None and stage.iterations == 0 and settings.replay:
            break
        at, windows = stage.level, coming()
        for then in plan[number + 1 : number + 2]:
            coming = aside(partial(_windows, problem, settings, then, images[then.level], Alone()), work)
        margin = 0 if problem.bounded or problem.led else border(plan, at)
        level = _open(problem, settings, stage, margin, images[at], windows, work)
        if before is None:
            field = _start(level, problem.exemplar.shape[2] if problem.target is not None else 0, rng)
        else:
            factor = 1 << (before[2] - at)
            field = transfer(before[0], before[1], level.frame, factor, level.features.shape[:2])
        if level.nearest is not None:
            field = level.nearest[field[..., 0], field[..., 1]]
        match = _Match(field, np.ones(field.shape[:2], np.float32), 0.0, 0.0)
        if before is not None or problem.start is None or problem.known is not None:
            _vote(level, match, level.weighted(0.0), work)
        for iteration in range(stage.iterations):
            draw = int(np.random.SeedSequence([seed, number, iteration]).generate_state(1, np.uint64)[0])
            weighted = aside(partial(level.weighted, settings.histogram), work)
            match = _search(level, match, settings, draw, (number, iteration), work)
            energies.append(match.energy)
            _vote(level, match, weighted(), work)
            done += 4.0**-at / total
            work.progress(min(1.0, done), f"level {levels - at} of {levels}")
        before = match.field, level.frame, at
    source = vote_source(
        match.field, match.weights, level.exemplar, level.falloff, level.frame.grid.step, level.canvas, work,
        level.known,
    )  # fmt: skip
    source = replayed(level.frame.crop(source), 1 << at, problem.size, problem.exemplar.shape)
    return Result(level.frame.crop(level.canvas), source, tuple(energies))


def _windows(problem: Problem, settings: Settings, stage: Stage, given: Given, work: Work) -> _Windows:
    """What a stage knows of the exemplar's windows; nothing where none is looked for, as what was found is copied."""
    window = stage.window
    colours, channels = problem.exemplar.shape[2], given.exemplar.shape[2]
    counted = slice(None) if given.usable is None else given.usable
    histograms = Histograms(given.exemplar[..., : problem.voted], given.importance, counted)
    if stage.iterations == 0:
        shape = [side - window + 1 for side in given.exemplar.shape[:2]]
        basis = Basis(window, np.zeros((0, 0), np.float32), np.zeros(0, np.float32))
        return _Windows(basis, np.ones(shape, np.float32), histograms)
    groups = [(slice(0, channels if settings.joint else colours), settings.detail)]
    if channels > colours and not settings.joint:
        groups.append((slice(colours, channels), 0.0))
    weights = [*(settings.weights or [1.0] * colours), *[1.0] * (channels - colours)]
    allowed = None if given.usable is None else whole_windows(given.usable, window)
    basis = principal_basis(
        given.exemplar, window, groups, settings.variance, work, allowed, weights, settings.directions
    )
    return _Windows(basis, evenness.local_relief(given.exemplar[..., :colours], window), histograms)


def _open(
    problem: Problem, settings: Settings, stage: Stage, margin: int, given: Given, windows: _Windows, work: Work
) -> _Level:  # fmt: skip
    """Prepare a level: components of the exemplar's windows, and a canvas with what is known of the output."""
    exemplar, window = given.exemplar, stage.window
    frame = Frame.of(problem.size, stage.level, window, margin, problem.wrap)
    colours, channels = problem.exemplar.shape[2], exemplar.shape[2]
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
    allowed = None if given.usable is None else whole_windows(given.usable, window)
    if stage.iterations:
        features = windows.basis.project(exemplar, 1, work, allowed)
    else:
        features = np.zeros((*(side - window + 1 for side in exemplar.shape[:2]), 0), np.float32)
    return _Level(
        exemplar=exemplar,
        canvas=canvas,
        voted=problem.voted,
        frame=frame,
        basis=windows.basis,
        features=features,
        share=np.maximum(_centres(given.importance, window), 1e-3),
        relief=windows.relief,
        histograms=windows.histograms,
        falloff=window_falloff(window, settings.falloff),
        allowed=allowed,
        nearest=None if allowed is None else nearest_places(allowed),
        wanted=wanted,
        known=known,
        trust=trust,
    )


def _trust(known: Flags, window: int) -> Array:
    """How much windows count in the vote: less the farther their centres are from known pixels (Wexler et al. 2007)."""
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        return np.ones_like(_centres(known, window), np.float32)
    trust = np.exp(-distance_transform_edt(~known) / (FADING * window))
    result: Array = _centres(np.maximum(trust, LEAST).astype(np.float32), window)
    return result


def _centres(values: Any, window: int) -> Any:
    """Values (h, w, ...) at the centres of all windows."""
    low, high = (window - 1) // 2, window // 2
    return values[low : values.shape[0] - high, low : values.shape[1] - high]


def _start(level: _Level, colours: int, rng: np.random.Generator) -> Field:
    """Random blocks as large as a window; with a guide behind so many colours, 0 = none, such as it asks for."""
    grid = level.frame.grid
    shape = level.features.shape[:2]
    block = max(1, grid.window // grid.step)
    present = wanted = None
    if colours:
        present = _centres(level.exemplar[..., colours:], grid.window)
        wanted = _centres(level.canvas[..., colours:], grid.window)[:: grid.step, :: grid.step]
    return random_blocks((grid.rows, grid.columns), (shape[0], shape[1]), block, grid.step, rng, wanted, present)


def _search(level: _Level, before: _Match, settings: Settings, seed: int, turn: tuple[int, int], work: Work) -> _Match:
    """Find the nearest exemplar window for each window of the canvas, and its weight (equation 6).

    ``turn`` are the numbers of the stage and of its iteration.
    """
    grid, wanted = level.frame.grid, level.wanted
    chosen = slice(None) if wanted is None else wanted
    fresh = before.standing is None or turn[1] % evenness.lasting(level.share, level.allowed) == 0
    crowd = aside(partial(_crowd, level, before.field if fresh and turn != (0, 0) else None, settings.evenness), work)
    overuse = aside(partial(_overuse, level, before, settings.evenness), work)
    windows = level.basis.project(level.canvas, grid.step, work, wanted)
    standing, crowded, more = before.standing, crowd(), overuse()
    if fresh or standing is None:
        standing = _standing(level, windows, crowded, settings.evenness, work)
    charge = standing if more is None else standing + more
    if turn == (0, 0) or exact_cost(windows, level.features) <= EXACT_LIMIT:
        field, distances = search_exact(windows, level.features, charge, work, wanted)
    else:
        field, distances = search_warm(
            windows, level.features, charge, before.field,
            step=grid.step, seed=seed, passes=settings.passes, work=work, wanted=wanted,
        )  # fmt: skip
    level.frame.wrap_windows(field)
    level.frame.wrap_windows(distances)
    squared = distances[chosen]
    if squared.size == 0:
        return _Match(field, np.ones(field.shape[:2], np.float32), 0.0, 0.0)
    energy = np.mean((squared / grid.window**2) ** (settings.exponent / 2), dtype=np.float64)
    weights = np.ones(field.shape[:2], np.float32)
    weights[chosen] = robust_weights(squared, settings.exponent)
    if level.trust is not None:
        weights *= level.trust
    return _Match(field, weights, float(np.mean(squared, dtype=np.float64)), float(energy), standing)


def _crowd(level: _Level, field: Field | None, share: float) -> Array | None:
    """Charge for copies around where all windows look for a source and have one."""
    if field is None or level.wanted is not None:
        return None
    return evenness.crowd(
        field, level.features, level.share, level.relief, evenness=share, step=level.frame.grid.step,
        allowed=level.allowed,
    )  # fmt: skip


def _overuse(level: _Level, before: _Match, share: float) -> Array | None:
    """Charge of one turn."""
    return evenness.charge(
        level.share, level.relief, before.field, before.mean,
        evenness=share, radius=level.frame.grid.window // 2, allowed=level.allowed, wanted=level.wanted,
    )  # fmt: skip


def _standing(level: _Level, windows: Array, crowd: Array | None, share: float, work: Work) -> Array:
    """Charge that may stand for some turns: infinite where nothing may be used, else 0 if only some windows look."""
    if level.wanted is not None:
        charge = np.zeros((1, 1, *level.share.shape), np.float32)
    else:
        charge = evenness.standing(
            windows, level.features, level.share, crowd,
            evenness=share, step=level.frame.grid.step, allowed=level.allowed, work=work,
        )  # fmt: skip
    if level.allowed is not None:
        charge[..., ~level.allowed] = np.inf
    return charge


def _vote(level: _Level, match: _Match, weighted: Array, work: Work) -> None:
    """Fill the canvas with the weighted mean of what the windows propose (equations 7 and 8)."""
    vote_mean(
        match.field, match.weights, weighted, level.falloff, level.frame.grid.step, level.canvas, work, level.known
    )
    level.frame.wrap_canvas(level.canvas)
