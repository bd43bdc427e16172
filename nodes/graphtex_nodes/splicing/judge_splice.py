"""How well a splice came out, told without a reference."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex import Axes, Displacement, LabelMap, Mask, Number, SourceMap, node
from graphtex_nodes.splicing.rigid_warp import moved
from graphtex_nodes.splicing.values import Extension, Moves

Array = NDArray[Any]

SHOWN = 0.85
"""An element is cut if less of it shows than this share."""
NEAR = 1.5
"""A pixel shows its element if its source is within so many pixels of the one expected."""
BENT = 1.5
"""An element is bent if it is so many times longer against its width than it was."""
LEAST = 9
"""Pixels of an element that are needed to tell how it is bent."""


class Verdict(NamedTuple):
    """Shares from 0 to 1, and a slope; see `JudgeSplice`."""

    cut: Number
    fidelity: Number
    holes: Number
    stretched: Number
    bent: Number
    slope: Number


@node
def judge_splice(
    elements: Extension,
    moves: Moves,
    mask: Annotated[Mask, Axes("h w")],
    source: Annotated[SourceMap, Axes("h w s")],
    holes: Annotated[Mask, Axes("h w")],
    warp: Displacement | None = None,
    laid: Annotated[SourceMap, Axes("h w s")] | None = None,
    cells: Annotated[LabelMap, Axes("h w")] | None = None,
) -> Verdict:
    """Count what goes wrong in splices: elements cut, covered or bent, foreground that is elsewhere, holes.

    Parameters
    ----------
    elements, moves
        What was spliced and where each texton went.
    mask, source
        The spliced foreground and sources, from `Refine`.
    holes
        Pixels that the warp left empty, from `Rasterize`.
    warp
        From `RigidWarp`; without it nothing can be told of `bent` and `slope`, which are 0 then.
    laid, cells
        Source and cells from `Retile`. If it has laid a wall anew, the warp does not count: `bent` is told of the
        foreground of cells, and nothing has a `slope`, since no joint is one that was there before.

    Returns
    -------
    cut
        Share of the elements that lie in the window as a whole of which less than 85 % shows, because the border of the
        extension or another element is in the way or the warp has torn them. 0 where there are none.
    fidelity
        Intersection over union of the spliced foreground and all given textons' pixels at their places.
    holes
        Share of pixels that had to be made up.
    stretched
        Share of the pixels expected in the foreground that show something else, or their element distorted.
    bent
        Share of the elements in the window that are made longer against their width by half or more: the ratio of
        the singular values of the affine map that is nearest to it over the element, by least squares.
    slope
        How far what lies between elements in the window, such as joints, turns: the mean of the absolute change of one
        component of the displacement along the other, the larger of the two. 0.1 is about 6 degrees.

    For the tag B=c, whose elements may be deformed, ``cut`` and ``stretched`` only tell how much they are; there
    ``bent`` and ``slope`` count. For other tags ``bent`` is near 0, and a ``slope`` is no fault: what lies between
    elements that keep their shape has to stretch.

    Raises
    ------
    ValueError
        The pictures do not have the size of the window.
    """
    shape = (elements.height, elements.width)
    if mask.shape != shape:
        raise ValueError(f"mask: expected shape {shape} as the window of elements, got {mask.shape}")
    pixels, places = moved(elements.labels, moves)
    index = elements.labels[pixels[:, 1], pixels[:, 0]]
    place = np.rint(places - (elements.left, elements.top)).astype(np.int64)
    given = moves.matched[index] > 0
    inside = ((place >= 0) & (place < (elements.width, elements.height))).all(axis=1)
    whole = moves.matched > 0
    whole[index[~inside]] = False
    whole &= np.bincount(index, minlength=len(whole)) > 0
    visible = given & inside
    x, y = place[visible].T
    wanted = elements.source[pixels[visible, 1], pixels[visible, 0], 1:3]
    shown = (np.abs(source[y, x, 1:3] - wanted) <= NEAR).all(axis=1)
    total = np.bincount(index[visible], minlength=len(whole))
    seen = np.bincount(index[visible], shown, minlength=len(whole))
    cut = seen[whole] < SHOWN * total[whole]
    expected = np.zeros(shape, bool)
    expected[y, x] = True
    both, either = np.count_nonzero(expected & mask), np.count_nonzero(expected | mask)
    return Verdict(
        float(cut.mean()) if len(cut) else 0.0,
        both / either if either else 1.0,
        float(holes.mean()),
        float(1 - shown.mean()) if len(shown) else 0.0,
        *_deformed(elements, moves, warp, mask, laid, cells),
    )


def _deformed(
    elements: Extension, moves: Moves, warp: Array | None, mask: Array, laid: Array | None, cells: Array | None
) -> tuple[float, float]:
    """Share of elements that are bent, and the slope of the background."""
    if laid is not None and cells is not None and (cells >= 0).any():
        return _bent_in_cells(mask, laid, cells), 0.0
    return (0.0, 0.0) if warp is None else (_bent(elements, moves, warp), _slope(elements, warp))


def _bent_in_cells(mask: Array, source: Array, cells: Array) -> float:
    """Share of the cells within the window whose foreground is bent from what it was in the texture."""
    rows, columns = np.nonzero(mask & (cells >= 0))
    index, count = cells[rows, columns], int(cells.max()) + 1
    bent, told = _longer(index, count, source[rows, columns, 2:0:-1].T, np.stack([columns, rows]))
    for line in (cells[0], cells[-1], cells[:, 0], cells[:, -1]):
        told[line[line >= 0]] = False
    return float(bent[told].mean()) if told.any() else 0.0


def _bent(elements: Extension, moves: Moves, warp: Array) -> float:
    """Share of the elements that lie in the window, by their centre, and are bent."""
    rows, columns = np.nonzero(elements.labels >= 0)
    index, before = elements.labels[rows, columns], np.stack([columns, rows])
    bent, told = _longer(index, len(moves.points), before, before + warp[rows, columns].T)
    place = moves.targets - (elements.left, elements.top)
    told &= ((place >= 0) & (place < (elements.width, elements.height))).all(axis=1) & (moves.matched > 0)
    return float(bent[told].mean()) if told.any() else 0.0


def _longer(index: Array, count: int, before: Array, after: Array) -> tuple[Array, Array]:
    """Which of so many elements are bent, and of which it can be told, by places (2, n) of their pixels."""
    size = np.bincount(index, minlength=count)

    def means(values: Array) -> Array:
        result: Array = np.bincount(index, values, count) / np.maximum(size, 1)
        return result

    apart = [values - means(values)[index] for values in (*before, *after)]
    own = np.array([[means(apart[i] * apart[j]) for i in (0, 1)] for j in (0, 1)]).transpose(2, 0, 1)
    both = np.array([[means(apart[i] * apart[j]) for i in (0, 1)] for j in (2, 3)]).transpose(2, 0, 1)
    told = (size >= LEAST) & (np.linalg.det(own) > 1e-6)
    bent = np.zeros(count, bool)
    if told.any():
        # the product of the affine map and own is both
        larger, smaller = np.linalg.svd(both[told] @ np.linalg.inv(own[told]), compute_uv=False).T
        bent[told] = larger > BENT * smaller
    return bent, told


def _slope(elements: Extension, warp: Array) -> float:
    """Mean slope that the background gets, where it comes to lie in the window."""
    shift = warp.astype(np.float64)
    across, down = np.diff(shift[:-1, :, 1], axis=1), np.diff(shift[:, :-1, 0], axis=0)
    row, column = np.indices(across.shape)
    x, y = column + shift[:-1, :-1, 0] - elements.left, row + shift[:-1, :-1, 1] - elements.top
    ground = ~(elements.mask[:-1, :-1] | elements.mask[1:, :-1] | elements.mask[:-1, 1:])
    ground &= (x >= 0) & (x < elements.width) & (y >= 0) & (y < elements.height)
    return max(float(np.abs(each[ground]).mean()) for each in (across, down)) if ground.any() else 0.0
