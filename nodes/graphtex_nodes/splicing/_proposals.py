"""Guesses at one element of a texture that nobody has pointed at."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.splicing._partitions import (
    LARGEST_SHARE,
    LEAST_COUNT,
    LEAST_SIDE,
    Even,
    Parts,
    colour_channels,
)
from graphtex_nodes.splicing._repeats import cell
from graphtex_nodes.splicing._templates import Example
from graphtex_nodes.splicing._unlit import squared_change

Array = NDArray[Any]

ALIKE = 1.6  # factor in area up to which two parts may be elements of one kind
BLOB = 0.3  # merit of a blob, which may be anything
SCALES = (2.0, 2.8, 4.0, 5.7, 8.0, 11.3)  # standard deviations of blobs, reduced pixels


@dataclass(frozen=True)
class Proposal:
    """An example, and how sure it is to be an element, 0 to 1."""

    example: Example
    merit: float


def proposals(even: Even, divided: list[Parts]) -> list[Proposal]:
    """Guesses from partitions and from blobs of a picture; the best first."""
    found = []
    for parts in divided:
        guess = from_parts(parts, parts.fits)
        if guess is not None:
            found.append(replace(guess, merit=guess.merit * parts.weight / max(divided[0].weight, 1e-12)))
    for channel in colour_channels(even.picture):
        found += [Proposal(enlarged(example, even.step, even.size), BLOB) for example in _blobs(channel)]
    return sorted(found, key=lambda guess: -guess.merit)


def from_parts(parts: Parts, some: Array) -> Proposal | None:
    """The most typical of the kind that covers most among some parts (n,); None if there are too few of a kind.

    Its merit is the parts' times the share of those parts' area that are of the kind.
    """
    index = np.flatnonzero(some)
    top, bottom, left, right = parts.boxes[index].T
    index = index[(bottom - top >= LEAST_SIDE) & (right - left >= LEAST_SIDE)]
    if len(index) < LEAST_COUNT:
        return None
    top, bottom, left, right = parts.boxes[index].T
    areas = parts.areas[index]
    shapes = np.log(np.stack([areas, bottom - top, right - left], axis=1).astype(np.float64))
    unlike = np.abs(shapes[:, None] - shapes[None]).max(axis=2)
    alike = unlike < np.log(ALIKE)
    # the kind that covers most, and of it the one that the others are least unlike to
    kind = np.flatnonzero(alike[int(np.argmax((alike * areas).sum(axis=1)))])
    if len(kind) < LEAST_COUNT:
        return None
    typical = kind[np.argmin(np.median(unlike[np.ix_(kind, kind)], axis=1))]
    example = Example.model_construct(
        x=(left[typical] + right[typical] - 1) / 2, y=(top[typical] + bottom[typical] - 1) / 2,
        width=float(right[typical] - left[typical]) + parts.rim,
        height=float(bottom[typical] - top[typical]) + parts.rim,
    )  # fmt: skip
    share = float(areas[kind].sum() / areas.sum())
    return Proposal(enlarged(example, parts.step, parts.size), parts.merit * share)


def from_repeats(even: Even) -> Proposal | None:
    """A cell of a picture that repeats itself, about a bright or a dark spot in the middle; None of others.

    Cloth and the like have elements without outlines: it is their repetition that tells them. Of bright and dark spots
    those are taken at which the boxes of cells cut through less: spots of the ground have elements all around them.
    """
    from scipy.ndimage import gaussian_filter

    found = cell(even.repeats)
    if found is None:
        return None
    width, height, merit = found
    channel = next(colour_channels(even.picture), None)
    if channel is None:
        return None
    spots = gaussian_filter(channel, min(width, height) / 4, mode="mirror")
    top, left = (max(0, int((side - size) / 2)) for side, size in zip(channel.shape, (height, width), strict=True))
    window = np.s_[top : top + int(height) + 1, left : left + int(width) + 1]
    cut = _on_outlines(np.sqrt(squared_change(even.picture)), width, height)
    bright, dark = (cut[_peaks_of(sign * spots, min(width, height))].mean() for sign in (1, -1))
    chosen = (spots if bright <= dark else -spots)[window]
    y, x = np.unravel_index(int(chosen.argmax()), chosen.shape)
    example = Example.model_construct(x=float(left + x), y=float(top + y), width=width, height=height)
    return Proposal(enlarged(example, even.step, even.size), merit)


def _peaks_of(spots: Array, size: float) -> Array:
    """Where a map (h, w) is as high as anywhere within a distance."""
    from scipy.ndimage import maximum_filter

    peaks: Array = (maximum_filter(spots, 2 * int(size / 2) + 1) == spots) & (spots > spots.mean())
    return peaks


def _on_outlines(change: Array, width: float, height: float) -> Array:
    """Mean of a map (h, w) on the outline of a box about each pixel."""
    from scipy.ndimage import uniform_filter

    outer = 2 * int(height / 2) + 1, 2 * int(width / 2) + 1
    inner = outer[0] - 2, outer[1] - 2
    sums = [uniform_filter(change, size, mode="mirror") * size[0] * size[1] for size in (outer, inner)]
    mean: Array = (sums[0] - sums[1]) / (outer[0] * outer[1] - inner[0] * inner[1])
    return mean


def enlarged(example: Example, step: float, size: tuple[int, ...]) -> Example:
    """An example of every `step`-th pixel in a picture of some (height, width)."""
    return Example(
        x=min(example.x * step, size[1] - 1), y=min(example.y * step, size[0] - 1),
        width=max(3.0, example.width * step), height=max(3.0, example.height * step),
    )  # fmt: skip


def _blobs(channel: Array) -> Iterator[Example]:
    """The typical bright and the typical dark blob of the scale whose blobs stand out most (Lindeberg 1998)."""
    from scipy.ndimage import gaussian_laplace

    from graphtex_nodes.splicing._peaks import local_maxima

    best: dict[int, tuple[float, Example]] = {}
    for scale in SCALES:
        dark = scale**2 * gaussian_laplace(channel, scale, mode="mirror")
        size = 2 * np.sqrt(2) * scale
        if size**2 > LARGEST_SHARE * channel.size:
            continue
        for sign in (-1, 1):
            places, values = local_maxima(sign * dark, max(1, round(scale)))
            inner = (places.min(axis=1) >= size / 2) & (
                (np.array(channel.shape[::-1]) - 1 - places).min(axis=1) >= size / 2
            )
            places, values = places[inner], values[inner]
            if len(values) < LEAST_COUNT:
                continue
            middle = int(np.argsort(values, kind="stable")[len(values) // 2])
            strength = float(values[middle]) * np.sqrt(len(values)) * size  # of all blobs together
            x, y = places[middle]
            example = Example.model_construct(x=float(x), y=float(y), width=size, height=size)
            if sign not in best or strength > best[sign][0]:
                best[sign] = strength, example
    yield from (best[sign][1] for sign in (-1, 1) if sign in best)
