"""The arrangement of one texture brought to the scale and orientation of another (Liu et al. 2009, section 4.1)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Elements, Number, Texture, node
from graphtex_nodes.splicing import _pattern
from graphtex_nodes.splicing._tiling import Tiling
from graphtex_nodes.splicing.values import Extension

Array = NDArray[Any]

GAIN = 0.1
"""Share of the cost that a turn must save: between unlike lattices all angles are about as bad."""
CLOSE = 0.4
"""Share of the places that may be nearer to the next one than elements are wide."""
TOUCH = 0.95
"""Distance of elements, over their diameter, at which they touch: they are not quite round."""
FARTHEST = 1.4
"""What places are spread by at most."""


class Alignment(NamedTuple):
    """Places in pixels of the window, and by how much the arrangement was sized and turned (degrees, clockwise)."""

    target: Elements
    scale: Number
    angle: Number


@node
def align_distributions(
    elements: Extension,
    arrangement: Texture,
    *,
    neighbours: Annotated[int, Field(ge=1, le=32, description="nearest textons that a distance is the mean of")] = 5,
    orientation: Annotated[
        Literal["radon", "kept"], Field(description="turn the arrangement as the elements', or keep it")
    ] = "radon",
    spread: Annotated[
        float | None, Field(ge=0.25, le=4, description="distance of places over that of the elements' own; see below")
    ] = None,
    ctx: Context = QUIET,
) -> Alignment:
    """Lay the textons of one texture over the window of another, as dense and turned as that one's own.

    The arrangement is sized so that the mean distance to the nearest textons is that of the elements, which keep their
    size. Its middle is laid on that of the window. Orientations are peaks over angle of the variance of the Radon
    transform of the points; a lattice has several, so each peak is tried, and the one kept whose assignment (equation
    4) costs least. It must cost a tenth less than no turn. A pattern without a clear peak is not turned.

    Parameters
    ----------
    elements
        The extension that is to be rearranged.
    arrangement
        Only its points and the size of its picture count. Where it is smaller than the window it is carried on: by
        periods that it has itself, otherwise by the sides of its picture, and gaps between the copies are filled.
    neighbours
        The paper has 4 to 6.
    spread
        The paper's is 1. By default places are up to 1.4 times farther apart where disjoint elements (F=d) would lie on
        each other: until no more than two fifths of them are nearer to the next one than elements are wide.

    Returns
    -------
    Alignment
        ``target`` has all places in the window and so far around it that an element there can reach into it.

    Raises
    ------
    ValueError
        Either has no texton, or several at one place, or points of the arrangement lie outside its picture.

    Notes
    -----
    One texton has no distance to others. A single element counts as one in each window; the single place of an
    arrangement stays where it is in its picture, is the only one, and neither `spread` nor `orientation` changes it.

    Textons at a border miss neighbours beyond it, which would make small samples look sparse; they do not count. The
    paper lays centroids on each other. A lattice is then half a cell off as often as not; here the middle is moved by
    the median displacement of a first assignment.
    """
    from graphtex_nodes.splicing.extend_texture import checked
    from graphtex_nodes.splicing.texton_labels import texton_reach

    checked(arrangement, "arrangement")
    for name, points in (("elements", elements.points), ("arrangement", arrangement.points)):
        if len(points) == 0:
            raise ValueError(f"{name}: expected at least one texton, got none")
    size = arrangement.image.shape[:2]
    if len(arrangement.points) == 1:
        return _alone(elements, arrangement.points, size)
    if len(elements.points) > 1:
        wanted = _pattern.spacing(elements.points, elements.image.shape[:2], neighbours)
    else:
        wanted = float(np.sqrt(elements.width * elements.height))
    own = _pattern.spacing(arrangement.points, size, neighbours)
    if own == 0 or wanted == 0:
        name = "elements" if wanted == 0 else "arrangement"
        raise ValueError(f"{name}: expected textons at different places, got distance 0 between neighbours")
    scale = wanted / own
    if spread is None:
        spread = _room(elements, scale * _pattern.distances(arrangement.points)) if elements.tag == "F=d" else 1.0
    scale *= spread
    turns = [0.0]
    if orientation == "radon":
        turns += _turns(elements, arrangement, wanted, own)
    margin = min(texton_reach(elements.labels, elements.points), wanted) + 1
    tiling = Tiling(arrangement.points, size, own)
    tried = []
    for turn in turns:
        ctx.check()
        places = _laid(elements, tiling, scale, turn, wanted)
        cost, settled = _settled(elements, places, margin)
        tried.append((cost if turn else (1 - GAIN) * cost, settled, turn))
    _, places, turn = min(tried, key=lambda entry: entry[0])
    count = len(places)
    return Alignment(Elements(places, np.zeros(count), np.ones(count)), scale, turn)


def _alone(elements: Extension, points: Array, size: tuple[int, int]) -> Alignment:
    """The only place of an arrangement where it is in its picture, which is fitted into the window."""
    window, picture = np.array([elements.width, elements.height]), np.array(size[::-1])
    scale = float((window / picture).min())
    places = (points - (picture - 1) / 2) * scale + (window - 1) / 2
    return Alignment(Elements(places, np.zeros(1), np.ones(1)), scale, 0.0)


def _room(elements: Extension, distances: Array) -> float:
    """By how much places must be spread so that disjoint elements do not lie on each other.

    The distances (n,) are those of places to the nearest other one.
    """
    sizes = np.bincount(elements.labels[elements.labels >= 0])
    if not sizes.any():
        return 1.0
    width = 2 * float(np.sqrt(np.median(sizes[sizes > 0]) / np.pi))
    return float(np.clip(TOUCH * width / max(float(np.quantile(distances, CLOSE)), 1e-9), 1, FARTHEST))


def _turns(elements: Extension, arrangement: Texture, wanted: float, own: float) -> list[float]:
    """Angles (degrees, clockwise, within 90) that lay a peak of the arrangement on the elements' highest."""
    here = _pattern.orientations(elements.points, wanted)
    there = _pattern.orientations(arrangement.points, own)
    if len(here) == 0:
        return []
    return [float((here[0] - angle + 90) % 180 - 90) for angle in there]


def _laid(elements: Extension, tiling: Tiling, scale: float, turn: float, margin: float) -> Array:
    """Places in and around the window."""
    size = np.array([elements.width, elements.height], np.float64)
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    rotation = np.array([[cos, sin], [-sin, cos]])  # of row vectors, clockwise with y down
    reach = size / 2 + 2 * margin
    corners = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) * reach @ rotation.T / scale
    middle = (np.array(tiling.size[::-1], np.float64) - 1) / 2
    points = tiling.over(middle + corners.min(axis=0), middle + corners.max(axis=0))
    places: Array = (points - middle) * scale @ rotation + (size - 1) / 2
    return places


def _settled(elements: Extension, places: Array, margin: float) -> tuple[float, Array]:
    """Mean cost of assigning textons to places after moving these by the mean displacement, and the moved places."""
    from graphtex_nodes.splicing.hungarian import assign

    corner = np.array([elements.left, elements.top])
    size = np.array([elements.width, elements.height])
    inside = ((places >= 0) & (places <= size - 1)).all(axis=1)
    if not inside.any():
        return np.inf, places
    chosen, taken, _ = assign(elements.points - corner, places[inside])
    moved = places + np.median(elements.points[chosen] - corner - places[inside][taken], axis=0)
    moved = moved[((moved >= -margin) & (moved <= size - 1 + margin)).all(axis=1)]
    distances = assign(elements.points - corner, moved)[2]
    return float(distances.mean()), moved
