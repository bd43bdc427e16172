"""Exemplars and copies of them, mirrored, turned and resampled, as one picture with a mask, and its origin."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.guidance import BINS
from graphtex_nodes.numerics.materials import MapKind, turn
from graphtex_nodes.numerics.parallel import Work, for_rows
from graphtex_nodes.numerics.sources import ANGLE, COLUMN, INDEX, LOG, MIRRORED, ROW, Look, continued

Array = NDArray[np.float32]
Flags = NDArray[np.bool_]

SHORT = 1.5
"""A scale is short when the output asks for this many times the share that the exemplar has of it ..."""
FEW = 0.5
"""... or when the exemplar has fewer elements (area over squared scale) of it than this quantile of wanted scales."""
LARGEST = 1 << 26
"""Pixels of all copies together: with more a synthesis would need some 20 GB."""
STEP = 1 / 3
"""Resampled copies differ by factors of 2 ** STEP: windows of any wanted scale are then at most 12 % off."""


@dataclass(frozen=True)
class Atlas:
    """Exemplars and copies of them below each other; the first exemplar itself is the upper left corner.

    Attributes
    ----------
    picture, scale, angle
        Colours (h, w, c), texel scale (h, w) or None, and direction (h, w) in degrees or None.
    usable
        Pixels (h, w) that may be copied: not those between the copies.
    origin
        A source map (h, w, 6): which point of which exemplar each pixel shows.
    """

    picture: Array
    scale: Array | None
    usable: Flags
    origin: Array
    angle: Array | None = None


@dataclass(frozen=True)
class Stock:
    """Which copies are made of exemplars.

    Attributes
    ----------
    mirror
        Whether there are mirror images.
    scales, largest
        The output's scales, and up to which factor copies are resampled to have them.
    angles, turn_step, arrows
        The output's directions (degrees), by how much turned copies differ, and whether a half turn matters.
    """

    mirror: bool = False
    scales: Array | None = None
    largest: float = 1.0
    angles: Array | None = None
    turn_step: float = 15.0
    arrows: bool = False


def original(
    picture: Array, scale: Array | None, usable: Flags | None, angle: Array | None = None, index: int = 0
) -> Atlas:
    """An exemplar alone, and its index."""
    height, width = picture.shape[:2]
    origin = np.zeros((height, width, 6), np.float32)
    origin[..., INDEX] = index
    origin[..., ROW], origin[..., COLUMN] = np.mgrid[:height, :width]
    return Atlas(picture, scale, np.ones((height, width), bool) if usable is None else usable, origin, angle)


def leading(exemplars: Sequence[Atlas], *, turned: bool) -> Array:
    """Colours (h, w, c) of the exemplar that levels are chosen for, their mean where it is not usable.

    It is the smallest of those that have at least half the largest one's smaller side, so that all these are seen on
    the coarsest level. If ``turned``, only its middle: what a copy turned by 45 degrees shows in an upright square.
    """
    sides = [min(exemplar.usable.shape) for exemplar in exemplars]
    first = exemplars[sides.index(min(side for side in sides if 2 * side >= max(sides)))]
    colours = first.picture
    if not first.usable.all():
        mean = colours[first.usable].mean(axis=0)
        colours = np.where(first.usable[..., None], colours, mean).astype(np.float32)
    if not turned:
        return colours
    top, left = (int(side * (1 - 0.5**0.5) / 2) for side in first.usable.shape)
    return colours[top : colours.shape[0] - top, left : colours.shape[1] - left]


def enlarged(exemplars: Sequence[Atlas], stock: Stock, unit: int, kinds: Sequence[MapKind] = ()) -> Atlas:
    """Exemplars with mirrored copies, turned ones, and copies resampled by factors from 1 / largest to ``largest``.

    Of a resampled copy those pixels are usable whose scale, as it is shown now, is short in the exemplars, of a turned
    one those whose direction is wanted; copies without such pixels are left out. Copies lie at multiples of ``unit``
    pixels and at least two units apart, so that they stay apart on levels where a pixel is ``unit`` pixels wide.
    Normals among the ``kinds`` turn with their copy.

    Raises
    ------
    ValueError
        If turned copies would be too many.
    """
    views = (False, True) if stock.mirror else (False,)
    looks = [(exemplar, Look(exemplar.picture, kinds)) for exemplar in exemplars]
    copies = [view(*look, mirrored=mirrored) for mirrored in views for look in looks]
    have = [exemplar.scale[exemplar.usable] for exemplar in exemplars if exemplar.scale is not None]
    if stock.scales is not None and have and stock.largest > 1:
        edges, short = _short(np.concatenate(have), stock.scales)
        steps = int(np.log2(stock.largest) / STEP + 1e-9)
        for number in [*range(-steps, 0), *range(1, steps + 1)]:
            for look, mirrored in product(looks, views):
                copy = view(*look, log=number * STEP, mirrored=mirrored)
                assert copy.scale is not None
                place = np.clip(np.searchsorted(edges, copy.scale, "right") - 1, 0, BINS - 1)
                copies += _limited(copy, short[place] & (copy.scale >= edges[0]) & (copy.scale <= edges[-1]))
    if stock.angles is not None and stock.turn_step > 0:
        circle = 360 if stock.arrows else 180
        wanted = _wanted(stock.angles, circle, stock.turn_step)
        angles = np.arange(stock.turn_step, circle, stock.turn_step).tolist()
        area = len(angles) * len(views) * sum(exemplar.usable.size for exemplar in exemplars)
        if area > LARGEST:
            raise ValueError(
                f"turn_step: {len(angles)} turned copies of exemplars of {area // len(angles):,} pixels are more than "
                f"the {LARGEST:,} pixels that there may be: expected a larger step or smaller exemplars"
            )
        for angle in angles:
            for look, mirrored in product(looks, views):
                copy = view(*look, angle=angle, mirrored=mirrored)
                assert copy.angle is not None
                copies += _limited(copy, wanted[np.rint(copy.angle).astype(np.intp) % circle])
    return _stacked(copies, unit)


def _wanted(angles: Array, circle: int, step: float) -> Flags:
    """For each whole degree of a circle whether the output has a direction within a step of it."""
    there = np.bincount(np.rint(angles).astype(np.intp).ravel() % circle, minlength=circle) > 0
    near = there.copy()
    for shift in range(1, int(np.ceil(step)) + 1):
        near |= np.roll(there, shift) | np.roll(there, -shift)
    return near


def _limited(copy: Atlas, wanted: Flags) -> list[Atlas]:
    """The part of a copy that is wanted, without what lies around it; nothing if there is none."""
    usable = copy.usable & wanted
    if not usable.any():
        return []
    rows, columns = (np.flatnonzero(usable.any(axis=1 - axis)) for axis in (0, 1))
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    scale, angle = (None if values is None else values[box] for values in (copy.scale, copy.angle))
    return [Atlas(copy.picture[box], scale, usable[box], copy.origin[box], angle)]


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


def view(exemplar: Atlas, look: Look, *, log: float = 0.0, angle: float = 0.0, mirrored: bool = False) -> Atlas:
    """An exemplar as it is, mirrored, then turned clockwise (degrees), then shown 2 ** log times as large."""
    if log == 0 and angle == 0 and not mirrored:
        return exemplar
    from scipy.ndimage import map_coordinates

    height, width = exemplar.usable.shape
    cos, sin = (abs(part) * 2.0**log for part in turn(angle))
    sides = (max(1, round(height * cos + width * sin)), max(1, round(width * cos + height * sin)))
    origin = np.zeros((*sides, 6), np.float32)
    middle = (height - 1) / 2, (width - 1) / 2
    origin[..., INDEX], origin[..., LOG] = exemplar.origin[0, 0, INDEX], log
    origin[..., ANGLE], origin[..., MIRRORED] = angle, mirrored
    down, right = np.mgrid[: sides[0], : sides[1]] - (np.array(sides)[:, None, None] - 1) / 2
    places = np.moveaxis(continued(origin, down, right) + middle, -1, 0)
    inside = np.ones(sides, bool)
    for axis, place in enumerate(places):
        size = exemplar.usable.shape[axis]
        inside &= (place > -0.75) & (place < size - 0.25)
        origin[..., ROW + axis] = np.clip(place, 0, size - 1)
    points = origin[inside]
    picture = np.zeros((*sides, exemplar.picture.shape[2]), np.float32)
    picture[inside] = look.at(points)
    whole = map_coordinates(exemplar.usable.astype(np.float32), places, order=1, mode="nearest") > 0.999
    scale = directions = None
    if exemplar.scale is not None:
        scale = map_coordinates(exemplar.scale, places, order=1, mode="nearest") * np.float32(2.0**log)
    if exemplar.angle is not None:
        nearest = map_coordinates(exemplar.angle, places, order=0, mode="nearest")
        directions = ((180 - nearest if mirrored else nearest) + np.float32(angle)).astype(np.float32)
    return Atlas(picture, scale, inside & whole, origin, directions)


def _stacked(copies: list[Atlas], unit: int) -> Atlas:
    """Copies below each other on one sheet."""
    if len(copies) == 1:
        return copies[0]
    tops, height = [], 0
    for copy in copies:
        tops.append(height)
        height += (-(-copy.usable.shape[0] // unit) + 2) * unit
    height = tops[-1] + copies[-1].usable.shape[0]
    shape = height, max(copy.usable.shape[1] for copy in copies)
    first = copies[0]
    picture = np.zeros((*shape, first.picture.shape[2]), np.float32)
    scale = None if first.scale is None else np.ones(shape, np.float32)
    angle = None if first.angle is None else np.zeros(shape, np.float32)
    usable, origin = np.zeros(shape, bool), np.zeros((*shape, 6), np.float32)
    for top, copy in zip(tops, copies, strict=True):
        box = slice(top, top + copy.usable.shape[0]), slice(0, copy.usable.shape[1])
        picture[box], usable[box], origin[box] = copy.picture, copy.usable, copy.origin
        if scale is not None and copy.scale is not None:
            scale[box] = copy.scale
        if angle is not None and copy.angle is not None:
            angle[box] = copy.angle
    return Atlas(picture, scale, usable, origin, angle)


def traced(sheet: Atlas, places: NDArray[np.integer], work: Work) -> tuple[Array, Array]:
    """Source map (h, w, 6) of rows and columns of a sheet (h, w, 2), and each point (n, 6) that it shows, once.

    Where they are negative, for known pixels, the source is any and shows nothing.
    """
    origins = sheet.origin.reshape(-1, 6)
    shown = np.zeros(len(origins), bool)
    source = np.empty((*places.shape[:2], 6), np.float32)

    def band(first: int, stop: int) -> None:
        part = places[first:stop]
        numbers = part[..., 0] * np.intp(sheet.origin.shape[1]) + part[..., 1]
        shown[numbers if part[..., 0].min() >= 0 else numbers[part[..., 0] >= 0]] = True
        origins.take(numbers, axis=0, mode="wrap", out=source[first:stop])

    for_rows(band, len(places), 10.0 * places.shape[1], work)
    return source, origins.compress(shown, axis=0)
