"""A picture in parts: its elements, if it has such that stand apart or only joints between them."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.illumination import evenly_lit, log_brightness
from graphtex_nodes.numerics.windows import leading_directions
from graphtex_nodes.splicing._joints import divided
from graphtex_nodes.splicing._repeats import Repeats, repeats
from graphtex_nodes.splicing._unlit import is_colourful, light_shares

Array = NDArray[Any]

SIDE = 200  # pixels that the longer side of the picture is reduced to
LEAST_COUNT = 4  # elements that make a texture
LEAST_SIDE = 4  # pixels of an element, reduced
LARGEST_SHARE = 0.12  # of the picture that one element covers
JOINTS = (3, 6)  # reduced pixels: half widths of what parts may be joined by
PINHOLE = 12  # reduced pixels
NECK = 0.75  # two parts have grown together where they are narrower than this share of the narrower one
RIM = 1.0  # reduced pixels: joints are taken half a pixel too wide on each side
CHANCE, CLEAR = 0.5, 0.75  # share of the variance between two sides: noise has 0.64, two colours have 1
BLURRED, SHARP = 0.45, 0.65  # the same of the borders of what joints part, between those kept and joined: noise has 0.5
MORE = 0.25  # of the parts on the ground of as many others are another kind
HARDLY_WORSE = 0.7  # times the merit
SMALLER = 0.25  # of the others' area: smaller ones are chips
SAME = 0.9  # share of parts that must be found again
GROUND = 0.25  # power of the pixels in parts, when partitions are compared


@dataclass(frozen=True)
class Even:
    """An evenly lit, reduced picture, pixels of the whole one between its own, and the (height, width) of that one."""

    picture: Array
    step: float
    size: tuple[int, ...]

    @cached_property
    def repeats(self) -> Repeats:
        """Where the picture repeats itself."""
        return repeats(self.picture)


@dataclass(frozen=True)
class Parts:
    """Parts of a reduced picture, by number from 1 on, 0 between them, and what each measures.

    Attributes
    ----------
    labels
        Shape (h, w).
    step, size
        Pixels of the picture between pixels of the reduced one, and its (height, width).
    rim
        Reduced pixels by which elements are wider than their parts.
    areas, points, boxes
        Pixels, centres of gravity (n, 2), and first and last row and column (n, 4), the last exclusive.
    roundness
        Area over that of the ellipse with the same second moments: 1 for ellipses, 0.95 for rectangles, little for
        what is forked or bent.
    fits
        Which are neither cut by the border nor too small or too large for elements.
    spread
        Standard deviation of the logarithms of the areas of those that fit, each weighing by its area.
    merit
        How much the parts look like elements, 0 to 1: their contrast x their mean roundness (0.5 counts nothing) x the
        share of them all that is in those not too large x the share of their outline that is free rather than cut x
        the evenness of their sizes.
    """

    labels: Array
    step: float
    size: tuple[int, ...]
    rim: float
    areas: Array
    points: Array
    boxes: Array
    roundness: Array
    fits: Array
    spread: float
    merit: float

    @property
    def weight(self) -> float:
        """What partitions of a picture are compared by: of two that are as good the one that covers more."""
        return self.merit * np.count_nonzero(self.labels) ** GROUND

    def hold(self, other: "Parts") -> bool:
        """Whether these are the other's parts, and more on its ground, and hardly worse."""
        from scipy.spatial import cKDTree

        if self.merit < HARDLY_WORSE * other.merit:
            return False
        x, y = np.rint(self.points[self.fits]).astype(int).T
        large = self.areas[self.fits] >= SMALLER * np.median(other.areas[other.fits])
        more = np.count_nonzero((other.labels[y, x] == 0) & large)
        apart = np.asarray(cKDTree(self.points[self.fits]).query(other.points[other.fits])[0])
        again = (apart <= np.sqrt(other.areas[other.fits]) / 4).mean()
        return bool(again >= SAME and more >= MORE * np.count_nonzero(other.fits))


def partitions(even: Even) -> list[Parts]:
    """A picture's partitions, the best first."""
    found = [measured(split(mask), contrast, even.step, even.size, rim) for mask, contrast, rim in solids(even.picture)]
    found += [measured(labels, contrast, even.step, even.size, RIM) for labels, contrast in packed(even.picture)]
    ordered = sorted((parts for parts in found if parts is not None), key=lambda parts: -parts.weight)
    # a colour may tell one kind of element only
    whole = next((parts for parts in ordered[1:] if parts.hold(ordered[0])), None)
    return ordered if whole is None else [whole, *(parts for parts in ordered if parts is not whole)]


def even_and_small(image: Array, side: int = SIDE) -> Even:
    """A picture without slow changes of light, reduced so that its longer side has so many pixels at most."""
    from graphtex_nodes.splicing._detection import reduced

    step = max(1.0, max(image.shape[:2]) / side)
    return Even(reduced(evenly_lit(image), step), step, image.shape[:2])


def solids(image: Array) -> Iterator[tuple[Array, float, float]]:
    """Masks (h, w) that may be elements: what lies between dark joints, between bright ones, and halves of colours.

    With each comes how much the two sides stand apart, 0 to 1, and by how many pixels its parts are too small.
    """
    from scipy.ndimage import binary_fill_holes, binary_opening, gaussian_filter, grey_closing

    light = gaussian_filter(log_brightness(image), 0.7)
    for signed, radius in itertools.product((light, -light), JOINTS):
        depth = grey_closing(signed, (2 * radius + 1,) * 2) - signed
        for joint, contrast in _halves(depth):
            yield without_small_holes(binary_opening(~joint), PINHOLE), contrast, RIM
    for channel in colour_channels(image):
        for above, contrast in _halves(gaussian_filter(channel, 0.7)):
            for half in (above, ~above):
                yield binary_fill_holes(binary_opening(half)), contrast, 0.0


def packed(image: Array) -> Iterator[tuple[Array, float]]:
    """Labels (h, w) of what dark or bright joints part, 0 on these, and how clear they are, 0 to 1."""
    for labels, clearness, _ in divided(image, BLURRED):
        yield labels, min(1.0, (clearness - BLURRED) / (SHARP - BLURRED))


def _halves(values: Array) -> Iterator[tuple[Array, float]]:
    """What is above Otsu's threshold, and how far above `CHANCE` the variance between the sides is, of `CLEAR`.

    Nothing of a constant map.
    """
    from skimage.filters import threshold_otsu

    if np.ptp(values) < 1e-6:
        return
    above = values > threshold_otsu(values)
    share = above.mean()
    between = share * (1 - share) * (values[above].mean() - values[~above].mean()) ** 2 / values.var()
    yield above, float(np.clip((between - CHANCE) / (CLEAR - CHANCE), 0, 1))


def without_small_holes(mask: Array, least: float) -> Array:
    """A mask (h, w) whose holes of less than `least` pixels are filled."""
    from scipy.ndimage import label

    holes = label(~mask)[0]
    small = np.bincount(holes.ravel()) < least
    small[0] = False
    filled: Array = mask | small[holes]
    return filled


def colour_channels(image: Array) -> Iterator[Array]:
    """The directions in colour along which a picture (h, w, c) varies most, and then in shares of the light."""
    yield from _leading(image)
    if image.shape[2] >= 3:
        shares = light_shares(image)
        if is_colourful(shares):
            yield from itertools.islice(_leading(shares), 1)


def _leading(image: Array) -> Iterator[Array]:
    """The first, and if it tells something the second, principal component of an image's channels."""
    flat = image.reshape(-1, image.shape[2]).astype(np.float64)
    flat = flat - flat.mean(axis=0)
    covariance = np.einsum("ni,nj->ij", flat, flat) / len(flat)
    directions = leading_directions(covariance, 1.0, 2, 40)
    values = (flat[:, :, None] * directions[None]).sum(axis=1)
    spreads = values.std(axis=0)
    for index in range(values.shape[1]):
        if spreads[index] > max(0.15 * spreads[0], 1e-4):
            yield values[:, index].reshape(image.shape[:2])


def split(mask: Array) -> Array:
    """Labels (h, w) of a mask's parts, each divided where it is narrow: a watershed over the distance to its border.

    Basins whose way to each other has no neck are of one part.
    """
    from scipy.ndimage import distance_transform_edt, gaussian_filter, label, maximum_filter
    from skimage.segmentation import watershed

    # beyond the picture parts go on
    depth = distance_transform_edt(np.pad(mask, 1, mode="edge"))[1:-1, 1:-1]
    depth = gaussian_filter(depth, 1.0) * mask
    middles = (maximum_filter(depth, 3) == depth) & mask & (depth >= 1.5)
    basins, count = label(middles, np.ones((3, 3)))
    basins = watershed(-depth, basins, mask=mask)
    labels: Array = _merged(basins, depth, count)[basins]
    return labels


def _merged(basins: Array, depth: Array, count: int) -> Array:
    """New number, from 1 on, of each basin: those whose pass is deep enough get the same."""
    deepest = np.zeros(count + 1)
    np.maximum.at(deepest, basins.ravel(), depth.ravel())
    passes = []
    for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        first, second = np.minimum(basins[one], basins[other]), np.maximum(basins[one], basins[other])
        beside = (first != second) & (first > 0)
        lower = np.minimum(depth[one], depth[other])[beside]
        passes.append(np.stack([lower, first[beside], second[beside]], axis=1))
    together = np.concatenate(passes)
    together = together[np.lexsort((together[:, 2], together[:, 1], -together[:, 0]))]
    _, first_time = np.unique(together[:, 1] * (count + 1) + together[:, 2], return_index=True)
    root = np.arange(count + 1)
    for index in np.sort(first_time):
        way, a, b = together[index]
        a, b = _root(root, int(a)), _root(root, int(b))
        if a != b and way >= NECK * min(deepest[a], deepest[b]):
            low, high = min(a, b), max(a, b)
            root[high] = low
            deepest[low] = max(deepest[low], deepest[high])
    roots = np.array([_root(root, index) for index in range(count + 1)])
    numbers: Array = np.unique(roots, return_inverse=True)[1]
    return numbers.astype(np.int64)


def _root(root: Array, index: int) -> int:
    while root[index] != index:
        index = int(root[index])
    return index


def measured(
    labels: Array, contrast: float, step: float, size: tuple[int, ...], rim: float = 0.0, least: int = LEAST_COUNT,
    largest: float = LARGEST_SHARE,
) -> Parts | None:  # fmt: skip
    """What the parts of a reduced picture measure, which stand apart so much; None for too few of them."""
    from scipy.ndimage import find_objects

    count = int(labels.max())
    row, column = np.nonzero(labels)
    index = labels[row, column] - 1

    def means(values: Array) -> Array:
        result: Array = np.bincount(index, values, count) / areas
        return result

    areas = np.bincount(index, minlength=count).astype(np.float64)
    if count < least:
        return None
    x, y = means(column), means(row)
    # a pixel is a square: it has a second moment of its own
    across, down = means(column**2) - x * x + 1 / 12, means(row**2) - y * y + 1 / 12
    skew = means(column * row) - x * y
    roundness = areas / (4 * np.pi * np.sqrt(np.maximum(across * down - skew * skew, 1e-9)))
    boxes = np.array([[r.start, r.stop, c.start, c.stop] for r, c in find_objects(labels)])
    whole = (boxes[:, [0, 2]] > 0).all(axis=1) & (boxes[:, [1, 3]] < labels.shape).all(axis=1)
    large = areas > largest * labels.size
    fits = whole & ~large & (areas >= LEAST_SIDE**2)
    if np.count_nonzero(fits) < least:
        return None
    share = areas[fits] / areas[fits].sum()
    sizes = np.log(areas[fits])
    spread = float(np.sqrt((share * (sizes - (share * sizes).sum()) ** 2).sum()))
    merit = (
        contrast * np.clip(2 * (share * roundness[fits]).sum() - 1, 0, 1)
        * (areas[~large].sum() / areas.sum()) * (1 - _cut(labels)) / (1 + spread)
    )  # fmt: skip
    return Parts(labels, step, size, rim, areas, np.stack([x, y], axis=1), boxes, roundness, fits, spread, float(merit))


def _cut(labels: Array) -> float:
    """Share of the parts' outlines that is with other parts."""
    cut = free = 0
    for one, other in ((labels[1:], labels[:-1]), (labels[:, 1:], labels[:, :-1])):
        differ, both = one != other, (one > 0) & (other > 0)
        cut += int(np.count_nonzero(differ & both))
        free += int(np.count_nonzero(differ & ~both))
    return cut / max(cut + free, 1)
