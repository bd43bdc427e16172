"""Forms, colours and reliefs of the elements that `textons` draws."""

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.image.exemplars._paint import linear

Array = NDArray[Any]
Form = Literal["disc", "leaf", "flower", "tile"]


class Look(NamedTuple):
    """sRGB colours from one end of an element's range to the other, of its middle, and of the ground it lies on."""

    dark: tuple[float, float, float]
    bright: tuple[float, float, float]
    middle: tuple[float, float, float]
    ground: tuple[float, float, float]


LOOKS: dict[Form, Look] = {
    "disc": Look((0.76, 0.24, 0.15), (0.90, 0.46, 0.16), (0.97, 0.72, 0.38), (0.22, 0.29, 0.36)),
    "leaf": Look((0.20, 0.42, 0.15), (0.42, 0.58, 0.20), (0.66, 0.74, 0.38), (0.77, 0.69, 0.56)),
    "flower": Look((0.88, 0.84, 0.90), (0.96, 0.90, 0.74), (0.88, 0.62, 0.10), (0.22, 0.34, 0.20)),
    "tile": Look((0.50, 0.25, 0.19), (0.70, 0.40, 0.27), (0.64, 0.33, 0.23), (0.76, 0.73, 0.67)),
}
LEAF_CENTRE = 0.07  # of gravity: 0.35 / 5 half lengths from the middle
CORNER = 0.12  # radius of a tile's corners, half lengths


def height(form: Form, x: Array, y: Array, proportion: float) -> Array:
    """Height over the ground in half lengths at element coordinates x, y (half lengths); -1 outside the outline."""
    if form == "disc":
        square = x * x + y * y
        inside, top = square < 1, 0.62 * np.sqrt(np.maximum(1 - square, 0))
    elif form == "leaf":
        x = x - LEAF_CENTRE
        half = 0.62 * np.maximum(1 - x * x, 0) * (1 - 0.35 * x)
        side = np.abs(y) / np.maximum(half, 1e-6)
        inside, top = side < 1, 0.9 * half * (1 - side * side) * (0.55 + 0.45 * np.minimum(4 * side, 1))
    elif form == "flower":
        radius, angle = np.hypot(x, y), np.arctan2(y, x)
        outline = 0.74 + 0.26 * np.cos(5 * angle)
        share = radius / outline
        inside = share < 1
        petals = np.sqrt(np.maximum(1 - share * share, 0)) * (0.6 + 0.4 * np.cos(5 * angle))
        top = 0.30 * petals + 0.28 * np.sqrt(np.maximum(1 - (radius / 0.34) ** 2, 0))
    else:
        dx, dy = np.abs(x) - (1 - CORNER), np.abs(y) - (proportion - CORNER)
        depth = CORNER - np.hypot(np.maximum(dx, 0), np.maximum(dy, 0)) - np.minimum(np.maximum(dx, dy), 0)
        bevel = np.clip(depth / 0.10, 0, 1)
        inside, top = depth > 0, 0.10 * bevel * (2 - bevel)
    result: Array = np.where(inside, 0.06 + top, -1)
    return result


def colour(form: Form, x: Array, y: Array, tone: Array) -> Array:
    """Linear colours (..., 3) at element coordinates; `tone` in [0, 1] tells elements apart."""
    look = LOOKS[form]
    dark, bright, middle = (linear(shade) for shade in (look.dark, look.bright, look.middle))
    body = dark + (bright - dark) * tone[..., None]
    if form == "disc":
        share = 0.6 * np.clip(1 - np.hypot(x, y), 0, 1)
    elif form == "leaf":
        rib = np.exp(-((y / 0.06) ** 2))
        veins = 0.5 * np.clip(np.cos(14 * (x - 0.9 * np.abs(y))) * 3 - 2, 0, 1)
        share = np.maximum(rib, veins)
    elif form == "flower":
        share = np.clip((0.36 - np.hypot(x, y)) / 0.08, 0, 1)
    else:
        share = 0.3 * np.clip(np.sin(9 * x + 5 * y + 20 * tone), 0, 1)
    result: Array = body + (middle - body) * share[..., None]
    return result
