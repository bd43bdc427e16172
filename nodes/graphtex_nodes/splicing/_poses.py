"""How elements that look like a given one are turned and sized."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Context, Elements
from graphtex_nodes.numerics.appearance import appearance_space
from graphtex_nodes.numerics.correlation import Correlator
from graphtex_nodes.splicing._nearness import places_in
from graphtex_nodes.splicing._templates import Example, cut_out

Array = NDArray[Any]

ANGLE_STEP = 15.0  # degrees between templates: a matching element is at most half of that off
SCALE_STEP = 1.2
CHANNELS = 4  # of the appearance vectors that turned templates are compared in
GRID = 17  # samples a side that a pose is refined on
HALVINGS = 5
FAINT = 0.3  # contrast, as a share of the example's, below which a likeness counts less
STARTS = (0.0, 180.0, 90.0, -90.0)  # how far off, in degrees, a coarse match of a nearly symmetric element may be
MARGIN = 2  # neighbourhoods of appearance vectors reach so far
REACHES = 16  # pixels: templates whose sizes fall between the same multiples share one correlator


@dataclass(frozen=True)
class Poses:
    """Places (n, 2), angles in degrees clockwise, scales, scores and the example that each looks like, all (n,)."""

    points: Array
    angles: Array
    scales: Array
    scores: Array
    kinds: Array

    def take(self, some: Array) -> "Poses":
        """Those of an index or a mask."""
        return Poses(*(column[some] for column in self.columns()))

    def columns(self) -> tuple[Array, ...]:
        """The fields in order."""
        return self.points, self.angles, self.scales, self.scores, self.kinds

    @staticmethod
    def joined(parts: "list[Poses]") -> "Poses":
        """All of them, those with the highest scores first."""
        together = Poses(*(np.concatenate(columns) for columns in zip(*(p.columns() for p in parts), strict=True)))
        return together.take(np.argsort(-together.scores, kind="stable"))

    def at(self, scale: float) -> "Poses":
        """All of them in a picture so many times as large."""
        return replace(self, points=self.points * scale)

    def turned(self, angle: float) -> "Poses":
        """All of them turned clockwise by an angle in degrees."""
        return Poses(self.points, self.angles + angle, self.scales, self.scores, self.kinds)


def templates(turn: float, growth: float, coarseness: int) -> list[tuple[float, float]]:
    """Angles and scales to look for, the plain one first; `coarseness` times the usual steps apart."""
    turns = int(np.ceil(turn / ANGLE_STEP / coarseness - 1e-9))
    angles = np.linspace(-turn, turn, 2 * turns + 1) if turns else np.zeros(1)
    if turn >= 180:
        angles = angles[1:]  # both ends are the same
    sizes = int(np.ceil(np.log(growth) / np.log(SCALE_STEP) / coarseness - 1e-9))
    scales = growth ** np.linspace(-1, 1, 2 * sizes + 1) if sizes else np.ones(1)
    pairs = [(float(angle), float(scale)) for scale in scales for angle in angles]
    return sorted(pairs, key=lambda pair: (abs(np.log(pair[1])), abs(pair[0]), pair))


class Sight:
    """A picture in appearance vectors, ready for templates cut out of it."""

    def __init__(self, image: Array, turned: bool, threads: int) -> None:
        self.image, self.turned, self.threads = image, turned, threads
        self.space = appearance_space(image)
        self.channels = CHANNELS if turned else self.space.mean.size
        self.appearance = self.space.project(image, threads)[..., : self.channels]
        self._correlators: dict[int, Correlator] = {}

    def best_poses(
        self, examples: list[Example], pairs: list[tuple[float, float]], ctx: Context
    ) -> tuple[Array, Array, Array, Array]:
        """Score, angle, scale and example (h, w) of the best matching template on each pixel."""
        largest = max(max(example.width, example.height) for example in examples) * max(scale for _, scale in pairs)
        correlator = self._correlator(int(largest) + 3)
        best = np.full(self.image.shape[:2], -np.inf)
        angles, scales, kinds = np.zeros(best.shape), np.ones(best.shape), np.zeros(best.shape, np.int64)
        for index, (angle, scale) in enumerate(pairs):
            ctx.progress(index / len(pairs), "looking for elements")
            for number, example in enumerate(examples):
                template, mask = self._template(example, f"examples[{number}]", angle, scale)
                scores = correlator.correlate(template, mask)
                better = scores > best
                best[better], angles[better], scales[better], kinds[better] = scores[better], angle, scale, number
        return best, angles, scales, kinds

    def _template(self, example: Example, name: str, angle: float, scale: float) -> tuple[Array, Array]:
        patch, _ = cut_out(self.image, example, name, angle=angle, scale=scale, margin=MARGIN, round_mask=self.turned)
        _, mask = cut_out(self.image, example, name, angle=angle, scale=scale, round_mask=self.turned)
        return self.space.project(patch)[MARGIN:-MARGIN, MARGIN:-MARGIN, : self.channels], mask

    def _correlator(self, reach: int) -> Correlator:
        reach = -(-reach // REACHES) * REACHES
        if reach not in self._correlators:
            self._correlators[reach] = Correlator(self.appearance, (reach, reach), self.threads)
        return self._correlators[reach]


def refined(
    image: Array, example: Example, poses: Poses, step: float, turn: bool, growth: float, ctx: Context
) -> Poses:  # fmt: skip
    """Poses that match the mean of all elements best, by a search with falling steps around each.

    Angles change with `turn` only, scales within `growth`.

    The first pass compares with the example, the second with the mean of what matched, whose own chance looks and
    surroundings are averaged out.
    """
    from scipy.ndimage import gaussian_filter1d

    if not len(poses.points):
        return poses
    smooth = image
    for axis in (0, 1):
        smooth = gaussian_filter1d(smooth, 0.5 * step, axis=axis, mode="mirror") if step > 1 else smooth
    line = np.linspace(-1, 1, GRID)
    u, v = (grid.ravel() for grid in np.meshgrid(line, line))
    round_grid = u * u + v * v <= 1.1
    reach = max(example.width, example.height) / 2
    if turn or growth > 1:
        u, v = u[round_grid] * reach, v[round_grid] * reach
    else:
        u, v = u * example.width / 2, v * example.height / 2
    given = Poses(np.array([[example.x, example.y]]), np.zeros(1), np.ones(1), np.ones(1), np.zeros(1, np.int64))
    smooth = np.ascontiguousarray(smooth, np.float32)
    wanted = _samples(smooth, given, u, v)[0]
    farthest = np.array([np.inf, np.inf, np.inf if turn else 0.0, np.log(growth)])
    for _ in range(2):
        ctx.check()
        starts = STARTS if turn else (0.0,)
        found = [_climb(smooth, wanted[0], u, v, poses.turned(start), step, farthest, ctx) for start in starts]
        best = np.argmax([each.scores for each in found], axis=0)
        each = np.arange(len(best))
        poses = Poses(*(np.stack(column)[best, each] for column in zip(*(f.columns() for f in found), strict=True)))
        likely = poses.take(poses.scores >= max(0.6, float(np.median(poses.scores))))
        if len(likely.points) < 3:
            break
        seen, weights = _samples(smooth, likely, u, v)
        weight = weights[..., None]
        wanted = ((seen * weight).sum(axis=0) / np.maximum(weight.sum(axis=0), 1e-9))[None]
    return poses


def _climb(
    image: Array, wanted: Array, u: Array, v: Array, poses: Poses, step: float, farthest: Array, ctx: Context
) -> Poses:  # fmt: skip
    """Move each pose to a better neighbour until none is, with steps that are halved."""
    from graphtex_nodes.numerics.parallel import for_rows
    from graphtex_nodes.splicing import pose_kernels

    values = np.stack([*poses.points.T, poses.angles, np.log(poses.scales)], axis=1)
    lengths = np.array([0.6 * step, 0.6 * step, ANGLE_STEP / 3, np.log(SCALE_STEP) / 3])
    scores = np.empty(len(values))

    def band(first: int, stop: int) -> None:
        pose_kernels.climb(image, wanted, u, v, FAINT, lengths, farthest, HALVINGS, values, scores, first, stop)

    for_rows(band, len(values), 4.0 * HALVINGS * np.count_nonzero(farthest) * wanted.size, ctx)
    angles = (values[:, 2] + 180) % 360 - 180
    return replace(poses, points=values[:, :2].copy(), angles=angles, scales=np.exp(values[:, 3]), scores=scores)


def _samples(image: Array, poses: Poses, u: Array, v: Array) -> tuple[Array, Array]:
    """Values (n, k, c) of a picture at places u, v (k,) of each element, and which of them lie in it (n, k)."""
    from scipy.ndimage import map_coordinates

    column, row = places_in(Elements(poses.points, poses.angles, poses.scales), u, v)
    values = [map_coordinates(channel, [row, column], order=1, mode="nearest") for channel in np.moveaxis(image, -1, 0)]
    inside = (row >= -0.5) & (row <= image.shape[0] - 0.5) & (column >= -0.5) & (column <= image.shape[1] - 0.5)
    return np.stack(values, axis=-1).astype(np.float64), inside.astype(np.float64)
