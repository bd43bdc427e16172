"""Where pixels lie in relation to elements."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Elements

Array = NDArray[Any]

FAR = 1e3  # half sizes: where no element is near
FARTHEST = 3  # pixels that elements may be off
GROUPS = 8  # of alike colours


def distances(shape: tuple[int, ...], elements: Elements, width: float, height: float) -> tuple[Array, Array]:
    """How far each pixel is from the nearest element's middle, in its half sizes: round, and square."""
    round_distance, square_distance = np.full(shape, FAR), np.full(shape, FAR)
    for (x, y), angle, scale in zip(elements.points, elements.angles, elements.scales, strict=True):
        reach = 1.5 * max(width, height) * scale
        top, bottom = (int(np.clip(place, 0, shape[0])) for place in (y - reach, y + reach + 1))
        left, right = (int(np.clip(place, 0, shape[1])) for place in (x - reach, x + reach + 1))
        dx, dy = np.arange(left, right) - x, np.arange(top, bottom)[:, None] - y
        cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        along, across = (dx * cos + dy * sin) / (width * scale / 2), (dy * cos - dx * sin) / (height * scale / 2)
        for distance, own in (
            (round_distance, np.hypot(along, across)),
            (square_distance, np.maximum(np.abs(along), np.abs(across))),
        ):
            window = distance[top:bottom, left:right]
            np.minimum(window, own, out=window)
    return round_distance, square_distance


def places_in(elements: Elements, u: Array, v: Array) -> tuple[Array, Array]:
    """Column and row (n, k) of places u, v (k,) of each element, in pixels of one that is neither turned nor sized."""
    cos = (np.cos(np.radians(elements.angles)) * elements.scales)[:, None]
    sin = (np.sin(np.radians(elements.angles)) * elements.scales)[:, None]
    return elements.points[:, :1] + cos * u - sin * v, elements.points[:, 1:] + sin * u + cos * v


def common_offset(image: Array, elements: Elements, width: float, height: float) -> Array:
    """Shift (x, y) of all elements by which the side of their outline tells most about a picture's (h, w, c) colours.

    The mutual information of alike colours and the inside of the elements' ellipses is largest where these lie on the
    elements. Light from one side moves what looks like an element towards it.
    """
    from graphtex_nodes.splicing._colours import clustered, told_by_hue

    shape = image.shape[:2]
    margin = FARTHEST + 1
    if min(shape) < 4 * margin:
        return np.zeros(2)
    groups = clustered(told_by_hue(image.reshape(-1, image.shape[2]).astype(np.float64)), GROUPS).reshape(shape)
    groups = groups[margin:-margin, margin:-margin]
    inside = distances(shape, elements, width, height)[0] < 1
    told = np.zeros((2 * margin + 1,) * 2)
    for down in range(-margin, margin + 1):
        for across in range(-margin, margin + 1):
            rows = slice(margin - down, shape[0] - margin - down)
            columns = slice(margin - across, shape[1] - margin - across)
            told[down + margin, across + margin] = _information(groups, inside[rows, columns])
    inner = told[1:-1, 1:-1]
    row, column = np.unravel_index(int(inner.argmax()), inner.shape)
    offset = []
    for place, line in ((column, told[row + 1]), (row, told[:, column + 1])):
        before, here, after = line[place : place + 3]
        bend = before - 2 * here + after
        offset.append(place - FARTHEST + (0.5 * (before - after) / bend if bend < 0 else 0.0))
    return np.array(offset)


def _information(groups: Array, inside: Array) -> float:
    """Mutual information, in nats, of the group and the side of each pixel."""
    joint = np.bincount((2 * groups + inside).ravel(), minlength=2 * GROUPS).reshape(GROUPS, 2) / groups.size
    apart = joint.sum(axis=1, keepdims=True) * joint.sum(axis=0)
    some = joint > 0
    return float((joint[some] * np.log(joint[some] / apart[some])).sum())
