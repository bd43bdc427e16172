"""Photographs whose element sizes were measured by hand: the judge that no generator of this project has made."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure
from benchmarks.size_spectra import relative_slope
from graphtex import Context
from graphtex_nodes import (
    contact_sheet,
    estimate_angles,
    load_image,
    optimize,
    resize_scale,
    scale_from_angles,
)
from graphtex_nodes.image.save import save_image
from graphtex_nodes.numerics.measures import source_scale_correlation

Array = NDArray[Any]

SEEDS = (0, 1, 2)
SURE = 0.3  # confidence of EstimateAngles below which it warns, and a user would measure sizes instead


@dataclass(frozen=True)
class Marks:
    """A file, the part of it that shows one texture, and sizes that were measured at rows of the file.

    `receding` tells that sizes were measured in the direction in which the plane recedes, where they go as its scale
    squared; `spectra` whether the elements rule the spectra of that direction, which then tell their sizes.
    """

    file: str
    left: int
    top: int
    right: int
    bottom: int
    sizes: dict[int, float]
    receding: bool = False
    spectra: bool = True

    def picture(self, folder: Path) -> Array:
        """Return the part of the file that shows the texture."""
        whole = load_image(path=folder / self.file)
        return np.ascontiguousarray(whole[self.top : self.bottom, self.left : self.right, :3])

    def across(self) -> Array:
        """Return sizes, or what goes with the scale as sizes across the receding direction do."""
        sizes = np.array(list(self.sizes.values()), np.float64)
        return np.sqrt(sizes) if self.receding else sizes

    def scale(self) -> Array:
        """Scale map by the marks: a straight line through them, as on a plane; its ends multiply to 1."""
        slope, level = np.polyfit(list(self.sizes), self.across(), 1)
        line = slope * np.arange(self.top, self.bottom) + level
        line = line / np.sqrt(line[0] * line[-1])
        return np.repeat(line[:, None], self.right - self.left, axis=1).astype(np.float32)


MARKED = {
    # widths of bricks, from 12 to 15 of them at each row
    "brick floor": Marks("perspective-brickfloor.png", 0, 0, 512, 512, {5: 29.7, 256: 35.5, 500: 41.7}),
    # widths of pavers, the mean of 6 to 14 of them between joints at each row (of 3 to 5 light ones at the first three)
    "paving": Marks(
        "perspective-brickplane-synthetic.png", 96, 120, 416, 512,
        {30: 18.2, 62: 21.6, 98: 26.0, 139: 30.6, 151: 32.0, 165: 33.6, 180: 35.4, 196: 37.0, 215: 39.2, 235: 41.4,
         258: 44.0, 283: 46.5, 313: 49.3, 345: 52.8, 383: 57.4, 430: 62.6, 480: 67.3},
    ),
    # thickness of planks from joint to joint, down the column 100
    "deck": Marks(
        "perspective-deckwater.jpg", 0, 316, 400, 560,
        {303: 12.9, 317: 14.3, 331: 14.6, 347: 17.1, 364: 16.1, 381: 19.3, 401: 20.7, 424: 24.3, 450: 27.9, 475: 22.5,
         500: 26.4, 531: 37.0},
        receding=True,
    ),
    # the pier's width between its rails
    "pier": Marks("perspective-pier.jpg", 415, 430, 605, 683, {450: 267, 563: 533, 677: 753}, spectra=False),
    # widths of flowers, about ten at each row; shadows of trees rule the spectrum of rows
    "anemones": Marks(
        "perspective-anemones.jpg", 0, 95, 512, 307, {78: 2.3, 122: 3.0, 170: 3.7, 215: 5.3, 262: 7.0},
        spectra=False,
    ),
}  # fmt: skip


def figures(pictures: Path | None, textures: Path) -> Iterator[Figure]:
    """Judge syntheses by the marks; where the angles are not sure, the marks guide them too."""
    for name, marks in MARKED.items():
        if not (textures / marks.file).is_file():
            print(f"{name}: {marks.file} is not in {textures}: passed over", file=sys.stderr)
            continue
        yield from judged(name, marks.picture(textures), marks, pictures)


def judged(name: str, exemplar: Array, marks: Marks, pictures: Path | None) -> Iterator[Figure]:
    """Range of the scale found, and slope and source scale of results against the marks."""
    told: list[str] = []
    angles = estimate_angles(exemplar, ctx=Context(on_warning=told.append))  # the confidence is a figure below
    measured, true = scale_from_angles(exemplar, slant=angles.slant, tilt=angles.tilt), marks.scale()
    found, guide = (measured, "by itself") if angles.confidence >= SURE else (true, "given the marks")
    width, height = 2 * exemplar.shape[1], 2 * exemplar.shape[0]
    wanted, truth = (resize_scale(scale, width=width, height=height) for scale in (found, true))
    ranges = [float(np.log(scale[0].mean() / scale[-1].mean())) for scale in (measured, true)]
    yield Figure(f"{name}: log range of scale found (reference: marked by hand)", ranges[0], "", ranges[1])
    yield Figure(f"{name}: confidence of EstimateAngles", angles.confidence)
    guided = [optimize(exemplar, found, wanted, rng=seed) for seed in SEEDS]
    plain = [optimize(exemplar, width=width, height=height, scale_weight=0.0, rng=seed) for seed in SEEDS]
    if marks.spectra:
        for label, results, bound in (("result", guided, ">= 0.9"), ("plain optimisation", plain, "<= 0.2")):
            slopes = [
                relative_slope(result.image, truth, exemplar, true, receding=marks.receding) for result in results
            ]
            yield Figure(f"{name}, {guide}: slope of {label} over the exemplar's", float(np.mean(slopes)), bound, 1.0)
    correlations = [
        float(np.mean([source_scale_correlation(result.source, [true], truth) for result in results]))
        for results in (guided, plain)
    ]
    yield Figure(
        f"{name}, {guide}: correlation of marked scale and source's", correlations[0], ">= 0.95", correlations[1]
    )
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        shown = {"exemplar": exemplar, "result": guided[0].image, "plain": plain[0].image}
        sheet = contact_sheet(list(shown.values()), columns=3, labels=list(shown))
        save_image(sheet, pictures / f"marked-{name.replace(' ', '-')}.png")
