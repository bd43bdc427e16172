"""Texel scale in a hole, from what surrounds it."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Context
from graphtex_nodes.numerics.continuation import continued, fitted_plane
from graphtex_nodes.numerics.homogeneity import SHORTEST, picture_recession
from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.plane_moves import Slope
from graphtex_nodes.numerics.window_mean import window_mean
from graphtex_nodes.perspective.feature_mask import feature_mask

Array = NDArray[Any]

EDGE = 4  # pixels around the hole where it makes false features
SEEN = 0.25  # share of a window that must be known for its density to count
DOUBTFUL = 0.3  # share of the variance of log scale that a plane must explain
FITTED = 64  # rows or columns of a map that suffice to fit a plane
STEEP = 0.05  # change of scale over the picture below which it counts as flat


def continued_scale(scale: Array, hole: Array, harmonic: bool, work: Work) -> Array:
    """A scale map (h, w) with values in the hole too: on a plane fitted to the others, or harmonic."""
    return _bounded(continued(scale, ~hole, harmonic, work))


def measured_scale(photo: Array, hole: Array, harmonic: bool, work: Work) -> Array:
    """Scale map (h, w) of a photo from what is seen outside the hole; 1 where nothing can be told.

    The plane on which the texture is the same everywhere (as in `EstimateAngles`); or, ``harmonic`` or where too little
    is seen for that, the density of features, smooth or on a plane.
    """
    found = None
    if not harmonic and min(hole.shape) >= SHORTEST:
        found = picture_recession(photo, ~hole, work, DOUBTFUL)
    if found is not None:
        if found.confidence < DOUBTFUL:
            return np.ones(hole.shape, np.float32)
        height, width = hole.shape
        rows, columns = np.ogrid[:height, :width]
        return _bounded(1 - found.down * (rows - (height - 1) / 2) - found.right * (columns - (width - 1) / 2))
    measured, seen = _densities(photo, hole)
    if not seen.any():
        return np.ones(hole.shape, np.float32)
    return _bounded(continued(measured, seen, True, work) if harmonic else fitted_plane(measured, seen))


def _bounded(scale: Array) -> Array:
    """A scale map within its range."""
    return np.clip(scale, 1 / 8, 8).astype(np.float32)


def slope_of(scale: Array, hole: Array) -> Slope:
    """How a scale map (h, w) changes around the middle of a hole, as that of a plane."""
    row, column = (float(x) for x in np.argwhere(hole).mean(axis=0))
    step = max(1, max(scale.shape) // FITTED)
    part = scale[::step, ::step]
    plane = fitted_plane(part, np.ones(part.shape, bool))
    down = float(plane[-1, 0] - plane[0, 0]) / max(1, part.shape[0] - 1) / step
    right = float(plane[0, -1] - plane[0, 0]) / max(1, part.shape[1] - 1) / step
    here = float(plane[0, 0]) + down * row + right * column
    if abs(down) * scale.shape[0] + abs(right) * scale.shape[1] < STEEP * abs(here) or here <= 0:
        return Slope(row, column)
    return Slope(row, column, down / here, right / here)


def hidden(photo: Array, hole: Array) -> Array:
    """A photo (h, w, c) with the mean colour of the rest in place of its hole."""
    # in double precision: the last bits of a single one would pass for texture
    return np.where(hole[..., None], photo[~hole].mean(axis=0, dtype=np.float64), photo).astype(np.float32)


def _densities(photo: Array, hole: Array) -> tuple[Array, Array]:
    """Scale by the density of features outside the hole (equation 1, bounded), and where enough is seen to tell."""
    from scipy.ndimage import binary_dilation

    filled = hidden(photo, hole)
    told: list[str] = []
    features = feature_mask(filled, ctx=Context(threads=1, on_warning=told.append))
    clear = ~binary_dilation(hole, iterations=EDGE)
    window = max(3, min(hole.shape) // 4)
    share = window_mean(clear.astype(np.float64), window)
    seen = ~hole & (share >= SEEN)
    if not (features & clear).any() or not seen.any():
        return np.ones(hole.shape), np.zeros(hole.shape, bool)
    density = window_mean((features & clear).astype(np.float64), window) / np.maximum(share, SEEN)
    middle = (density[seen].min() + density[seen].max()) / 2
    return 2 - density / middle, seen
