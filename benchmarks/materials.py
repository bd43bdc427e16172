"""Textures that tile, material maps and their replay, and grain that follows a field of directions."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure
from benchmarks.perspective import mean, write
from benchmarks.plain import exemplars
from graphtex_nodes import (
    flow_from_image,
    flow_pattern,
    image_from_angles,
    optimize,
    replay,
    sample,
    sand,
    split_maps,
    stack_maps,
)
from graphtex_nodes.numerics.materials import MapKind
from graphtex_nodes.numerics.measures import seam_energy
from graphtex_nodes.numerics.orientation import orientation_error
from graphtex_nodes.numerics.pyramid import halve

Array = NDArray[Any]

Sides = Literal["both", "none"]
TILES = ((192, 192), (173, 211))  # even sizes and odd ones
KINDS: list[MapKind] = ["colour", "normal", "scalar"]
FLOW = 384
SEED = 1


def figures(pictures: Path | None, textures: Path | None = None) -> Iterator[Figure]:
    """Measure tiles of generated exemplars and samples, or of a folder's pictures; the rest on generated ones."""
    yield from tiles(exemplars(textures), pictures)
    yield from maps(pictures)
    yield from flow(pictures)


def tiles(chosen: dict[str, Array], pictures: Path | None) -> Iterator[Figure]:
    """Energy of the step over the border, on both sides and two sizes; reference: an output that does not tile."""
    ranks: list[float] = []
    others: list[float] = []
    for name, exemplar in chosen.items():
        excess: dict[Sides, list[float]] = {"both": [], "none": []}
        for height, width in TILES:
            for sides, found in excess.items():
                image = optimize(exemplar, width=width, height=height, tileable=sides, rng=SEED).image
                measured = [seam_energy(image, axis) for axis in (0, 1)]
                (ranks if sides == "both" else others).extend(rank for rank, _ in measured)
                found.extend(ratio for _, ratio in measured)
                if sides == "both":
                    write({name: exemplar, "tiled": np.tile(image, (2, 2, 1))}, pictures, f"tile-{name}-{width}.png")
        yield Figure(
            f"{name}: largest energy of a seam over the largest of a step inside",
            max(excess["both"]),
            "<= 1",
            max(excess["none"]),
        )
    yield Figure("mean rank of seams among the steps inside (0.5 = no seam)", mean(ranks), "<= 0.7", mean(others))


def maps(pictures: Path | None) -> Iterator[Figure]:
    """Normals' length, and what a replay of the source map makes of the maps one by one and of larger ones."""
    large = [sample(name=f"bricks{kind}") for kind in ("", "-normal", "-height")]
    stack = stack_maps([halve(each) for each in large[:1]] + [unit(halve(large[1])), halve(large[2])], kinds=KINDS)
    for mirror in (False, True):
        label = "with mirrored copies" if mirror else "plain"
        known, ignorant = (optimize(stack, kinds=kinds, mirror=mirror, rng=SEED) for kinds in (KINDS, []))
        yield Figure(
            f"material maps, {label}: largest error of a normal's length (reference: kinds not told)",
            longest(known.image),
            "<= 0.0101",
            longest(ignorant.image),
        )
        copied = optimize(stack, kinds=KINDS, mirror=mirror, vote="discrete", rng=SEED)
        again = [
            replay(copied.source, [part], kinds=[kind])
            for part, kind in zip(split_maps(stack, kinds=KINDS), KINDS, strict=True)
        ]
        apart = float(np.abs(np.concatenate(again, axis=2) - copied.image).max())
        yield Figure(f"material maps, {label}: largest difference of the replay of each map", apart, "<= 0")
    result = optimize(stack, kinds=KINDS, vote="discrete", rng=SEED)
    twice = replay(result.source, [large[2]], factor=2.0)
    smaller = twice.reshape(twice.shape[0] // 2, 2, twice.shape[1] // 2, 2, 1).mean(axis=(1, 3))
    small = large[2].reshape(128, 2, 128, 2, 1).mean(axis=(1, 3))
    apart = float(np.abs(smaller - replay(result.source, [small])).max())
    yield Figure("maps of twice the resolution: largest difference of the replay's means", apart, "<= 1e-06")
    shown = dict(zip(("colour", "normal", "height"), split_maps(known.image, kinds=KINDS), strict=True))
    write({name: part if part.shape[2] == 3 else part.repeat(3, axis=2) for name, part in shown.items()}, pictures,
          "material-maps.png")  # fmt: skip


def unit(encoded: Array) -> Array:
    """Normals of unit length."""
    return split_maps(encoded, kinds=["normal"])[0]


def longest(stack: Array) -> float:
    """Largest error of the length of a stack's normals."""
    return float(np.abs(np.linalg.norm(stack[..., 3:6] * 2.0 - 1, axis=2) - 1).max())


def flow(pictures: Path | None) -> Iterator[Figure]:
    """Mean error of the direction of ripples against the field; reference: plain synthesis."""
    exemplar = sand(rng=11).image
    own = flow_from_image(exemplar).angle
    plain = optimize(exemplar, width=FLOW, height=FLOW, rng=SEED).image
    for pattern in ("circular", "radial", "wave"):
        field = flow_pattern(pattern=pattern, width=FLOW, height=FLOW)
        result = optimize(exemplar, exemplar_angle=own, target_angle=field, rng=SEED)
        yield Figure(
            f"flow, {pattern}: mean error of direction in degrees",
            orientation_error(result.image, field),
            "<= 12",
            orientation_error(plain, field),
        )
        yield Figure(f"flow, {pattern}: coverage", result.coverage, ">= 0.5")
        shown = {"exemplar": exemplar, "wanted": image_from_angles(field), "result": result.image}
        write(shown, pictures, f"flow-{pattern}.png")
