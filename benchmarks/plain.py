"""Plain synthesis (no scales) beside other tools, judged from the pictures alone.

Coherence tells of long copies where an exemplar's parts differ. Where elements are alike and lie apart on plain ground
it is high for any tool that keeps them whole. The exemplar's own coherence is printed beside it: that of one half of it
as made from the other, of which neither is a copy. It changes no bound. Of walls, paving and cloth it is told how far
they stay in step over the whole output.
"""

import statistics
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import peers
from benchmarks.figures import Figure
from benchmarks.likeness import likeness
from benchmarks.regularity import order, regular
from graphtex_nodes import bricks, contact_sheet, flowers, load_image, optimize, pebbles, sample, sand, woven_cloth
from graphtex_nodes.image.save import save_image
from graphtex_nodes.numerics.measures import patch_distance

Array = NDArray[Any]

CROP = 256
OUTPUT = 512
SEED = 1  # of generated exemplars
SEEDS = (1, 2, 3)  # of outputs; medians over them are judged, and the worst of them for a collapse
GENERATED: dict[str, Any] = {
    "pebbles": pebbles, "bricks": bricks, "flowers": flowers, "cloth": woven_cloth, "sand": sand,
}  # fmt: skip
SAMPLES = ("brick", "grass", "gravel")
SUFFIXES = {".png", ".jpg", ".jpeg", ".tif", ".tiff"}
COHERENCE, COVERAGE = 0.9, 0.8
MASK_VALUES = 2
ORDER = 0.75  # pieces that begin at random have 0.2 to 0.8
COLLAPSED = 0.5  # coverage: an output that shows less than half of its exemplar repeats some parts all over
WINS = 10 / 12  # share of textures on which a peer's patch distance should be undercut


@dataclass(frozen=True)
class Score:
    """A tool's result on one texture: the picture, medians over seeds, and the lowest coverage of them."""

    image: Array
    distance: float
    coherence: float
    coverage: float
    worst: float


def figures(pictures: Path | None, textures: Path | None = None) -> Iterator[Figure]:
    """Compare on crops of generated exemplars and samples, or of all pictures in a folder."""
    tools = peers.synthesisers()
    if not tools:
        print("G'MIC is not installed (pip install 'graphtex[bench]'): no peer to compare with", file=sys.stderr)
    ours: list[Score] = []
    theirs: dict[str, list[Score]] = {tool: [] for tool in tools}
    chosen = exemplars(textures)
    for name, exemplar in chosen.items():
        ours.append(
            typical(judged(optimize(exemplar, width=OUTPUT, height=OUTPUT, rng=s).image, exemplar) for s in SEEDS)
        )
        for tool, run in tools.items():
            theirs[tool].append(typical(judged(run(exemplar, (OUTPUT, OUTPUT), s), exemplar) for s in SEEDS))
        yield from compared(name, own_coherence(exemplar), ours[-1], [scores[-1] for scores in theirs.values()])
        yield from in_order(name, exemplar, ours[-1].image, [scores[-1].image for scores in theirs.values()])
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            others = {tool: scores[-1].image for tool, scores in theirs.items()}
            shown = {"exemplar": exemplar, "graphtex": ours[-1].image, **others}
            sheet = contact_sheet(list(shown.values()), columns=len(shown), labels=list(shown))
            save_image(sheet, pictures / f"plain-{name}.png")
    yield from summary(ours, theirs)


def compared(name: str, own: float, ours: Score, others: Sequence[Score]) -> Iterator[Figure]:
    """Figures of one texture with its own coherence, beside the tool that comes closest."""
    best = min(others, key=lambda score: score.distance, default=None)
    reference = None if best is None else 100 * best.distance
    bound = "" if reference is None else f"<= {reference:.4g}"
    yield Figure(f"{name}: patch distance x 100", 100 * ours.distance, bound, reference)
    yield Figure(f"{name}: coherence", ours.coherence, f"<= {COHERENCE}", None if best is None else best.coherence)
    yield Figure(f"{name}: coherence of the exemplar's halves", own)
    yield Figure(f"{name}: coverage", ours.coverage, f">= {COVERAGE}", None if best is None else best.coverage)


def in_order(name: str, exemplar: Array, ours: Array, others: Sequence[Array]) -> Iterator[Figure]:
    """How far pictures keep to the lattice or rows of a regular exemplar, beside the best of other tools."""
    found = regular(exemplar)
    if found is not None:
        own = order(exemplar, found)
        best = max((order(image, found) for image in others), default=None)
        label = f"{name}: autocorrelation at repeats over the exemplar's"
        yield Figure(label, order(ours, found) / own, f">= {ORDER}", None if best is None else best / own)


def summary(ours: Sequence[Score], theirs: Mapping[str, Sequence[Score]]) -> Iterator[Figure]:
    """Counts and worst figures over all textures."""
    count = len(ours)
    for tool, scores in theirs.items():
        wins = sum(own.distance < other.distance for own, other in zip(ours, scores, strict=True))
        yield Figure(f"share of {count} textures closer to the exemplar than {tool}'s", wins / count, f">= {WINS:.3f}")
        both = sum(
            own.distance < other.distance and own.coherence <= COHERENCE
            for own, other in zip(ours, scores, strict=True)
        )
        label = f"share of textures closer than {tool}'s with coherence <= {COHERENCE}"
        yield Figure(label, both / count, f">= {WINS:.3f}")
    everyone = {"graphtex": ours, **theirs}
    for tool, scores in everyone.items():
        bounded = tool == "graphtex"
        coherent = sum(score.coherence <= COHERENCE for score in scores) / count
        yield Figure(f"{tool}: share of textures with coherence <= {COHERENCE}", coherent)
        yield Figure(f"{tool}: highest coherence", max(score.coherence for score in scores))
        covered = sum(score.coverage >= COVERAGE for score in scores) / count
        yield Figure(f"{tool}: share of textures with coverage >= {COVERAGE}", covered, ">= 1" if bounded else "")
        yield Figure(f"{tool}: lowest coverage", min(score.coverage for score in scores))
        lost = sum(score.worst < COLLAPSED for score in scores)
        yield Figure(f"{tool}: textures that collapsed with some seed", lost, "<= 0" if bounded else "")


def judged(image: Array, exemplar: Array) -> Score:
    """Measure a result by nothing but the pictures."""
    found = likeness(image, exemplar)
    return Score(image, patch_distance(image, exemplar), found.coherence, found.coverage, found.coverage)


def own_coherence(exemplar: Array) -> float:
    """Highest coherence of one half of an exemplar, left, right, upper or lower, as made from the other one."""
    pairs = [np.array_split(exemplar, 2, axis) for axis in (0, 1)]
    return max(likeness(*each).coherence for one, other in pairs for each in ((one, other), (other, one)))


def typical(scores: Iterable[Score]) -> Score:
    """Medians of several results on one texture; the picture is that of the median distance."""
    ordered = sorted(scores, key=lambda score: score.distance)
    middle = ordered[len(ordered) // 2]
    coherence, coverage = (
        statistics.median(values) for values in zip(*((s.coherence, s.coverage) for s in ordered), strict=True)
    )
    return Score(middle.image, middle.distance, coherence, coverage, min(score.worst for score in ordered))


def exemplars(folder: Path | None) -> dict[str, Array]:
    """Pictures of 256 x 256 pixels by name: those of a folder, or without one what everyone has.

    Pictures of two values are left out: they are masks that lie beside photographs, of a hole or an object, and hold no
    texture to be like.
    """
    if folder is None:
        made = {name: kind(width=CROP, height=CROP, rng=SEED).image for name, kind in GENERATED.items()}
        return made | {name: crop(sample(name=name)) for name in SAMPLES}
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    loaded = {path.stem: load_image(path=path)[..., :3] for path in files}
    found = {name: crop(picture) for name, picture in loaded.items() if len(np.unique(picture)) > MASK_VALUES}
    if not found:
        raise ValueError(f"textures: expected pictures ({', '.join(sorted(SUFFIXES))}) in {folder}, got none")
    return found


def crop(picture: Array) -> Array:
    """The middle 256 x 256 pixels (less of a smaller picture), halved before while no side gets below that."""
    while min(picture.shape[:2]) >= 2 * CROP:
        height, width = (n // 2 * 2 for n in picture.shape[:2])
        picture = picture[:height, :width].reshape(height // 2, 2, width // 2, 2, -1).mean(axis=(1, 3))
    top, left = (max(0, (n - CROP) // 2) for n in picture.shape[:2])
    return np.ascontiguousarray(picture[top : top + CROP, left : left + CROP])
