"""Where the vanishing line of a plane lies, told from how well its texture fits itself after moves over the plane."""

from dataclasses import replace

import numpy as np

from graphtex_nodes.numerics.move_search import Level, anchors, fits, laid_flat
from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.plane_moves import Slope

LEAST, STEEPEST, STEEPER = 0.15, 1.6, 1.2
"""Changes of scale over the picture that are tried, in units of that at the hole; and their ratio."""
ANCHORS = 9
"""Places along the hole's border that are asked."""
ROUNDS = 4
"""Rounds of smaller and smaller steps up, down and sideways."""
TELLING = 0.9
"""Share of the median mismatch that the least must stay below for it to tell the slope."""


def refined(slope: Slope, level: Level, work: Work) -> Slope:
    """The slope near the given one after whose moves a picture fits best around its hole.

    Of a texture without any order all slopes fit alike: the given one is then kept.
    """
    if slope.flat:
        return slope
    variance = float(level.picture[~level.hole].var(axis=0, dtype=np.float64).sum())

    def mismatch(tried: Slope) -> float:
        sheet = laid_flat(tried, level)
        places = anchors(sheet, ANCHORS)
        # an anchor for which nothing fits must not make a slope look better
        costs = np.full(max(1, len(places)), 2 * variance)
        for fit in fits(tried, sheet, places, None, 1, work):
            costs[fit.anchor] = fit.cost
        return float(costs.mean())

    change = abs(slope.down) * level.hole.shape[0] + abs(slope.right) * level.hole.shape[1]
    factors = np.exp(np.arange(np.log(LEAST), np.log(STEEPEST), np.log(STEEPER))) / change
    tried = [replace(slope, down=slope.down * factor, right=slope.right * factor) for factor in factors]
    costs = [mismatch(each) for each in tried]
    best = min(costs)
    if best > TELLING * float(np.median(costs)):
        return slope
    chosen = tried[costs.index(best)]
    step = float(np.hypot(chosen.down, chosen.right)) * (STEEPER - 1) / 2
    for _ in range(ROUNDS):
        for down, right in ((step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)):
            other = replace(chosen, down=chosen.down + down, right=chosen.right + right)
            cost = mismatch(other)
            if cost < best:
                best, chosen = cost, other
        step /= 2
    return chosen
