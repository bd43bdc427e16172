"""Holes in generated planes: do the elements put there have the size that the perspective asks for?"""

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import peers
from benchmarks.figures import Figure
from graphtex_nodes import bricks, complete, contact_sheet, exemplar_inpaint, pebbles, woven_cloth
from graphtex_nodes.image.save import save_image
from graphtex_nodes.numerics.measures import element_sizes, patch_distance

Array = NDArray[Any]

SIDE = 288
BANDS = 3  # of a hole, by scale
WINDOW = 11  # pixels: what is traced back to where it was copied from
COMPONENTS = 16
APART = 0.2  # the window found may be this much further than the nearest
WORST = float(np.log(8))  # the error of a band without any element
SHARE = 0.5  # of a baseline's error that is asked for


@dataclass(frozen=True)
class Case:
    """A hole in a plane whose picture and scale are known. Scale is the same along rows."""

    picture: Array
    scale: Array
    hole: Array


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Fill ten holes with every tool there is."""
    tools: dict[str, Callable[[Array, Array, int], Array]] = {
        "graphtex": lambda picture, hole, seed: complete(picture, hole, rng=seed).image,
        "ExemplarInpaint": lambda picture, hole, seed: exemplar_inpaint(picture, hole).image,
    }
    others = peers.fillers()
    if not others:
        print("no tool for holes is installed (pip install 'graphtex[bench]')", file=sys.stderr)
    tools |= others
    found = cases()
    errors: dict[str, list[float]] = {name: [] for name in tools}
    distances: dict[str, list[float]] = {name: [] for name in tools}
    sources: dict[str, list[float]] = {name: [] for name in tools}
    seconds = dict.fromkeys(tools, 0.0)
    floor, origin = [], []
    for number, case in enumerate(found):
        blanked = np.where(case.hole[..., None], np.float32(0.5), case.picture)
        shown = {"hole": blanked}
        floor.append(size_error(case.picture, case))
        origin.append(source_error(case.picture, case))
        for name, tool in tools.items():
            start = time.perf_counter()
            shown[name] = tool(blanked, case.hole, number)
            seconds[name] += time.perf_counter() - start
            errors[name].append(size_error(shown[name], case))
            sources[name].append(source_error(shown[name], case))
            distances[name].append(100 * hole_distance(shown[name], case))
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            shown["truth"] = case.picture
            sheet = contact_sheet(list(shown.values()), columns=len(shown), labels=list(shown))
            save_image(sheet, pictures / f"completion-{number}.png")
    noise = float(np.mean(floor))
    yield Figure(f"log size error of the truth itself in {len(found)} holes (taken off below)", noise**0.5)
    astray = float(np.mean(np.square(origin)))
    yield Figure("log scale error of sources of the truth itself (taken off below too)", astray**0.5)
    excess = {name: max(0.0, float(np.mean(each)) - noise) ** 0.5 for name, each in errors.items()}
    excess_of_sources = {
        name: max(0.0, float(np.mean(np.square(each))) - astray) ** 0.5 for name, each in sources.items()
    }
    measures = {
        "log scale error of sources": (excess_of_sources, SHARE),
        "log size error": (excess, SHARE),
        "seconds": (seconds, None),
        "patch distance x 100": ({name: float(np.mean(each)) for name, each in distances.items()}, None),
    }
    for measure, (values, share) in measures.items():
        mine = values.pop("graphtex")
        yield Figure(f"{measure} in holes", mine)
        for name, other in values.items():
            bound = "" if share is None else f"<= {share * other:.4g}"
            yield Figure(f"{measure} in holes, beside {name}'s", mine, bound, other)


def cases() -> list[Case]:
    """Ten holes, round and square, in three kinds of planes with slants of 45 to 60 degrees."""
    y, x = np.mgrid[:SIDE, :SIDE]
    result = []
    for number in range(10):
        kind, size, turned = ((pebbles, 16.0, False), (woven_cloth, 10.0, False), (bricks, 32.0, True))[number % 3]
        slant, tilt = 45.0 + 5 * (number % 4), 90.0 * turned
        made = kind(width=SIDE, height=SIDE, size=size, slant=slant, tilt=tilt, rng=30 + number)
        picture, scale = made.image, made.scale
        if turned:  # the plane recedes to the right: turned, its far side is up
            picture, scale = (np.ascontiguousarray(np.swapaxes(each, 0, 1)[::-1]) for each in (picture, scale))
        top, left = 100 + 30 * (number % 4), 100 + 25 * (number // 3)
        radius = 34 + 4 * (number % 3)
        apart = np.hypot(y - top, x - left) if number % 2 else np.maximum(np.abs(y - top), np.abs(x - left))
        result.append(Case(picture, scale, apart <= radius))
    return result


def source_error(picture: Array, case: Case) -> float:
    """By how much the log scale of the known windows most like those of the hole differs from the hole's, on average.

    Tools copy, so this tells at which scale they should have and at which they did, without the chance of few elements.
    What is no copy, as the truth itself, finds windows of scattered scales: their mean is taken with its sign, for the
    mean of absolute differences would be larger for the truth than for any tool. Only windows that lie in the hole as a
    whole count.
    """
    from scipy.spatial import cKDTree

    views = np.lib.stride_tricks.sliding_window_view
    touched = views(case.hole, (WINDOW, WINDOW))
    known, inside = (np.asarray(each) for each in (~touched.any(axis=(2, 3)), touched.all(axis=(2, 3))))
    inside[1::2] = inside[:, 1::2] = False
    middle = WINDOW // 2
    log_scale = np.log(case.scale[middle : middle + known.shape[0], middle : middle + known.shape[1]])
    there, here = (
        views(np.asarray(each, np.float32), (WINDOW, WINDOW), axis=(0, 1)).reshape(*known.shape, -1)[chosen]
        for each, chosen in ((case.picture, known), (picture, inside))
    )
    mean = there.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((there - mean)[::5], rowvar=False))
    axes = axes[:, ::-1][:, :COMPONENTS]
    _, nearest = cKDTree((there - mean) @ axes).query((here - mean) @ axes, eps=APART)
    return float(abs((log_scale[known][nearest] - log_scale[inside]).mean()))


def size_error(picture: Array, case: Case) -> float:
    """Mean square error of the log of element sizes in bands of the hole.

    What is right is a power law of the scale, fitted to the true picture as a whole. The size in a band is the length
    of its rows over the number of crossings of the true picture's median there, all channels alike.
    """
    scales, sizes = element_sizes(case.picture, case.scale)
    slope, offset = np.polyfit(np.log(scales), np.log(sizes), 1)
    rows = np.flatnonzero(case.hole.any(axis=1))
    errors = []
    for band in np.array_split(rows, BANDS):
        inside = case.hole[band]
        above = picture[band] > np.median(case.picture[band], axis=1, keepdims=True)
        both = inside[:, 1:] & inside[:, :-1]
        crossings = int((above[:, 1:] != above[:, :-1])[both].sum())
        length = int(both.sum()) * picture.shape[2]
        wanted = slope * np.log(case.scale[band][inside]).mean() + offset
        errors.append(min(WORST, abs(np.log(length / crossings) - wanted)) if crossings else WORST)
    return float(np.mean(np.square(errors)))


def hole_distance(picture: Array, case: Case) -> float:
    """Patch distance of the hole's box to the same box of the truth: blur costs here, where it would pay in PSNR."""
    rows, columns = (np.flatnonzero(case.hole.any(axis=axis)) for axis in (1, 0))
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    return patch_distance(picture[box], case.picture[box])
