"""Textures of repeated elements whose places, outlines, angles and sizes are known."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Elements, Image, LabelMap, Mask, Points, Rng, node
from graphtex_nodes.image.exemplars._forms import LOOKS, Form, colour, height
from graphtex_nodes.image.exemplars._paint import encoded, fractal, lay, linear, openness, shading
from graphtex_nodes.image.exemplars._view import Height, Width
from graphtex_nodes.numerics.arrangements import apart_points, lattice_points
from graphtex_nodes.numerics.plane import Region, photograph, seen_plane

Array = NDArray[Any]
Arrangement = Literal["square", "hexagonal", "brick", "random"]

OVERSAMPLING = 2.5  # texels a pixel: outlines are hard, so they need more than soft materials


class Textons(NamedTuple):
    """A generated texture and all that is to be found in it."""

    image: Image
    mask: Mask
    labels: LabelMap
    elements: Elements
    centres: Points


class Laid(NamedTuple):
    """Elements on the plane: centres (n, 2) in plane units, y up; angle in degrees, scale, form's index, tone."""

    centres: Array
    angles: Array
    scales: Array
    kinds: Array
    tones: Array


@node
def textons(
    *,
    width: Width = 256,
    height: Height = 256,
    size: Annotated[float, Field(ge=6, le=512, description="length of an element in pixels")] = 28.0,
    form: Annotated[Form, Field(description="what the elements are")] = "disc",
    other: Annotated[Form | None, Field(description="a second kind, which every other element is, at random")] = None,
    arrangement: Annotated[Arrangement, Field(description="a lattice, or random with a least distance")] = "square",
    spacing: Annotated[
        float, Field(ge=0.7, le=8, description="distance of neighbours over their size; below 1 they overlap")
    ] = 1.35,
    jitter: Annotated[
        float, Field(ge=0, le=0.5, description="how far elements are moved at random, as a share of their size")
    ] = 0.0,
    turn: Annotated[float, Field(ge=0, le=180, description="elements are turned by up to this many degrees")] = 0.0,
    growth: Annotated[
        float, Field(ge=1, le=2, description="elements are up to this many times larger or smaller")
    ] = 1.0,
    proportion: Annotated[float, Field(ge=0.2, le=1, description="width of a tile over its length")] = 0.5,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Textons:
    """Lit elements on a ground, seen face on, with the truth of where each one is.

    Parameters
    ----------
    form, other
        ``disc`` looks the same however it is turned, ``flower`` every 72 degrees, ``tile`` every 180, ``leaf`` never.
    spacing
        Rows of tiles in lattices stand apart by their width plus the gap of their columns. In ``random`` it is the
        least distance.

    Returns
    -------
    image
        Shape (height, width, 3), sRGB-encoded in [0, 1].
    mask
        True on elements, those cut by the border included.
    labels
        1 and up for each element in the order of `elements`, then those whose centre is outside; 0 is the ground.
    elements
        Those whose centre is in the picture, from top to bottom: angle in degrees clockwise (a leaf at 0 points to the
        right), and scale relative to `size`.
    centres
        The points of `elements`.

    Examples
    --------
    >>> made = textons(width=80, height=60, size=20.0, spacing=1.0, form="leaf", turn=30.0)
    >>> len(made.centres), bool(np.abs(made.elements.angles).max() <= 30)
    (12, True)
    """
    plane = seen_plane(width, height, 0.0, 0.0, None)
    forms: list[Form] = [form] if other is None else [form, other]
    laid, order = _lay_out(width, height, size, len(forms), arrangement, spacing, jitter, turn, growth,
                           proportion if form == "tile" and not turn and other is None else 1.0, rng)  # fmt: skip
    keys = [int(key) for key in rng.integers(1 << 62, size=3)]

    def paint(region: Region) -> Array:
        ctx.check()
        return _paint(region, laid, forms, size, proportion, keys)

    picture = photograph(plane, paint, oversampling=OVERSAMPLING)
    pixels = Region(-(width - 1) / 2, -(height - 1) / 2, height, width, 1.0)
    owner = _relief(pixels, laid, forms, size, proportion, keys[0])[1][::-1]
    number = np.zeros(len(order) + 1, np.int32)
    number[order] = np.arange(1, len(order) + 1)
    labels = number[owner]  # owner -1, the ground, takes the last, 0
    points = np.stack([laid.centres[:, 0] + (width - 1) / 2, (height - 1) / 2 - laid.centres[:, 1]], axis=1)[order]
    inside = (points >= 0).all(axis=1) & (points <= (width - 1, height - 1)).all(axis=1)
    points = points[inside]
    found = Elements(points, laid.angles[order][inside], laid.scales[order][inside])
    return Textons(encoded(picture), labels > 0, labels, found, points)


def _lay_out(
    width: int, height: int, size: float, forms: int, arrangement: Arrangement, spacing: float, jitter: float,
    turn: float, growth: float, proportion: float, rng: np.random.Generator,
) -> tuple[Laid, Array]:  # fmt: skip
    """Elements on and around the picture, one kind after the other, and their order from top to bottom.

    In the order all those with their centre in the picture come first.
    """
    reach = 2 * size * growth
    low, high = -np.array([width, height]) / 2 - reach, np.array([width, height]) / 2 + reach
    step = size * (growth - 1 + spacing)
    if arrangement == "random":
        points = apart_points(low, high, step, rng)
    else:
        cell = (step, step - size * (1 - proportion))
        points = lattice_points(arrangement, low + rng.uniform(0, 1, 2) * cell, high, cell)
    points = points + rng.uniform(-1, 1, points.shape) * jitter * size
    count = len(points)
    kinds = rng.integers(0, forms, count)
    by_kind = np.argsort(kinds, kind="stable")
    angles, scales = rng.uniform(-turn, turn, count), growth ** rng.uniform(-1, 1, count)
    laid = Laid(points[by_kind], angles[by_kind], scales[by_kind], kinds[by_kind], rng.random(count))
    outside = (np.abs(laid.centres) > np.array([width - 1, height - 1]) / 2).any(axis=1)
    order = np.lexsort((laid.centres[:, 0], -laid.centres[:, 1].round(6), outside))
    return laid, order


def _relief(
    region: Region, laid: Laid, forms: list[Form], size: float, proportion: float, key: int
) -> tuple[Array, Array]:
    """Heights in plane units, and which element is on top (-1 = the ground)."""
    ground = np.float32(0.012 * size) * fractal(region, 0.25 * size, key)
    owner = np.full(ground.shape, -1, np.int32)
    for index, form in enumerate(forms):
        first, stop = np.searchsorted(laid.kinds, [index, index + 1])
        half = size / 2 * laid.scales[first:stop]
        turned = np.radians(laid.angles[first:stop])

        def rise(
            some: Array, du: Array, dv: Array, form: Form = form, half: Array = half, turned: Array = turned
        ) -> Array:
            unit, (x, y) = half[some, None, None], _turned(du[:, None, :], dv[:, :, None], turned[some, None, None])
            return (height(form, x / unit, y / unit, proportion) * unit).astype(np.float32)

        lay(laid.centres[first:stop], 1.2 * half, rise, region, ground, owner, first=int(first))
    return ground, owner


def _turned(du: Array, dv: Array, angle: Array) -> tuple[Array, Array]:
    """Coordinates (x, y down) in elements that are turned clockwise, of offsets (right, up)."""
    cos, sin = np.cos(angle), np.sin(angle)
    return du * cos - dv * sin, -(du * sin + dv * cos)


def _paint(
    region: Region, laid: Laid, forms: list[Form], size: float, proportion: float, keys: list[int]
) -> Array:  # fmt: skip
    """Linear light (rows, columns, 3) of the elements and their ground."""
    relief, owner = _relief(region, laid, forms, size, proportion, keys[0])
    grain, mottle = fractal(region, 0.06 * size, keys[1]), fractal(region, 0.5 * size, keys[2])
    albedo = linear(LOOKS[forms[0]].ground) * (1 + 0.22 * grain + 0.14 * mottle)[..., None]
    for index, form in enumerate(forms):
        row, column = np.nonzero((owner >= 0) & (laid.kinds[owner] == index))
        whose = owner[row, column]
        du, dv = region.u[column] - laid.centres[whose, 0], region.v[row] - laid.centres[whose, 1]
        half = size / 2 * laid.scales[whose]
        x, y = _turned(du, dv, np.radians(laid.angles[whose]))
        shade = colour(form, x / half, y / half, laid.tones[whose])
        albedo[row, column] = shade * (1 + 0.08 * grain + 0.06 * mottle)[row, column, None]
    sun = shading(relief, region, 0.0, elevation=50, reach=0.3 * size, softness=0.03 * size)
    sky = openness(relief, region, 0.08 * size, 0.6)
    light: Array = sun[..., None] * np.array([0.80, 0.76, 0.68], np.float32)
    light = light + sky[..., None] * np.array([0.26, 0.29, 0.33], np.float32)
    return albedo * light
