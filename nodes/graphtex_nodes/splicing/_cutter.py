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
from graphtex_nodes.splicing._nearness import distances

Array = NDArray[Any]

CORE, RIM = 0.85, 1.12  # where an element surely is, and where it surely ends, in its half sizes
FARTHEST = 0.35  # share of what lies outside of all elements that surely is background
LEAST_BACKGROUND = 0.02  # share of the picture that background colours are learned from
CAP = 8.0  # of -log p: no pixel is surer than that
HARD = 1e6
SPECK = 0.02  # of an element's area: smaller parts and holes are mistakes
RARE = 0.15  # share of a background colour among elements, over its share outside
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

    def evened(self, image: Array, shape: tuple[int, ...] | None = None, window: tuple[slice, slice] = WHOLE) -> Array:
        """A picture, or a window of one of that shape, without the trend of light."""
        even = image if self.trend is None else without_trend(image, self.trend, shape, window)
        result: Array = even.astype(np.float64)
        return result

    def features(self, pixels: Array) -> Array:
        """What pixels (n, c) are compared by."""
        return told_by_hue(pixels) if self.colours == "mixture" else pixels

    def cost(self, pixels: Array) -> Array:
        """What pixels (n, c) cost as foreground less what they cost as background."""
        features = self.features(pixels)
        if self.colours == "literal":
            near, far = (nearest_cost(features, each) for each in self.samples)
            distance: Array = near - far
            return distance
        ours, theirs = (mixture_cost(features, each, self.clusters) for each in self.samples)
        costs: Array = np.clip(ours - theirs, -CAP, CAP)
        return costs

    def smoothness_of(self, picture: Array) -> tuple[Array, Array]:
        """What it costs to part pixels (h, w) from their right and their lower neighbours."""
        right, down = smoothness_costs(picture, self.sigma)
        return self.smoothness * right, self.smoothness * down

    def cut(
        self, image: Array, known: Array, elements: Elements | None, width: float, height: float, ctx: Context
    ) -> Array:
        """The mask (h, w) that costs least, with colours learned anew from it."""
        picture = self.evened(image)
        pixels = picture.reshape(-1, picture.shape[2])
        features = self.features(pixels)
        seeds = _seeds(known, elements, width, height, features)
        ctx.check()
        right, down = self.smoothness_of(picture)
        mask = seeds > 0
        for turn in range(ROUNDS if self.colours == "mixture" else 1):
            ctx.progress(turn / ROUNDS, "learning colours")
            self.samples = [features[(seeds == side).ravel()] for side in (1, -1)]
            costs = self.cost(pixels).reshape(mask.shape) - HARD * known
            mask = least_cut(costs, right, down)
            if not mask.any() or mask.all():
                break
            seeds = np.where(mask, 1, -1)
        size = width * height if elements is not None else 16.0
        mask = _cleaned(mask, SPECK * size, known)
        if self.colours == "mixture":
            mask = (sharpened(mask, np.maximum(picture, 0) ** 2.2) | (known > 0)) & ~(known < 0)
        if not mask.any() or mask.all():
            raise ValueError(
                f"image: expected colours that tell elements from what is between them, got "
                f"{'only' if mask.all() else 'no'} foreground; mark some of both by foreground, background or strokes"
            )
        return mask


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

    Elements that touch leave little ground: what is farthest from all that were found is then parts of such ones.
    """
    margin = int(np.ceil(max(width, height) * np.median(elements.scales) / 2))
    inner = np.zeros(shape, bool)
    inner[margin : shape[0] - margin, margin : shape[1] - margin] = True
    return inner if inner.any() else ~inner


def _cleaned(mask: Array, least: float, known: Array) -> Array:
    """A mask without parts and holes of less than `least` pixels, but for what is known."""
    from scipy.ndimage import label

    for side in (True, False):
        parts, _ = label(mask == side)
        small = np.bincount(parts.ravel()) < least
        small[0] = False
        mask = np.where(small[parts], not side, mask)
    cleaned: Array = (mask | (known > 0)) & ~(known < 0)
    return cleaned
