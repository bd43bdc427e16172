"""The labelling of a picture in elements and ground that costs least."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Context, Elements
from graphtex_nodes.numerics.illumination import WHOLE, without_trend
from graphtex_nodes.splicing._colours import (
    least_cut,
    mixture_cost,
    nearest_cost,
    sharpened,
    smoothness_costs,
    told_by_hue,
    typical_of,
)
from graphtex_nodes.splicing._joints import Joints, along_joints, joints_around
from graphtex_nodes.splicing._nearness import distances, places_in
from graphtex_nodes.splicing._partitions import LEAST_COUNT, without_small_holes

Array = NDArray[Any]

CORE, RIM = 0.85, 1.12  # where an element surely is, and where it surely ends, in its half sizes
FARTHEST = 0.35  # share of what lies outside of all elements that surely is background
LEAST_BACKGROUND = 0.02  # share of the picture that background colours are learned from
CAP = 8.0  # of -log p: no pixel is surer than that
HARD = 1e6
SPECK = 0.02  # of an element's area: smaller parts and holes are mistakes
RARE = 0.15  # share of a background colour among elements, over its share outside
LOST = 0.25  # share of elements that may come out as background
PACKED = 0.5  # share of the picture in elements from which there may be joints between them
EATEN, LESS = 0.1, 0.5  # share of elements' insides from which joints are tried, and what they must bring it down to
MOST = 0.25  # of an element's inside must be foreground: rings are elements too
ROUNDS = 3  # of learning colours from the last cut


class Cutter:
    """The energy of a labelling, whose colours are learned from one picture and then hold for others."""

    def __init__(
        self, colours: str, clusters: int, sigma: float | None, smoothness: float, trend: Array | None
    ) -> None:
        self.colours, self.clusters, self.sigma, self.smoothness, self.trend = (
            colours, clusters, sigma, smoothness, trend,
        )  # fmt: skip
        self.samples: list[Array] = []
        self.joints: Joints | None = None

    def evened(self, image: Array, shape: tuple[int, ...] | None = None, window: tuple[slice, slice] = WHOLE) -> Array:
        """A picture, or a window of one of that shape, without the trend of light."""
        even = image if self.trend is None else without_trend(image, self.trend, shape, window)
        result: Array = even.astype(np.float64)
        return result

    def cost(self, pixels: Array) -> Array:
        """What pixels (n, c) cost as foreground less what they cost as background, by their colours."""
        return self._cost(self._features(pixels))

    def smoothness_of(self, picture: Array) -> tuple[Array, Array]:
        """What it costs to part pixels (h, w) from their right and their lower neighbours."""
        right, down = smoothness_costs(picture, self.sigma)
        return self.smoothness * right, self.smoothness * down

    def cut(
        self, image: Array, known: Array, elements: Elements | None, width: float, height: float, ctx: Context
    ) -> Array:
        """The mask (h, w) that costs least, with colours learned anew from it."""
        picture = self.evened(image)
        mask = self._cut(picture, known, elements, width, height, ctx)
        eaten = eaten_share(mask, elements, width, height)
        if (
            self.colours == "mixture"
            and elements is not None
            and eaten > EATEN
            and _packed(known, elements, width, height)
        ):
            found = joints_around(picture, elements.points, min(width, height))
            if found is not None:
                by_joints = along_joints(found, picture, known, self.smoothness_of, ctx)
                by_joints = _cleaned(by_joints, SPECK * width * height, known)
                if eaten_share(by_joints, elements, width, height) < LESS * eaten and not by_joints.all():
                    mask, self.joints = by_joints, found
        lost = lost_share(mask, elements, width, height)
        if not mask.any() or mask.all():
            raise ValueError(
                f"image: expected colours that tell elements from what is between them, got "
                f"{'only' if mask.all() else 'no'} foreground; mark some of both by foreground, background or strokes"
            )
        if lost > LOST:
            ctx.warn(
                f"{lost:.0%} of the elements came out as background; give all elements, or mark some of both by strokes"
            )
        return mask

    def _features(self, pixels: Array) -> Array:
        """What pixels (n, c) are compared by."""
        return told_by_hue(pixels) if self.colours == "mixture" else pixels

    def _cost(self, features: Array) -> Array:
        if self.colours == "literal":
            near, far = (nearest_cost(features, each) for each in self.samples)
            distance: Array = near - far
            return distance
        ours, theirs = (mixture_cost(features, each, self.clusters) for each in self.samples)
        costs: Array = np.clip(ours - theirs, -CAP, CAP)
        return costs

    def _cut(
        self, picture: Array, known: Array, elements: Elements | None, width: float, height: float, ctx: Context
    ) -> Array:
        """The mask that costs least by colours."""
        features = self._features(picture.reshape(-1, picture.shape[2]))
        seeds = _seeds(known, elements, width, height, features)
        ctx.check()
        right, down = self.smoothness_of(picture)
        mask = seeds > 0
        for turn in range(ROUNDS if self.colours == "mixture" else 1):
            ctx.progress(turn / ROUNDS, "learning colours")
            self.samples = [features[(seeds == side).ravel()] for side in (1, -1)]
            mask = least_cut(self._cost(features).reshape(mask.shape) - HARD * known, right, down)
            if not mask.any() or mask.all():
                break
            seeds = np.where(mask, 1, -1)
        size = width * height if elements is not None else 16.0
        mask = _cleaned(mask, SPECK * size, known)
        if self.colours == "mixture":
            mask = (sharpened(mask, np.maximum(picture, 0) ** 2.2) | (known > 0)) & ~(known < 0)
        return mask


def lost_share(mask: Array, elements: Elements | None, width: float, height: float) -> float:
    """Share of the elements most of whose inside is background; 0 without elements."""
    ours, seen = _insides(mask, elements, width, height)
    return float((ours.sum(axis=1) < MOST * seen.sum(axis=1)).mean()) if len(ours) else 0.0


def eaten_share(mask: Array, elements: Elements | None, width: float, height: float) -> float:
    """Share of the elements' insides that is background; 0 without elements."""
    ours, seen = _insides(mask, elements, width, height)
    return float(1 - ours.sum() / seen.sum()) if seen.any() else 0.0


def _packed(known: Array, elements: Elements, width: float, height: float) -> bool:
    """Whether elements leave little room: only then is what lies between them joints."""
    return float((distances(known.shape, elements, width, height)[0] < 1).mean()) > PACKED


def _insides(mask: Array, elements: Elements | None, width: float, height: float) -> tuple[Array, Array]:
    """Whether places in each element are in the mask, and whether in the picture, (n, k); (0, 0) without elements."""
    if elements is None or not len(elements.points):
        return np.zeros((0, 0), bool), np.zeros((0, 0), bool)
    line = np.linspace(-CORE, CORE, 9)
    u, v = (grid.ravel() for grid in np.meshgrid(line, line))
    inside = u * u + v * v <= CORE * CORE
    u, v = u[inside] * width / 2, v[inside] * height / 2
    column, row = (np.rint(places).astype(np.int64) for places in places_in(elements, u, v))
    seen = (row >= 0) & (row < mask.shape[0]) & (column >= 0) & (column < mask.shape[1])
    return mask[row.clip(0, mask.shape[0] - 1), column.clip(0, mask.shape[1] - 1)] & seen, seen


def _seeds(known: Array, elements: Elements | None, width: float, height: float, pixels: Array) -> Array:
    """Where colours are learned from first: 1 foreground, -1 background, 0 not at all."""
    seeds = known.copy()
    if elements is not None and len(elements.points):
        if width <= 0 or height <= 0:
            raise ValueError(f"width: expected the elements' size above 0, got {width:g} x {height:g}")
        nearness, outside = distances(known.shape, elements, width, height)
        if not (known < 0).any():
            inner = _inner(known.shape, elements, width, height)
            rim = min(RIM, float(np.quantile(outside[inner], 1 - LEAST_BACKGROUND)))
            beyond = inner & (outside >= rim) & (known == 0)
            if beyond.any():
                beyond &= nearness >= np.quantile(nearness[beyond], 1 - FARTHEST)
            ground = typical_of(pixels, beyond.ravel(), (nearness < 1).ravel(), RARE)
            seeds[ground.reshape(seeds.shape)] = -1
        if not (known > 0).any():
            core = typical_of(pixels, ((nearness < CORE) & (seeds == 0)).ravel(), (seeds < 0).ravel(), 1.0)
            seeds[core.reshape(seeds.shape)] = 1
    for name, side in (("foreground", 1), ("background", -1)):
        if not (seeds == side).any():
            raise ValueError(f"{name}: expected some pixels of it, by elements, a mask or strokes, got none")
    return seeds


def _inner(shape: tuple[int, ...], elements: Elements, width: float, height: float) -> Array:
    """Where no element lies whose middle is beyond the picture's border, unseen; everywhere if there is no such place.

    Elements that touch leave little ground: what is farthest from all that were found is then parts of such ones. A
    few elements are no pattern that goes on there, and what is so far from the border may be within one of them.
    """
    if len(elements.points) < LEAST_COUNT:
        return np.ones(shape, bool)
    margin = int(np.ceil(max(width, height) * np.median(elements.scales) / 2))
    inner = np.zeros(shape, bool)
    inner[margin : shape[0] - margin, margin : shape[1] - margin] = True
    return inner if inner.any() else ~inner


def _cleaned(mask: Array, least: float, known: Array) -> Array:
    """A mask without parts and holes of less than `least` pixels, but for what is known."""
    mask = without_small_holes(~without_small_holes(~mask, least), least)
    cleaned: Array = (mask | (known > 0)) & ~(known < 0)
    return cleaned
