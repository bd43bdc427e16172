"""How many levels and which windows a synthesis uses."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.frames import whole_windows
from graphtex_nodes.numerics.lattice import RESOLVED, Repeats, repeats
from graphtex_nodes.numerics.pyramid import level_size, masked_pyramid, pyramid
from graphtex_nodes.numerics.structure import structure

Array = NDArray[np.float32]

WINDOW = 8
"""Side of the windows. On the coarsest level ones of twice that come before: what they see is an arrangement."""
COARSEST = 16
"""Least side of an exemplar on the coarsest level, two windows."""
SEPARATE = 2.0
"""Pixels that a period needs on the coarsest level: below, copies meet out of step there, and stay so."""
LEAST_PERIODIC = 8
"""Least side on the coarsest level of an exemplar with a period that is resolved there."""
ENOUGH = 128
"""Most pixels a side on which repeats are looked for, if the coarsest level has not more."""
SEEN = 6
"""Distances over which pixels are related that a window of the coarsest level needs to see, and no more ..."""
FEWEST = 3
"""... but so many levels there are if the exemplar allows them."""
SMALLEST = 4
"""Least side that an exemplar may have on the coarsest level when the user asks for more levels."""

FINE = 2
"""Finest levels: they take most of the time, while coarser ones decide what is where."""

MOST = 18
"""Most iterations of a level, unless the user asks for more."""

FEW = 64
"""Windows that a partly usable exemplar needs on a level: fewer would all be pasted over and over."""
LEAST = 8
"""Side below which windows of such an exemplar are not made smaller: they would see too little to arrange anything."""


@dataclass(frozen=True)
class Stage:
    """Iterations on one level (0 is the finest) with one window."""

    level: int
    window: int
    iterations: int


def automatic_levels(exemplar: Array) -> int:
    """Number of levels for an exemplar (h, w, c).

    As many as leave a side of :data:`COARSEST` pixels, so that windows see arrangements of half the exemplar: with
    fewer, large elements break and rare ones get lost. One less for a periodic exemplar whose period would not be
    resolved on the coarsest level: there a window of twice the side sees the same half of the exemplar, twice as sharp.
    More, down to :data:`LEAST_PERIODIC` pixels, where it would still be resolved: copies then join without faults.
    And no more than the exemplar's structure needs: where pixels are related over short distances only, as in grass,
    coarser levels arrange nothing and make pieces large, which then repeat. One less again for a lattice of cells that
    are hardly told from each other on the coarsest level: being kept in step is all the arrangement that they need.
    """
    side = min(exemplar.shape[:2])
    levels = 1
    while level_size(side, levels) >= COARSEST:
        levels += 1
    period, reach = structure(exemplar)
    if levels > 1 and 0 < period < SEPARATE * 2 ** (levels - 1):
        levels -= 1
    while period >= SEPARATE * 2**levels and level_size(side, levels) >= LEAST_PERIODIC:
        levels += 1
    while levels > FEWEST and WINDOW * 2 ** (levels - 2) >= SEEN * reach:
        levels -= 1
    if levels > FEWEST and period > 0:
        found = coarse_repeats(pyramid(exemplar, levels))
        levels -= int(found is not None and found.cells and found.period < RESOLVED)
    return levels


def coarse_repeats(levels: Sequence[Array]) -> Repeats | None:
    """After how many pixels of the last of an exemplar's ``levels`` (h, w, c) it repeats itself.

    They are found on a finer one, but on none with more than :data:`ENOUGH` pixels a side.
    """
    last = len(levels) - 1
    at = next((level for level in range(last) if max(levels[level].shape[:2]) <= ENOUGH), last)
    coarse = 1 << (last - at)
    found = repeats(levels[at], max(1, coarse // 2))
    return None if found is None else found.enlarged(1 / coarse)


def most_levels(shape: Sequence[int]) -> int:
    """Largest number of levels that an exemplar of this height and width allows."""
    levels = 1
    while level_size(min(shape[:2]), levels) >= SMALLEST:
        levels += 1
    return levels


def stages(shape: Sequence[int], levels: int, windows: Sequence[int], iterations: int) -> list[Stage]:
    """What to do in order: levels from coarse to fine, on each the windows from large to small.

    Without ``windows`` they are those of :data:`WINDOW`. The finest level has half of the ``iterations``: pieces are
    cut anew after it, which makes up for more. The next one has one more than ``iterations``, and coarser ones three
    times as many for each level beyond it, at most :data:`MOST`: there they cost little, and decide whether elements
    stay whole. A level's windows share them. The finest level uses the smallest window alone. A window is at most half
    the exemplar's smaller side on its level.
    """
    result = []
    for level in range(levels - 1, -1, -1):
        side = min(level_size(shape[0], level), level_size(shape[1], level))
        largest = max(side // 2, min(side, SMALLEST))
        chosen = windows or ((2 * WINDOW, WINDOW) if level == levels - 1 else (WINDOW,))
        sizes = sorted({min(window, largest) for window in chosen}, reverse=True)
        count = iterations + level if level < FINE else min(max(MOST, iterations), 3 * iterations * (level - 1))
        if level == 0 and levels > 1:
            sizes, count = sizes[-1:], -(-count // 2)
        result += [Stage(level, size, -(-count // len(sizes))) for size in sizes]
    return result


def plan(
    exemplar: Array, usable: NDArray[np.bool_] | None, levels: int, windows: Sequence[int], iterations: int
) -> list[Stage]:
    """The stages for an exemplar (h, w, c) and its usable pixels (None = all); no levels or windows: automatic ones.

    Raises
    ------
    ValueError
        If more levels are asked for than the exemplar allows.
    """
    most = most_levels(exemplar.shape)
    if levels > most:
        raise ValueError(f"levels: expected at most {most} for an exemplar of shape {exemplar.shape}, got {levels}")
    result = stages(exemplar.shape, levels or automatic_levels(exemplar), windows, iterations)
    if usable is None:
        return result
    masks = masked_pyramid(usable.astype(np.float32), usable, result[0].level + 1)[1]
    return fitting(result, masks)


def eased(stages: Sequence[Stage], fine: int, coarse: int) -> list[Stage]:
    """The stages with their iterations divided, rounded up: by ``fine`` on the :data:`FINE` finest levels.

    With a ``fine`` of 0 these have no iterations, but for the coarsest level.
    """
    idle = 0 if fine else min(FINE, stages[0].level)
    result = []
    for stage in stages:
        divisor = fine if fine and stage.level < FINE else coarse
        result.append(Stage(stage.level, stage.window, 0 if stage.level < idle else -(-stage.iterations // divisor)))
    return result


def fitting(stages: Sequence[Stage], usable: Sequence[NDArray[np.bool_]]) -> list[Stage]:
    """Stages for an exemplar of which only some pixels are usable: ``usable`` masks of its levels, the finest first.

    Windows are halved, but not below :data:`LEAST`, until :data:`FEW` of them hold usable pixels only; a stage where
    fewer do is left out. If all are, what is left is one on the finest level with the largest window that fits as
    often, or at a quarter of the usable pixels where these are few: one place alone would be pasted everywhere.
    """
    result: list[Stage] = []
    for stage in stages:
        window = stage.window
        while window // 2 >= LEAST and _count(usable[stage.level], window) < FEW:
            window //= 2
        same = bool(result) and (result[-1].level, result[-1].window) == (stage.level, window)
        if not same and _count(usable[stage.level], window) >= FEW:
            result.append(Stage(stage.level, window, stage.iterations))
    if not result or result[-1].level > 0:
        window = stages[-1].window
        enough = min(FEW, np.count_nonzero(usable[0]) / 4)
        while _count(usable[0], window) < enough:
            window -= 1
        result.append(Stage(0, window, stages[-1].iterations))
    return result


def border(plan: Sequence[Stage], level: int) -> int:
    """Pixels that the canvas of a level reaches over the output on each side: its largest window; 0 on the finest.

    A pixel at the output's border lies at the border of all its windows, so without this its sources would lie near
    the same border of the exemplar. On coarse levels, where a window is half the exemplar, plain synthesis would then
    repeat the exemplar's layout, and with it a trend of texel sizes that it should not know of. A synthesis that is led
    by a target does without: windows beyond the output would ask for the rarest scales, those at the borders, again and
    again, and as all windows share the exemplar, those inside would have to do with middle ones.
    """
    return 0 if level == 0 else max(stage.window for stage in plan if stage.level == level)


def rim(window: int, usable: NDArray[np.bool_] | None, grain: float) -> int:
    """Pixels by which the exemplar's windows reach over its border, where it is mirrored.

    A quarter of their side: windows inside alone would hardly show what is at the border, since it lies at the border
    of the few that hold it, and on coarse levels an eighth of the exemplar on each side was shown half as often as its
    middle. Pixels of the rim are never copied. With a wider one elements that the border cuts look whole, and come out
    halved. ``grain``, 1 where there are no such elements, takes half as much again. Where only parts of an exemplar are
    ``usable``, its windows hold nothing else.
    """
    return int(window * (2 + grain) / 8) if usable is None else 0


def _count(usable: NDArray[np.bool_], window: int) -> int:
    """How many windows hold usable pixels only."""
    return int(np.count_nonzero(whole_windows(usable, window)))
