"""Pictures by name that need no file of the user's and no network."""

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from functools import partial
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field

from graphtex import QUIET, Context, Image, node, opener
from graphtex_nodes.image.exemplars.bricks import HIGHEST, bricks
from graphtex_nodes.image.exemplars.flowers import flowers
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.image.exemplars.sand import sand
from graphtex_nodes.image.exemplars.textons import textons
from graphtex_nodes.image.exemplars.woven_cloth import woven_cloth
from graphtex_nodes.image.normals import normals_from_height

_small = partial(textons, width=192, height=192)
ELEMENTS: Mapping[str, Callable[..., Any]] = {
    "berries": partial(_small, size=24.0, arrangement="hexagonal", spacing=0.97, jitter=0.03, rng=21),
    "blossoms": partial(_small, form="flower", arrangement="random", spacing=1.05, turn=36.0, rng=22),
    "leaves": partial(
        _small, form="leaf", size=34.0, arrangement="hexagonal", spacing=1.1, jitter=0.1, turn=40.0, rng=23
    ),
    "oranges": partial(_small, jitter=0.08, rng=24),
    "tiles": partial(_small, form="tile", size=40.0, arrangement="brick", spacing=1.12, proportion=0.45, rng=25),
}
"""Textures of separate elements, 192 x 192 in colour, with the truth about them."""

PAVING = partial(bricks, kind="paving", size=56.0, slant=52.0, rng=3)

GENERATED: Mapping[str, Callable[..., Any]] = {
    "pebbles": partial(pebbles, slant=55.0, rng=1),
    "pebbles-flat": partial(pebbles, rng=2),
    "pebbles-far": partial(pebbles, size=12.0, rng=12),
    "paving": PAVING,
    "flowers": partial(flowers, slant=50.0, rng=4),
    "flowers-flat": partial(flowers, rng=5),
    "bricks": partial(bricks, rng=6),
    "bricks-wall": partial(bricks, slant=50.0, tilt=75.0, rng=7),
    "cloth": partial(woven_cloth, rng=8),
    "matting": partial(woven_cloth, size=13.0, slant=56.0, rng=13),
    "twill": partial(woven_cloth, weave="twill", warp=(0.55, 0.20, 0.20), rng=9),
    "sand": partial(sand, slant=50.0, rng=10),
    "sand-flat": partial(sand, rng=11),
}
"""Samples of surfaces, 256 x 256 in colour."""

MATERIALS: Mapping[str, Callable[[Any], NDArray[Any]]] = {
    "bricks-height": lambda made: made.height,
    "bricks-normal": lambda made: normals_from_height(made.height, relief=48 * HIGHEST),
}
"""Maps of the sample before the hyphen."""

DRAWINGS: Mapping[str, Callable[[], NDArray[Any]]] = {"spiral": lambda: _spiral(256)}
"""Grey drawings, 256 x 256."""

PHOTOGRAPHS = ("brick", "grass", "gravel")
"""Grey photographs, 512 x 512, that scikit-image's wheel brings (CC0)."""

NAMES = tuple(sorted((*DRAWINGS, *ELEMENTS, *GENERATED, *MATERIALS, *PHOTOGRAPHS)))


def _known(name: str) -> str:
    if name not in NAMES:
        near = get_close_matches(name, NAMES, n=1)
        first = f"{near[0]!r} or another of" if near else "one of"
        raise ValueError(f"should be {first} the samples {', '.join(NAMES)}")
    return name


@opener(Image, scheme="sample")
@node
def sample(
    *,
    name: Annotated[str, AfterValidator(_known), Field(description="which sample", examples=list(NAMES))],
    ctx: Context = QUIET,
) -> Image:
    """A picture that ships with the package: ``sample:pebbles`` where a graph file wants a path.

    ``pebbles``, ``paving``, ``flowers``, ``matting`` and ``sand`` are planes in perspective; ``pebbles-flat``,
    ``flowers-flat``, ``sand-flat``, ``bricks``, ``cloth`` and ``twill`` are face on, ``bricks-wall`` from the side,
    ``pebbles-far`` from twice the distance. They are drawn by the nodes of their names with a fixed seed, 256 x 256, in
    colour. ``berries``, ``blossoms``, ``leaves``, ``oranges`` and ``tiles`` are separate elements that `Textons` draws,
    192 x 192, in colour. ``brick``, ``grass`` and ``gravel`` are grey photographs of 512 x 512 pixels from
    scikit-image. ``bricks-height`` and ``bricks-normal`` are further maps of ``bricks``. ``spiral`` is a grey drawing,
    for what is laid out by the brightness of a picture.

    Returns
    -------
    Image
        (256, 256, 3), (192, 192, 3) or (512, 512, 1), sRGB-encoded in [0, 1]; heights and drawings (256, 256, 1), and
        normals encoded as StackMaps has them.

    Raises
    ------
    ValueError
        No sample has this name; the message lists them all.
    """
    if name in PHOTOGRAPHS:
        return _photograph(name)
    if name in DRAWINGS:
        return DRAWINGS[name]()
    if name in MATERIALS:
        return MATERIALS[name](GENERATED[name.rpartition("-")[0]](ctx=ctx))
    image: NDArray[Any] = {**ELEMENTS, **GENERATED}[name](ctx=ctx).image
    return image


def _photograph(name: str) -> NDArray[np.float32]:
    """A picture of scikit-image's wheel, read from its folder: its own loader would download what it does not find."""
    from importlib.resources import files

    from PIL import Image as pillow

    with files("skimage.data").joinpath(f"{name}.png").open("rb") as file, pillow.open(file) as picture:
        grey = np.asarray(picture.convert("L"), np.float32)
    return grey[..., None] / np.float32(255)


def _spiral(side: int) -> NDArray[np.float32]:
    """A soft white band on black that winds out from the middle, (side, side, 1)."""
    y, x = (np.mgrid[:side, :side] - (side - 1) / 2) / side
    turns = np.hypot(x, y) * 2.0 - np.arctan2(y, x) / (2 * np.pi)
    drawn: NDArray[np.float32] = (0.5 + 0.5 * np.cos(2 * np.pi * turns))[..., None].astype(np.float32)
    return drawn
