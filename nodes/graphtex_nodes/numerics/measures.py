"""Measures of a synthesis: does its texel scale follow the target, and are its patches the exemplar's?

*Coherence* and *coverage*, which belong beside any of these, are in `sources`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.window_mean import block_mean

Array = NDArray[Any]

SHORTEST_LINE = 32  # pixels: shorter lines across a picture's corner hold too few elements


def scale_slope(image: Array, scale: Array, *, bands: int = 8) -> float:
    """Log-log slope of the measured size of elements against the scale that they should have.

    0 where elements are equally large everywhere, whatever the scale map says. A picture that follows its map perfectly
    scores below 1, because pixels far away blend a deeper piece of the plane: at slants of 45 to 60 degrees pebbles
    score 0.53 on average, woven cloth 0.77. So compare with the slope of the exemplar, not with 1. One picture of 256 x
    256 pixels leaves an error of about 0.07 for pebbles. Where lines meet few elements or only parts of them (bricks
    along their courses 0.1 to 0.3, across them 0.55; flowers on grass 0.2 to 0.5) one picture tells little.

    Parameters
    ----------
    image
        (h, w, c), any encoding.
    scale
        (h, w), positive. Its general direction of change is what counts for the direction of the lines.
    bands
        Number of bands of equal width in log scale; bands without elements are left out.

    Raises
    ------
    ValueError
        The scale is constant, or fewer than two bands can be measured.
    """
    scales, sizes = element_sizes(image, scale, bands=bands)
    if len(scales) < 2:
        raise ValueError(f"scale: a slope needs at least two bands that hold elements, got {len(scales)} of {bands}")
    x, y = np.log(scales), np.log(sizes)
    x = x - x.mean()
    return float((x * y).sum() / (x * x).sum())


def element_sizes(image: Array, scale: Array, *, bands: int = 8) -> tuple[Array, Array]:
    """Mean scale and mean size of elements (pixels) in bands of equal width in log scale, sizes along equal scale.

    The picture is read along straight lines at right angles to the mean gradient of the scale, all channels alike. A
    size is the mean distance between crossings of a line's median; each crossing counts for the scale where it is, so
    curved scale maps are followed too.

    Raises
    ------
    ValueError
        The scale is constant, so no direction is one of equal scale.
    """
    scale = np.asarray(scale, np.float64)
    lines, line_scale, inside = _lines_of_equal_scale(np.asarray(image, np.float64), scale)
    edges = np.linspace(np.log(scale.min()), np.log(scale.max()), bands + 1)
    band = np.clip(np.searchsorted(edges, np.log(np.where(inside, line_scale, 1)), side="right") - 1, 0, bands - 1)
    size = _run_lengths(lines, inside, band, bands)
    weight = np.bincount(band[inside], minlength=bands)
    mean = np.bincount(band[inside], np.log(line_scale[inside]), bands) / np.maximum(weight, 1)
    return np.exp(mean[np.isfinite(size)]), size[np.isfinite(size)]


def _lines_of_equal_scale(image: Array, scale: Array) -> tuple[Array, Array, Array]:
    """Picture (lines, samples, channels), scale and which samples lie inside; each line has (about) one scale."""
    from scipy.ndimage import map_coordinates

    height, width = scale.shape
    y, x = np.mgrid[:height, :width]
    x, y = x - (width - 1) / 2, y - (height - 1) / 2
    plane = np.stack([x.ravel(), y.ravel(), np.ones(scale.size)], axis=1)
    right, down, _ = np.linalg.lstsq(plane, scale.ravel(), rcond=None)[0]
    steep = np.hypot(right, down)
    if steep * max(scale.shape) < 1e-6 * scale.max():
        raise ValueError("scale: expected a map that changes across the picture, got a constant one")
    right, down = right / steep, down / steep
    reach = int(np.hypot(height, width) / 2) + 1
    steps = np.arange(-reach, reach + 1)
    column = steps[:, None] * right - steps * down + (width - 1) / 2
    row = steps[:, None] * down + steps * right + (height - 1) / 2
    slack = 1e-6
    inside: Array = (row >= -slack) & (column >= -slack) & (row <= height - 1 + slack) & (column <= width - 1 + slack)
    inside = inside & (inside.sum(axis=1, keepdims=True) >= min(SHORTEST_LINE, *scale.shape))
    lines = [map_coordinates(channel, [row, column], order=1, mode="nearest") for channel in np.moveaxis(image, -1, 0)]
    return np.stack(lines, axis=-1), map_coordinates(scale, [row, column], order=1, mode="nearest"), inside


def _run_lengths(lines: Array, inside: Array, band: Array, bands: int) -> Array:
    """Samples over crossings of each line's median, for each band; infinite where nothing crosses."""
    used = np.asarray(inside.any(axis=1))[:, None, None]
    middle = np.nanmedian(np.where(used, _masked(lines, inside), 0), axis=1, keepdims=True)
    above: Array = lines > middle
    crossing = (above[:, 1:] != above[:, :-1]).sum(axis=2)
    both = inside[:, 1:] & inside[:, :-1]
    counted = np.bincount(band[:, 1:][both], crossing[both], bands)
    length = np.bincount(band[:, 1:][both], minlength=bands) * lines.shape[2]
    return np.where(counted > 0, length / np.maximum(counted, 1), np.inf)


def _masked(lines: Array, inside: Array) -> Array:
    return np.where(inside[..., None], lines, np.nan)


def source_scale_correlation(source: Array, scales: Sequence[Array], target: Array) -> float:
    """Pearson correlation of the target scale with the true scale of what was put there.

    Parameters
    ----------
    source
        Source map (h, w, 6): exemplar's index, row, column, log2 of the resampling (1 = shown at twice its size) ...
    scales
        True scale map of each exemplar.
    target
        (h, w), the scale that was asked for.

    Raises
    ------
    ValueError
        Sizes disagree, or one side is constant.
    """
    if source.shape[:2] != target.shape:
        raise ValueError(f"target: expected the size of the source map {source.shape[:2]}, got {target.shape}")
    which, row, column = (np.rint(source[..., k]).astype(np.intp) for k in range(3))
    found = np.empty(target.shape)
    for number, scale in enumerate(scales):
        here = which == number
        found[here] = scale[row[here].clip(0, scale.shape[0] - 1), column[here].clip(0, scale.shape[1] - 1)]
    found *= 2.0 ** source[..., 3]
    if np.ptp(found) < 1e-9 or np.ptp(target) < 1e-9:
        raise ValueError("target: a correlation needs scales that vary on both sides")
    return float(np.corrcoef(found.ravel(), target.ravel())[0, 1])


def patch_distance(
    image: Array, exemplar: Array, *, patch: int = 7, levels: int = 3, directions: int = 64, seed: int = 0
) -> float:
    """Sliced Wasserstein distance between the patches of two pictures, mean over scales that halve each time.

    Patches of patch x patch x channels values are projected on random directions of length 1, and the quantiles of the
    projections compared by absolute difference: 0 for equal pictures, about 0.01 for two pictures of one material.
    """
    rng = np.random.default_rng(seed)
    pictures = [np.asarray(image, np.float32), np.asarray(exemplar, np.float32)]
    total = 0.0
    for _ in range(levels):
        axes = rng.standard_normal((patch * patch * pictures[0].shape[2], directions))
        axes = (axes / np.linalg.norm(axes, axis=0)).astype(np.float32)
        quantiles = [_projected_quantiles(picture, axes, patch) for picture in pictures]
        total += float(np.abs(quantiles[0] - quantiles[1]).mean())
        pictures = [block_mean(picture, 2) for picture in pictures]
        if min(min(picture.shape[:2]) for picture in pictures) < patch:
            raise ValueError(f"levels: pictures are too small for {levels} levels of {patch}-pixel patches")
    return total / levels


def seam_energy(image: Array, axis: int) -> tuple[float, float]:
    """How the border over which a picture (h, w, c) continues compares with the steps between its own rows or columns.

    A step's energy is the mean squared difference of two neighbouring rows (axis 0) or columns (axis 1). Returned are
    the share of the steps inside whose energy is below that over the border, evenly spread from 0 to 1 where no seam
    shows, and the border's energy over the largest one inside, at most 1 there.
    """
    step = np.roll(np.asarray(image, np.float64), -1, axis) - image
    energy = (step * step).mean(axis=(1 - axis, 2))
    inside, border = energy[:-1], float(energy[-1])
    largest = float(inside.max(initial=0))
    return float(np.mean(inside < border)) if inside.size else 0.0, border / largest if largest > 0 else 0.0


def _projected_quantiles(picture: Array, axes: Array, patch: int) -> Array:
    """Quantiles (257, directions) of the projections of all patches, at steps of two pixels."""
    windows = np.lib.stride_tricks.sliding_window_view(picture, (patch, patch), axis=(0, 1))[::2, ::2]
    flat = windows.reshape(-1, axes.shape[0])
    quantiles: Array = np.quantile(flat @ axes, np.linspace(0, 1, 257), axis=0)
    return quantiles
