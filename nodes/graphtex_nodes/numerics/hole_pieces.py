"""A hole filled with large pieces of the picture moved over its plane, cut where they agree best."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.expansion import expand
from graphtex_nodes.numerics.membrane import SCREEN, relaxed
from graphtex_nodes.numerics.move_search import Fit, Level, anchors, fits, laid_flat
from graphtex_nodes.numerics.parallel import Work, for_each
from graphtex_nodes.numerics.plane_moves import Move, Slope, Views
from graphtex_nodes.numerics.pyramid import masked_pyramid
from graphtex_nodes.numerics.strangeness import Strangeness

Array = NDArray[Any]

BLUR = 0.2
"""Cost of a pixel that is shown twice as large as in its source, in standard deviations of the picture."""
UNLIKE = 0.3
"""Cost of a pixel that a plain shift brings from where the scale is twice or half as large, or as far across: there the
plane looks as different, likewise."""
JOIN = 0.005
"""Cost of each pair of pixels across a seam, likewise. Next to nothing: where dark parts make the deviation large, more
would save the seams between bright pieces that match, and end a shadow at the hole's border instead."""
LACKING = 1.0
"""Cost of a known pixel around the hole for which a piece has no source, likewise."""
SWEEPS = 3
"""Times that each move is tried on the coarsest level."""
OUTLINE = 0.5
"""Differences at a seam that are bent away by half, likewise."""
NONE = 1e4
"""Cost of a pixel of the hole without source: above that of any seam."""
ANCHORS, BEST, MOST = 33, 3, 96
"""Places along the hole's border, moves of each of them, and moves of all together, from which the cut chooses."""
SEARCHED, CUT = 150_000, 4_000
"""Pixels of the reduced picture in which moves are looked for, and of the hole in the one where it is cut first."""
SWAY = 2
"""Pixels that a seam may move on each finer level."""
PROBES = 2000
"""Known pixels by which a move is made more precise on a finer level."""
LOOK = 500
"""Elementary steps that it takes to look up a pixel between others."""


@dataclass(frozen=True)
class Pieces:
    """What was put in the hole: colours (n, c), rows and columns taken from (n, 2), log2 of how much they are enlarged
    (n,), and which pixels could be filled (n,)."""

    colours: Array
    source: Array
    log: Array
    filled: Array


def halvings(level: Level) -> tuple[list[Level], int]:
    """A picture and its halvings, the finest first, and the number of the one in which moves are looked for.

    The last has a hole of no more than :data:`CUT` pixels.
    """
    result, count = [level], 1
    while (level.hole.size >> (2 * count - 2)) > SEARCHED:
        count += 1
    searched = count - 1
    while (int(level.hole.sum()) >> (2 * count - 2)) > CUT:
        count += 1
    pictures, _ = masked_pyramid(level.picture, ~level.hole, count)
    for smaller in pictures[1:]:
        result.append(Level(smaller, ~_any(~result[-1].usable), _any(result[-1].hole)))
    return result, searched


def _any(mask: Array) -> Array:
    """Whether any of two by two pixels is True."""
    height, width = mask.shape
    padded: Array = np.pad(mask, [(0, height % 2), (0, width % 2)], mode="edge")
    return padded[::2, ::2] | padded[1::2, ::2] | padded[::2, 1::2] | padded[1::2, 1::2]


def choose(level: Level, slopes: Sequence[Slope], log_scale: Array | None, work: Work) -> list[Fit]:
    """The best moves of a picture with the log2 of its texel scale (h, w), over planes of several slopes.

    The best of each anchor come first: among smooth parts of a picture many moves fit, and would leave none for others.
    """
    found: list[Fit] = []
    for slope in slopes:
        sheet = laid_flat(slope, level)
        found += fits(slope, sheet, anchors(sheet, ANCHORS), log_scale if slope.flat else None, BEST, work)
    if log_scale is not None:
        steepness = max(float(np.hypot(slope.down, slope.right)) for slope in slopes) / np.log(2)
        found = [fit.distorted(steepness) for fit in found]
    distinct: dict[Move, Fit] = {}
    for fit in sorted(found, key=lambda fit: fit.cost):
        distinct.setdefault(fit.move, fit)
    first: dict[int, Fit] = {}
    for fit in distinct.values():
        first.setdefault(fit.anchor, fit)
    return sorted(distinct.values(), key=lambda fit: first[fit.anchor] is not fit)[:MOST]


def fill(levels: Sequence[Level], found: Sequence[Fit], searched: int, bends: Array, work: Work) -> Pieces:
    """The hole of the first level filled; ``found`` are moves of the one numbered ``searched``.

    Down to that one moves may be chosen anywhere; on finer ones seams move only a little. What was chosen nowhere in a
    halving is not tried in the picture itself. ``bends`` tells which channels (c,) are bent to meet at seams, see
    :func:`materials.bending`.
    """
    labels = np.full(levels[-1].hole.shape, -1)
    moves = [fit.move.halved(len(levels) - 1 - searched) for fit in found]
    strange = Strangeness.of(levels[-1], moves, _spread(levels[-1]), work)
    for number in range(len(levels) - 1, -1, -1):
        level = levels[number]
        views = Views.of(level.picture, level.usable)
        if number < len(levels) - 1:
            labels = labels.repeat(2, axis=0).repeat(2, axis=1)[: level.hole.shape[0], : level.hole.shape[1]]
            labels[~level.region] = -1
            strange = strange.finer()
            if number < max(1, searched):
                used, at = np.unique(labels[labels >= 0], return_inverse=True)
                labels[labels >= 0] = at
                found, strange = [found[label] for label in used], strange.of_moves(used)
        if number < searched:
            found = _finer_fits(found, level, views, work)
        here = [replace(fit, move=fit.move.halved(max(0, number - searched))) for fit in found]
        labels = _cut(level, views, here, labels, None if number < searched else strange, work)
        work.progress(1 - number / len(levels), "cutting pieces")
    return _painted(levels[0], views, [fit.move for fit in here], labels, bends, work)


def _finer_fits(found: Sequence[Fit], level: Level, views: Views, work: Work) -> list[Fit]:
    """Fits of a level half as fine, made right to the pixel."""
    finer, region = list(found), level.region

    def refine(number: int) -> None:
        finer[number] = _finer(found[number], level, region, views)

    for_each(refine, len(finer), 9.0 * PROBES * LOOK, work)
    return finer


def _finer(fit: Fit, level: Level, region: Array, views: Views) -> Fit:
    """A fit of a level half as fine, its move made right to the pixel by the known pixels around its anchor."""
    row, column, radius = 2 * fit.row + 0.5, 2 * fit.column + 0.5, 2 * fit.radius
    y, x = np.ogrid[: level.hole.shape[0], : level.hole.shape[1]]
    near = region if not radius else (y - row) ** 2 + (x - column) ** 2 <= radius**2
    rows, columns = np.nonzero(near & ~level.hole)
    stride = max(1, rows.size // PROBES)
    rows, columns = rows[::stride], columns[::stride]
    wanted = level.picture[rows, columns]
    middle = fit.move.halved(-1)
    best, chosen = np.inf, middle
    for down in (0, -1, 1):
        for right in (0, -1, 1):
            move = Move(middle.slope, middle.down + down, middle.right + right)
            colours, usable, _ = views.moved(move, rows, columns)
            cost = float(((colours - wanted)[usable] ** 2).sum() / usable.sum()) if usable.any() else np.inf
            if cost < best:
                best, chosen = cost, move
    return replace(fit, move=chosen, row=row, column=column, radius=radius)


def _cut(
    level: Level, views: Views, found: Sequence[Fit], labels: Array, strange: Strangeness | None, work: Work
) -> Array:
    """Labels (h, w) of the moves in the region of a level; where nothing is ``strange``, seams move only a little."""
    from graphtex_nodes.numerics.join_kernels import join_costs

    region = free = level.region
    if strange is None:
        from scipy.ndimage import binary_dilation

        seams = np.zeros(labels.shape, bool)
        for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
            apart = (labels[one] != labels[other]) & region[one] & region[other]
            seams[one] |= apart
            seams[other] |= apart
        if not seams.any():
            return labels
        free = binary_dilation(seams, iterations=SWAY) & region
        region = binary_dilation(free) & region
    rows, columns = np.nonzero(region)
    within, spread = level.hole[rows, columns], _spread(level)
    copies = np.empty((len(found), rows.size, level.picture.shape[2]), np.float32)
    unary = np.empty((len(found), rows.size), np.float32)
    shown, loose, given = level.picture[rows, columns], free[rows, columns], labels[rows, columns]

    def look(number: int) -> None:
        fit = found[number]
        copies[number], usable, enlarged = views.moved(fit.move, rows, columns)
        wrong = _length(copies[number] - shown) / spread
        poor = BLUR * np.log2(np.maximum(enlarged, 1)) + UNLIKE * fit.distortion
        poor += 0 if strange is None else strange.at(number, rows, columns)
        unary[number] = np.where(within, np.where(usable, poor, NONE), np.where(usable, wrong, LACKING))
        unary[number] += np.where(loose | (given == number), 0, 10 * NONE)

    for_each(look, len(found), float(LOOK * rows.size), work)
    count = np.full(labels.shape, -1)
    count[region] = np.arange(rows.size)
    first, second = _neighbours(count)

    def seam(one: Array, other: Array) -> Array:
        costs = np.empty(first.size)
        join_costs(copies, one, other, first, second, JOIN, 1 / spread, costs)
        return costs

    result = labels.copy()
    started = bool((given >= 0).all())
    start = given if started else np.argmin(unary, axis=0)
    result[region] = expand(unary, first, second, seam, start, 1 if started else SWEEPS, work)
    return result


def _painted(level: Level, views: Views, moves: Sequence[Move], labels: Array, bends: Array, work: Work) -> Pieces:
    """Colours and sources of the labelled hole; pieces are bent to meet each other and what is known."""
    rows, columns = np.nonzero(level.hole)
    chosen = labels[rows, columns]
    colours, usable = views.looked_up(moves, chosen, rows, columns)
    source, log = np.zeros((rows.size, 2)), np.zeros(rows.size)
    for label, move in enumerate(moves):
        at = chosen == label
        source_rows, source_columns, enlarged = move.sources(rows[at], columns[at])
        source[at], log[at] = np.stack([source_rows, source_columns], axis=1), np.log2(enlarged)
    colours += _bend(level, views, moves, labels, colours, usable, bends, work)
    seen = level.picture[level.usable]
    return Pieces(np.clip(colours, seen.min(axis=0), seen.max(axis=0)), source, log, usable)


def _bend(
    level: Level, views: Views, moves: Sequence[Move], labels: Array, colours: Array, usable: Array, bends: Array,
    work: Work,
) -> Array:  # fmt: skip
    """Corrections (n, c) of the hole's colours: gradients stay, and across a seam are those of the pieces there.

    Channels whose ``bends`` is 0 need none, and those where it is 2 are bent at outlines too.
    """
    rows, columns = np.nonzero(level.hole)
    number = np.full(labels.shape, -1)
    number[level.hole] = np.arange(rows.size)
    correction, spread = np.zeros(colours.shape, np.float32), _spread(level)
    degrees, edges, lacks = np.full(rows.size, SCREEN), [], []
    for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        there_rows, there_columns = rows + down, columns + right
        inside = (there_rows >= 0) & (there_rows < labels.shape[0])
        inside &= (there_columns >= 0) & (there_columns < labels.shape[1])
        here = np.flatnonzero(inside)
        there_rows, there_columns = there_rows[here], there_columns[here]
        there = number[there_rows, there_columns]
        degrees[here[there >= 0]] += 1
        edges.append((here[there >= 0], there[there >= 0]))
        mine, others = labels[rows[here], columns[here]], labels[there_rows, there_columns]
        border = there < 0
        at = np.flatnonzero(border | (mine != others))
        p, q, border = here[at], there[at], border[at]
        ahead, goes_on = views.looked_up(moves, mine[at], there_rows[at], there_columns[at])
        # a piece that does not go on is taken to go on with the same colour
        ahead = np.where(goes_on[:, None], ahead, colours[p])
        beside, fits_here = views.looked_up(moves, others[at], rows[p], columns[p])
        theirs = np.where(border[:, None], level.picture[there_rows[at], there_columns[at]], colours[q])
        # that of two pieces which goes on over their seam, or the mean of both, tells what the step should be
        told = ((goes_on, theirs - ahead), (fits_here, beside - colours[p]))
        weights = [(each & usable[p] & usable[q]).astype(np.float32)[:, None] for each, _ in told]
        between = sum(weight * lack for weight, (_, lack) in zip(weights, told, strict=True))
        step = np.where(border[:, None], theirs - ahead, between / np.maximum(sum(weights), 1))
        # a large difference is the outline of an element: bent away, it would smear
        gentle = 1 / (1 + (_length(step) / (OUTLINE * spread)) ** 2)
        lacks.append((p, border, step, gentle))
    for way in (1, 2):
        channels = np.flatnonzero(bends == way)
        if not channels.size:
            continue
        degree, right_side = degrees.copy(), np.zeros((rows.size, channels.size))
        for p, border, step, gentle in lacks:
            share = gentle if way == 1 else np.ones_like(gentle)
            right_side[p] += share[:, None] * step[:, channels]
            degree[p[border]] += share[border]
        correction[:, channels] = relaxed(degree, edges, right_side, work)
    return correction


def _spread(level: Level) -> float:
    """Total standard deviation of what is known."""
    return float(np.sqrt(level.picture[~level.hole].var(axis=0, dtype=np.float64).sum())) or 1.0


def _length(vectors: Array) -> Array:
    """Euclidean lengths over the last axis."""
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", vectors, vectors)))


def _neighbours(number: Array) -> tuple[Array, Array]:
    """All pairs of vertical and horizontal neighbours that have numbers (h, w) of 0 or more."""
    ends = []
    for one, other in ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:])):
        both = (one >= 0) & (other >= 0)
        ends.append((one[both], other[both]))
    return np.concatenate([one for one, _ in ends]), np.concatenate([other for _, other in ends])
