"""Where elements that touch end: they hide the ground that would tell it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Elements
from graphtex_nodes.splicing._nearness import places_in
from graphtex_nodes.splicing._pattern import distances
from graphtex_nodes.splicing._unlit import squared_change

Array = NDArray[Any]

TOUCHING = 1.1  # distance of neighbours over their size
FARTHEST = 0.15  # of an element's size that its centre may be off
WRONG = 0.2  # share of its size that may be wrong
STEPS, HALVINGS = 3, 4  # of the search
SAMPLES = 48  # on an outline


def touching(elements: Elements, width: float, height: float) -> bool:
    """Whether most elements lie as near to another one as their size allows."""
    if len(elements.points) < 2:
        return False
    return bool(np.median(distances(elements.points / (width, height)) / elements.scales) < TOUCHING)


def outline_fit(image: Array, elements: Elements, width: float, height: float) -> tuple[Array, float, float]:
    """Shift (x, y) of all elements, and their size, at which a picture's (h, w, c) colours change most on the outlines.

    Between elements that touch there is no colour of a ground to go by. Light from one side makes what is alike of them
    end where their own shade begins; yet nothing changes more than where the shade of one meets the light of the next.
    Outlines are ellipses or rectangles, whichever fits better.
    """
    from graphtex_nodes.splicing._colours import told_by_hue

    logs = told_by_hue(image.reshape(-1, image.shape[2]).astype(np.float64)).reshape(image.shape)
    # by the root many clear places count more than few very clear ones
    change = squared_change(logs) ** 0.25
    turn = np.linspace(0, 2 * np.pi, SAMPLES, endpoint=False)
    ellipse = np.stack([np.cos(turn), np.sin(turn)]) / 2
    rectangle = ellipse / np.abs(ellipse).max(axis=0) / 2
    start = np.array([0.0, 0.0, width, height])
    usual = _usual(change, elements, np.array([width, height]))
    fits = [_climbed(usual, outline, start) for outline in (ellipse, rectangle)]
    found = max(fits, key=lambda fit: fit[0])[1]
    return found[:2], float(found[2]), float(found[3])


def _usual(change: Array, elements: Elements, size: Array) -> Array:
    """Mean of a map (h, w) around all elements, (2 down + 1, 2 across + 1), pixel by pixel."""
    from scipy.ndimage import map_coordinates

    across, down = np.ceil(size * (0.5 + WRONG / 2 + FARTHEST)).astype(int) + 2
    u, v = np.meshgrid(np.arange(-across, across + 1), np.arange(-down, down + 1))
    column, row = places_in(elements, u.ravel(), v.ravel())
    inside = (row >= 0) & (row <= change.shape[0] - 1) & (column >= 0) & (column <= change.shape[1] - 1)
    seen = map_coordinates(change, [row, column], order=1, mode="nearest") * inside
    usual: Array = (seen.sum(axis=0) / np.maximum(inside.sum(axis=0), 1)).reshape(u.shape)
    return usual


def _climbed(usual: Array, outline: Array, start: Array) -> tuple[float, Array]:
    """The most change on outlines (2, k) of side 1, and the shift and size there: a grid, then falling steps."""
    unit = np.array([FARTHEST, FARTHEST, WRONG, WRONG]) * np.tile(start[2:], 2) / STEPS
    grid = np.stack(np.meshgrid(*4 * [np.arange(-STEPS, STEPS + 1)], indexing="ij"), axis=-1).reshape(-1, 4)
    near = np.concatenate([np.eye(4), -np.eye(4), np.zeros((1, 4))])
    best, value = start, 0.0
    for halving in range(HALVINGS):
        places = best + unit * (grid if halving == 0 else near / 2**halving)
        for _ in range(1 if halving == 0 else 4):
            values = _mean_on(usual, outline, places)
            value, best = float(values.max()), places[int(values.argmax())]
            places = best + unit * near / 2**halving
    return value, best


def _mean_on(usual: Array, outline: Array, places: Array) -> Array:
    """Mean of a map about (0, 0) on an outline (2, k), for each of some shifts and sizes (n, 4)."""
    from scipy.ndimage import map_coordinates

    middle = (np.array(usual.shape) - 1) / 2
    column, row = (places[:, axis, None] + outline[axis] * places[:, 2 + axis, None] for axis in (0, 1))
    values: Array = map_coordinates(usual, [row + middle[0], column + middle[1]], order=1, mode="nearest").mean(axis=1)
    return values
