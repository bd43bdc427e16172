"""The scale map as one more channel: how it is weighted, where a synthesis starts, what it asks of the exemplar."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.continuation import fitted_plane, plane_share

Array = NDArray[np.float32]

BINS = 24
FITTED = 128
"""Pixels of a map's longer side that suffice to tell noise."""
SPREADS = (0.08, 0.2)
"""Standard deviations of log scale that are noise, and that are more than that."""
SHARES = (0.65, 0.85)
"""Shares of the variance on a plane that noise has, and that it has not."""
LEAST = 0.1
"""What is left of the weight of noise: enough for a larger weight to have its way."""
MOST_COMPARED, COMPARED_AT_ONCE = 1 << 24, 1 << 18
"""Pairs of a wish and what there is of which distances are worked out for a first field, and for a part of it."""


def scale_factor(colours: Array, scale: Array, weight: float) -> float:
    """Factor that makes the standard deviation of ``scale`` ``weight`` times the total one of ``colours`` (..., c).

    0 when the scale is constant: it then says nothing.
    """
    spread = float(np.std(scale, dtype=np.float64))
    total = float(np.sqrt(np.var(colours.reshape(-1, colours.shape[-1]), axis=0, dtype=np.float64).sum()))
    if spread < 1e-6:
        return 0.0
    return weight * (total if total > 0 else 1.0) / spread


def trust(scale: Array, chosen: NDArray[np.bool_], planes: Sequence[tuple[Array, NDArray[np.bool_]]] = ()) -> float:
    """How far a measured map (h, w) is more than noise where ``chosen``: from 0.1 to 1.

    Maps that are measured on a texture of one size spread by 1 to 9 % all the same, and no plane explains more than
    two thirds of that. Guided by them at full weight, what has the same noise is put side by side again and again. So
    what spreads by 20 % counts fully, and what lies on a plane, however little it spreads. A map that is put together
    from several tells no plane: then these, each with what is chosen of it, are the ``planes``.
    """
    values, known = _thinned(scale, chosen)
    if not known.any():
        return 1.0
    trusted = max(LEAST, _ramp(float(np.std(np.log(values[known]))), *SPREADS))
    for part in planes or [(scale, chosen)]:
        values, known = _thinned(*part)
        if known.any():
            share = plane_share(values[known], fitted_plane(values, known)[known])
            trusted = max(trusted, _ramp(share, *SHARES))
    return round(trusted, 2)  # the last bits of a fit may differ with the number of threads, those of a picture may not


def _thinned(scale: Array, chosen: NDArray[np.bool_]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """A map and what is chosen of it, at every so many pixels."""
    step = max(1, max(scale.shape) // FITTED)
    return scale[::step, ::step].astype(np.float64), chosen[::step, ::step]


def _ramp(value: float, low: float, high: float) -> float:
    """0 up to the low value, 1 from the high one, linear between."""
    return min(max((value - low) / (high - low), 0.0), 1.0)


def resampled(scale: Array, size: tuple[int, int]) -> Array:
    """The map (h, w) at another size (height, width), bilinear with repeated borders; itself if that is its own."""
    for axis in (0, 1):
        count = scale.shape[axis]
        if count == size[axis]:
            continue
        place = np.clip((np.arange(size[axis]) + 0.5) * count / size[axis] - 0.5, 0, count - 1)
        low = np.minimum(place.astype(np.intp), max(count - 2, 0))
        part = np.expand_dims((place - low).astype(np.float32), 1 - axis)
        scale = scale.take(low, axis) * (1 - part) + scale.take(np.minimum(low + 1, count - 1), axis) * part
    return np.ascontiguousarray(scale, np.float32)


def missing_share(exemplar_scale: Array, target_scale: Array, tolerance: float = 0.05) -> float:
    """Share of the target whose scale the exemplar does not have, within the relative tolerance."""
    low, high = float(exemplar_scale.min()), float(exemplar_scale.max())
    outside = (target_scale < low * (1 - tolerance)) | (target_scale > high * (1 + tolerance))
    return float(np.mean(outside))


def importance(exemplar_scale: Array, target_scale: Array) -> Array:
    """How much of each exemplar pixel (...) the output wants, mean 1: the ratio of the densities of the two scales.

    Any shapes: only the scales count. With it, "the exemplar's histogram" and "even use" mean those of an exemplar with
    the target's scales.
    """
    low = float(np.log(exemplar_scale.min()))
    high = float(np.log(exemplar_scale.max()))
    if high - low < 1e-6:
        return np.ones_like(exemplar_scale)

    def bins(scale: Array) -> NDArray[np.intp]:
        place = (np.log(scale) - low) / (high - low) * BINS
        result: NDArray[np.intp] = np.clip(place.astype(np.intp), 0, BINS - 1)
        return result

    return _wanted(bins(exemplar_scale), bins(target_scale), "edge")


def direction_channels(angles: Array, arrows: bool) -> Array:
    """Cosine and sine (..., 2) of angles (degrees), of twice the angles unless directions are arrows."""
    radians = np.radians(angles.astype(np.float64)) * (1 if arrows else 2)
    return np.stack([np.cos(radians), np.sin(radians)], axis=-1).astype(np.float32)


def direction_importance(have: Array, want: Array) -> tuple[Array, float]:
    """As :func:`importance` for channels of direction (..., 2), and the share of what is wanted that none is near."""

    def bins(channels: Array) -> NDArray[np.intp]:
        turns = np.arctan2(channels[..., 1], channels[..., 0]) / (2 * np.pi) % 1
        result: NDArray[np.intp] = (turns * BINS).astype(np.intp) % BINS
        return result

    present, asked = bins(have), bins(want)
    near = np.bincount(present.ravel(), minlength=BINS) > 0
    near |= np.roll(near, 1) | np.roll(near, -1)
    return _wanted(present, asked, "wrap"), float(np.mean(~near[asked]))


def _wanted(have: NDArray[np.intp], want: NDArray[np.intp], border: Literal["edge", "wrap"]) -> Array:
    """Ratio of the densities of what is wanted and what is there, at each that is there; both are numbers of bins."""
    kernel = np.array([1, 2, 1]) / 4
    present, asked = (
        np.convolve(np.pad(np.bincount(part.ravel(), minlength=BINS) / part.size, 1, mode=border), kernel, "valid")
        for part in (have, want)
    )
    ratio = np.clip(asked / np.maximum(present, 1e-6), 0.05, 20)
    result = ratio[have]
    relative: Array = (result / result.mean()).astype(np.float32)
    return relative


def random_blocks(
    grid: tuple[int, int], shape: tuple[int, int], block: int, step: int, rng: np.random.Generator,
    wanted: Array | None = None, present: Array | None = None,
) -> NDArray[np.int32]:  # fmt: skip
    """A first field (rows, columns, 2): blocks of windows copied from random places.

    Parameters
    ----------
    grid
        Rows and columns of the field.
    shape
        Rows and columns of the exemplar's windows; sources are below it.
    block
        Side of the blocks in grid places.
    step
        Pixels between grid places.
    wanted, present
        Guide (scale, direction) at each place of the grid (rows, columns, g) and at each of the exemplar's windows.
        With them a block's place is drawn among the tenth of the exemplar's windows that are nearest to its wish.
    """
    down, right = -(-grid[0] // block), -(-grid[1] // block)
    if wanted is None or present is None:
        # Whole decks instead of independent draws: every part of the exemplar gets its chance.
        size = shape[0] * shape[1]
        decks = [rng.permutation(size) for _ in range(-(-down * right // size))]
        chosen = np.concatenate(decks)[: down * right]
    else:
        middle_rows = np.minimum(np.arange(down) * block + block // 2, grid[0] - 1)
        middle_columns = np.minimum(np.arange(right) * block + block // 2, grid[1] - 1)
        wishes = wanted[np.ix_(middle_rows, middle_columns)].reshape(down * right, -1)
        pick = _of_scale if wishes.shape[1] == 1 else _alike
        chosen = pick(wishes, present.reshape(-1, wishes.shape[1]), rng)
    places = np.stack(np.unravel_index(chosen, shape), axis=-1).reshape(down, right, 2)
    field = places.repeat(block, axis=0).repeat(block, axis=1)[: grid[0], : grid[1]]
    inside = np.stack(np.meshgrid(np.arange(grid[0]) % block, np.arange(grid[1]) % block, indexing="ij"), axis=-1)
    result: NDArray[np.int32] = np.clip(field + inside * step, 0, np.array(shape) - 1).astype(np.int32)
    return result


def _of_scale(wanted: Array, present: Array, rng: np.random.Generator) -> NDArray[np.intp]:
    """For each wanted scale (n, 1) the index of a random one of the present (m, 1) scales near it in rank."""
    wanted, present = wanted[:, 0], present[:, 0]
    order = np.argsort(present, kind="stable")
    ordered = present[order]
    margin = ordered.size // 20
    low = np.maximum(np.searchsorted(ordered, wanted, "left") - margin, 0)
    high = np.minimum(np.searchsorted(ordered, wanted, "right") + margin, ordered.size)
    low = np.minimum(low, ordered.size - 1)
    high = np.maximum(high, low + 1)
    chosen: NDArray[np.intp] = order[low + (rng.random(wanted.size) * (high - low)).astype(np.intp)]
    return chosen


def _alike(wanted: Array, present: Array, rng: np.random.Generator) -> NDArray[np.intp]:
    """For each wish (n, g) the index of a random one of the tenth of what is present (m, g) that is nearest to it.

    With many wishes a sample of what is present has to do.
    """
    few = max(1, min(len(present), MOST_COMPARED // len(wanted)))
    sample = np.arange(few, dtype=np.intp) * len(present) // few
    count = max(1, few // 10)
    draws, chosen = rng.random(len(wanted)), np.empty(len(wanted), np.intp)
    at_once = max(1, COMPARED_AT_ONCE // few)
    for first in range(0, len(wanted), at_once):
        part = slice(first, first + at_once)
        apart = ((present[sample] - wanted[part, None]) ** 2).sum(axis=2)
        near = apart <= np.partition(apart, count - 1, axis=1)[:, count - 1 : count]
        rank = (draws[part] * near.sum(axis=1)).astype(np.intp)
        chosen[part] = sample[np.argmax(near.cumsum(axis=1) > rank[:, None], axis=1)]
    return chosen
