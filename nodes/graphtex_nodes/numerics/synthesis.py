"""Texture optimisation over a pyramid (Kwatra et al. 2005; Kopf et al. 2007; Dong et al. 2008, section 4)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import takewhile

import numpy as np

from graphtex_nodes.numerics import evenness
from graphtex_nodes.numerics.completeness import completed
from graphtex_nodes.numerics.frames import Frame, replayed, transfer
from graphtex_nodes.numerics.lattice import KEPT
from graphtex_nodes.numerics.levels import Stage, border
from graphtex_nodes.numerics.parallel import Alone, Work, aside
from graphtex_nodes.numerics.preparation import (
    Level,
    Windows,
    exemplar_windows,
    first_field,
    in_step,
    open_level,
    quick,
    repeated,
)
from graphtex_nodes.numerics.problem import Array, Field, Given, Problem, Result, Settings, pyramids
from graphtex_nodes.numerics.search import EXACT_LIMIT, Charge, exact_cost, search_exact, search_warm
from graphtex_nodes.numerics.transport import prices
from graphtex_nodes.numerics.voting import robust_weights, vote_mean, vote_source


@dataclass(frozen=True)
class _Match:
    """A source for each window, its weight in the vote, the mean squared distance, and a charge that may stand."""

    field: Field
    weights: Array
    mean: float = 0.0
    standing: Charge | None = None


@dataclass(frozen=True)
class _Charges:
    """What sources that were found tell: what copies pay that are close together, and what is used too often."""

    crowd: tuple[Array, int] | None
    overuse: Array | None


def synthesise(
    problem: Problem, plan: Sequence[Stage], settings: Settings, rng: np.random.Generator, work: Work
) -> Result:
    """Fill the output from coarse to fine: start, then search and vote in turn on each stage of the plan.

    The result depends on the arguments alone, never on ``work`` and its threads.
    """
    levels = plan[0].level + 1
    if settings.replay:
        plan = [*plan[:1], *takewhile(lambda stage: stage.iterations, plan[1:])]
    images = pyramids(problem, levels)
    regular = repeated(problem, images)
    lacking = problem.free and settings.evenness > 0 and regular is None
    seed = int(rng.integers(2**63))
    total = sum(stage.iterations * 4.0**-stage.level for stage in plan)
    done = 0.0
    energies: list[float] = []
    before: tuple[Field, Frame, int, int] | None = None
    frames = [_frame(problem, plan, stage) for stage in plan]
    coming = _coming(problem, settings, plan, frames, images, work)
    for number, (stage, frame) in enumerate(zip(plan, frames, strict=True)):
        at, windows = stage.level, coming.pop(0)()
        level = open_level(problem, settings, stage, frame, images[at], windows)
        here = None if regular is None else regular.enlarged(1 << (levels - 1 - at))
        if before is None:
            field = first_field(level, problem.exemplar.shape[2] if problem.target is not None else 0, rng)
            field = field if here is None else in_step(level, field, here.shifts)
        else:
            rims = before[3], windows.rim
            field = transfer(before[0], before[1], frame, 1 << (before[2] - at), windows.share.shape, rims)
        if windows.nearest is not None:
            field = windows.nearest[field[..., 0], field[..., 1]]
        match = _Match(field, np.ones(field.shape[:2], np.float32))
        charges = aside(partial(_charges, level, match, settings.evenness, (number, 0)), work)
        if before is not None or problem.start is None or problem.known is not None:
            _vote(level, match, level.weighted(0.0), work)
        for iteration in range(stage.iterations):
            draw = int(np.random.SeedSequence([seed, number, iteration]).generate_state(1, np.uint64)[0])
            weighted = aside(partial(level.weighted, settings.histogram), work)
            match, squared = _search(level, match, charges, settings, draw, (number, iteration), work)
            if here is not None and here.period < KEPT:
                match = replace(match, field=in_step(level, match.field, here.shifts))
            if iteration + 1 < stage.iterations:
                charges = aside(partial(_charges, level, match, settings.evenness, (number, iteration + 1)), work)
            energy = aside(partial(_energy, squared, stage.window, settings.exponent), work)
            _vote(level, match, weighted(), work)
            energies.append(energy())
            done += 4.0**-at / total
            work.progress(min(1.0, done), f"level {levels - at} of {levels}")
        field, finer = match.field, number + 1 < len(plan) and plan[number + 1].level < at
        # what levels with prices lack changes much on the next ones; the finest has none to join what is put in
        if lacking and finer and stage.iterations and windows.market is None:
            field = _completed(level, field, work)
        before = field, frame, at, windows.rim
    source = vote_source(
        match.field, match.weights, windows.exemplar, level.falloff, frame.grid.step, level.canvas, work, level.known,
        windows.rim,
    )  # fmt: skip
    source = replayed(frame.crop(source), 1 << at, problem.size, problem.exemplar.shape)
    return Result(frame.crop(level.canvas), source, tuple(energies))


def _frame(problem: Problem, plan: Sequence[Stage], stage: Stage) -> Frame:
    """Where the output lies on the canvas of a stage."""
    margin = 0 if problem.bounded or problem.led else border(plan, stage.level)
    return Frame.of(problem.size, stage.level, stage.window, margin, problem.wrap)


def _coming(
    problem: Problem, settings: Settings, plan: Sequence[Stage], frames: Sequence[Frame], images: Sequence[Given],
    work: Work,
) -> list[Callable[[], Windows]]:  # fmt: skip
    """What gives the exemplar's windows of each stage: all but the first are found beside the stages before them.

    Coarse stages leave a second thread much idle time.
    """

    def windows(number: int, work: Work) -> Windows:
        stage = plan[number]
        return exemplar_windows(problem, settings, stage, frames[number].grid.step, images[stage.level], work)

    return [
        aside(partial(windows, number, Alone()), work)
        if number > 0 and quick(stage, images[stage.level])
        else partial(windows, number, work)
        for number, stage in enumerate(plan)
    ]


def _search(
    level: Level, before: _Match, charges: Callable[[], _Charges], settings: Settings, seed: int, turn: tuple[int, int],
    work: Work,
) -> tuple[_Match, Array]:  # fmt: skip
    """Find the nearest exemplar window for each window of the canvas, and its weight (equation 6).

    Besides, the squared distances of those that look for a source.

    ``turn`` are the numbers of the stage and of its iteration.
    """
    grid, wanted = level.frame.grid, level.wanted
    features = level.windows.features
    windows = level.windows.basis.project(level.canvas, grid.step, work, wanted)
    found = charges()
    standing = before.standing
    if standing is None or _fresh(level, before, turn):
        standing = _standing(level, windows, found.crowd, settings.evenness, work)
    charge = standing
    if found.overuse is not None:
        charge = Charge(standing.own + found.overuse, standing.shared, standing.cell)
    if turn == (0, 0) or exact_cost(windows, features) <= EXACT_LIMIT:
        field, distances = search_exact(windows, features, charge, work, wanted)
    else:
        field, distances = search_warm(
            windows, features, charge, before.field,
            step=grid.step, seed=seed, passes=settings.passes, work=work, wanted=wanted,
        )  # fmt: skip
    level.frame.wrap_windows(field)
    level.frame.wrap_windows(distances)
    squared = distances[slice(None) if wanted is None else wanted]
    weights = np.ones(field.shape[:2], np.float32)
    if squared.size == 0:
        return _Match(field, weights), squared
    weights[slice(None) if wanted is None else wanted] = robust_weights(squared, settings.exponent)
    if level.trust is not None:
        weights *= level.trust
    return _Match(field, weights, float(np.mean(squared, dtype=np.float64)), standing), squared


def _energy(squared: Array, window: int, exponent: float) -> float:
    """Mean over windows of (mean squared difference of a pixel) ** (r / 2), from squared distances of windows."""
    return float(np.mean((squared / window**2) ** (exponent / 2), dtype=np.float64)) if squared.size else 0.0


def _fresh(level: Level, before: _Match, turn: tuple[int, int]) -> bool:
    """Whether prices and what crowding costs are found anew."""
    lasting = evenness.lasting(level.windows.share, level.windows.allowed)
    return before.standing is None or turn[1] % lasting == 0


def _charges(level: Level, before: _Match, share: float, turn: tuple[int, int]) -> _Charges:
    """What windows cost in a turn by what was found before it."""
    windows, frame = level.windows, level.frame
    crowd = None
    if windows.variance > 0 and turn != (0, 0) and _fresh(level, before, turn):
        crowd = evenness.crowd(
            before.field, windows.relief,
            variance=windows.variance, evenness=share, step=frame.grid.step, grain=windows.grain,
        )  # fmt: skip
    overuse = evenness.charge(
        windows.share, windows.relief, before.field, before.mean,
        evenness=share, radius=frame.grid.window // 2, step=frame.grid.step, allowed=windows.allowed,
        wanted=level.wanted, homes=windows.homes,
    )  # fmt: skip
    return _Charges(crowd, overuse)


def _standing(level: Level, windows: Array, crowd: tuple[Array, int] | None, share: float, work: Work) -> Charge:
    """Charge that may stand for some turns: infinite where nothing may be used, else 0 if only some windows look."""
    allowed, market = level.windows.allowed, level.windows.market
    shape = level.windows.share.shape
    may = np.ones(shape, bool) if allowed is None else allowed
    own = np.where(may, np.float32(0), np.float32(np.inf))
    if market is not None:
        own[may] = prices(windows.reshape(-1, windows.shape[2]), market, share, work)
    return Charge(own) if crowd is None else Charge(own, *crowd)


def _completed(level: Level, field: Field, work: Work) -> Field:
    """Sources of a level's windows that show most of the exemplar."""
    windows, frame = level.windows, level.frame
    found = completed(
        field, partial(windows.basis.project, level.canvas, frame.grid.step, work), windows.features,
        step=frame.grid.step, inside=frame.shown(), allowed=windows.allowed, homes=windows.homes,
    )  # fmt: skip
    frame.wrap_windows(found)
    return found


def _vote(level: Level, match: _Match, weighted: Array, work: Work) -> None:
    """Fill the canvas with the weighted mean of what the windows propose (equations 7 and 8)."""
    vote_mean(
        match.field, match.weights, weighted, level.falloff, level.frame.grid.step, level.canvas, work, level.known
    )
    level.frame.wrap_canvas(level.canvas)
