"""Colours of copied pieces bent to meet each other and known pixels (Pérez et al. 2003, screened)."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work, for_rows

Array = NDArray[np.float32]

SCREEN = 1e-3
"""Pull towards the copied colours: a correction fades to 1/e over about 1 / sqrt(SCREEN) = 32 pixels."""
TOLERANCE = 1e-4
"""Residual at which the solver stops, relative to that of no correction."""
MOST = 600
TORN = 0.5
"""Length of a missing step, in deviations of the exemplar, that counts 1/e: where it is longer, an outline is torn, and
colours would run over it."""


def missing(
    image: Array, steps: Array, variance: float, bends: NDArray[np.uint8], wrap: tuple[bool, bool], work: Work
) -> Array:
    r"""What pixels of faded pieces lack (c, h, w), summed over the steps to their neighbours.

    A step :math:`m_{pq}` short of the pieces' own counts :math:`\exp(-|m_{pq}|^2 / t^2)`, t from :data:`TORN`.

    Parameters
    ----------
    image
        Shape (h, w, c).
    steps
        Differences (2, h, w, c) to the pixels below and to the right as the pieces have them.
    variance
        Sum of the variances of the exemplar's channels.
    bends
        Which channels (c,) are to be bent, see :func:`materials.bending`; of others nothing is told.
    """
    from graphtex_nodes.numerics import membrane_kernels

    height, width, channels = image.shape
    result = np.empty((channels, height, width), np.float32)
    lines, step_lines = image.reshape(height, -1), steps.reshape(2, height, -1)
    longest = np.float32(max(TORN**2 * variance, float(np.finfo(np.float32).tiny)))

    def band(first: int, stop: int) -> None:
        around = map(np.uint8, wrap)
        membrane_kernels.missing_steps(lines, step_lines, longest, bends, *around, result, first, stop)

    for_rows(band, height, width * 8 * channels, work)
    return result


def level(
    image: Array, lack: Array, limits: tuple[Array, Array], reach: float, wrap: tuple[bool, bool], work: Work
) -> None:
    r"""Take from an image (h, w, c) of faded pieces the steps of brightness and colour between them.

    With :math:`m_{pq}` what steps between neighbours lack, the correction d minimises

    .. math:: \sum_{pq} (d_q - d_p - m_{pq})^2 + \epsilon \sum_p d_p^2,

    Poisson blending, held near the copied colours by epsilon = 1 / ``reach``^2, and solved by cosine transforms
    (Fourier transforms along sides where the image wraps around).

    Parameters
    ----------
    lack
        As :func:`missing` tells; it is overwritten.
    limits
        Least and largest values (c,) that the image may have.
    reach
        Pixels over which a correction fades to 1/e.
    """
    from graphtex_nodes.numerics import membrane_kernels

    if not lack.any():
        return
    height, width, channels = image.shape
    lines = image.reshape(height, -1)

    def solved(first: int, stop: int) -> None:
        for channel in range(first, stop):
            lack[channel] = screened(lack[channel], 1 / reach**2, wrap)

    def corrected(first: int, stop: int) -> None:
        membrane_kernels.correct(lines, lack, *limits, first, stop)

    for_rows(solved, channels, height * width * 40, work)
    for_rows(corrected, height, width * 2 * channels, work)


def screened(right_side: Array, screen: float, wrap: tuple[bool, bool]) -> Array:
    """Values (h, w) with ``screen`` * value + sum of differences to the four neighbours = ``right_side``.

    Over the array's borders nothing flows, or it goes on at the other side along axes that wrap around.
    """
    from scipy import fft

    waves = [axis for axis in (0, 1) if wrap[axis]]
    cosines = [axis for axis in (0, 1) if not wrap[axis]]
    stiffness = np.float32(screen)
    for axis in (0, 1):
        angle = (2 if wrap[axis] else 1) * np.pi * np.arange(right_side.shape[axis]) / right_side.shape[axis]
        along = (2 - 2 * np.cos(angle)).astype(np.float32)
        if waves and axis == waves[-1]:
            along = along[: along.size // 2 + 1]
        stiffness = stiffness + (along[:, None] if axis == 0 else along)
    values = fft.dctn(right_side, axes=cosines, norm="ortho") if cosines else right_side
    if waves:
        spectrum = fft.rfftn(values, axes=waves) / stiffness
        values = fft.irfftn(spectrum, s=[right_side.shape[axis] for axis in waves], axes=waves)
    else:
        values /= stiffness
    result: Array = fft.idctn(values, axes=cosines, norm="ortho") if cosines else values
    return result


def join_known(
    image: Array, lack: Array, source: NDArray[np.int32], exemplar: Array, usable: NDArray[np.bool_],
    bends: NDArray[np.uint8], wrap: tuple[bool, bool], work: Work,
) -> Array:  # fmt: skip
    r"""An image (h, w, c) whose copied pixels meet its known ones without a step; known ones are bit-identical.

    With :math:`m_{pq}` what a known pixel q has more than the continuation of the piece at its neighbour p, and what
    steps between unknown ones lack, the correction d of the unknown pixels minimises

    .. math:: \sum_{pq\ unknown} (d_q - d_p - m_{pq})^2 + \sum_{q\ known} (d_p - m_{pq})^2 + \epsilon \sum_p d_p^2,

    which is Poisson blending with the pieces' gradients and the known pixels as its border, held near the copied
    colours by epsilon.

    Parameters
    ----------
    lack
        As :func:`missing` tells, of the steps between unknown pixels alone.
    source
        Row and column (h, w, 2) in the exemplar (eh, ew, c); negative for known pixels.
    usable
        Exemplar pixels (eh, ew) that can continue a piece.
    bends
        Which channels (c,) are bent: those where it is 0 stay as they were copied, see :func:`materials.bending`.
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
    right_side = np.moveaxis(lack, 0, -1)[unknown].astype(np.float64)
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
        np.add.at(right_side, number.ravel()[here], (image.reshape(-1, channels)[there] - ahead) * (bends > 0))
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
