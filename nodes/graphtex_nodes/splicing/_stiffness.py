"""The quadratic energy of a context-dependent deformation as a matrix (Liu et al. 2009, section 4.2, equation 5)."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.splicing.tags import RigidPart

Array = NDArray[Any]
Constraint = Literal["centres", "elements"]

CONSTRAINT, RIGIDITY = 1e4, 1e2  # lambda_G and lambda_R
MEMBRANE = 1e-6 * RIGIDITY
"""As little as determines what is open: a hundred times more strains elements by half a percent."""
SOFT = 2e-5
"""Share of the rigidity that elements have between rigid joints: with none, only the pixels around a centre follow it;
a hundred times more slants bed joints."""


@dataclass(frozen=True)
class Rules:
    """A row of table 1: which side of the mask is rigid, lambda_P and epsilon."""

    foreground: bool
    crossing: float
    leak: float


RULES: dict[RigidPart, Rules] = {
    "F=c": Rules(True, 1.0, 1e-3),
    "F=d": Rules(True, 1.0, 1e-3),
    "B=c": Rules(False, 0.0, 1.0),
}


def centre_rows(points: Array, shape: tuple[int, ...]) -> Any:
    """Sparse (n, pixels): the value at each point, between pixels bilinear."""
    from scipy.sparse import csr_array

    height, width = shape
    x, y = np.clip(points[:, 0], 0, width - 1), np.clip(points[:, 1], 0, height - 1)
    left = np.minimum(x.astype(np.int64), max(width - 2, 0))
    top = np.minimum(y.astype(np.int64), max(height - 2, 0))
    right, bottom = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    across, down = x - left, y - top
    weights = [(1 - across) * (1 - down), across * (1 - down), (1 - across) * down, across * down]
    columns = [top * width + left, top * width + right, bottom * width + left, bottom * width + right]
    rows = np.tile(np.arange(len(points)), 4)
    return csr_array(
        (np.concatenate(weights), (rows, np.concatenate(columns))), shape=(len(points), height * width)
    )  # fmt: skip


def pixel_rows(labels: Array) -> Any:
    """Sparse (m, pixels): the value at each pixel that belongs to a texton, in order."""
    from scipy.sparse import csr_array

    pixels = np.flatnonzero(labels.ravel() >= 0)
    return csr_array((np.ones(len(pixels)), (np.arange(len(pixels)), pixels)), shape=(len(pixels), labels.size))


def matrix(rigid: Array, rules: Rules, rows: Any, free: Array | None, labels: Array | None, transposed: bool) -> Any:
    r"""Matrix of the energy of one component of the displacement.

    .. math:: \lambda_G C^T C + \lambda_R R^T R + \mu L

    with C the constraint's rows, R the difference of each pixel from the weighted mean of its neighbours, and L the
    Laplacian of the pixel grid, a membrane that ties down what the other two leave open.

    Parameters
    ----------
    rigid
        M_A (h, w).
    rows
        Sparse (n, pixels), in units of the displacement.
    free
        Pixels (h, w) that R leaves out, None = none.
    labels
        Rigid bodies (h, w): neighbours in different ones, neither of them -1, hold each other no more than the ground
        does. None = all one.
    transposed
        False for the x component, True for the y component.
    """
    from scipy.sparse import csr_array, diags_array

    height, width = rigid.shape
    index = np.arange(height * width, dtype=np.int32).reshape(height, width)
    if transposed:
        rigid, index = rigid.T, index.T
        labels = None if labels is None else labels.T
    tied = _along_border(rigid)
    parts = []
    for down, right in ((0, 1), (0, -1), (1, 0), (-1, 0)):
        here, there = _pair(rigid.shape, down, right)
        holds = rigid[there]
        if labels is not None:
            holds = holds & ~((labels[here] != labels[there]) & (labels[here] >= 0) & (labels[there] >= 0))
        weight = holds + rules.leak
        if down:
            coupled = tied | ~(rigid[here] | rigid[there])
            weight = np.where(coupled, weight, rules.crossing * weight)
        parts.append((index[here].ravel(), index[there].ravel(), weight.ravel()))
    first, second, weights = (np.concatenate(part) for part in zip(*parts, strict=True))
    count = rigid.size
    total = np.bincount(first, weights, minlength=count)
    used = total[first] > 0
    first, second, weights = first[used], second[used], weights[used] / total[first[used]]
    counted = np.zeros(count)
    counted[index.ravel()] = _counted(rigid, rules, free.T if free is not None and transposed else free).ravel()
    mean = csr_array((weights, (first, second)), shape=(count, count))
    residual = (diags_array((total > 0).astype(np.float64)) - mean).tocsr()
    return (
        CONSTRAINT * (rows.T @ rows)
        + RIGIDITY * (residual.T @ diags_array(counted) @ residual)
        + MEMBRANE * _laplacian((height, width))
    ).tocsc()


def _counted(rigid: Array, rules: Rules, free: Array | None) -> Array:
    """How much the difference of each pixel from its neighbours counts."""
    counted = np.ones(rigid.shape) if rules.foreground else np.where(rigid, 1.0, SOFT)
    return counted if free is None else np.where(free, 0.0, counted)


def _along_border(rigid: Array) -> Array:
    """Pairs (h - 1, w) of a pixel and the one below, both rigid, along a border of the rigid part (fig. 5).

    The figure is not legible; what it must say follows from its four cases: both pixels to the left of the pair, or
    both to the right, are not rigid, with the neighbour below or above.
    """
    both = rigid[:-1] & rigid[1:]
    neither = ~rigid[:-1] & ~rigid[1:]
    beside = np.zeros_like(both)
    beside[:, 1:] |= neither[:, :-1]
    beside[:, :-1] |= neither[:, 1:]
    return both & beside


def _pair(shape: tuple[int, ...], down: int, right: int) -> tuple[Any, Any]:
    """Slices of all pixels that have a neighbour in a direction, and of those neighbours."""
    here, there = [], []
    for move, side in zip((down, right), shape, strict=True):
        here.append(slice(max(0, -move), side - max(0, move)))
        there.append(slice(max(0, move), side - max(0, -move)))
    return tuple(here), tuple(there)


def _laplacian(shape: tuple[int, int]) -> Any:
    """Five-point Laplacian, nothing flows over the border."""
    from scipy.sparse import diags_array, eye_array, kron

    lines: list[Any] = []
    for side in shape:
        if side == 1:
            lines.append(diags_array(np.zeros(1)))
            continue
        diagonal = np.full(side, 2.0)
        diagonal[[0, -1]] = 1
        beside = eye_array(side, k=1) + eye_array(side, k=-1)
        lines.append(diags_array(diagonal) - beside)
    return kron(lines[0], eye_array(shape[1])) + kron(eye_array(shape[0]), lines[1])
