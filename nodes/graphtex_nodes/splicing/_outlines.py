"""Masks of large pictures: cut out of a reduced picture, then refined along their outlines."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Context

Array = NDArray[Any]

LARGE = 1 << 20  # pixels above which a picture is reduced first
LEAST_SIDE = 12.0  # pixels of an element that must be left
TILE, MARGIN = 512, 8  # pixels of a tile, and what it sees of its neighbours
SURE = 1e6  # cost of what lies off the outlines


def reduction(shape: tuple[int, ...], side: float) -> float:
    """Pixels of a picture between those of the reduced one that is cut first; 1 for the picture as it is.

    Elements with a shorter side of `side` pixels stay recognisable.

    >>> reduction((4096, 4096), 400.0), reduction((4096, 4096), 18.0), reduction((512, 512), 60.0)
    (4.0, 1.5, 1.0)
    """
    return max(1.0, min(float(np.sqrt(shape[0] * shape[1] / LARGE)), side / LEAST_SIDE))


def nearest_indices(sides: tuple[int, ...], small: tuple[int, ...], step: float) -> list[Array]:
    """For each axis which pixel of the reduced picture is nearest to each of the picture."""
    return [
        np.minimum(np.rint(np.arange(side) / step).astype(np.int64), less - 1)
        for side, less in zip(sides, small, strict=True)
    ]


def refined_outlines(
    coarse: Array, step: float, known: Array, tile: Callable[[tuple[slice, slice]], Array],
    cost: Callable[[Array], Array], smoothness: Callable[[Array], tuple[Array, Array]], ctx: Context,
) -> Array:  # fmt: skip
    """A mask of all pixels, from that of every `step`-th (h, w): the cut that costs least within bands.

    A band reaches two pixels of the reduced picture to both sides of each outline; elsewhere the mask stays
    (banded graph cuts, Lombaert et al. 2005).

    Parameters
    ----------
    known
        1 where foreground is known, -1 where background is, at all pixels.
    tile
        The part (rows, columns, c) of the picture in two slices.
    cost
        What each of some pixels (n, c) costs as foreground less as background.
    smoothness
        What parts each pixel of a tile from its right and its lower neighbour.
    """
    from scipy.ndimage import binary_dilation

    from graphtex_nodes.splicing._colours import least_cut, sharpened

    height, width = known.shape
    rows, columns = nearest_indices(known.shape, coarse.shape, step)
    square = np.ones((5, 5), bool)
    band = binary_dilation(coarse, square) & binary_dilation(~coarse, square)
    mask = np.empty(known.shape, bool)
    corners = [(top, left) for top in range(0, height, TILE) for left in range(0, width, TILE)]
    for number, (top, left) in enumerate(corners):
        ctx.progress(number / len(corners), "refining outlines")
        window = tuple(
            slice(max(0, start - MARGIN), min(side, start + TILE + MARGIN))
            for start, side in ((top, height), (left, width))
        )
        at = np.ix_(rows[window[0]], columns[window[1]])
        part, open_ = coarse[at], band[at] & (known[window] == 0)
        if open_.any():
            picture = tile((window[0], window[1]))
            costs = np.where(part, -SURE, SURE)
            costs[open_] = cost(picture[open_])
            costs -= SURE * known[window]
            right, down = smoothness(picture)
            part = sharpened(least_cut(costs, right, down), np.maximum(picture, 0) ** 2.2)
        part = (part | (known[window] > 0)) & ~(known[window] < 0)
        inner = tuple(
            slice(start - w.start, start - w.start + TILE) for start, w in zip((top, left), window, strict=True)
        )
        kept = part[inner]
        mask[top : top + kept.shape[0], left : left + kept.shape[1]] = kept
    return mask


def refined_labels(coarse: Array, mask: Array, step: float) -> Array:
    """Labels of a mask's pixels, of those of every `step`-th pixel (h, w), 0 where there is none near."""
    from scipy.ndimage import distance_transform_edt

    away, (row, column) = distance_transform_edt(coarse == 0, return_indices=True)
    grown = np.where(away <= 3, coarse[row, column], 0)
    at = np.ix_(*nearest_indices(mask.shape, coarse.shape, step))
    labels: Array = np.where(mask, grown[at], 0).astype(np.int32)
    return labels
