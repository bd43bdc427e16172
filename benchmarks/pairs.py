"""Photographs spliced in pairs, from the pictures alone and with an element given, and judged without a reference."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure
from benchmarks.splicing_warp import splice
from graphtex import Context, Gap
from graphtex_nodes import (
    align_distributions,
    contact_sheet,
    find_textons,
    judge_splice,
    load_image,
    prepare_texture,
    separate_foreground,
    shrink_image,
    texture_entry,
)
from graphtex_nodes.image.save import save_image
from graphtex_nodes.numerics.measures import patch_distance
from graphtex_nodes.splicing._templates import Example
from graphtex_nodes.splicing.prepare_texture import PreparedTexture
from graphtex_nodes.splicing.tags import Tag

Array = NDArray[Any]

SIDE = 192  # pixels of the longer side, as of entries that splicing/database makes
WINDOW = 256  # pixels of a splice's sides: of the largest elements some twenty show
CUT, FAITHFUL, MADE_UP, EMPTY, UNLIKE, BENT = 0.1, 0.85, 0.3, 0.1, 1.25, 0.35
LEAST = 8  # of twelve pairs that should be sound


@dataclass(frozen=True)
class Photograph:
    """A file, the part of it that is used (left, top, width, height; None = all), and what a user tells of it.

    The element is in pixels of that part after it is shrunk; others are up to ``growth`` times larger
    or smaller. Without one the right elements are found, as the user has seen. ``tag`` is set where another is wanted.
    """

    file: str
    part: tuple[int, int, int, int] | None = None
    element: Example | None = None
    growth: float = 1.0
    tag: Tag | None = None

    def picture(self, folder: Path) -> Array:
        """Return the part, shrunk."""
        whole = load_image(path=folder / self.file)[..., :3]
        left, top, width, height = self.part or (0, 0, whole.shape[1], whole.shape[0])
        return shrink_image(np.ascontiguousarray(whole[top : top + height, left : left + width]), longest=SIDE)


def element(x: float, y: float, width: float, height: float) -> Example:
    """Return an example."""
    return Example(x=x, y=y, width=width, height=height)


PHOTOGRAPHS = {
    "coins": Photograph("elements-coins.png"),
    "dots": Photograph("elements-dots.png"),
    "flagstones": Photograph("elements-flagstones.jpg"),
    "hexpaving": Photograph("regular-hexpaving.jpg"),
    "brickpavement": Photograph("regular-brickpavement.jpg", (0, 0, 384, 384)),
    "herringbone": Photograph("regular-herringbone.jpg", (0, 0, 256, 256), element(64, 96, 32, 24)),
    # a cloth hangs together: the pale squares may be deformed
    "checkweave": Photograph("regular-checkweave.jpg", (0, 0, 384, 384), element(121, 90, 17, 24), tag="B=c"),
    "gravel": Photograph("stochastic-gravel.png", (0, 0, 256, 256), element(131, 95, 22, 18), 2.0, "B=c"),
    "stonewall": Photograph("material-stonewall-albedo.jpg", (0, 0, 512, 512)),
    "cheese": Photograph("material-cheese-albedo.jpg", None, element(113, 81, 10, 10), 2.0),
    "bricks": Photograph("material-bricks-albedo.jpg"),
    "wool": Photograph("material-wool-albedo.jpg", (0, 0, 128, 128), element(73, 54, 20, 20), tag="B=c"),
}
# chosen before any was spliced: elements apart and packed, on lattices and on irregular arrangements
PAIRS = (
    ("coins", "hexpaving"), ("dots", "coins"), ("flagstones", "brickpavement"), ("hexpaving", "coins"),
    ("brickpavement", "dots"), ("herringbone", "hexpaving"), ("checkweave", "flagstones"), ("gravel", "dots"),
    ("stonewall", "bricks"), ("cheese", "hexpaving"), ("bricks", "stonewall"), ("wool", "checkweave"),
)  # fmt: skip


class Outcome(NamedTuple):
    """A spliced pair: shares that `JudgeSplice` tells and that of places without an element, and likeness.

    `unlike` is the patch distance of the result to the texture over that of the texture's two halves; `doubtful` what
    the tool warned of in either texture.
    """

    tag: str
    doubtful: bool
    cut: float
    fidelity: float
    holes: float
    empty: float
    unlike: float
    bent: float
    slope: float
    image: Array

    @property
    def sound(self) -> bool:
        """Whether nothing is known to be wrong: what may be deformed should not be bent out of its likeness."""
        if self.doubtful or self.holes > MADE_UP or self.empty > EMPTY:
            return False
        if self.tag == "B=c":
            return self.unlike <= UNLIKE and self.bent <= BENT
        return self.cut <= CUT and self.fidelity >= FAITHFUL


def figures(pictures: Path | None, textures: Path | None = None) -> Iterator[Figure]:
    """Judge the pairs of a folder's pictures, found without help and with what a user would tell."""
    if textures is None:
        print("pairs: expected --textures, a folder of photographs: nothing is measured", file=sys.stderr)
        return
    missing = sorted({each.file for each in PHOTOGRAPHS.values() if not (textures / each.file).is_file()})
    if missing:
        print(f"pairs: {', '.join(missing)} not in {textures}: nothing is measured", file=sys.stderr)
        return
    images = {name: photograph.picture(textures) for name, photograph in PHOTOGRAPHS.items()}
    for mode, given in (("by itself", False), ("helped", True)):
        entries = {name: entry(name, image, given) for name, image in images.items()}
        outcomes = {
            pair: spliced(own[0], goal[0], own[1] or goal[1])
            for pair in PAIRS
            if (own := entries[pair[0]]) is not None and (goal := entries[pair[1]]) is not None
        }
        for (one, other), outcome in outcomes.items():
            for measure in ("cut", "fidelity", "holes", "empty", "unlike", "bent", "slope"):
                yield Figure(f"{one} as {other}, {mode}: {measure}", getattr(outcome, measure))
        sound = sum(outcome.sound for outcome in outcomes.values())
        yield Figure(f"{mode}: sound pairs of {len(PAIRS)}", sound, f">= {LEAST}" if given else "")
        if pictures is not None:
            pictures.mkdir(parents=True, exist_ok=True)
            save_image(sheet(images, outcomes), pictures / f"pairs-{mode.replace(' ', '-')}.png")


def entry(name: str, image: Array, given: bool) -> tuple[PreparedTexture, bool] | None:
    """A picture made ready to splice, and whether nobody has looked where the tool warns; None if it refuses."""
    told: list[str] = []
    ctx = Context(on_warning=told.append)
    photograph = PHOTOGRAPHS[name]
    examples, growth = [photograph.element] if given and photograph.element else [], photograph.growth if given else 1.0
    try:
        found = find_textons(image, examples=examples, growth=growth, ctx=ctx)
        cut = separate_foreground(image, found.elements, width=found.width, height=found.height, ctx=ctx)
        texture = texture_entry(image, cut.mask, found.points, tag=photograph.tag if given else None, ctx=ctx)
    except ValueError as refusal:
        print(f"{name}: {refusal}", file=sys.stderr)
        return None
    return prepare_texture(texture, width=WINDOW, height=WINDOW), bool(told) and not given


def spliced(one: PreparedTexture, other: PreparedTexture, doubtful: bool) -> Outcome:
    """Splice a pair and judge it."""
    moves, warp, drawn, refined = splice(one, other.texture)
    verdict = judge_splice(
        one.extension, moves, refined.mask, refined.source, drawn.holes, warp, drawn.source, drawn.cells
    )
    wanted = align_distributions(one.extension, other.texture).target.points
    image = one.texture.image
    middle = image.shape[1] // 2
    return Outcome(
        one.texture.tag, doubtful, verdict.cut, verdict.fidelity, verdict.holes,
        1 - float(np.count_nonzero(moves.matched)) / len(wanted),
        patch_distance(refined.image, image) / patch_distance(image[:, :middle], image[:, middle:]),
        verdict.bent, verdict.slope, refined.image,
    )  # fmt: skip


def sheet(images: dict[str, Array], outcomes: dict[tuple[str, str], Outcome]) -> Array:
    """All pairs: elements, arrangement, result."""
    shown: list[Array | Gap] = []
    labels: list[str | float] = []
    for pair in PAIRS:
        found = outcomes.get(pair)
        shown += [*(images[name] for name in pair), np.ones((8, 8, 3), np.float32) if found is None else found.image]
        labels += [*pair, "not spliced" if found is None else f"{found.tag} {'sound' if found.sound else 'not sound'}"]
    return contact_sheet(shown, columns=6, labels=labels)
