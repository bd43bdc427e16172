"""Scale maps continued from where they are known into where they are not."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.membrane import laplace
from graphtex_nodes.numerics.parallel import Work

Array = NDArray[np.float32]

ROUNDS = 20
ROUNDING = 0.01
"""Standard deviation of log scale that tells nothing."""
SPREAD = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""
REJECT = 4.685
"""Tukey's constant: residuals above this many standard deviations have no weight."""


def fitted_plane(values: NDArray[Any], known: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The linear function of row and column nearest to the known values (h, w), everywhere, by a robust fit.

    The texel scale of a plane in perspective is linear in the picture. Squares are re-weighted with Tukey's biweight,
    so that what does not lie on the plane hardly counts. Fewer than three known pixels, or all in a line, fix only what
    they can: the least change is taken.
    """
    row, column = np.mgrid[: values.shape[0], : values.shape[1]]
    size = max(values.shape)
    every = np.stack([np.ones(values.size), row.ravel() / size, column.ravel() / size], axis=1)
    place = every[known.ravel()]
    # with the mean taken out, the least solution of an undetermined fit is the flat one
    middle = place.mean(axis=0)
    seen = values[known].astype(np.float64)
    weights = np.ones(seen.size)
    fit, level = np.zeros(3), float(np.median(seen))
    for _ in range(ROUNDS):
        level = float((weights * seen).sum() / weights.sum())
        middle = (weights[:, None] * place).sum(axis=0) / weights.sum()
        away = place - middle
        normal = np.einsum("ni,nj->ij", weights[:, None] * away, away)
        side = np.einsum("ni,n->i", weights[:, None] * away, seen - level)
        fit = np.linalg.lstsq(normal, side, rcond=1e-10)[0]
        rest = np.abs(seen - level - away @ fit)
        limit = REJECT * SPREAD * float(np.median(rest))
        if limit < 1e-9:
            break
        weights = np.maximum(1 - (rest / limit) ** 2, 0) ** 2
    plane: NDArray[np.float64] = (level + (every - middle) @ fit).reshape(values.shape)
    return plane


def plane_share(values: NDArray[Any], plane: NDArray[np.float64]) -> float:
    """Share of the variance of the logarithm of values (any shape) that lies on the plane of the same places.

    A spread of 1 % that no plane explains is always added: less is rounding.
    """
    found = np.log(np.maximum(plane, 1 / 64))
    left = ((np.log(values) - found) ** 2).mean()
    explained = found.var()
    return float(explained / (explained + left + ROUNDING**2))


def continued(values: Array, known: NDArray[np.bool_], harmonic: bool, work: Work) -> Array:
    """Values (h, w) of which the known ones stay; others lie on the plane fitted to them, or are ``harmonic``.

    Harmonic values (each the mean of its neighbours) meet the known ones at the border.
    """
    plane = fitted_plane(values, known)
    result = np.where(known, values, plane)
    if harmonic:
        result[~known] += laplace(np.where(known, values - plane, 0), known, work)
    return result.astype(np.float32)
