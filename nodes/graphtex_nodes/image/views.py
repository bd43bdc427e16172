"""The picture of every socket type, as reports and the studio show it: uint8 (h, w, 3 or 4)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import (
    AngleMap,
    Directions,
    Displacement,
    Elements,
    Image,
    LabelMap,
    Mask,
    Points,
    ScaleMap,
    SourceMap,
    Texture,
    Vector,
    Views,
    ViewStack,
    view,
)
from graphtex_nodes.image.files.labels import hsv_to_rgb, palette

Bytes = NDArray[np.uint8]

_CANVAS = 480  # the longer side of drawings that have no picture below them
_RADIUS = 3
_DOT = (214, 39, 40)
_BLUE = (31, 119, 180)
_EMPTY = np.full((1, 1, 3), 128, np.uint8)  # values without a pixel


@view(Image)
def view_image(value: NDArray[np.float32]) -> Bytes:
    """Clip to [0, 1]; 2 and 4 channels with their alpha; of more the first three as colour, each further one beside."""
    if value.size == 0:
        return _EMPTY
    samples = _bytes(value)
    channels = samples.shape[2]
    if channels <= 2:
        return np.concatenate([samples[..., [0, 0, 0]], samples[..., 1:]], axis=2)
    if channels <= 4:
        return samples
    rest = [np.repeat(samples[..., i, None], 3, axis=2) for i in range(3, channels)]
    return _side_by_side([samples[..., :3], *rest])


@view(Mask)
def view_mask(value: NDArray[np.bool_]) -> Bytes:
    """Show True as white, False as black."""
    return _grey(value.astype(np.uint8) * 255)


@view(ScaleMap)
def view_scale(value: NDArray[np.float32]) -> Bytes:
    """Show grey 128 where the scale is 1, in proportion elsewhere, white from 1.99 on."""
    return _grey(_bytes(value * (128 / 255)))


@view(AngleMap)
def view_angles(value: NDArray[np.float32]) -> Bytes:
    """Show the direction as hue: right is red, left cyan."""
    if value.size == 0:
        return _EMPTY
    full = np.ones(value.shape)
    return _bytes(hsv_to_rgb(value.astype(np.float64) / 360, full, full))


@view(LabelMap)
def view_labels(value: NDArray[np.int32]) -> Bytes:
    """Show a colour for each label, always the same one; labels below 0 are dark grey."""
    return palette(value) if value.size else _EMPTY


@view(Displacement)
def view_displacement(value: NDArray[np.float32]) -> Bytes:
    """Show the direction as hue (right is red), the length as saturation: white is 0, full colour the longest."""
    if value.size == 0:
        return _EMPTY
    x, y = value[..., 0].astype(np.float64), value[..., 1].astype(np.float64)
    length = np.hypot(x, y)
    rgb = hsv_to_rgb(np.arctan2(y, x) / (2 * np.pi), length / max(float(length.max()), 1e-12), np.ones_like(length))
    return _bytes(rgb)


@view(SourceMap)
def view_source(value: NDArray[np.float32]) -> Bytes:
    """Show red for the source's column, green for its row, blue for the exemplar's index (0 is dark).

    Patches copied whole show as smooth ramps, their borders as steps; mirrored pixels are lighter.
    """
    if value.size == 0:
        return _EMPTY
    share = [_share(value[..., 2]), _share(value[..., 1]), _share(value[..., 0])]
    rgb = np.stack(share, axis=2)
    rgb += 0.35 * (value[..., 5:6] != 0) * (1 - rgb)
    return _bytes(rgb)


@view(Points)
def view_points(value: NDArray[np.float64]) -> Bytes:
    """Show the points as dots within the least rectangle that holds them."""
    ground, moved = _drawing(value)
    return _dots(ground, moved)


@view(Elements)
def view_elements(value: Elements) -> Bytes:
    """Show each element as a dot with a line along its angle (clockwise), as long as its scale is large."""
    from PIL import Image as Pictures
    from PIL import ImageDraw

    ground, moved = _drawing(value.points)
    picture = Pictures.fromarray(ground)
    draw = ImageDraw.Draw(picture)
    spread = _CANVAS / (2 * np.sqrt(max(len(moved), 1)) + 1)
    largest = max(float(np.abs(value.scales).max(initial=0)), 1e-12)
    turn = np.radians(value.angles)
    tips = moved + (spread * value.scales / largest)[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    for start, end in zip(moved.tolist(), tips.tolist(), strict=True):
        draw.line([*start, *end], fill=_BLUE, width=2)
    return _dots(np.array(picture), moved)


@view(Texture)
def view_texture(value: Texture) -> Bytes:
    """Show the texture, and beside it its background dimmed with the texton points on top."""
    picture = view_image(value.image)[..., :3]
    if value.image.size == 0 or value.mask.shape != value.image.shape[:2]:
        return _dots(picture, value.points)
    dimmed = np.where(value.mask[..., None], picture, picture // 4 + 160)
    return _side_by_side([picture[:, : value.image.shape[1]], _dots(dimmed[:, : value.image.shape[1]], value.points)])


@view(ViewStack)
def view_stack(value: ViewStack) -> Bytes:
    """Show all views, about as many to a row as rows, in order."""
    return view_views(value.views)


@view(Views)
def view_views(value: NDArray[np.float32]) -> Bytes:
    """Show all pictures, about as many to a row as rows, in order."""
    pictures = [view_image(one)[..., :3] for one in value]
    if not pictures:
        return _EMPTY
    across = int(np.ceil(np.sqrt(len(pictures))))
    blank = np.full_like(pictures[0], 255)
    pictures += [blank] * (-len(pictures) % across)
    rows = [_side_by_side(pictures[i : i + across]) for i in range(0, len(pictures), across)]
    return np.concatenate(_with_gaps(rows, axis=0), axis=0)


@view(Directions)
def view_directions(value: NDArray[np.float64]) -> Bytes:
    """Show the half sphere from above, its rim slant 90, tilt 0 upwards: viewing red, lighting blue."""
    side, reach = 193, 88.0
    row, column = np.mgrid[:side, :side] - side // 2
    picture = np.where(((row**2 + column**2) <= reach**2)[..., None], np.uint8(255), np.uint8(225)).repeat(3, axis=2)
    for column_of_slant, colour in ((2, _BLUE), (0, _DOT)):
        radius = reach * value[:, column_of_slant] / 90
        tilt = np.radians(value[:, column_of_slant + 1])
        for x, y in zip(radius * np.sin(tilt), -radius * np.cos(tilt), strict=True):
            picture[(column - x) ** 2 + (row - y) ** 2 <= _RADIUS**2] = colour
    return picture


@view(Vector)
def view_vector(value: NDArray[np.float64]) -> Bytes:
    """Show the numbers as bars from zero, in order; of more than 480 every so many are left out."""
    shown = value[:: -(-len(value) // _CANVAS) or 1]
    if not len(shown):
        return _EMPTY
    low, high = min(0.0, float(shown.min())), max(0.0, float(shown.max()))
    height, width = 96, max(1, _CANVAS // len(shown))
    ends = np.rint((np.stack([shown, np.zeros_like(shown)]) - low) / ((high - low) or 1.0) * (height - 1))
    level = np.arange(height - 1, -1, -1)[:, None]
    inside = (level >= ends.min(axis=0)) & (level <= ends.max(axis=0))
    return np.where(inside.repeat(width, axis=1)[..., None], np.array(_BLUE, np.uint8), np.uint8(255))


def _bytes(value: NDArray[Any]) -> Bytes:
    levels: NDArray[Any] = np.rint(np.clip(value, 0, 1) * 255.0)
    return levels.astype(np.uint8)


def _grey(samples: Bytes) -> Bytes:
    return np.repeat(samples[..., None], 3, axis=2) if samples.size else _EMPTY


def _share(values: NDArray[np.float32]) -> NDArray[np.float64]:
    low, high = float(values.min()), float(values.max())
    share: NDArray[np.float64] = (values.astype(np.float64) - low) / max(high - low, 1e-12)
    return share


def _with_gaps(parts: list[Bytes], *, axis: int) -> list[Bytes]:
    """Put white lines of 4 pixels between pictures."""
    shape = list(parts[0].shape)
    shape[axis] = 4
    line = np.full(shape, 255, np.uint8)
    return [piece for part in parts for piece in (line, part)][1:]


def _side_by_side(pictures: list[Bytes]) -> Bytes:
    return np.concatenate(_with_gaps(pictures, axis=1), axis=1)


def _drawing(points: NDArray[np.float64]) -> tuple[Bytes, NDArray[np.float64]]:
    """White ground that the points fit on, and the points moved and enlarged to it."""
    margin = 16.0
    low = points.min(axis=0) if len(points) else np.zeros(2)
    extent = (points.max(axis=0) if len(points) else np.zeros(2)) - low
    factor = (_CANVAS - 2 * margin) / max(float(extent.max()), 1e-12) if extent.any() else 1.0
    width, height = np.ceil((extent * factor + 2 * margin).round(6)).astype(int)
    return np.full((height, width, 3), 255, np.uint8), (points - low) * factor + margin


def _dots(ground: Bytes, points: NDArray[Any]) -> Bytes:
    from PIL import Image as Pictures
    from PIL import ImageDraw

    picture = Pictures.fromarray(np.ascontiguousarray(ground))
    draw = ImageDraw.Draw(picture)
    for x, y in points.tolist():
        draw.ellipse([x - _RADIUS, y - _RADIUS, x + _RADIUS, y + _RADIUS], fill=_DOT, outline=(255, 255, 255))
    return np.array(picture)
