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
from graphtex_nodes.numerics.measures import patch_distance

Array = NDArray[Any]

SIDE = 320
BANDS = 4  # of a hole, by scale
OTHERS = 3  # pictures of the same plane and material that tell what is right
WINDOW = 9  # pixels: what is traced back to where it was copied from
COMPONENTS = 16
SMOOTH = 1.0  # pixels: detail much finer than that is sharpness, not size
LEVELS = (0.25, 0.5, 0.75)  # quantiles of each row whose crossings count: more are less a matter of chance
APART = 0.2  # the window found may be this much further than the nearest
WORST = float(np.log(8))  # the error of a band without any element
SHARE = 0.5  # of a baseline's error that is asked for


@dataclass(frozen=True)
class Case:
    """A hole in a plane whose picture and scale are known, and other pictures of it. Scale is the same along rows."""

    picture: Array
    scale: Array
    hole: Array
    others: list[Array]


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Fill ten holes with every tool there is."""
    tools: dict[str, Callable[[Array, Array, int], Any]] = {
        "graphtex": lambda picture, hole, seed: complete(picture, hole, rng=seed),
        "ExemplarInpaint": lambda picture, hole, seed: exemplar_inpaint(picture, hole),
    }
    others = peers.fillers()
    if not others:
        print("no tool for holes is installed (pip install 'graphtex[bench]')", file=sys.stderr)
    tools |= others
    found = cases()
    sizes: dict[str, list[float]] = {name: [] for name in ["the truth", *tools]}
    sharp: dict[str, list[float]] = {name: [] for name in ["the truth", *tools]}
    sources: dict[str, list[float]] = {name: [] for name in tools}
    distances: dict[str, list[float]] = {name: [] for name in tools}
    seconds = dict.fromkeys(tools, 0.0)
    for number, case in enumerate(found):
        blanked = np.where(case.hole[..., None], np.float32(0.5), case.picture)
        shown = {"hole": blanked}
        sizes["the truth"].append(size_error(case.picture, case))
        sharp["the truth"].append(size_error(case.picture, case, smooth=0.0))
        for name, tool in tools.items():
            start = time.perf_counter()
            result = tool(blanked, case.hole, number)
            seconds[name] += time.perf_counter() - start
            shown[name] = result if isinstance(result, np.ndarray) else result.image
            told = traced_errors(result, case) if isinstance(result, np.ndarray) else source_errors(result.source, case)
            sources[name].append(float(np.mean(np.square(told))))
            sizes[name].append(size_error(shown[name], case))
            sharp[name].append(size_error(shown[name], case, smooth=0.0))
            distances[name].append(100 * hole_distance(shown[name], case))
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            shown["truth"] = case.picture
            sheet = contact_sheet(list(shown.values()), columns=len(shown), labels=list(shown))
            save_image(sheet, pictures / f"completion-{number}.png")
    measures = {
        "log scale error of sources": ({name: float(np.mean(each)) ** 0.5 for name, each in sources.items()}, SHARE),
        "log size error": ({name: float(np.mean(each)) ** 0.5 for name, each in sizes.items()}, SHARE),
        "log size error with sharpness": ({name: float(np.mean(each)) ** 0.5 for name, each in sharp.items()}, None),
        "seconds": (seconds, None),
        "patch distance x 100": ({name: float(np.mean(each)) for name, each in distances.items()}, None),
    }
    for measure, (values, share) in measures.items():
        mine = values.pop("graphtex")
        yield Figure(f"{measure} in {len(found)} holes", mine)
        for name, other in values.items():
            bound = "" if share is None or name == "the truth" else f"<= {share * other:.4g}"
            yield Figure(f"{measure}, beside {name}'s", mine, bound, other)


def cases(first: int = 30, count: int = 10) -> list[Case]:
    """Holes of five shapes in three kinds of planes with slants of 50 to 60 degrees; seeds from ``first`` on.

    They hold many elements of a wide range of sizes; two shapes leave little or nothing beside them at equal scale, and
    one of these lies where elements are largest.
    """
    result = []
    for number in range(count):
        kind, size, turned = ((pebbles, 12.0, False), (woven_cloth, 8.0, False), (bricks, 24.0, True))[number % 3]
        views = []
        for seed in [first + number, *(1000 * (other + 1) + first + number for other in range(OTHERS))]:
            slant, tilt = 50.0 + 5 * (number // 2 % 3), 90.0 * turned
            made = kind(width=SIDE, height=SIDE, size=size, slant=slant, tilt=tilt, rng=seed)
            picture, scale = made.image, made.scale
            if turned:  # the plane recedes to the right: turned, its far side is up
                picture, scale = (np.ascontiguousarray(np.swapaxes(each, 0, 1)[::-1]) for each in (picture, scale))
            views.append(picture)
        result.append(Case(views[0], scale, shape(number % 5), views[1:]))
    return result


def shape(number: int) -> Array:
    """Hole (side, side): winding and long, broad, at the near border, slanting and long, in the near corner."""
    y, x = np.mgrid[:SIDE, :SIDE]
    shapes = (
        (np.abs(x - 160 - 20 * np.sin(y / 40)) <= 44) & (y >= 50) & (y <= 285),
        np.hypot((y - 160) / 70, (x - 160) / 130) <= 1,
        (y >= 225) & (np.abs(x - 170) <= 110),
        (np.abs(x - 160 + 0.6 * (y - 160)) <= 45) & (y >= 45) & (y <= 265),
        (y >= 190) & (x >= 140),
    )
    return np.asarray(shapes[number])


def source_errors(source: Array, case: Case) -> Array:
    """Log of the size of what each pixel of the hole shows over the size that belongs there, by a source map."""
    row, column = (np.rint(source[case.hole][:, channel]).astype(int) for channel in (1, 2))
    shown = np.log(case.scale[row, column]) + np.log(2) * source[case.hole][:, 3]
    errors: Array = shown - np.log(case.scale[case.hole])
    return errors


def traced_errors(picture: Array, case: Case) -> Array:
    """The same of a tool that has no source map: where windows of the hole were copied from is told by their looks.

    The known window most like one of the hole is taken for its source. That finds pure copies (of those of
    ExemplarInpaint, whose source map tells, it makes errors a seventh larger); what is enlarged has no such window.
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
    errors: Array = log_scale[known][nearest] - log_scale[inside]
    return errors


def size_error(picture: Array, case: Case, smooth: float = SMOOTH) -> float:
    """Mean square error of the log of element sizes in bands of the hole, all channels alike.

    What is right are the sizes in the same pixels of other pictures of the plane, whose quantiles count too. Detail of
    less than ``smooth`` pixels is taken away first: with it the truth moved by half a pixel, which interpolation blurs,
    would be judged worse than elements of wrong sizes. Too large and too small elements in one band make up for each
    other, and pebbles a quarter larger are found an eighth larger: this sees less than the sources.
    """
    from scipy.ndimage import gaussian_filter

    shown, *others = (gaussian_filter(each, (smooth, smooth, 0)) for each in (picture, *case.others))
    errors = []
    for band in np.array_split(np.flatnonzero(case.hole.any(axis=1)), BANDS):
        inside = case.hole[band]
        levels = np.quantile(np.concatenate([other[band] for other in others], axis=1), LEVELS, axis=1)[:, :, None]
        wanted = np.mean([np.log(element_size(other[band], inside, levels)) for other in others])
        errors.append(min(WORST, abs(np.log(element_size(shown[band], inside, levels)) - wanted)))
    return float(np.mean(np.square(errors)))


def element_size(rows: Array, inside: Array, levels: Array) -> float:
    """Geometric mean of the pixels between crossings of the levels (k, h, 1, c) along and across rows (h, w, c).

    Infinite where there are none along one of them.
    """
    result = 1.0
    for one, other in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        both = inside[one] & inside[other]
        above = [rows > level for level in levels]
        crossings = sum(int((each[one] != each[other])[both].sum()) for each in above)
        result *= int(both.sum()) * rows.shape[2] * len(levels) / crossings if crossings else float("inf")
    return float(np.sqrt(result))


def hole_distance(picture: Array, case: Case) -> float:
    """Patch distance of the hole's box to the same box of the truth: blur costs here, where it would pay in PSNR."""
    rows, columns = (np.flatnonzero(case.hole.any(axis=axis)) for axis in (1, 0))
    box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    return patch_distance(picture[box], case.picture[box])
