"""How well a splice came out, told without a reference."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex import Axes, Mask, Number, SourceMap, node
from graphtex_nodes.splicing.rigid_warp import moved
from graphtex_nodes.splicing.values import Extension, Moves

Array = NDArray[Any]

SHOWN = 0.85
"""An element is cut if less of it shows than this share."""
NEAR = 1.5
"""A pixel shows its element if its source is within so many pixels of the one expected."""


class Verdict(NamedTuple):
    """Shares from 0 to 1; see `JudgeSplice`."""

    cut: Number
    fidelity: Number
    holes: Number
    stretched: Number


@node
def judge_splice(
    elements: Extension,
    moves: Moves,
    mask: Annotated[Mask, Axes("h w")],
    source: Annotated[SourceMap, Axes("h w s")],
    holes: Annotated[Mask, Axes("h w")],
) -> Verdict:
    """Count what goes wrong in splices: elements cut or covered, foreground that is not where it should be, holes.

    Parameters
    ----------
    elements, moves
        What was spliced and where each texton went.
    mask, source
        The spliced foreground and sources, from `Refine`.
    holes
        Pixels that the warp left empty, from `Rasterize`.

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

    For the tag B=c, whose elements may be deformed, ``cut`` and ``stretched`` only tell how much they are.

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
    )
