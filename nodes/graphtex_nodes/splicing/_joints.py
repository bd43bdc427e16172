"""Elements that fill a picture but for the joints between them, however unlike in colour they are."""

import heapq
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex import Context

Array = NDArray[Any]
Smoothness = Callable[[Array], tuple[Array, Array]]

REACH = 3  # pixels: joints may be twice as wide
DEEP = 0.9  # quantile of depth: what is deeper, as shadows are, parts no more
SHALLOW = 0.01  # of the depths' deviation: what is less deep divides nothing
CUTS = (0.05, 0.12, 0.2, 0.3, 0.45, 0.6, 0.75)  # of the way from the median to the largest depth: below is relief
NARROW = 0.5  # of the usual depth of joints: what is deeper and beside them is joint too
CERTAIN = 4.0  # cost of a pixel without any depth as a joint
SIDE, LEAST_SIDE = 200, 12.0  # pixels of a picture that is searched, and of elements in it
WIDE = 1.5  # times the usual width of joints: none is wider


class Joints(NamedTuple):
    """What joints part: a mask (h, w) of every `step`-th pixel of a picture, and 1 for dark joints, -1 for bright."""

    mask: Array
    step: float
    sign: int


class Ridges(NamedTuple):
    """Borders of a division: the two basins (n, 2) that each parts, its mean depth (n,), and its length (n,)."""

    sides: Array
    depths: Array
    lengths: Array


def joint_depths(light: Array, reach: int) -> Array:
    """How much darker pixels (h, w) are than what is on both sides of them, up to `reach` pixels away."""
    from scipy.ndimage import grey_closing

    depths = grey_closing(light, (2 * reach + 1,) * 2) - light
    cut: Array = np.minimum(depths, np.quantile(depths, DEEP))
    return cut


def divided(image: Array, least: float = 0.0) -> Iterator[tuple[Array, float, int]]:
    """All :func:`divisions` of a picture (h, w, c) by dark joints, with a 1, and by bright ones, with a -1."""
    for sign in (1, -1):
        for labels, clearness in divisions(joint_depths(_light(image, sign, 1.0), REACH), least):
            yield labels, clearness, sign


def divisions(depth: Array, least: float = 0.0) -> Iterator[tuple[Array, float]]:
    """Labels (h, w) of what joints part, 0 on these, from many parts to few, and how clear the joints are.

    Those with joints that are not clearer than `least` are left out.

    A watershed over the depth of joints divides too much: every crack and shadow of relief makes a basin. Two basins
    are joined where the border between them is the least deep in the mean, which gaps in a joint hardly change, and a
    crack that ends within a part does not last either (after Arbelaez et al. 2011). How clear they are is the share of
    the variance of the borders' depths that is between those kept and those joined.
    """
    from scipy.ndimage import gaussian_filter, label
    from skimage.morphology import h_minima
    from skimage.segmentation import watershed

    smooth = gaussian_filter(depth, 1.0)
    if np.ptp(smooth) < 1e-6:
        return
    basins = watershed(smooth, label(h_minima(smooth, SHALLOW * smooth.std()))[0])
    ridges = _ridges(basins, depth)
    joined = list(_joined(ridges, int(basins.max())))
    root = np.arange(basins.max() + 1)
    usual, most = float(np.median(depth)), float(depth.max())
    limits = iter([usual + share * (most - usual) for share in CUTS])
    limit = next(limits, None)
    for value, one, other in [*joined, (np.inf, 0, 0)]:
        while limit is not None and value > limit:
            roots = _flat(root)
            clearness = _clearness(roots, ridges)
            if clearness > least:
                yield _without_joints(roots[basins], depth), clearness
            limit = next(limits, None)
        root[other] = one


def _ridges(basins: Array, depth: Array) -> Ridges:
    """Borders between basins, in order of their sides."""
    count = int(basins.max()) + 1
    keys, values = [], []
    for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        apart = basins[one] != basins[other]
        low, high = np.minimum(basins[one], basins[other])[apart], np.maximum(basins[one], basins[other])[apart]
        keys.append(low.astype(np.int64) * count + high)
        values.append(np.maximum(depth[one], depth[other])[apart])
    found, index = np.unique(np.concatenate(keys), return_inverse=True)
    lengths = np.bincount(index, minlength=len(found))
    depths = np.bincount(index, np.concatenate(values), len(found)) / np.maximum(lengths, 1)
    return Ridges(np.stack([found // count, found % count], axis=1), depths, lengths)


def _joined(ridges: Ridges, count: int) -> Iterator[tuple[float, int, int]]:
    """Pairs of basins in the order in which they are joined, the second into the first, and the deepest so far."""
    beside: list[dict[int, tuple[float, int]]] = [{} for _ in range(count + 1)]
    heap = []
    for (one, other), depth, length in zip(ridges.sides.tolist(), ridges.depths, ridges.lengths, strict=True):
        beside[one][other] = beside[other][one] = (float(depth * length), int(length))
        heap.append((float(depth), one, other, int(length)))
    heapq.heapify(heap)
    highest = 0.0
    while heap:
        depth, one, other, length = heapq.heappop(heap)
        if beside[one].get(other, (0.0, 0))[1] != length:
            continue  # an older border of theirs
        highest = max(highest, depth)
        yield highest, one, other
        del beside[one][other], beside[other][one]
        for third, (total, more) in beside[other].items():
            del beside[third][other]
            before = beside[one].get(third, (0.0, 0))
            now = before[0] + total, before[1] + more
            beside[one][third] = beside[third][one] = now
            heapq.heappush(heap, (now[0] / now[1], min(one, third), max(one, third), now[1]))
        beside[other] = {}


def _flat(root: Array) -> Array:
    """The last root of each basin."""
    result = root.copy()
    while not np.array_equal(result, result[result]):
        result = result[result]
    return result


def _clearness(root: Array, ridges: Ridges) -> float:
    """Share of the variance of borders' depths that is between kept and joined ones, each pixel of them counting."""
    kept = root[ridges.sides[:, 0]] != root[ridges.sides[:, 1]]
    weight = ridges.lengths / max(int(ridges.lengths.sum()), 1)
    if kept.all() or not kept.any():
        return 0.0
    share = float(weight[kept].sum())
    means = [float((weight * ridges.depths)[side].sum() / weight[side].sum()) for side in (kept, ~kept)]
    variance = float((weight * (ridges.depths - (weight * ridges.depths).sum()) ** 2).sum())
    return share * (1 - share) * (means[0] - means[1]) ** 2 / max(variance, 1e-12)


def _without_joints(parts: Array, depth: Array) -> Array:
    """Parts numbered from 1 on, 0 in the joints between them: their borders, and what is about as deep beside these."""
    from scipy.ndimage import binary_propagation, distance_transform_edt

    border = np.zeros(parts.shape, bool)
    for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
        border[one] |= parts[one] != parts[other]
    if border.any():
        deep = depth > NARROW * np.median(depth[border])
        # shadows of relief that run into a joint are as deep, and wider
        half = float(np.median(distance_transform_edt(deep)[border]))
        deep &= distance_transform_edt(~border) < WIDE * half
        border |= binary_propagation(border & deep, mask=deep)
    labels: Array = np.unique(np.where(border, 0, parts + 1), return_inverse=True)[1].reshape(parts.shape)
    return labels if border.any() else labels + 1


def joints_around(image: Array, centres: Array, side: float) -> Joints | None:
    """The joints of a picture (h, w, c) that part most of some elements' centres (n, 2) from each other; None without.

    Elements with a shorter side of `side` pixels stay at least `LEAST_SIDE` wide in what is searched.
    """
    from graphtex_nodes.splicing._detection import reduced

    step = max(1.0, min(max(image.shape[:2]) / SIDE, side / LEAST_SIDE))
    small = reduced(image, step)
    last = np.array(small.shape[1::-1]) - 1
    x, y = np.clip(np.rint(centres / step), 0, last).astype(np.intp).T
    best, found = 0.0, None
    for labels, clearness, sign in divided(small):
        own = len(np.setdiff1d(labels[y, x], [0])) / max(len(x), 1)
        if own * clearness > best:
            best, found = own * clearness, Joints(labels > 0, step, sign)
    return found


def along_joints(joints: Joints, image: Array, known: Array, smoothness: Smoothness, ctx: Context) -> Array:
    """The mask (h, w) of all of a picture, of that of every `step`-th pixel: cut anew along its outlines by depth.

    `known` is 1 where foreground is known, -1 where background is; `smoothness` what parts neighbours of a part.
    """
    from graphtex_nodes.splicing._outlines import nearest_indices, refined_outlines

    depth = joint_depths(_light(image, joints.sign, joints.step), round(REACH * joints.step))[..., None]
    joint = ~joints.mask[np.ix_(*nearest_indices(image.shape[:2], joints.mask.shape, joints.step))]
    limit = NARROW * max(float(np.median(depth[joint])), 1e-6) if joint.any() else 1.0

    def tile(window: tuple[slice, slice]) -> Array:
        return np.concatenate([image[window], depth[window]], axis=2)

    return refined_outlines(
        joints.mask, joints.step, known, tile, lambda pixels: CERTAIN * (pixels[:, -1] / limit - 1),
        lambda picture: smoothness(picture[..., :-1]), ctx,
    )  # fmt: skip


def _light(image: Array, sign: int, step: float) -> Array:
    from scipy.ndimage import gaussian_filter

    from graphtex_nodes.numerics.illumination import log_brightness

    light: Array = sign * gaussian_filter(log_brightness(image), 0.7 * step)
    return light
