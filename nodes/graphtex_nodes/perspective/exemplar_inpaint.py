"""Filling by copies of patches in the order of their priority (Criminisi, Pérez & Toyama 2003, 2004)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, SourceMap, node

Array = NDArray[Any]


class Inpainting(NamedTuple):
    """The filled picture, and where each pixel comes from."""

    image: Image
    source: SourceMap


@node
def exemplar_inpaint(
    photo: Annotated[Image, Axes("h w c")],
    hole: Annotated[Mask, Axes("h w")],
    source: Annotated[Mask, Axes("h w")] | None = None,
    *,
    patch: Annotated[
        int, Field(ge=1, le=65, description="side of the patches, odd; larger than a texture's elements")
    ] = 9,
    colours: Annotated[
        Literal["lab", "channels"],
        Field(description="patches are compared in CIE L*a*b* (pictures of 3 channels) or in the channels as they are"),
    ] = "lab",
    surroundings: Annotated[
        int | None, Field(ge=1, le=16384, description="pixels around the hole to take from; none: all of the photo")
    ] = None,
    ctx: Context = QUIET,
) -> Inpainting:
    r"""Fill a hole with patches copied from the rest of the photo, strong edges first.

    Pixels p on the border of what is yet to fill, the front, have the priority

    .. math:: P(p) = C(p)\,D(p),\quad C(p) = \frac{1}{|\Psi_p|} \sum_{q \in \Psi_p,\ known} C(q),\quad
       D(p) = |\nabla I_p^\perp \cdot n_p|,

    with :math:`\Psi_p` the patch around p, n the front's normal, and :math:`\nabla I_p` the strongest gradient of a
    known pixel of the patch: confidence is high where much is known, data where an edge runs into the front. Again and
    again, the patch of the highest priority takes its unknown pixels from the source patch whose colours are nearest
    (sum of squared differences over the known pixels), and these pixels get the confidence C(p). At the start C is 1
    outside the hole.

    It knows nothing of perspective: elements have the size that suits their neighbours. `Complete` does better there;
    this is what it is compared with.

    Parameters
    ----------
    photo
        (h, w, c). Pixels in the hole are not read.
    hole
        (h, w), True where to fill. Any shape and any number of parts, also at the border.
    source
        (h, w), True where texture may be taken from. Without it from all that is known.
    patch
        The paper's is 9. If nowhere as large a patch is free of the hole, the largest that is serves, with a warning.

    Returns
    -------
    Inpainting
        ``image`` equals the photo bit by bit outside the hole. ``source`` has the row and column in the photo of each
        pixel, outside the hole its own.

    Raises
    ------
    ValueError
        The hole is everything, nothing is left to take from, or ``patch`` is even.

    Notes
    -----
    Departures, where the paper leaves it open or stops: 0.001 is added to D (of L* of 0 to 100, or channels as they
    are), so that confidence rules where no edge meets the front, for else P is 0 all along it; the normal is the
    gradient of the filled region by Sobel's operator, not that of a smoothed polygon; of patches that are equally near
    the closest is taken; D is not divided by 255, which changes no order. The search is exhaustive, as in the paper.

    Examples
    --------
    >>> stripes = np.tile(np.float32([0, 0, 1, 1]), (24, 6))[..., None]
    >>> hole = np.zeros((24, 24), bool)
    >>> hole[8:13, 8:13] = True
    >>> bool((exemplar_inpaint(stripes, hole).image == stripes).all())
    True
    """
    if hole.all():
        raise ValueError(f"hole: expected some pixels outside it, got all of shape {hole.shape}")
    if patch % 2 == 0:
        raise ValueError(f"patch: expected an odd number, got {patch}")
    from graphtex_nodes.numerics.sources import COLUMN, ROW, own_places

    image, places = photo.copy(), own_places(hole.shape)
    if not hole.any():
        return Inpainting(image, places)
    usable = ~hole if source is None else source & ~hole
    if surroundings is not None:
        usable = usable & _near(hole, surroundings)
    if not usable.any():
        raise ValueError(f"source: expected some pixels outside the hole, got none in shape {hole.shape}")

    from graphtex_nodes.numerics.jit import announce

    announce(ctx, "inpaint_kernels")
    found = _filled(_planes(photo, colours), hole, *_centres(usable, patch, ctx), ctx)
    image[hole] = photo[found[hole, 0], found[hole, 1]]
    places[..., ROW][hole], places[..., COLUMN][hole] = found[hole, 0], found[hole, 1]
    return Inpainting(image, places)


def _near(hole: Array, reach: int) -> Array:
    """The bounding box of the hole with ``reach`` pixels around it."""
    near = np.zeros(hole.shape, bool)
    rows, columns = (np.flatnonzero(hole.any(axis=1 - axis)) for axis in (0, 1))
    near[max(0, rows[0] - reach) : rows[-1] + reach + 1, max(0, columns[0] - reach) : columns[-1] + reach + 1] = True
    return near


def _planes(photo: Array, colours: str) -> Array:
    """Values (c, h, w) in which patches are compared."""
    from graphtex_nodes.numerics.cielab import lab_of

    values = lab_of(photo) if colours == "lab" and photo.shape[2] == 3 else photo
    return np.ascontiguousarray(np.moveaxis(values, -1, 0), np.float32)


def _centres(usable: Array, patch: int, ctx: Context) -> tuple[Array, int]:
    """Centres (h, w) of patches that are usable as a whole, and their radius: the largest up to patch // 2."""
    from graphtex_nodes.numerics.frames import whole_windows

    for radius in range(patch // 2, -1, -1):
        side = 2 * radius + 1
        if side > min(usable.shape):
            continue
        whole = whole_windows(usable, side)
        if whole.any():
            break
    if radius < patch // 2:
        ctx.warn(f"no patch of {patch} pixels is free of the hole: patches of {2 * radius + 1} are copied")
    centres = np.zeros(usable.shape, bool)
    centres[radius : usable.shape[0] - radius, radius : usable.shape[1] - radius] = whole
    return centres, radius


def _filled(planes: Array, hole: Array, centres: Array, radius: int, ctx: Context) -> Array:
    """Row and column (h, w, 2) that each pixel of the hole comes from; its own elsewhere."""
    from graphtex_nodes.numerics import inpaint_kernels

    planes = np.where(hole, np.float32(0), planes)
    filled = (~hole).view(np.uint8).copy()
    confidence = filled.astype(np.float32)
    priority = np.full(hole.shape, -1, np.float32)
    found = np.moveaxis(np.indices(hole.shape), 0, -1).copy()
    box = _patch(hole, 0, slice(0, hole.shape[0]), slice(0, hole.shape[1]))
    total = left = int(np.count_nonzero(hole))
    rows, columns = (np.flatnonzero(hole.any(axis=1 - axis)) for axis in (0, 1))
    inner = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    while left:
        inpaint_kernels.prioritise(
            planes, filled, confidence, radius, priority, box[0].start, box[0].stop, box[1].start, box[1].stop
        )
        first = np.unravel_index(int(np.argmax(priority[inner])), priority[inner].shape)
        y, x = int(first[0]) + inner[0].start, int(first[1]) + inner[1].start
        around = _patch(hole, radius, slice(y, y + 1), slice(x, x + 1))
        row, column = _nearest(planes, filled, centres, radius, (y, x), around, ctx)
        corner = np.array([around[0].start, around[1].start])
        missing = np.argwhere(filled[around] == 0) + corner
        here = missing[:, 0], missing[:, 1]
        there = here[0] + (row - y), here[1] + (column - x)
        planes[:, here[0], here[1]] = planes[:, there[0], there[1]]
        found[here] = np.stack(there, axis=-1)
        confidence[here] = np.float32(confidence[around].sum(dtype=np.float64) / confidence[around].size)
        filled[here] = 1
        left -= len(missing)
        # what a patch changes is seen by patches that reach it, and by gradients and normals one pixel further
        box = _patch(hole, radius + 1, *around)
        ctx.progress(1 - left / total, "filling")
    return found


def _patch(hole: Array, radius: int, rows: slice, columns: slice) -> tuple[slice, slice]:
    """A box with ``radius`` pixels around it, as far as the picture goes."""
    return (
        slice(max(0, rows.start - radius), min(hole.shape[0], rows.stop + radius)),
        slice(max(0, columns.start - radius), min(hole.shape[1], columns.stop + radius)),
    )


def _nearest(
    planes: Array, filled: Array, centres: Array, radius: int, at: tuple[int, int], around: tuple[slice, slice],
    ctx: Context,
) -> tuple[int, int]:  # fmt: skip
    """Centre of the source patch most like the filled pixels of the patch ``around`` a place."""
    from graphtex_nodes.numerics import inpaint_kernels
    from graphtex_nodes.numerics.parallel import for_rows

    known = np.argwhere(filled[around]) + np.array([around[0].start, around[1].start])
    # neighbours tell nearly the same: pixels far apart first, so that a bad patch is soon given up
    known = known[np.argsort((np.arange(len(known)) * 0.618034) % 1, kind="stable")]
    wanted = np.ascontiguousarray(planes[:, known[:, 0], known[:, 1]].T)
    offsets = (known - at).astype(np.int32)
    height, width = centres.shape
    costs, columns = np.full(height, np.inf, np.float32), np.zeros(height, np.int32)
    allowed = centres.view(np.uint8)

    def band(first: int, stop: int) -> None:
        inpaint_kernels.search_patch(
            planes, allowed, offsets, wanted, radius, *at, costs, columns, first + radius, stop + radius
        )

    for_rows(band, height - 2 * radius, width * wanted.size / 16, ctx)
    apart = (np.arange(height) - at[0]) ** 2 + (columns.astype(np.int64) - at[1]) ** 2
    best = int(np.lexsort((apart, costs))[0])
    return best, int(columns[best])
