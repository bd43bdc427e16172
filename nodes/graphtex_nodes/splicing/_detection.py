"""Elements of a picture that look like given ones."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Context
from graphtex_nodes.splicing._peaks import local_maxima, suppress
from graphtex_nodes.splicing._poses import Poses, Sight, refined, templates
from graphtex_nodes.splicing._templates import Example
from graphtex_nodes.splicing._unlit import unlit

Array = NDArray[Any]

PLAIN_SIDE = 16.0  # pixels that the shorter side of an element is reduced to, when all are alike
FAINT = 0.3  # scores that are no elements whatever the others are
TURNED_SIDE = 12.0  # and when they are turned, where there are many templates
TRIAL_SIDE = 9.0
LARGEST = 1 << 23  # pixels that are searched
HALVING = 0.9  # standard deviation, pixels, that a picture is smoothed by before every second pixel is taken


@dataclass(frozen=True)
class Detection:
    """Elements, the similarity map (h, w) at the resolution searched, and the pixels between its pixels."""

    poses: Poses
    similarity: Array
    step: float


def reduced(image: Array, step: float) -> Array:
    """Every `step`-th pixel of a smoothed picture, the first at (0, 0).

    Large pictures are halved as often as leaves a step of 2: smoothing them as wide as that takes would take long.
    """
    from scipy.ndimage import gaussian_filter1d, map_coordinates

    if step <= 1:
        return image
    smooth, variance = image, 0.0
    while step >= 4:
        smooth, step, variance = halved(smooth), step / 2, (variance + HALVING**2) / 4
    deviation = float(np.sqrt((HALVING * step / 2) ** 2 - variance))
    for axis in (0, 1):
        smooth = gaussian_filter1d(smooth, deviation, axis=axis, mode="mirror")
    rows, columns = (np.arange(0, side - 0.5, step) for side in smooth.shape[:2])
    grid = np.meshgrid(rows, columns, indexing="ij")
    return np.stack([map_coordinates(c, grid, order=1, mode="nearest") for c in np.moveaxis(smooth, -1, 0)], axis=-1)


def halved(image: Array) -> Array:
    """Every second pixel of a smoothed picture, the first at (0, 0)."""
    from scipy.ndimage import gaussian_filter1d

    down = gaussian_filter1d(image, HALVING, axis=0, mode="mirror")[::2]
    return np.ascontiguousarray(gaussian_filter1d(down, HALVING, axis=1, mode="mirror")[:, ::2])


class Search:
    """A picture in which elements are looked for that are turned and sized within given ranges.

    What does not depend on the element is prepared once for each resolution, since choosing among guesses takes many
    searches.
    """

    def __init__(self, image: Array, turn: float, growth: float, radius: float, ctx: Context) -> None:
        self.turn, self.growth, self.radius, self.ctx = turn, growth, radius, ctx
        self.turned = turn > 0 or growth > 1
        self.image = unlit(image) if self.turned else image
        self._halves = [self.image]
        self._sights: dict[float, Sight] = {}

    def detect(self, examples: list[Example]) -> Detection:
        """What looks like the examples, the most alike first, with places between pixels."""
        found = self.coarsely(examples)
        poses, step = found.poses, found.step
        if not len(poses.points) or not (self.turned or step > 1):
            return found
        turn = self.turn > 0
        half, left = self._halved(step)
        share = left / step
        poses = poses.at(share)
        poses = Poses.joined([
            refined(half, resized(example, share), poses.take(poses.kinds == kind), left, turn, self.growth, self.ctx)
            for kind, example in enumerate(examples)
        ]).at(1 / share)  # fmt: skip
        return Detection(thinned(poses, examples, self.radius), found.similarity, step)

    def coarsely(self, examples: list[Example]) -> Detection:
        """What looks like the examples, at the resolution at which all of the picture is compared with them."""
        short = min(min(example.width, example.height) for example in examples)
        return self._found(examples, max(1.0, short / (TURNED_SIDE if self.turned else PLAIN_SIDE)), 1)

    def tried(self, example: Example) -> Poses:
        """Quickly: at a low resolution, and the poses are those of the best templates."""
        step = max(1.0, min(example.width, example.height) / TRIAL_SIDE)
        # resolutions that are factors of sqrt(2) apart serve all examples
        step = 2.0 ** (np.floor(2 * np.log2(step)) / 2)
        return self._found([example], step, 2).poses

    def _found(self, examples: list[Example], step: float, coarseness: int) -> Detection:
        sight = self._sight(step, examples)
        scaled = [resized(example, 1 / step) for example in examples]
        similarity, angles, scales, kinds = sight.best_poses(
            scaled, templates(self.turn, self.growth, coarseness), self.ctx
        )
        reach = max(1, round(min(min(e.width, e.height) for e in scaled) / 6))
        points, scores = local_maxima(similarity, reach)
        column, row = np.rint(points).astype(int).T
        poses = Poses(points * step, angles[row, column], scales[row, column], scores, kinds[row, column])
        return Detection(thinned(poses.take(poses.scores > FAINT), examples, self.radius), similarity, step)

    def _halved(self, step: float) -> tuple[Array, float]:
        """The picture halved until less than 4 is left of a step, and what is left."""
        times = max(0, int(np.floor(np.log2(step))) - 1)
        while len(self._halves) <= times:
            self.ctx.check()
            self._halves.append(halved(self._halves[-1]))
        return self._halves[times], step / 2.0**times

    def _sight(self, step: float, examples: list[Example]) -> Sight:
        if step not in self._sights:
            shape = [len(np.arange(0, side - 0.5, step)) for side in self.image.shape[:2]]
            if shape[0] * shape[1] > LARGEST:
                height, width = self.image.shape[:2]
                short = min(min(example.width, example.height) for example in examples)
                raise ValueError(
                    f"image: expected at most {LARGEST} pixels for elements of {short:g} pixels, got {height} x "
                    f"{width}: search a part of it, or resample it"
                )
            self._sights[step] = Sight(reduced(*self._halved(step)), self.turned, self.ctx.threads)
        return self._sights[step]


def resized(example: Example, scale: float) -> Example:
    """An example in a picture so many times as large."""
    return Example.model_construct(
        x=example.x * scale, y=example.y * scale, width=max(example.width * scale, 3.0),
        height=max(example.height * scale, 3.0),
    )  # fmt: skip


def thinned(poses: Poses, examples: list[Example], radius: float) -> Poses:
    """Poses, the strongest first, without those that a stronger one is too near to."""
    if not len(poses.points):
        return poses
    sizes = np.array([[example.width, example.height] for example in examples])[poses.kinds]
    return poses.take(suppress(poses.points, sizes * poses.scales[:, None], poses.angles, radius))
