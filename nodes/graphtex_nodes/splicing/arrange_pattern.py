"""Arrangements by design: patterns for the elements of one texture (Liu et al. 2009, Fig. 9)."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Elements, Rng, node
from graphtex_nodes.splicing.values import Extension

Array = NDArray[Any]
Pattern = Literal["own", "random", "square", "hexagonal", "brick", "ring", "spiral"]
Drawn = Literal["random", "square", "hexagonal", "brick", "ring", "spiral"]

JAMMED = 0.68
"""Points of a random pattern for each square of their least distance, when about full."""
MOST = 100_000


@node
def arrange_pattern(
    elements: Extension,
    *,
    pattern: Annotated[Pattern, Field(description="how places are laid out")] = "hexagonal",
    density: Annotated[
        float, Field(gt=0, le=16, description="places for each area over the textons' own number")
    ] = 1.0,
    spacing: Annotated[
        float, Field(ge=0, description="distance of places in pixels; 0 = by the textons' own number and density")
    ] = 0.0,
    aspect: Annotated[float, Field(ge=0.1, le=10, description="width over height of a cell of a lattice")] = 1.0,
    angle: Annotated[float, Field(ge=-360, le=360, description="turns the pattern, degrees clockwise")] = 0.0,
    jitter: Annotated[
        float, Field(ge=0, le=1, description="how far places are moved at random, as a share of their distance")
    ] = 0.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Elements:
    """Lay places in a pattern over the window of an extension, and so far around it that elements there reach into it.

    ============= ==================================================================================
    ``own``       the textons' places, spread from the window's middle as `density` or `spacing` asks
    ``random``    no two nearer than their distance, otherwise at random
    ``square``    rows and columns
    ``hexagonal`` rows moved by half a cell, sqrt(3) / 2 apart
    ``brick``     rows moved by half a cell
    ``ring``      circles about the middle
    ``spiral``    one arm from the middle, its turns a distance apart
    ============= ==================================================================================

    Parameters
    ----------
    elements
        How many textons there are for each area is what ``density`` is relative to.
    density
        With more than about 1.5, elements overlap and the extension's factor must be larger.

    Returns
    -------
    Elements
        Places in pixels of the window, neither turned nor sized.

    Raises
    ------
    ValueError
        There is no texton, or there would be more than 100,000 places.
    """
    from graphtex_nodes.splicing.texton_labels import texton_reach

    if len(elements.points) == 0:
        raise ValueError("elements: expected at least one texton, got none")
    own = len(elements.points) / elements.mask.size
    wanted = own * density
    distance = spacing or _distance(pattern, wanted, aspect)
    window = np.array([elements.width, elements.height], np.float64)
    reach = window / 2 + min(texton_reach(elements.labels, elements.points), 2 * distance)
    if 4 * np.prod(reach) / distance**2 > MOST:
        raise ValueError(
            f"{'spacing' if spacing else 'density'}: expected at most {MOST} places, got places {distance:.3g} px apart"
        )
    if pattern == "own":
        corner = np.array([elements.left, elements.top])
        offset = (elements.points - corner - (window - 1) / 2) * (distance / _distance("square", own, 1.0))
    else:
        offset = _offsets(pattern, float(np.hypot(*reach)), distance, aspect, rng)
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    places: Array = offset @ np.array([[cos, sin], [-sin, cos]])
    places = places + rng.uniform(-1, 1, places.shape) * jitter * distance
    places = places[(np.abs(places) <= reach).all(axis=1)] + (window - 1) / 2
    return Elements(places, np.zeros(len(places)), np.ones(len(places)))


def _distance(pattern: Pattern, density: float, aspect: float) -> float:
    """Distance of neighbours in a row of a pattern with so many points for each pixel."""
    cell = {"hexagonal": 2 / np.sqrt(3) * aspect, "square": aspect, "brick": aspect, "random": JAMMED}
    return float(np.sqrt(cell.get(pattern, 1.0) / density))


def _offsets(pattern: Drawn, reach: float, distance: float, aspect: float, rng: np.random.Generator) -> Array:
    """Places within ``reach`` of the middle, relative to it."""
    from graphtex_nodes.numerics.arrangements import apart_points, lattice_points

    if pattern == "random":
        return apart_points(np.full(2, -reach), np.full(2, reach), distance, rng)
    if pattern == "ring":
        circles = [np.zeros((1, 2))]
        for number in range(1, int(reach / distance) + 1):
            count = round(2 * np.pi * number)
            turn = 2 * np.pi * np.arange(count) / count
            circles.append(number * distance * np.stack([np.cos(turn), np.sin(turn)], axis=1))
        return np.concatenate(circles)
    if pattern == "spiral":
        # r = d t / 2 pi has the length d t^2 / 4 pi from the middle, but for its first turn
        count = int(np.pi * (reach / distance) ** 2)
        turn = np.sqrt(4 * np.pi * np.arange(count))
        arm: Array = (distance * turn / (2 * np.pi))[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return arm
    cell = (distance, distance / aspect)
    rows = cell[1] * (np.sqrt(3) / 2 if pattern == "hexagonal" else 1)
    # from a place an even number of rows away, so that one lies in the middle
    low: Array = -np.array([cell[0], 2 * rows]) * np.ceil(reach / np.array([cell[0], 2 * rows]))
    return lattice_points(pattern, low, np.full(2, reach), cell)
