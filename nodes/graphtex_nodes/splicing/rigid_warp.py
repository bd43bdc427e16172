"""Context-dependent deformation: textons go to their places, rigid parts keep their shape (Liu et al. 2009, 4.2)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import QUIET, Context, Displacement, node
from graphtex_nodes.numerics.jit import announce
from graphtex_nodes.splicing._stiffness import CONSTRAINT, RULES
from graphtex_nodes.splicing.factor_warp import Hold, constraint_rows, held_labels
from graphtex_nodes.splicing.tags import checked_tag
from graphtex_nodes.splicing.values import Extension, Factor, Moves

Array = NDArray[Any]


@node
def rigid_warp(
    elements: Extension,
    moves: Moves,
    factor_x: Factor,
    factor_y: Factor,
    *,
    hold: Hold = "centres",
    ctx: Context = QUIET,
) -> Displacement:
    """Displacement of each pixel of an extension that takes its textons to their places (equation 5).

    Parameters
    ----------
    elements
        The extension (h, w) that both factors were made from.
    moves
        Where each of its textons goes. Angles and scales count with ``hold: elements`` alone: a centre cannot turn.
    factor_x, factor_y
        From `FactorWarp`, with the same `hold`.

    Returns
    -------
    Displacement
        (h, w, 2): pixel p of the extension goes to p plus this.

    Raises
    ------
    ValueError
        The moves or a factor are of another extension.

    Notes
    -----
    ``elements`` takes each pixel p of a texton at c to :math:`t + s R (p - c)`, the similarity that its move names.
    """
    shape = elements.mask.shape
    if moves.points.shape != elements.points.shape or not np.array_equal(moves.points, elements.points):
        raise ValueError(f"moves: expected the {len(elements.points)} textons of elements, got other points")
    for name, factor in (("factor_x", factor_x), ("factor_y", factor_y)):
        if len(factor.order) != elements.mask.size:
            raise ValueError(f"{name}: expected a factor of {elements.mask.size} pixels, got {len(factor.order)}")
    announce(ctx, "warp_kernels")
    rows, _ = constraint_rows(elements, hold)
    wanted = moves.targets - moves.points if hold == "centres" else _similarities(elements, moves)
    right_side = CONSTRAINT * (rows.T @ wanted)
    shared = RULES[checked_tag(elements.tag, "elements.tag")].crossing == 1
    if shared:
        solved = solve(factor_x, right_side)
    else:
        parts = [solve(factor, right_side[:, [axis]]) for axis, factor in enumerate((factor_x, factor_y))]
        solved = np.concatenate(parts, axis=1)
    return solved.reshape(*shape, 2).astype(np.float32)


def solve(factor: Factor, right_side: Array) -> Array:
    """Solution (n, m) of the factorised system for m right sides."""
    from graphtex_nodes.splicing import warp_kernels

    permuted = np.ascontiguousarray(right_side[factor.order].T)
    warp_kernels.solve(factor.starts, factor.rows, factor.values, factor.pivots, permuted)
    result = np.empty_like(right_side)
    result[factor.order] = permuted.T
    return result


def moved(labels: Array, moves: Moves) -> tuple[Array, Array]:
    """Pixels (m, 2) that belong to a texton, x and y in order, and the places that its similarity takes them to."""
    rows, columns = np.nonzero(labels >= 0)
    index = labels[rows, columns]
    pixels = np.stack([columns, rows], axis=1)
    offset = pixels - moves.points[index]
    turn = np.radians(moves.angles[index])
    cos, sin = moves.scales[index] * np.cos(turn), moves.scales[index] * np.sin(turn)
    turned = np.stack([cos * offset[:, 0] - sin * offset[:, 1], sin * offset[:, 0] + cos * offset[:, 1]], axis=1)
    return pixels, moves.targets[index] + turned


def _similarities(elements: Extension, moves: Moves) -> Array:
    """Displacement (m, 2) of each pixel that is held, in order."""
    pixels, places = moved(held_labels(elements), moves)
    displacement: Array = places - pixels
    return displacement
