"""Perspective-aware synthesis on generated planes, whose true texel scale is known."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import spearmanr

import graphtex as gt
from benchmarks.figures import Figure
from graphtex.document import Output
from graphtex_nodes import (
    bricks,
    contact_sheet,
    feature_mask,
    feature_scale,
    flowers,
    pebbles,
    resize_scale,
)
from graphtex_nodes.image.save import save_image
from graphtex_nodes.numerics.measures import patch_distance, scale_slope, source_scale_correlation

GRAPH = Path(__file__).parent.parent / "graphs" / "perspective" / "feature-mask.yaml"
KINDS: dict[str, Any] = {"pebbles": pebbles, "bricks": bricks, "flowers": flowers}
POSES = [(30.0, 0.0), (45.0, 20.0), (50.0, -40.0), (60.0, 0.0)]
SEED = 20


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Measure the analysis on many poses, and the shipped graph on one pose of each kind."""
    yield from analysis()
    for name, kind in KINDS.items():
        yield from synthesis(name, kind, pictures)


def analysis() -> Iterator[Figure]:
    """Rank correlation of FeatureScale with the truth; asked for from slant 45 up."""
    for name, kind in KINDS.items():
        for slant, tilt in POSES:
            exemplar = kind(slant=slant, tilt=tilt, rng=SEED)
            found = feature_scale(feature_mask(exemplar.image))
            rank = float(spearmanr(found.ravel(), exemplar.scale.ravel()).statistic)
            yield Figure(
                f"FeatureScale, {name} at {slant:g}, tilt {tilt:g}: Spearman", rank, ">= 0.93" if slant >= 45 else ""
            )


def synthesis(name: str, kind: Any, pictures: Path | None) -> Iterator[Figure]:
    """Slope of element size against the true scale, in the exemplar, the result and plain optimisation."""
    exemplar = kind(slant=55.0, rng=SEED)
    truth = resize_scale(exemplar.scale, width=512, height=512)
    plan = gt.load(GRAPH)
    plan.outputs.clear()
    for socket in ("image", "source", "coverage", "coherence"):
        plan.outputs[socket] = Output(f"result.{socket}")
    plan.outputs["plain"] = Output("plain.image")
    result = gt.run(plan, {"exemplar": exemplar.image}, cache=False)
    own = scale_slope(exemplar.image, exemplar.scale)
    yield Figure(
        f"{name}: slope of the result over the exemplar's", scale_slope(result["image"], truth) / own, ">= 0.8", 1.0
    )
    yield Figure(
        f"{name}: slope of plain optimisation over the exemplar's",
        scale_slope(result["plain"], truth) / own,
        "<= 0.2",
        1.0,
    )
    correlation = source_scale_correlation(result["source"], [exemplar.scale], truth)
    yield Figure(f"{name}: correlation of wanted scale and source's", correlation, ">= 0.9")
    yield Figure(f"{name}: coverage", result["coverage"], ">= 0.7")
    yield Figure(f"{name}: coherence", result["coherence"])
    distance = patch_distance(result["image"], exemplar.image)
    yield Figure(f"{name}: patch distance", distance, "", patch_distance(result["plain"], exemplar.image))
    if pictures is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        sheet = contact_sheet(
            [np.asarray(exemplar.image), result["image"], result["plain"]],
            columns=3,
            labels=["exemplar", "result", "plain"],
        )
        save_image(sheet, pictures / f"perspective-{name}.png")
