"""Guesses at one element of a texture that nobody has pointed at."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.illumination import evenly_lit
from graphtex_nodes.numerics.windows import leading_directions
from graphtex_nodes.splicing._templates import Example
from graphtex_nodes.splicing._unlit import is_colourful, light_shares

Array = NDArray[Any]

SIDE = 200  # pixels that the longer side of the picture is reduced to
LEAST_COUNT = 4  # elements that make a texture
LEAST_SIDE = 4  # pixels of an element, reduced
LARGEST_SHARE = 0.12  # of the picture that one element covers
ALIKE = 1.6  # factor in area up to which two parts may be elements of one kind
SCALES = (2.0, 2.8, 4.0, 5.7, 8.0, 11.3)  # standard deviations of blobs, reduced pixels


@dataclass(frozen=True)
class Proposal:
    """An example, all the like parts (n, 2) that it was picked from, and how sure the parts make it, 0 to 1."""

    example: Example
    likes: Array
    merit: float


def proposals(image: Array) -> list[Proposal]:
    """Guesses from parts of even colour, from their thickest places, and from blobs, the best first."""
    from graphtex_nodes.splicing._detection import reduced

    step = max(1.0, max(image.shape[:2]) / SIDE)
    small = reduced(evenly_lit(image), step)
    found: list[Proposal] = []
    for channel in colour_channels(small):
        for mask in halves(channel):
            found += [*_from_parts(mask), *_from_thickness(mask)]
        found += _from_blobs(channel)
    found.sort(key=lambda guess: -guess.merit)
    return [Proposal(_enlarged(guess.example, step, image.shape), guess.likes * step, guess.merit) for guess in found]


def _enlarged(example: Example, step: float, shape: tuple[int, ...]) -> Example:
    return Example(
        x=min(example.x * step, shape[1] - 1), y=min(example.y * step, shape[0] - 1),
        width=max(3.0, example.width * step), height=max(3.0, example.height * step),
    )  # fmt: skip


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


def halves(channel: Array) -> list[Array]:
    """The parts of a map above and below Otsu's threshold, without specks and pinholes."""
    from scipy.ndimage import binary_fill_holes, binary_opening, gaussian_filter
    from skimage.filters import threshold_otsu

    smooth = gaussian_filter(channel, 0.7)
    if np.ptp(smooth) < 1e-6:
        return []
    above = smooth > threshold_otsu(smooth)
    return [binary_fill_holes(binary_opening(half)) for half in (above, ~above)]


def _from_parts(mask: Array) -> Iterator[Proposal]:
    """The most typical of the connected parts that do not touch the border."""
    from scipy.ndimage import find_objects, label

    parts, count = label(mask)
    if count < LEAST_COUNT:
        return
    areas = np.bincount(parts.ravel(), minlength=count + 1)[1:]
    boxes = np.array([[r.start, r.stop, c.start, c.stop] for r, c in find_objects(parts)])
    height, width = boxes[:, 1] - boxes[:, 0], boxes[:, 3] - boxes[:, 2]
    whole = (boxes[:, 0] > 0) & (boxes[:, 2] > 0) & (boxes[:, 1] < mask.shape[0]) & (boxes[:, 3] < mask.shape[1])
    fits = whole & (height >= LEAST_SIDE) & (width >= LEAST_SIDE) & (areas <= LARGEST_SHARE * mask.size)
    if np.count_nonzero(fits) < LEAST_COUNT:
        return
    index = np.flatnonzero(fits)
    shapes = np.log(np.stack([areas[index], height[index], width[index]], axis=1).astype(np.float64))
    unlike = np.abs(shapes[:, None] - shapes[None]).max(axis=2)
    alike = unlike < np.log(ALIKE)
    # the kind that covers most, and of it the one that the others are least unlike to
    chosen = int(np.argmax((alike * areas[index]).sum(axis=1)))
    kind = np.flatnonzero(alike[chosen])
    if len(kind) < LEAST_COUNT:
        return
    typical = kind[np.argmin(np.median(unlike[np.ix_(kind, kind)], axis=1))]
    top, bottom, left, right = boxes[index[typical]]
    example = Example.model_construct(
        x=(left + right - 1) / 2, y=(top + bottom - 1) / 2, width=float(right - left), height=float(bottom - top)
    )
    likes = np.stack([(boxes[index[kind], 2] + boxes[index[kind], 3] - 1) / 2,
                      (boxes[index[kind], 0] + boxes[index[kind], 1] - 1) / 2], axis=1)  # fmt: skip
    merit = areas[index[kind]].sum() / max(1, areas[fits | (areas > LARGEST_SHARE * mask.size)].sum())
    yield Proposal(example, likes, float(merit))


def _from_thickness(mask: Array) -> Iterator[Proposal]:
    """Where parts that have grown together are thickest; the size is twice their thickness."""
    from scipy.ndimage import distance_transform_edt, gaussian_filter

    from graphtex_nodes.splicing._peaks import local_maxima

    if mask.all() or not mask.any():
        return
    depth = distance_transform_edt(mask)
    places, depths = local_maxima(gaussian_filter(depth, 1.0), 2)
    inner = (places.min(axis=1) >= depths) & ((np.array(mask.shape[::-1]) - 1 - places).min(axis=1) >= depths)
    places, depths = places[inner], depths[inner]
    kind = np.abs(np.log(depths / np.median(depths))) < np.log(ALIKE) / 2 if len(depths) else np.zeros(0, bool)
    size = 2 * float(np.median(depths[kind])) + 2 if kind.any() else 0.0
    if np.count_nonzero(kind) < LEAST_COUNT or size < LEAST_SIDE or size**2 > LARGEST_SHARE * mask.size:
        return
    typical = np.flatnonzero(kind)[np.argmin(np.abs(depths[kind] - np.median(depths[kind])))]
    x, y = places[typical]
    example = Example.model_construct(x=float(x), y=float(y), width=size, height=size)
    yield Proposal(example, places[kind], float(np.count_nonzero(kind) / len(kind)))


def _from_blobs(channel: Array) -> Iterator[Proposal]:
    """The typical bright and the typical dark blob of the scale whose blobs stand out most (Lindeberg 1998)."""
    from scipy.ndimage import gaussian_laplace

    from graphtex_nodes.splicing._peaks import local_maxima

    for sign in (-1, 1):
        best: tuple[float, Proposal] | None = None
        for scale in SCALES:
            response = sign * scale**2 * gaussian_laplace(channel, scale, mode="mirror")
            places, values = local_maxima(response, max(1, round(scale)))
            size = 2 * np.sqrt(2) * scale
            inner = (places.min(axis=1) >= size / 2) & (
                (np.array(channel.shape[::-1]) - 1 - places).min(axis=1) >= size / 2
            )
            places, values = places[inner], values[inner]
            if len(values) < LEAST_COUNT or size**2 > LARGEST_SHARE * channel.size:
                continue
            middle = int(np.argsort(values, kind="stable")[len(values) // 2])
            strength = float(values[middle]) * np.sqrt(len(values)) * size  # of all blobs together
            x, y = places[middle]
            example = Example.model_construct(x=float(x), y=float(y), width=size, height=size)
            if best is None or strength > best[0]:
                best = strength, Proposal(example, places, 0.3)
        if best is not None:
            yield best[1]
