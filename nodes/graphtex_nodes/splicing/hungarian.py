"""Which texton goes where: the cheapest assignment (Liu et al. 2009, section 4.1, equation 4)."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Elements, Number, node
from graphtex_nodes.splicing.values import Extension, Moves

Array = NDArray[Any]

MOST_PAIRS = 50_000_000
"""Largest cost matrix, 400 MB."""
JOINT = 1.0
"""What an element costs in which pieces of the extension meet, in usual distances of neighbours."""
NEIGHBOURS = 6
"""Matched textons that a surplus one follows."""


class Assignment(NamedTuple):
    """Where each texton goes, the mean distance of that (pixels), and how many places got no texton."""

    moves: Moves
    distance: Number
    empty: Number


@node
def hungarian(
    elements: Extension,
    target: Elements,
    *,
    farthest: Annotated[
        float, Field(ge=0, description="places farther than this many pixels stay empty; 0 = no limit")
    ] = 0.0,
    ctx: Context = QUIET,
) -> Assignment:
    r"""Assign textons to the places of an arrangement so that the sum of their distances is the smallest.

    .. math:: f = \arg\min_{f} \sum_i \| p_i - f(p_i) \|,\quad f \text{ injective}

    Parameters
    ----------
    elements
        Textons (n) to be moved; those that its border cuts are taken only where there are too few others.
    target
        Places (m) in pixels of the window, with an angle and a scale each.
    farthest
        A texton that would have to go farther is not assigned: an unassigned pair costs as much as this distance.

    Returns
    -------
    Assignment
        ``moves`` has all n textons: the min(n, m) assigned ones, and the surplus, which moves by the mean displacement
        of its nearest assigned neighbours, weighted by the inverse squared distance. So every texton is a constraint of
        the warp whatever the arrangement, and one factorisation serves all (see `FactorWarp`).

    Raises
    ------
    ValueError
        There is no texton or no place, or more than 5e7 pairs of them.

    Notes
    -----
    The paper assumes equal numbers; here either may be larger, and a warning tells of places that stay empty. Disjoint
    elements (F=d) in or beside which two pieces of the extension meet, and may be cut, are taken where others are far.
    """
    points = elements.points
    if len(points) == 0:
        raise ValueError("elements: expected at least one texton, got none")
    if len(target.points) == 0:
        raise ValueError("target: expected at least one place, got none")
    if len(points) * len(target.points) > MOST_PAIRS:
        raise ValueError(
            f"target: expected at most {MOST_PAIRS:.0e} pairs of textons and places, got {len(points)} x "
            f"{len(target.points)}: a smaller window has fewer"
        )
    places = target.points + np.array([elements.left, elements.top])
    extra = np.where(_joined(elements), JOINT * _usual_distance(points), 0.0)
    extra[_cut(elements)] = sum(elements.mask.shape)
    moved, taken, distances = assign(points, places, farthest, extra)
    empty = len(places) - len(taken)
    if empty:
        ctx.warn(f"{empty} of {len(places)} places got no texton: extend the elements by a larger factor")
    targets, angles, scales, matched = points.copy(), np.zeros(len(points)), np.ones(len(points)), np.zeros(len(points))
    targets[moved], matched[moved] = places[taken], 1
    angles[moved], scales[moved] = target.angles[taken], target.scales[taken]
    if 0 < len(moved) < len(points):
        rest = matched == 0
        targets[rest] += carried(points[moved], places[taken] - points[moved], points[rest])
    mean = float(distances.mean()) if len(distances) else 0.0
    return Assignment(Moves(points.copy(), targets, angles, scales, matched), mean, empty)


def assign(
    points: Array, places: Array, farthest: float = 0.0, extra: Array | None = None
) -> tuple[Array, Array, Array]:
    """Indices of points and of the places that they are assigned to, and their distances.

    ``extra`` (n,) is what taking a point costs beside its distance.

    >>> assign(np.array([[0.0, 0.0], [5.0, 0.0]]), np.array([[4.0, 0.0]]))
    (array([1]), array([0]), array([1.]))
    """
    from scipy.optimize import linear_sum_assignment
    from scipy.spatial.distance import cdist

    found = cdist(points, places)
    costs = np.minimum(found, farthest) if farthest else found
    chosen, taken = linear_sum_assignment(costs if extra is None else costs + extra[:, None])
    distances = found[chosen, taken]
    near = distances <= farthest if farthest else np.ones(len(distances), bool)
    return chosen[near], taken[near], distances[near]


def carried(known: Array, shifts: Array, points: Array) -> Array:
    """Shifts (n, 2) of points from those of the nearest known ones, weighted by the inverse squared distance."""
    from scipy.spatial import cKDTree

    count = min(NEIGHBOURS, len(known))
    found, index = cKDTree(known).query(points, k=[*range(1, count + 1)])
    distances = np.asarray(found)
    weights = 1 / (distances**2 + 1e-6)
    weights /= weights.sum(axis=1, keepdims=True)
    result: Array = (weights[..., None] * shifts[index]).sum(axis=1)
    return result


def _cut(elements: Extension) -> Array:
    """Which textons touch the border."""
    labels = elements.labels
    cut = np.zeros(len(elements.points) + 1, bool)
    for line in (labels[0], labels[-1], labels[:, 0], labels[:, -1]):
        cut[line] = True  # -1, the background, is the last
    return cut[:-1]


def _joined(elements: Extension) -> Array:
    """Which disjoint textons hold or touch a seam between pieces of the extension."""
    found = np.zeros(len(elements.points) + 1, bool)
    if elements.tag == "F=d":
        place, labels = elements.source[..., 1:3], elements.labels
        down = (np.diff(place, axis=0) != np.array([1, 0])).any(axis=2)
        right = (np.diff(place, axis=1) != np.array([0, 1])).any(axis=2)
        for beside in (labels[:-1][down], labels[1:][down], labels[:, :-1][right], labels[:, 1:][right]):
            found[beside] = True  # -1, the background, is the last
    return found[:-1]


def _usual_distance(points: Array) -> float:
    """Median distance to the nearest other point; 0 for a single one."""
    from graphtex_nodes.splicing._pattern import distances

    return float(np.median(distances(points))) if len(points) > 1 else 0.0
