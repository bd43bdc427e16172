"""Plain synthesis (no scales) beside other tools, judged from the pictures alone."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks import peers
from benchmarks.figures import Figure
from benchmarks.likeness import likeness
from graphtex_nodes import bricks, contact_sheet, flowers, load_image, optimize, pebbles, sample, sand, woven_cloth
from graphtex_nodes.image.save import save_image
from graphtex_nodes.numerics.measures import patch_distance

Array = NDArray[Any]

CROP = 256
OUTPUT = 512
SEED = 1
GENERATED: dict[str, Any] = {
    "pebbles": pebbles, "bricks": bricks, "flowers": flowers, "cloth": woven_cloth, "sand": sand,
}  # fmt: skip
SAMPLES = ("brick", "grass", "gravel")
SUFFIXES = {".png", ".jpg", ".jpeg", ".tif", ".tiff"}
COHERENCE, COVERAGE = 0.9, 0.8
WINS = 10 / 12  # share of textures on which a peer's patch distance should be undercut


@dataclass(frozen=True)
class Score:
    """A tool's result on one texture."""

    image: Array
    distance: float
    coherence: float
    coverage: float


def figures(pictures: Path | None, textures: Path | None = None) -> Iterator[Figure]:
    """Compare on crops of generated exemplars and samples, or of all pictures in a folder."""
    tools = peers.synthesisers()
    if not tools:
        print("G'MIC is not installed (pip install 'graphtex[bench]'): no peer to compare with", file=sys.stderr)
    wins = dict.fromkeys(tools, 0)
    chosen = exemplars(textures)
    for name, exemplar in chosen.items():
        ours = judged(optimize(exemplar, width=OUTPUT, height=OUTPUT, rng=SEED).image, exemplar)
        others = {tool: judged(run(exemplar, (OUTPUT, OUTPUT), SEED), exemplar) for tool, run in tools.items()}
        best = min(others.values(), key=lambda score: score.distance, default=None)
        yield Figure(
            f"{name}: patch distance x 100",
            100 * ours.distance,
            "" if best is None else f"<= {100 * best.distance:.4g}",
            None if best is None else 100 * best.distance,
        )
        yield Figure(f"{name}: coherence", ours.coherence, f"<= {COHERENCE}", None if best is None else best.coherence)
        yield Figure(f"{name}: coverage", ours.coverage, f">= {COVERAGE}", None if best is None else best.coverage)
        for tool, score in others.items():
            wins[tool] += ours.distance < score.distance
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            shown = {"exemplar": exemplar, "graphtex": ours.image, **{tool: s.image for tool, s in others.items()}}
            sheet = contact_sheet(list(shown.values()), columns=len(shown), labels=list(shown))
            save_image(sheet, pictures / f"plain-{name}.png")
    for tool, count in wins.items():
        yield Figure(f"share of textures closer to the exemplar than {tool}'s", count / len(chosen), f">= {WINS:.3f}")


def judged(image: Array, exemplar: Array) -> Score:
    """Measure a result by nothing but the pictures."""
    found = likeness(image, exemplar)
    return Score(image, patch_distance(image, exemplar), found.coherence, found.coverage)


def exemplars(folder: Path | None) -> dict[str, Array]:
    """Pictures of 256 x 256 pixels by name: those of a folder, or without one what everyone has."""
    if folder is None:
        made = {name: kind(width=CROP, height=CROP, rng=SEED).image for name, kind in GENERATED.items()}
        return made | {name: crop(sample(name=name)) for name in SAMPLES}
    files = sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES)
    if not files:
        raise ValueError(f"textures: expected pictures ({', '.join(sorted(SUFFIXES))}) in {folder}, got none")
    return {path.stem: crop(load_image(path=path)[..., :3]) for path in files}


def crop(picture: Array) -> Array:
    """The middle 256 x 256 pixels (less of a smaller picture), halved before while no side gets below that."""
    while min(picture.shape[:2]) >= 2 * CROP:
        height, width = (n // 2 * 2 for n in picture.shape[:2])
        picture = picture[:height, :width].reshape(height // 2, 2, width // 2, 2, -1).mean(axis=(1, 3))
    top, left = (max(0, (n - CROP) // 2) for n in picture.shape[:2])
    return np.ascontiguousarray(picture[top : top + CROP, left : left + CROP])
