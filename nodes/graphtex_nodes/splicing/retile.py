"""Walls laid anew where a warp cannot follow: each element gets a cell around its place."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Elements, Image, LabelMap, Mask, SourceMap, Texture, node
from graphtex_nodes.splicing._blocks import Blocks, blocks
from graphtex_nodes.splicing.values import Extension, Moves

Array = NDArray[Any]

ROUGH, OTHER = 0.2, 1.3
"""A warp cannot follow if, in the median, neighbours are to go so far apart over their distance, or elements to be
turned and sized so much; or if there are so many times more or fewer places than elements."""
NEIGHBOURS = 6
FEW = 0.25
GAP, LEAST_GAP, MOST_GAP = 1.2, 1.3, 2.3
"""Walls have no gaps: a place gets an element, too, if it is so many times farther from all others than few of their
cells reach, and at least so many radii of elements. Cells that reach farther than so many are those of an arrangement
with gaps everywhere, such as a line."""
MARGIN = 2.0
"""Radii of cells by which walls are laid beyond the window, so that cells at its border have neighbours."""
FAR = 0.05
"""What a place costs that is a usual distance away; a cell of twice an element's area costs 1."""
SPARE = 1.5
"""Elements to choose from, over the places."""


class Retiling(NamedTuple):
    """A picture as from `Rasterize`, and which place each pixel belongs to."""

    image: Image
    mask: Mask
    source: SourceMap
    holes: Mask
    cells: LabelMap


@node
def retile(
    texture: Texture,
    elements: Extension,
    moves: Moves,
    image: Annotated[Image, Axes("h w c")],
    mask: Annotated[Mask, Axes("h w")],
    source: Annotated[SourceMap, Axes("h w s")],
    holes: Annotated[Mask, Axes("h w")],
    *,
    when: Annotated[
        Literal["stiff", "never"],
        Field(description="lay walls anew whose joints are too stiff to follow, or leave every picture as it is"),
    ] = "stiff",
    ctx: Context = QUIET,
) -> Retiling:
    """Lay a wall anew, element by element, if its joints keep its elements from going to their places.

    A wall is a texture of the tag B=c in which only narrow joints part the elements. Warps keep the joints' width and
    which element is beside which, so most arrangements are out of their reach. Here each place gets an element of its
    own. The window is divided into cells: a pixel belongs to the place whose element, as an ellipse, would have to grow
    least to cover it (an anisotropic Voronoi diagram, Labelle & Shewchuk 2003). The outline of each element is laid
    along the border of its cell, half a joint away, with corners as round as the wall's have; its inside follows
    smoothly (mean value coordinates, Floater 2003). So elements change their size and form, and all joints are as wide
    as they were.

    Parameters
    ----------
    texture
        The texture that the elements come from (not its extension).
    elements, moves
        Its extension, for the window that is filled, and where its textons go.
    image, mask, source, holes
        From `Rasterize`.

    Returns
    -------
    Retiling
        Ready for `Refine`. A wall laid anew has no holes. Other tags, textures with wide joints, and arrangements that
        a warp can follow stay what they are: if, in the median, neighbours go less than a fifth of their distance apart
        and elements are turned and sized no more than that, and if there are about as many places as elements.
        ``cells`` has the place that each pixel belongs to, -1 everywhere in what was not laid anew.

    Raises
    ------
    ValueError
        The texture's parts do not fit together, the picture does not have the size of the window, the moves are of
        another extension, or a place asks for a scale that is not positive.

    Notes
    -----
    A departure from the paper, which warps all tags. The elements are not those that `Hungarian` assigned: so that they
    are deformed little, they are assigned anew by the size and elongation of the cells (the distance of the logarithms
    of covariances), and a little by distance, which spreads the copies of an element out. Those that the border of the
    picture cuts, or that are ragged, are not used. Gaps of the arrangement get elements as well.
    """
    from graphtex_nodes.splicing.extend_texture import checked
    from graphtex_nodes.splicing.texton_labels import texton_labels
    from graphtex_nodes.splicing.texture_entry import jointed

    tag = checked(texture)
    size = elements.height, elements.width
    if mask.shape != size:
        raise ValueError(f"mask: expected shape {size} as the window of elements, got {mask.shape}")
    if image.shape[2] != texture.image.shape[2]:
        raise ValueError(f"image: expected {texture.image.shape[2]} channels as the texture, got {image.shape[2]}")
    if len(moves.points) != len(elements.points):
        raise ValueError(f"moves: expected {len(elements.points)} textons as elements, got {len(moves.points)}")
    if not (moves.scales[moves.matched > 0] > 0).all():
        raise ValueError(f"moves: expected positive scales, got {moves.scales[moves.matched > 0].min():g}")
    given = Retiling(image, mask, source, holes, np.full(size, -1, np.int32))
    if when == "never" or tag != "B=c" or not _stiff(elements, moves):
        return given
    if not jointed(texture.mask, texton_labels(texture.mask, texture.points)):
        return given
    found = blocks(texture.mask, texture.points)
    if found is None:
        ctx.warn("the wall is not laid anew: nearly all its elements are ragged, or cut by the border of the picture")
        return given
    placed = moves.matched > 0
    target = Elements(moves.targets[placed] - (elements.left, elements.top), moves.angles[placed], moves.scales[placed])
    return _laid(texture, found, target, size, ctx)


def _stiff(elements: Extension, moves: Moves) -> bool:
    """Whether a warp cannot do what is asked of a wall."""
    from scipy.spatial import cKDTree

    matched = moves.matched > 0
    points, shifts = moves.points[matched], (moves.targets - moves.points)[matched]
    if len(points) < 2:
        return False
    corner, size = np.array([elements.left, elements.top]), np.array([elements.width, elements.height])
    own, wanted = (
        np.count_nonzero(((places >= corner) & (places < corner + size)).all(axis=1)) + 1
        for places in (moves.points, moves.targets[matched])
    )
    count = min(NEIGHBOURS, len(points) - 1)
    distance, index = cKDTree(points).query(points, k=[*range(2, count + 2)])
    apart = np.hypot(*np.moveaxis(shifts[index] - shifts[:, None], -1, 0))
    changed = np.abs(moves.scales[matched] * np.exp(1j * np.radians(moves.angles[matched])) - 1)
    rough = max(float(np.median(apart / np.maximum(distance, 1e-9))), float(np.median(changed)))
    return rough > ROUGH or not 1 / OTHER <= wanted / own <= OTHER


def _laid(texture: Texture, found: Blocks, target: Elements, size: tuple[int, int], ctx: Context) -> Retiling:
    """Fill a window (height, width) with blocks."""
    from scipy.ndimage import find_objects

    from graphtex_nodes.splicing._walls import cells, drawn, turned
    from graphtex_nodes.splicing.rasterize import sampled

    margin = int(np.ceil(MARGIN * (found.radius + found.joint)))
    whole = size[0] + 2 * margin, size[1] + 2 * margin
    target = _without_gaps(target._replace(points=target.points + margin), found, whole)
    kinds = _chosen(found, target, whole, texture.mask.shape)
    divided = cells(target.points, turned(found.forms[kinds], target.angles, target.scales), whole)
    window = np.s_[margin : margin + size[0], margin : margin + size[1]]
    spots, inside, visible = np.zeros((*whole, 2)), np.zeros(whole, bool), np.zeros(whole, bool)
    visible[window] = True
    parts = find_objects(divided.owner + 1)
    shown = divided.owner[window].astype(np.int32)
    for number in np.unique(shown):
        ctx.progress(float(number) / len(parts), "laying the wall")
        part = parts[number]
        wanted = visible[part] & (divided.owner[part] == number)
        spots[part][wanted], inside[part][wanted] = drawn(
            divided, number, part, wanted, int(kinds[number]), float(target.angles[number]), found
        )
    spots = np.clip(spots[window], 0, np.array(texture.mask.shape[::-1]) - 1).astype(np.float32)
    source = np.zeros((*size, 6), np.float32)
    source[..., 1:3] = spots[..., ::-1]
    return Retiling(sampled(texture.image, spots), inside[window], source, np.zeros(size, bool), shown)


def _without_gaps(target: Elements, found: Blocks, size: tuple[int, int]) -> Elements:
    """Places in a window, and some in its gaps."""
    from graphtex_nodes.splicing._tiling import without_gaps

    count = len(target.points)
    distance, index = _nearest(target.points, size)
    reach = np.zeros(count)
    np.maximum.at(reach, index.ravel(), distance.ravel())
    usual = float(np.quantile(reach[reach > 0], FEW))
    radius = found.radius + found.joint
    widest = LEAST_GAP * radius if usual > MOST_GAP * radius else max(GAP * usual, LEAST_GAP * radius)
    points = without_gaps(target.points, widest, np.full(2, -widest), np.array(size[::-1]) + widest)
    more = len(points) - count
    return Elements(points, np.pad(target.angles, (0, more)), np.pad(target.scales, (0, more), constant_values=1))


def _nearest(places: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """Distance and index of the nearest place of each pixel (h, w)."""
    from scipy.spatial import cKDTree

    pixels = np.moveaxis(np.indices(size)[::-1], 0, -1)
    distance, index = cKDTree(places).query(pixels)
    return np.asarray(distance), np.asarray(index)


def _chosen(found: Blocks, target: Elements, size: tuple[int, int], picture: tuple[int, ...]) -> Array:
    """Which block is laid at each place of a window: of copies of the picture beside each other, what fits."""
    from scipy.optimize import linear_sum_assignment
    from scipy.spatial.distance import cdist

    from graphtex_nodes.splicing._blocks import shape
    from graphtex_nodes.splicing._pattern import distances
    from graphtex_nodes.splicing._walls import cell_forms, turned

    places = target.points
    wanted = turned(cell_forms(_nearest(places, size)[1], len(places)), -target.angles, 1 / target.scales)
    own = np.stack([shape(form) for form in found.forms])
    unlike = ((np.stack([shape(form) for form in wanted])[:, None] - own) ** 2).sum(axis=2)
    sides, period = np.array(size[::-1]), np.array(picture[::-1])
    usual = max(float(np.median(distances(places))), 1.0)
    rings = np.ceil((sides / period - 1) / 2).astype(int)
    while np.prod(2 * rings + 1) * len(own) < SPARE * len(places):
        rings += 1
    shifts = np.stack(np.meshgrid(*(np.arange(-ring, ring + 1) for ring in rings)), axis=-1).reshape(-1, 1, 2) * period
    copies = found.outlines.mean(axis=1) + (sides - period) / 2 + shifts
    costs = cdist(places, copies.reshape(-1, 2), "sqeuclidean")
    costs *= FAR / usual**2
    costs += np.tile(unlike, len(shifts))
    kinds: Array = linear_sum_assignment(costs)[1] % len(own)
    return kinds
