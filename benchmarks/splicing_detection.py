"""Elements found and cut out of generated textures, whose truth is known."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure, in_turns
from graphtex_nodes import contact_sheet, draw_elements, find_textons, separate_foreground, textons
from graphtex_nodes.image.save import save_image
from graphtex_nodes.splicing._agreement import agreement, central
from graphtex_nodes.splicing._automatic import TRIED
from graphtex_nodes.splicing._partitions import even_and_small, partitions
from graphtex_nodes.splicing._proposals import proposals
from graphtex_nodes.splicing._templates import Example

Array = NDArray[Any]

SEEDS = (1, 2)
NOISE, DARKEST = 0.02, 0.5
TEXTURES = {
    "square": partial(textons, jitter=0.1),
    "hexagonal": partial(textons, form="flower", arrangement="hexagonal", jitter=0.1),
    "random": partial(textons, form="leaf", size=34.0, arrangement="random", spacing=0.9),
    "two kinds": partial(textons, form="flower", other="disc", arrangement="hexagonal", jitter=0.08),
    "touching": partial(textons, arrangement="hexagonal", spacing=0.97, jitter=0.03),
    "bricks": partial(textons, form="tile", size=44.0, arrangement="brick", spacing=1.12, proportion=0.45),
}
TURNED = partial(textons, form="leaf", size=34.0, arrangement="random", turn=180.0, growth=1.25, spacing=1.0)


def figures(pictures: Path | None) -> Iterator[Figure]:
    """F1 of the elements, overlap of the foreground, and errors of angle and scale."""
    right = []
    for name, make in TEXTURES.items():
        size = make.keywords.get("size", 28.0)
        given, automatic, overlaps, alone_overlaps = [], [], [], []
        for seed in SEEDS:
            made = make(rng=seed)
            found = find_textons(made.image, examples=examples(made, 2 if name == "two kinds" else 1))
            given.append(agreement(found.points, made, size)[0])
            alone = find_textons(made.image)
            automatic.append(agreement(alone.points, made, size)[0])
            overlaps.append(foregrounds(made, found))
            alone_overlaps.append(min(foregrounds(made, alone).values()))
        yield Figure(f"{name}: least F1 with a given element", min(given), ">= 0.98")
        yield Figure(f"{name}: least F1 of automatic detection", min(automatic))
        right.append(min(automatic) >= 0.9)
        for kind in overlaps[0]:
            yield Figure(f"{name}: least foreground IoU, {kind}", min(each[kind] for each in overlaps), ">= 0.9")
        yield Figure(f"{name}: least foreground IoU of automatic detection", min(alone_overlaps), ">= 0.9")
        if pictures is not None:
            save(pictures / f"detection-{name.replace(' ', '-')}.png", made, found, alone)
    yield Figure("textures with automatic F1 >= 0.9", float(sum(right)), ">= 4")
    yield from turned()
    yield from speed()


def foregrounds(made: Any, found: Any) -> dict[str, float]:
    """Overlap (IoU) of the automatic foreground with the truth, clean, with noise, and under a ramp of light."""
    shades = np.linspace(DARKEST, 1, made.image.shape[1], dtype=np.float32)[None, :, None]
    noise = np.random.default_rng(1).normal(0, NOISE, made.image.shape).astype(np.float32)
    spoiled = {"clean": made.image, "2 % noise": np.clip(made.image + noise, 0, 1), "ramp": made.image * shades}
    overlaps = {}
    for kind, image in spoiled.items():
        try:
            cut = separate_foreground(image, found.elements, width=found.width, height=found.height)
        except ValueError:  # a refusal is a miss
            overlaps[kind] = 0.0
            continue
        overlaps[kind] = float((cut.mask & made.mask).sum()) / float((cut.mask | made.mask).sum())
    return overlaps


def turned() -> Iterator[Figure]:
    """Largest errors over the elements that are whole in the picture."""
    shares, angles, scales = [], [0.0], [0.0]
    for seed in SEEDS:
        made = TURNED(rng=seed)
        index, example = central(made)
        found = find_textons(made.image, examples=[example], turn=180.0, growth=1.6)
        share, which, true = agreement(found.elements.points, made, 34.0)
        middle = (np.array(made.mask.shape[::-1]) - 1) / 2
        whole = (np.abs(made.centres[true] - middle) < middle - 22).all(axis=1)
        which, true = which[whole], true[whole]
        off = found.elements.angles[which] - (made.elements.angles[true] - made.elements.angles[index])
        sizes = found.elements.scales[which] * made.elements.scales[index] / made.elements.scales[true]
        shares.append(share)
        angles.append(float(np.abs((off + 180) % 360 - 180).max()))
        scales.append(float(np.abs(sizes - 1).max()))
    yield Figure("turned and sized: least F1 with a given element", min(shares), ">= 0.98")
    yield Figure("turned and sized: largest error of an angle, degrees", max(angles), "<= 8")
    yield Figure("turned and sized: largest error of a scale", max(scales), "<= 0.1")


def speed() -> Iterator[Figure]:
    """Seconds a picture of 128 x 128; compared with a careful search of each guess."""
    pictures = [
        make(width=128, height=128, size=make.keywords.get("size", 28.0) / 2, rng=3) for make in TEXTURES.values()
    ]

    def search() -> None:
        for made in pictures:
            find_textons(made.image)

    def careful() -> None:
        for made in pictures:
            even = even_and_small(made.image)
            for guess in proposals(even, partitions(even))[:TRIED]:
                find_textons(made.image, examples=[guess.example])

    def cut() -> None:
        for made, found in zip(pictures, elements, strict=True):
            separate_foreground(made.image, found.elements, width=found.width, height=found.height)

    elements = [find_textons(made.image) for made in pictures]
    automatic, every, ground = (each / len(pictures) for each in in_turns(search, careful, cut, repeat=3))
    yield Figure("128 x 128: automatic detection, s; reference every guess with care", automatic, "", every)
    yield Figure("128 x 128: automatic detection, time over that of every guess with care", automatic / every, "<= 0.6")
    yield Figure("128 x 128: foreground, s", ground)


def examples(made: Any, kinds: int) -> list[Example]:
    """One element of each kind."""
    index, first = central(made)
    return [first] if kinds == 1 else [first, central(made, index)[1]]


def save(path: Path, made: Any, found: Any, alone: Any) -> None:
    """The texture, what was found with an element given, and what without."""
    path.parent.mkdir(parents=True, exist_ok=True)
    drawn = [draw_elements(made.image, each.elements, width=each.width, height=each.height) for each in (found, alone)]
    save_image(contact_sheet([made.image, *drawn], columns=3, labels=["texture", "given", "automatic"]), path)
