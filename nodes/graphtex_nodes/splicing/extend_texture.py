"""A texture carried on beyond its borders with its mask and textons (image quilting, Efros & Freeman 2001)."""

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Texture, node
from graphtex_nodes.splicing.tags import checked_tag
from graphtex_nodes.splicing.texton_labels import texton_labels
from graphtex_nodes.splicing.values import Extension

Array = NDArray[Any]

LARGEST = 600_000
"""Pixels of an extension: the factorisation of its warp takes half a minute and 6 GB then."""
OVERLAP = 0.3
"""Least share of a piece that must lie on what is there already, to tell where it fits."""
GAIN = 0.6
"""Least share of the largest number of pixels that a piece at any place could add."""
ELEMENT = 0.5
"""Extra cost of a cut through a pixel of the foreground, in differences of colour."""
CERTAIN = 1e6
DOWN, RIGHT = np.zeros((2, 3, 3))
DOWN[2, 1] = RIGHT[1, 2] = 1
Side = Annotated[int, Field(ge=0, le=4096, description="pixels of the window; 0 = as the texture")]


@node
def extend_texture(
    texture: Texture,
    *,
    factor: Annotated[float, Field(ge=1, le=4, description="sides of the extension over those of the window")] = 1.5,
    width: Side = 0,
    height: Side = 0,
    ctx: Context = QUIET,
) -> Extension:
    """Carry a texture on, so that an arrangement over the whole window finds an element for each of its places.

    The picture stays in the middle of the window. Copies of it as a whole are laid around it, one after the other:
    each where it agrees best (mean squared difference of colour and mask over the overlap, by FFT) among the places
    that cover much of what is still empty, joined by a minimum cut that avoids the elements. Mask, points and the
    coordinates of all pixels follow. Of a texture with a single element only what is around this is repeated, from the
    middle of the window on, so that there are elements to be arranged.

    Parameters
    ----------
    texture
        Image (h, w, c), mask (h, w), points inside it.
    factor
        With 1 and no other size, the texture itself.
    width, height
        Size of the window.

    Returns
    -------
    Extension
        At least ``factor`` times as large as the window, which lies in its middle. A texton belongs to the piece that
        has the pixel at its centre; of two within half the usual distance one is kept.

    Raises
    ------
    ValueError
        The mask has another size, points lie outside, a tag is not known, or the extension exceeds 600,000 pixels.

    Notes
    -----
    Efros and Freeman join many small square patches. Whole copies need far fewer seams, and few elements are cut.
    """
    tag = checked(texture)
    size = texture.image.shape[:2]
    window = height or size[0], width or size[1]
    rows, columns = (int(np.ceil(side * factor)) for side in window)
    if rows * columns > LARGEST:
        raise ValueError(
            f"texture: expected a window of at most {int(LARGEST / factor**2)} pixels with factor {factor:g}, got "
            f"{window[0]} x {window[1]}: resample the texture or choose a smaller width and height"
        )
    if len(texture.points) == 1 and size != (rows, columns):
        part, period = _lone_element(texture)
        shifts, owner = _quilt(_part_of(texture, part), (rows, columns), ctx, period)
        shifts -= [side.start for side in part]
    else:
        shifts, owner = _quilt(texture, (rows, columns), ctx)
    place = np.moveaxis(np.mgrid[:rows, :columns], 0, -1) - shifts[owner]
    source = np.zeros((rows, columns, 6), np.float32)
    source[..., 1:3] = place
    image, mask = (part[place[..., 0], place[..., 1]] for part in (texture.image, texture.mask))
    points = _points(texture.points, shifts, owner)
    labels = texton_labels(mask, points)
    if len(points) and labels.max() < 0:
        ctx.warn("no texton lies on the foreground: there is nothing to take; is the mask the wrong way round?")
    left, top = (columns - window[1]) // 2, (rows - window[0]) // 2
    return Extension(image, mask, points, tag, labels, source, left, top, window[1], window[0])


def checked(texture: Texture, name: str = "texture") -> str:
    """The tag of a texture; ValueError if its parts do not fit together."""
    height, width = texture.image.shape[:2]
    if texture.mask.shape != (height, width):
        raise ValueError(f"{name}: expected a mask of shape {(height, width)} as the image, got {texture.mask.shape}")
    x, y = texture.points.T
    outside = np.count_nonzero((x < -0.5) | (y < -0.5) | (x > width - 0.5) | (y > height - 0.5))
    if outside:
        raise ValueError(f"{name}: expected points inside the image of shape {(height, width)}, got {outside} outside")
    return checked_tag(texture.tag, f"{name}.tag")


def _lone_element(texture: Texture) -> tuple[tuple[slice, slice], tuple[int, int]]:
    """The part of a texture around its only element, and the distance (rows, columns) of its copies.

    On each side there is ground, a quarter as wide as the element if the picture reaches so far; half is overlapped.
    """
    pixels = np.argwhere(texton_labels(texture.mask, texture.points) == 0)
    if not len(pixels):
        return (slice(0, texture.mask.shape[0]), slice(0, texture.mask.shape[1])), texture.mask.shape
    parts, period = [], []
    for first, last, side in zip(pixels.min(axis=0), pixels.max(axis=0) + 1, texture.mask.shape, strict=True):
        margin = -(-(last - first) // 4)
        part = slice(max(0, int(first - margin)), min(side, int(last + margin)))
        parts.append(part)
        period.append(int(part.stop - part.start + last - first + 1) // 2)
    return (parts[0], parts[1]), (period[0], period[1])


def _part_of(texture: Texture, part: tuple[slice, slice]) -> Texture:
    """A texture cut down to some rows and columns that hold all its points."""
    corner = part[1].start, part[0].start
    return Texture(texture.image[part], texture.mask[part], texture.points - corner, texture.tag)


def _quilt(
    texture: Texture, size: tuple[int, int], ctx: Context, period: tuple[int, int] | None = None
) -> tuple[Array, Array]:
    """Shift (row, column) of each piece, and which piece each pixel of the extension (h, w) comes from.

    Pieces lie where they fit best, or at whole multiples of a period (rows, columns) from each other.
    """
    from graphtex_nodes.splicing._fit import Fit

    rows, columns = texture.image.shape[:2]
    first = (size[0] - rows) // 2, (size[1] - columns) // 2
    shifts, owner = [first], np.full(size, -1, np.int32)
    kept = _reach(first, (rows, columns), size)
    owner[kept] = 0
    if (owner < 0).any():
        features = np.concatenate([texture.image, texture.mask[..., None].astype(np.float32)], axis=2)
        canvas = np.zeros((*size, features.shape[2]), np.float32)
        canvas[kept] = features[_part(kept, first)]
        fit = Fit(features, size)
        distance = _distance(size)
        while (owner < 0).any():
            ctx.progress(float(np.mean(owner >= 0)), "extending")
            wanted = divmod(int(np.where(owner < 0, distance, np.inf).argmin()), size[1])
            if period:
                top, left = (at - (at - begin) % step for at, begin, step in zip(wanted, first, period, strict=True))
                shift = top, left
            else:
                shift = fit.best(canvas, owner >= 0, wanted, OVERLAP, GAIN)
            _join(features, canvas, owner, shift, len(shifts))
            shifts.append(shift)
    return np.array(shifts), owner


def _distance(size: tuple[int, int]) -> Array:
    """Distance of each pixel from the middle, in half sides."""
    row, column = np.ogrid[: size[0], : size[1]]
    distance: Array = np.maximum(np.abs(row * 2 + 1 - size[0]) / size[0], np.abs(column * 2 + 1 - size[1]) / size[1])
    return distance


def _reach(shift: tuple[int, int], piece: tuple[int, int], size: tuple[int, int]) -> tuple[slice, slice]:
    """What a shifted piece covers of the extension."""
    top, left = (
        slice(max(0, move), min(whole, move + side)) for move, side, whole in zip(shift, piece, size, strict=True)
    )
    return top, left


def _part(covered: tuple[slice, slice], shift: tuple[int, int]) -> tuple[slice, slice]:
    """Which part of the piece that is."""
    top, left = (slice(part.start - move, part.stop - move) for part, move in zip(covered, shift, strict=True))
    return top, left


def _join(features: Array, canvas: Array, owner: Array, shift: tuple[int, int], number: int) -> None:
    """Lay a piece on the canvas, cut where it differs least from what lies there."""
    import maxflow

    covered = _reach(shift, features.shape[:2], owner.shape)
    new, old, owned = features[_part(covered, shift)], canvas[covered], owner[covered]
    empty = owned < 0
    step = np.sqrt(((new[..., :-1] - old[..., :-1]) ** 2).sum(axis=2, dtype=np.float64))
    step += ELEMENT * ((new[..., -1] > 0.5) | (old[..., -1] > 0.5)) + 1e-4
    step[empty] = 0
    graph = maxflow.Graph[float](step.size, 3 * step.size)
    nodes = graph.add_grid_nodes(step.shape)
    for structure, ahead in ((DOWN, (1, 0)), (RIGHT, (0, 1))):
        weights = step + np.roll(step, (-ahead[0], -ahead[1]), (0, 1))
        # beside an empty pixel only one of the two pictures is known: it counts for both
        weights *= 1 + (empty != np.roll(empty, (-ahead[0], -ahead[1]), (0, 1)))
        graph.add_grid_edges(nodes, weights, structure, symmetric=True)
    graph.add_grid_tedges(nodes, CERTAIN * _joined(owner, covered), CERTAIN * empty)
    graph.maxflow()
    taken = graph.get_grid_segments(nodes) | empty
    owned[taken] = number
    old[taken] = new[taken]


def _joined(owner: Array, covered: tuple[slice, slice]) -> Array:
    """Which pixels of the covered part touch what was there before and lies outside it."""
    others = owner >= 0
    others[covered] = False
    around = np.zeros(owner.shape, bool)
    around[1:] |= others[:-1]
    around[:-1] |= others[1:]
    around[:, 1:] |= others[:, :-1]
    around[:, :-1] |= others[:, 1:]
    joined: Array = around[covered] & (owner[covered] >= 0)
    return joined


def _points(points: Array, shifts: Array, owner: Array) -> Array:
    """Textons of all pieces that have the pixel at their centre; of two too close ones the first."""
    from graphtex_nodes.splicing._pattern import apart, distances

    found: Array = np.concatenate([points + shift[::-1] for shift in shifts])
    piece = np.repeat(np.arange(len(shifts)), len(points))
    column, row = np.rint(found).astype(np.int64).T
    inside = (row >= 0) & (row < owner.shape[0]) & (column >= 0) & (column < owner.shape[1])
    inside[inside] = owner[row[inside], column[inside]] == piece[inside]
    found = found[inside]
    if len(points) < 2:
        return found
    return apart(found, float(np.median(distances(points))) / 2)
