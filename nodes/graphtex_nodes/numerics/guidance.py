"""The scale map as one more channel: how it is weighted, where a synthesis starts, what it asks of the exemplar."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]

BINS = 24


def scale_factor(colours: Array, scale: Array, weight: float) -> float:
    """Factor that makes the standard deviation of ``scale`` ``weight`` times the total one of ``colours`` (..., c).

    0 when the scale is constant: it then says nothing.
    """
    spread = float(np.std(scale, dtype=np.float64))
    total = float(np.sqrt(np.var(colours.reshape(-1, colours.shape[-1]), axis=0, dtype=np.float64).sum()))
    if spread < 1e-6:
        return 0.0
    return weight * (total if total > 0 else 1.0) / spread


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

    have = np.bincount(bins(exemplar_scale).ravel(), minlength=BINS) / exemplar_scale.size
    want = np.bincount(bins(target_scale).ravel(), minlength=BINS) / target_scale.size
    kernel = np.array([1, 2, 1]) / 4
    have, want = (np.convolve(np.pad(part, 1, mode="edge"), kernel, "valid") for part in (have, want))
    ratio = np.clip(want / np.maximum(have, 1e-6), 0.05, 20)
    result = ratio[bins(exemplar_scale)]
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
        Scale at each place of the grid and at each of the exemplar's windows. With them a block's place is drawn among
        the exemplar's windows of that scale and the twentieth below and above it.
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
        chosen = _of_scale(wanted[np.ix_(middle_rows, middle_columns)].ravel(), present.ravel(), rng)
    places = np.stack(np.unravel_index(chosen, shape), axis=-1).reshape(down, right, 2)
    field = places.repeat(block, axis=0).repeat(block, axis=1)[: grid[0], : grid[1]]
    inside = np.stack(np.meshgrid(np.arange(grid[0]) % block, np.arange(grid[1]) % block, indexing="ij"), axis=-1)
    result: NDArray[np.int32] = np.clip(field + inside * step, 0, np.array(shape) - 1).astype(np.int32)
    return result


def _of_scale(wanted: Array, present: Array, rng: np.random.Generator) -> NDArray[np.intp]:
    """For each wanted scale (n,) the index of a random one of the present (m,) scales near it in rank."""
    order = np.argsort(present, kind="stable")
    ordered = present[order]
    margin = ordered.size // 20
    low = np.maximum(np.searchsorted(ordered, wanted, "left") - margin, 0)
    high = np.minimum(np.searchsorted(ordered, wanted, "right") + margin, ordered.size)
    low = np.minimum(low, ordered.size - 1)
    high = np.maximum(high, low + 1)
    chosen: NDArray[np.intp] = order[low + (rng.random(wanted.size) * (high - low)).astype(np.intp)]
    return chosen
