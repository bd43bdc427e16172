"""Windows (square neighbourhoods) of images and their principal components."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import window_kernels
from graphtex_nodes.numerics.parallel import Work, for_rows

Array = NDArray[np.float32]

SAMPLES = 1024
"""Windows from which a basis is made."""
LARGEST_COVARIANCE = 512
"""Rows of a covariance; larger windows are averaged over blocks of pixels, their detail is left to smaller ones."""
DIRECTIONS = 48
"""Principal components that are kept at most."""
ROUNDS = 6
"""Rounds of orthogonal iteration: the kept share of variance is then right to about 0.1 %."""


@dataclass(frozen=True)
class Grid:
    """Places of the windows on a canvas: corners at multiples of the step, the last one ends at the canvas's border."""

    rows: int
    columns: int
    window: int
    step: int

    @property
    def canvas(self) -> tuple[int, int]:
        """Height and width of the canvas that the windows cover."""
        return (self.rows - 1) * self.step + self.window, (self.columns - 1) * self.step + self.window

    @staticmethod
    def covering(height: int, width: int, window: int, step: int) -> "Grid":
        """The smallest grid whose canvas holds (height, width)."""
        rows = -(-max(0, height - window) // step) + 1
        columns = -(-max(0, width - window) // step) + 1
        return Grid(rows, columns, window, step)


@dataclass(frozen=True)
class Basis:
    """Directions (n * n * c, k) in which windows vary, and the coordinates (k,) of the mean window.

    n is ``window`` / ``pool``: windows are seen as means of blocks of ``pool`` x ``pool`` pixels, times ``pool``, so
    that distances are those of windows that are constant on each block.
    """

    window: int
    directions: Array
    mean: Array
    pool: int = 1

    def project(self, image: Array, step: int, work: Work, wanted: NDArray[np.bool_] | None = None) -> Array:
        """Coordinates (rows, columns, k) of the windows of an image (h, w, c) at multiples of ``step``.

        Windows that are not ``wanted`` (rows, columns) may have any; None = all are.
        """
        height, width, channels = image.shape
        shape = ((height - self.window) // step + 1, (width - self.window) // step + 1, self.mean.size)
        out = np.zeros(shape, np.float32)
        flags = (np.ones(shape[:2], bool) if wanted is None else np.ascontiguousarray(wanted)).view(np.uint8)
        pooled = _pooled(image, self.pool)
        if self.pool > 1:
            pooled = np.pad(pooled, ((0, 0), (0, -pooled.shape[1] % self.pool), (0, 0)))
            pooled = np.concatenate([pooled[:, first :: self.pool] for first in range(self.pool)], axis=1)
        flat = pooled.reshape(len(pooled), -1)
        used = int(np.flatnonzero(self.directions.any(axis=0)).max(initial=-1)) + 1
        rows = np.ascontiguousarray(self.directions.T[: used + used % 2])  # the rest is padding

        def band(first: int, stop: int) -> None:
            window_kernels.project(
                flat, channels, self.window // self.pool, self.pool, step, rows, self.mean, flags, out, first, stop
            )  # fmt: skip

        for_rows(band, shape[0], shape[1] * rows.size / 8, work)
        return out


def principal_basis(
    image: Array, window: int, groups: list[tuple[slice, float]], variance: float, work: Work,
    allowed: NDArray[np.bool_] | None = None, weights: Sequence[float] | None = None, directions: int = DIRECTIONS,
) -> Basis:  # fmt: skip
    """Principal components of the windows of an image, for each group of channels apart.

    Parameters
    ----------
    image
        Shape (h, w, c).
    window
        Side of the windows in pixels.
    groups
        Channels that share components (colour and scale apart, Dong et al. 2008, section 4.2), and how far their
        components are evened: see :func:`evened`.
    variance
        Share of each group's variance that is kept, 0 to 1.
    allowed
        Which windows (rows, columns) count; None = all.
    weights
        How much differences in each channel count, from 0; None = all alike.
    directions
        Most components of a group.

    Notes
    -----
    The covariance of a regular subsample is summed in a fixed order and its leading directions are found by
    orthogonal iteration without BLAS or LAPACK, whose results change with the number of threads.
    """
    channels = image.shape[2]
    pool = max(_pool(window, part.stop - part.start) for part, _ in groups)
    side = window // pool
    relative = np.ones(channels, np.float32) if weights is None else np.array(weights, np.float32)
    samples = _sample(_pooled(image, pool), side, pool, allowed)
    mean = samples.mean(axis=0, dtype=np.float64)
    kept: list[NDArray[np.float64]] = []
    for group, share in groups:
        part = np.zeros((-(-len(samples) // 4) * 4, *samples.shape[1:3], len(relative[group])), np.float32)
        np.subtract(samples[..., group], mean[:, :, group].astype(np.float32), out=part[: len(samples)])
        if (relative[group] != 1).any():
            part *= relative[group]
        part = part.reshape(len(part), -1)
        total = np.zeros((part.shape[1], part.shape[1]))

        def band(first: int, stop: int, part: Array = part, total: NDArray[np.float64] = total) -> None:
            window_kernels.add_products(part, total, first, stop)

        for_rows(band, len(total), len(total) * len(part) / 8, work)
        total = np.tril(total) + np.tril(total, -1).T
        covariance = total / len(samples)
        leading = evened(leading_directions(covariance, variance, directions), covariance, share)
        spread = np.zeros((side, side, channels, leading.shape[1]))
        spread[:, :, group] = leading.reshape(side, side, -1, leading.shape[1]) * relative[group, None]
        kept.append(spread.reshape(-1, leading.shape[1]))
    columns = np.concatenate(kept, axis=1)
    padding = -columns.shape[1] % 8  # whole vectors: faster, and zeros change no distance
    columns = np.pad(columns, ((0, 0), (0, padding)))
    offset = (mean.reshape(-1, 1) * columns).sum(axis=0)
    return Basis(window, np.ascontiguousarray(columns, np.float32), offset.astype(np.float32), pool)


def _pool(window: int, channels: int) -> int:
    """Side of the pixel blocks that large windows are averaged over, so that a covariance stays below 512 rows."""
    pool = 1
    while (window // pool) ** 2 * channels > LARGEST_COVARIANCE and window % (2 * pool) == 0:
        pool *= 2
    return pool


def _pooled(image: Array, pool: int) -> Array:
    """Sums over pool x pool pixels from each pixel on, over pool: coordinates in constant blocks of length 1."""
    if pool == 1:
        return np.ascontiguousarray(image)
    for axis in (0, 1):
        lines = np.moveaxis(image, axis, 0)
        count = len(lines) - pool + 1
        image = np.moveaxis(np.sum([lines[start : start + count] for start in range(pool)], axis=0), 0, axis)
    return np.ascontiguousarray(image / np.float32(pool))


def _sample(image: Array, side: int, spacing: int, allowed: NDArray[np.bool_] | None) -> Array:
    """At most ``SAMPLES`` windows (n, side, side, c) of each spacing-th pixel, spread evenly and aperiodically."""
    reach = (side - 1) * spacing + 1
    views = np.lib.stride_tricks.sliding_window_view(image, (reach, reach), axis=(0, 1))[..., ::spacing, ::spacing]
    rows, columns = views.shape[:2]
    total = rows * columns if allowed is None else int(np.count_nonzero(allowed))
    count = min(total, SAMPLES)
    places = (np.arange(count) * total // count).astype(np.int64)
    if allowed is not None:
        places = np.flatnonzero(allowed)[places]
    return np.ascontiguousarray(np.moveaxis(views[places // columns, places % columns], 1, -1), np.float32)


def leading_directions(
    covariance: NDArray[np.float64], variance: float, largest: int = DIRECTIONS, rounds: int = ROUNDS
) -> NDArray[np.float64]:
    """Orthonormal columns that keep the wanted share of a covariance, by orthogonal iteration.

    At least one column, at most ``largest``. Columns come in the order of falling variance but need not be the
    eigenvectors themselves unless there are many rounds: distances within their span are the same.
    """
    size = len(covariance)
    count = min(size, largest)
    trace = float(np.trace(covariance))
    order = np.argsort(-np.diag(covariance), kind="stable")
    rows: NDArray[np.float64] = np.cos(np.outer(np.arange(1, count + 1), np.arange(1, size + 1)) * 2.399963) / size
    rows[np.arange(count), order[:count]] += 1.0
    variances = np.zeros(count)
    window_kernels.iterate(np.ascontiguousarray(covariance), rows, variances, rounds if trace > 0 else 0)
    if trace <= 0:
        return rows[:1].T
    rows, variances = rows[variances > 0], variances[variances > 0]
    share = np.cumsum(variances) / trace
    return np.ascontiguousarray(rows[: int(np.searchsorted(share, variance)) + 1].T)


def evened(columns: NDArray[np.float64], covariance: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Columns with lengths s ** -share for components of standard deviation s, and the same total variance.

    0 leaves distances as they are, 1 makes all components count alike (whitening). In between, thin lines and other
    detail gain on large areas of colour.
    """
    variances = (columns * np.einsum("ij,jk->ik", covariance, columns)).sum(axis=0)
    if share <= 0 or variances.min() <= 0:
        return columns
    gains = variances ** (-share / 2)
    gains *= np.sqrt(variances.sum() / (variances * gains**2).sum())
    result: NDArray[np.float64] = columns * gains
    return result
