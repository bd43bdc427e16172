"""Appearance vectors: each pixel's neighbourhood in a few numbers (Lefebvre & Hoppe 2006, section 3)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Alone
from graphtex_nodes.numerics.windows import Basis, leading_directions

Array = NDArray[Any]

WINDOW = 5
CHANNELS = 8
SAMPLES = 3000  # neighbourhoods that a basis is made from
ROUNDS = 40  # of orthogonal iteration: channels are then the principal components in order
FALL = 0.5  # Gaussian weight of a neighbourhood's sides against its middle


def gaussian_weights() -> Array:
    """Weights (5, 5) of a neighbourhood's pixels, 1 in the middle."""
    half = WINDOW // 2
    offset = np.arange(-half, half + 1)
    line = FALL ** ((offset / half) ** 2)
    weights: Array = line[:, None] * line[None, :]
    return weights


@dataclass(frozen=True)
class AppearanceSpace:
    """Principal components of a picture's neighbourhoods: rows (25 c, k) with the weights in them, mean (k,)."""

    components: Array
    mean: Array
    kept: float

    def project(self, image: Array, threads: int = 1) -> Array:
        """Appearance vectors (h, w, k), float32, of a picture (h, w, c); beyond its border it is mirrored."""
        half = WINDOW // 2
        padded = np.pad(image, ((half, half), (half, half), (0, 0)), mode="symmetric").astype(np.float32)
        count = self.mean.size
        columns = np.pad(self.components, ((0, 0), (0, count % 2))).astype(np.float32)  # kernels take pairs of them
        basis = Basis(WINDOW, columns, np.pad(self.mean, (0, count % 2)).astype(np.float32))
        return np.ascontiguousarray(basis.project(padded, 1, Alone(threads))[..., :count])


def appearance_space(image: Array, channels: int = CHANNELS) -> AppearanceSpace:
    """Leading principal components of the Gaussian-weighted 5 x 5 neighbourhoods of a picture (h, w, c).

    A fixed, even subsample is summed in a fixed order and no LAPACK is used, so bits do not change with threads.
    """
    half = WINDOW // 2
    padded = np.pad(image, ((half, half), (half, half), (0, 0)), mode="symmetric")
    views = np.lib.stride_tricks.sliding_window_view(padded, (WINDOW, WINDOW), axis=(0, 1))
    total = image.shape[0] * image.shape[1]
    count = min(total, SAMPLES)
    row, column = np.divmod(np.arange(count) * total // count, image.shape[1])
    samples = np.moveaxis(views[row, column], 1, -1).astype(np.float64)
    weights = gaussian_weights()[:, :, None]
    mean = samples.mean(axis=0)
    part = ((samples - mean) * weights).reshape(count, -1)
    covariance = np.einsum("ni,nj->ij", part, part) / count
    directions = leading_directions(covariance, 1.0, channels, ROUNDS)
    trace = float(np.trace(covariance))
    held = float((directions * np.einsum("ij,jk->ik", covariance, directions)).sum())
    components = (directions.reshape(WINDOW, WINDOW, image.shape[2], -1) * weights[..., None]).reshape(
        part.shape[1], -1
    )
    offset = (mean.reshape(-1, 1) * components).sum(axis=0)
    return AppearanceSpace(components, offset, min(held / trace, 1.0) if trace > 0 else 1.0)
