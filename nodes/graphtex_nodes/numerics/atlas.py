"""An exemplar enlarged by mirrored and resampled copies of itself: one picture with a mask, and its origin."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.guidance import BINS, resampled
from graphtex_nodes.numerics.sources import COLUMN, ROW

Array = NDArray[np.float32]
Flags = NDArray[np.bool_]

LOG, MIRRORED = 3, 5
"""Columns of a source map: log2 of the resampling, and whether it is mirrored."""
SHORT = 1.5
"""A scale is short when the output asks for this many times the share that the exemplar has of it ..."""
FEW = 0.5
"""... or when the exemplar has fewer elements (area over squared scale) of it than this quantile of wanted scales."""
STEP = 1 / 3
"""Resampled copies differ by factors of 2 ** STEP: windows of any wanted scale are then at most 12 % off."""


@dataclass(frozen=True)
class Atlas:
    """Copies of an exemplar below each other; the exemplar itself is the upper left corner.

    Attributes
    ----------
    picture, scale
        Colours (h, w, c) and texel scale (h, w) or None.
    usable
        Pixels (h, w) that may be copied: not those between the copies.
    origin
        A source map (h, w, 6): which point of the exemplar each pixel shows.
    """

    picture: Array
    scale: Array | None
    usable: Flags
    origin: Array


def original(picture: Array, scale: Array | None, usable: Flags | None) -> Atlas:
    """The exemplar alone."""
    origin = np.zeros((*picture.shape[:2], 6), np.float32)
    origin[..., ROW], origin[..., COLUMN] = np.mgrid[: picture.shape[0], : picture.shape[1]]
    return Atlas(picture, scale, np.ones(picture.shape[:2], bool) if usable is None else usable, origin)


def enlarged(atlas: Atlas, target: Array | None, *, mirror: bool, largest: float, unit: int) -> Atlas:
    """The exemplar with its mirror image, and with copies resampled by factors from 1 / largest to ``largest``.

    Of a resampled copy those pixels are usable whose scale, as it is shown now, is short in the exemplar; copies
    without such pixels are left out. Copies lie at multiples of ``unit`` pixels and at least two units apart, so that
    they stay apart on levels where a pixel is ``unit`` pixels wide.
    """
    copies = [atlas]
    if target is not None and atlas.scale is not None:
        edges, short = _short(atlas.scale[atlas.usable], target)
        steps = int(np.log2(largest) / STEP + 1e-9)
        for number in [*range(-steps, 0), *range(1, steps + 1)]:
            copy = _resampled(atlas, number * STEP)
            assert copy.scale is not None
            place = np.clip(np.searchsorted(edges, copy.scale, "right") - 1, 0, BINS - 1)
            usable = copy.usable & short[place] & (copy.scale >= edges[0]) & (copy.scale <= edges[-1])
            if usable.any():
                rows, columns = (np.flatnonzero(usable.any(axis=1 - axis)) for axis in (0, 1))
                box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
                copies.append(Atlas(copy.picture[box], copy.scale[box], usable[box], copy.origin[box]))
    if mirror:
        copies += [_mirrored(copy) for copy in copies]
    return _stacked(copies, unit)


def _short(have: Array, want: Array) -> tuple[NDArray[np.float64], Flags]:
    """Edges of bins of scale, and which of them the output asks for and the exemplar is short of."""
    low, high = min(have.min(), want.min()), max(have.max(), want.max())
    edges = np.geomspace(low, max(high, low * 1.001), BINS + 1)
    edges[0], edges[-1] = low, max(high, edges[-1])
    counts = [np.histogram(values, edges)[0] for values in (have, want)]
    wanted = counts[1] > 0
    elements = counts[0] / (edges[1:] * edges[:-1])
    short: Flags = wanted & (counts[1] / want.size > SHORT * counts[0] / have.size)
    short |= wanted & (elements < np.quantile(elements[wanted], FEW))
    return edges, short


def _mirrored(atlas: Atlas) -> Atlas:
    """Right to left."""
    origin = atlas.origin[:, ::-1].copy()
    origin[..., MIRRORED] = 1 - origin[..., MIRRORED]
    scale = None if atlas.scale is None else atlas.scale[:, ::-1]
    return Atlas(atlas.picture[:, ::-1], scale, atlas.usable[:, ::-1], origin)


def _resampled(atlas: Atlas, log: float) -> Atlas:
    """Shown 2 ** log times as large: cubic splines, before them a Gaussian where it gets smaller."""
    from scipy.ndimage import gaussian_filter, map_coordinates

    factor = 2.0**log
    height, width = (max(1, round(side * factor)) for side in atlas.picture.shape[:2])
    y = (np.arange(height) + 0.5) / factor - 0.5
    x = (np.arange(width) + 0.5) / factor - 0.5
    places = np.meshgrid(y, x, indexing="ij")
    blur = 0.5 * np.sqrt(max(0.0, factor**-2 - 1))
    colours: list[Any] = []
    for channel in np.moveaxis(atlas.picture, -1, 0):
        smooth = gaussian_filter(channel, blur, mode="nearest") if blur > 0 else channel
        found = map_coordinates(smooth, places, order=3, mode="nearest")
        colours.append(np.clip(found, channel.min(), channel.max()))
    nearest = np.ix_(
        np.clip(np.rint(y), 0, atlas.picture.shape[0] - 1).astype(int),
        np.clip(np.rint(x), 0, atlas.picture.shape[1] - 1).astype(int),
    )
    usable = map_coordinates(atlas.usable.astype(np.float32), places, order=1, mode="nearest") > 0.999
    origin = atlas.origin[nearest].copy()
    origin[..., ROW], origin[..., COLUMN] = places[0], places[1]
    origin[..., ROW] = np.clip(origin[..., ROW], 0, atlas.picture.shape[0] - 1)
    origin[..., COLUMN] = np.clip(origin[..., COLUMN], 0, atlas.picture.shape[1] - 1)
    origin[..., LOG] = log
    scale = None if atlas.scale is None else resampled(atlas.scale, (height, width)) * np.float32(factor)
    return Atlas(np.stack(colours, axis=-1).astype(np.float32), scale, usable, origin)


def _stacked(copies: list[Atlas], unit: int) -> Atlas:
    """Copies below each other on one sheet."""
    tops, height = [], 0
    for copy in copies:
        tops.append(height)
        height += (-(-copy.usable.shape[0] // unit) + 2) * unit
    height = tops[-1] + copies[-1].usable.shape[0]
    shape = height, max(copy.usable.shape[1] for copy in copies)
    first = copies[0]
    picture = np.zeros((*shape, first.picture.shape[2]), np.float32)
    scale = None if first.scale is None else np.ones(shape, np.float32)
    usable, origin = np.zeros(shape, bool), np.zeros((*shape, 6), np.float32)
    for top, copy in zip(tops, copies, strict=True):
        box = slice(top, top + copy.usable.shape[0]), slice(0, copy.usable.shape[1])
        picture[box], usable[box], origin[box] = copy.picture, copy.usable, copy.origin
        if scale is not None and copy.scale is not None:
            scale[box] = copy.scale
    return Atlas(picture, scale, usable, origin)
