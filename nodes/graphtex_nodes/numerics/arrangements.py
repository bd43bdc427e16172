"""Points in the plane: regular lattices, and random ones that keep a distance."""

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Lattice = Literal["square", "hexagonal", "brick"]

ROUNDS = 40  # of random darts; what is still free then is smaller than a disc


def lattice_points(kind: Lattice, low: Array, high: Array, cell: tuple[float, float]) -> Array:
    """Points (n, 2) of a lattice in the box from `low` to `high`, row by row, one of them at `low`.

    `cell` is the distance of neighbours in a row and, but for ``hexagonal``, of rows; hexagonal rows are
    sqrt(3) / 2 times that apart. Every second row of ``hexagonal`` and ``brick`` is moved by half a cell.

    >>> lattice_points("brick", np.zeros(2), np.array([4.0, 1.0]), (4.0, 1.0)).tolist()
    [[0.0, 0.0], [4.0, 0.0], [2.0, 1.0]]
    """
    across, down = cell[0], cell[1] * (np.sqrt(3) / 2 if kind == "hexagonal" else 1)
    columns, rows = (int((high[k] - low[k]) / step) + 2 for k, step in ((0, across), (1, down)))
    row, column = np.mgrid[:rows, :columns]
    shift = 0.0 if kind == "square" else 0.5
    points = np.stack([low[0] + (column + shift * (row % 2)) * across, low[1] + row * down], axis=-1).reshape(-1, 2)
    kept: Array = points[(points <= high + 1e-9).all(axis=1)]
    return kept


def apart_points(low: Array, high: Array, distance: float, rng: np.random.Generator) -> Array:
    """Random points (n, 2) in the box from `low` to `high`, none nearer than `distance` to another, nearly full.

    Darts are thrown in rounds; one stays if no point that stayed before and no earlier dart of its round is too near.
    """
    from scipy.spatial import cKDTree

    points = np.empty((0, 2))
    darts = max(16, int(np.prod(high - low) / distance**2))
    for _ in range(ROUNDS):
        fresh = rng.uniform(low, high, (darts, 2))
        if len(points):
            fresh = fresh[cKDTree(points).query(fresh)[0] >= distance]
        if not len(fresh):
            break
        close = cKDTree(fresh).query_pairs(distance, output_type="ndarray")
        stays = np.ones(len(fresh), bool)
        if len(close):
            stays[close.max(axis=1)] = False
        points = np.concatenate([points, fresh[stays]])
    return points
