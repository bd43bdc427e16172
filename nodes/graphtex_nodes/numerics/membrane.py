"""Colours of copied pieces bent towards known pixels beside them (Pérez et al. 2003, screened)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work

Array = NDArray[np.float32]

SCREEN = 1e-3
"""Pull towards the copied colours: a correction fades to 1/e over about 1 / sqrt(SCREEN) = 32 pixels."""
TOLERANCE = 1e-4
"""Residual at which the solver stops, relative to that of no correction."""
MOST = 600


def join_known(
    image: Array, source: NDArray[np.int32], exemplar: Array, usable: NDArray[np.bool_], wrap: tuple[bool, bool],
    work: Work,
) -> Array:  # fmt: skip
    r"""An image (h, w, c) whose copied pixels meet its known ones without a step; known ones are bit-identical.

    With :math:`m_{pq}` what a known pixel q has more than the continuation of the piece at its neighbour p, the
    correction d of the unknown pixels minimises

    .. math:: \sum_{pq\ unknown} (d_p - d_q)^2 + \sum_{q\ known} (d_p - m_{pq})^2 + \epsilon \sum_p d_p^2,

    which is Poisson blending with the pieces' gradients and the known pixels as its border, held near the copied
    colours by epsilon.

    Parameters
    ----------
    source
        Row and column (h, w, 2) in the exemplar (eh, ew, c); negative for known pixels.
    usable
        Exemplar pixels (eh, ew) that can continue a piece.
    wrap
        Whether the image wraps around along its rows and columns.
    """
    unknown = source[..., 0] >= 0
    if unknown.all() or not unknown.any():
        return image
    number = np.full(unknown.shape, -1, np.int64)
    number[unknown] = np.arange(np.count_nonzero(unknown))
    count, channels = int(number.max()) + 1, image.shape[2]
    degree = np.full(count, SCREEN)
    right_side = np.zeros((count, channels))
    edges = []
    for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        here, there = _pairs(unknown.shape, down, right, wrap)
        here, there = here[unknown.ravel()[here]], there[unknown.ravel()[here]]
        degree += np.bincount(number.ravel()[here], minlength=count)
        inner = unknown.ravel()[there]
        edges.append((number.ravel()[here[inner]], number.ravel()[there[inner]]))
        here, there = here[~inner], there[~inner]
        place = source.reshape(-1, 2)[here] + np.array([down, right])
        fits = ((place >= 0) & (place < usable.shape)).all(axis=1)
        fits[fits] = usable[place[fits, 0], place[fits, 1]]
        # a piece that cannot be continued is taken to go on with the same colour
        ahead = image.reshape(-1, channels)[here].astype(np.float64)
        ahead[fits] = exemplar[place[fits, 0], place[fits, 1]]
        np.add.at(right_side, number.ravel()[here], image.reshape(-1, channels)[there] - ahead)
    result = image.copy()
    result[unknown] += relaxed(degree, edges, right_side, work).astype(np.float32)
    seen = exemplar[usable]
    result[unknown] = np.clip(result[unknown], seen.min(axis=0), seen.max(axis=0))
    return result


def laplace(values: NDArray[np.float64], known: NDArray[np.bool_], work: Work) -> NDArray[np.float64]:
    """Harmonic values (n,) of the pixels that are not known: each is the mean of its neighbours (h, w).

    Over the array's border nothing flows. At least one pixel must be known.
    """
    number = np.cumsum(~known.ravel()) - 1
    count = int(np.count_nonzero(~known))
    degree, right_side = np.zeros(count), np.zeros((count, 1))
    edges = []
    for down, right in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        here, there = _pairs(known.shape, down, right, (False, False))
        unknown = ~known.ravel()[here]
        here, there = here[unknown], there[unknown]
        degree += np.bincount(number[here], minlength=count)
        border = known.ravel()[there]
        right_side[:, 0] += np.bincount(number[here[border]], values.ravel()[there[border]], count)
        edges.append((number[here[~border]], number[there[~border]]))
    result: NDArray[np.float64] = relaxed(degree, edges, right_side, work)[:, 0]
    return result


def _pairs(
    shape: tuple[int, ...], down: int, right: int, wrap: tuple[bool, bool]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Flat indices of all pixels that have a neighbour in a direction, and of that neighbour."""
    index = np.arange(shape[0] * shape[1]).reshape(shape)
    there = np.roll(index, (-down, -right), (0, 1))
    inside = np.ones(shape, bool)
    if down and not wrap[0]:
        inside[-1 if down > 0 else 0] = False
    if right and not wrap[1]:
        inside[:, -1 if right > 0 else 0] = False
    return index[inside], there[inside]


def relaxed(degree: Any, edges: list[Any], right_side: Any, work: Work) -> Any:
    """Values (n, c) with degree * value - sum of neighbours' values = right side (n, c): a screened Poisson equation.

    ``edges`` are pairs of arrays, nodes and their neighbours, each pair in both directions. Conjugate gradients with
    the diagonal as preconditioner, all channels at a time, each with its own steps.
    """
    from scipy.sparse import csr_array, diags_array

    size = degree.size
    rows = np.concatenate([edge[0] for edge in edges])
    columns = np.concatenate([edge[1] for edge in edges])
    matrix = (diags_array(degree) - csr_array((np.ones(rows.size), (rows, columns)), shape=(size, size))).tocsr()
    solution = np.zeros_like(right_side)
    residual = right_side.copy()
    scaled = residual / degree[:, None]
    direction = scaled.copy()
    old = _products(residual, scaled)
    goal = TOLERANCE**2 * old
    for step in range(MOST):
        if step % 20 == 0:
            work.check()
        if (old <= goal).all():
            break
        image = matrix @ direction
        curvature = _products(direction, image)
        length = old / np.where(curvature > 0, curvature, 1)
        solution += length * direction
        residual -= length * image
        scaled = residual / degree[:, None]
        new = _products(residual, scaled)
        direction = scaled + new / np.where(old > 0, old, 1) * direction
        old = new
    return solution


def _products(one: Any, other: Any) -> Any:
    """Scalar product of each channel (c,) of values (n, c); sums over a first axis are several times as slow."""
    return np.einsum("ij,ij->j", one, other)
