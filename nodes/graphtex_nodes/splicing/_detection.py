"""Elements of a picture that look like given ones."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Context
from graphtex_nodes.numerics.appearance import appearance_space
from graphtex_nodes.splicing._peaks import local_maxima, score_floor, suppress
from graphtex_nodes.splicing._poses import Poses, best_poses, refined, templates
from graphtex_nodes.splicing._templates import Example
from graphtex_nodes.splicing._unlit import unlit

Array = NDArray[Any]

PLAIN_SIDE = 16.0  # pixels that the shorter side of an element is reduced to, when all are alike
FAINT = 0.3  # scores that are no elements whatever the others are
TURNED_SIDE = 12.0  # and when they are turned, where there are many templates
TRIAL_SIDE = 9.0
LARGEST = 1 << 23  # pixels that are searched


@dataclass(frozen=True)
class Detection:
    """Elements, the similarity map (h, w) at the resolution searched, and the pixels between its pixels."""

    poses: Poses
    similarity: Array
    step: float


def reduced(image: Array, step: float) -> Array:
    """Every `step`-th pixel of a smoothed picture, the first at (0, 0)."""
    from scipy.ndimage import gaussian_filter1d, map_coordinates

    if step <= 1:
        return image
    smooth = image
    for axis in (0, 1):
        smooth = gaussian_filter1d(smooth, 0.45 * step, axis=axis, mode="mirror")
    rows, columns = (np.arange(0, side - 0.5, step) for side in image.shape[:2])
    grid = np.meshgrid(rows, columns, indexing="ij")
    return np.stack([map_coordinates(c, grid, order=1, mode="nearest") for c in np.moveaxis(smooth, -1, 0)], axis=-1)


def detect(
    image: Array, examples: list[Example], *, turn: float, growth: float, radius: float, floor: float | None,
    ctx: Context, trial: bool = False,
) -> Detection:  # fmt: skip
    """Find what looks like the examples, turned by up to `turn` degrees and up to `growth` times larger or smaller.

    A `trial` is quick: it searches at a low resolution, and its poses are those of the best templates.
    """
    turned = turn > 0 or growth > 1
    short = min(min(example.width, example.height) for example in examples)
    step = max(1.0, short / (TRIAL_SIDE if trial else TURNED_SIDE if turned else PLAIN_SIDE))
    image = unlit(image) if turned else image
    small = reduced(image, step)
    if small.shape[0] * small.shape[1] > LARGEST:
        raise ValueError(
            f"image: expected at most {LARGEST} pixels for elements of {short:g} pixels, got {image.shape[0]} x "
            f"{image.shape[1]}: search a part of it, or resample it"
        )
    scaled = [
        Example.model_construct(
            x=e.x / step, y=e.y / step, width=max(e.width / step, 3), height=max(e.height / step, 3)
        )
        for e in examples
    ]
    space = appearance_space(small)
    similarity, angles, scales, kinds = best_poses(
        small, space, scaled, templates(turn, growth, 2 if trial else 1), ctx
    )
    reach = max(1, round(min(min(e.width, e.height) for e in scaled) / 6))
    points, scores = local_maxima(similarity, reach)
    column, row = np.rint(points).astype(int).T
    poses = Poses(points * step, angles[row, column], scales[row, column], scores, kinds[row, column])
    poses = poses.take(poses.scores > FAINT)
    if not len(poses.points):
        return Detection(poses, similarity, step)
    poses = _thinned(poses, examples, radius)
    if (turned or step > 1) and not trial:
        poses = Poses.joined([
            refined(image, example, poses.take(poses.kinds == kind), step, turn > 0, growth > 1, ctx)
            for kind, example in enumerate(examples)
        ])  # fmt: skip
        poses = _thinned(poses, examples, radius)
    least = score_floor(poses.scores) if floor is None else floor
    return Detection(poses.take(poses.scores >= least), similarity, step)


def _thinned(poses: Poses, examples: list[Example], radius: float) -> Poses:
    """Poses without those that a stronger one is too near to."""
    sizes = np.array([[example.width, example.height] for example in examples])[poses.kinds]
    return poses.take(suppress(poses.points, sizes * poses.scales[:, None], poses.angles, radius))
