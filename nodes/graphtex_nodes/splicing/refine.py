"""The last step of a splice: holes filled and stretched parts made anew (Liu et al. 2009, section 4.3)."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, Rng, SourceMap, Texture, node
from graphtex_nodes.numerics.jit import announce
from graphtex_nodes.numerics.parallel import for_rows
from graphtex_nodes.splicing._stiffness import RULES
from graphtex_nodes.splicing.neighbour_sets import NeighbourSets
from graphtex_nodes.splicing.tags import checked_tag
from graphtex_nodes.splicing.texton_labels import with_rim

Array = NDArray[Any]

STRAY = 1.1
"""Cost of a similar pixel over that of a continuation: pieces grow."""
STILL = 1.0
"""Pixels that moved no farther than this keep the colour that was drawn, which is exact between pixels."""


class Refined(NamedTuple):
    """The spliced picture, its foreground, and where each pixel comes from."""

    image: Image
    mask: Mask
    source: SourceMap


@node
def refine(
    texture: Texture,
    sets: NeighbourSets,
    image: Annotated[Image, Axes("h w c")],
    mask: Annotated[Mask, Axes("h w")],
    source: Annotated[SourceMap, Axes("h w s")],
    holes: Annotated[Mask, Axes("h w")],
    *,
    jitter: Annotated[
        int, Field(ge=0, le=64, description="pixels by which what is not rigid is shaken, so that it is made anew")
    ] = 2,
    passes: Annotated[int, Field(ge=0, le=16, description="corrections at each of the two spacings")] = 2,
    rigid_charge: Annotated[
        float, Field(ge=1, le=1000, description="cost of a source in or beside something rigid where none should be")
    ] = 4.0,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Refined:
    """Fill the holes of a drawn splice and make its non-rigid parts anew, so that stretching does not show.

    Each pixel has a source in the texture. Holes get one that is not rigid; sources of the non-rigid part are shaken
    by ``jitter``. Then, on every second pixel and on every pixel in turn, sources are corrected: of the continuations
    of its eight neighbours' sources and of pixels similar to these, a pixel takes the one whose surroundings agree best
    with what its neighbours expect (Lefebvre & Hoppe 2006, four sub-passes each). Rigid pixels and the pixels around
    them keep their sources throughout.

    Parameters
    ----------
    texture
        The texture that the elements come from (not its extension).
    sets
        From `NeighbourSets` of the same texture.
    image, mask, source, holes
        From `Rasterize`.

    Returns
    -------
    Refined
        No holes are left. Pixels whose source moved by a pixel at most keep their drawn colours, others have those of
        their source.

    Raises
    ------
    ValueError
        The sets are of another texture, or the picture has other channels than the texture.

    Notes
    -----
    The paper fills holes with random non-rigid pixels, out of which two levels make no structure wider than a few
    pixels. Here a hole begins as the continuation of what surrounds it, and random only where that meets something
    rigid.
    """
    from graphtex_nodes.splicing.extend_texture import checked

    checked(texture)
    shape = texture.mask.shape
    if sets.fine_appearance.shape[:2] != shape:
        raise ValueError(f"sets: expected those of a texture of shape {shape}, got {sets.fine_appearance.shape[:2]}")
    if image.shape[2] != texture.image.shape[2]:
        raise ValueError(f"image: expected {texture.image.shape[2]} channels as the texture, got {image.shape[2]}")
    announce(ctx, "coherence_kernels")
    foreground = RULES[checked_tag(texture.tag, "texture.tag")].foreground
    rigid_source = texture.mask if foreground else ~texture.mask
    # soft edges of elements would show as ghosts; between joints there is no room for rims
    barred = with_rim(rigid_source) if foreground else rigid_source
    barred = rigid_source if barred.all() else barred
    rigid = (mask if foreground else ~mask) & ~holes
    fixed = with_rim(rigid) & ~holes
    drawn = np.clip(np.rint(source[..., 1:3]), 0, np.array(shape) - 1).astype(np.int32)
    start = _shaken(drawn, holes, fixed, barred, jitter, rng)
    charge = np.where(barred, np.float32(rigid_charge), np.float32(1))
    coarse = np.ascontiguousarray(start[::2, ::2])
    _correct(coarse, fixed[::2, ::2], sets.coarse_appearance, sets.coarse_sets, charge, 2, passes, ctx)
    fine = _doubled(coarse, mask.shape, shape)
    fine[fixed] = drawn[fixed]
    _correct(fine, fixed, sets.fine_appearance, sets.fine_sets, charge, 1, passes, ctx)
    moved = np.abs(fine - source[..., 1:3]).max(axis=2) > STILL
    moved |= holes
    result, places = image.copy(), source.copy()
    result[moved] = texture.image[fine[moved, 0], fine[moved, 1]]
    found = mask.copy()
    found[moved] = texture.mask[fine[moved, 0], fine[moved, 1]]
    places[moved] = 0
    places[moved, 1:3] = fine[moved]
    return Refined(result, found, places)


def _shaken(
    drawn: Array, holes: Array, fixed: Array, rigid: Array, jitter: int, rng: np.random.Generator
) -> Array:  # fmt: skip
    """Sources (h, w, 2) to begin with."""
    start = drawn.copy()
    limit = np.array(rigid.shape) - 1
    noise = rng.integers(-jitter, jitter + 1, drawn.shape)
    loose = ~fixed & ~holes
    start[loose] = np.clip(drawn[loose] + noise[loose], 0, limit)
    if holes.any():
        start[holes] = _filled(drawn, holes, fixed, rigid, rng)
    return start


def _filled(drawn: Array, holes: Array, fixed: Array, rigid: Array, rng: np.random.Generator) -> Array:
    """Sources (n, 2) of the holes: continuations of the nearest pixel around where these are not rigid, else random."""
    from scipy.ndimage import distance_transform_edt

    places = np.argwhere(~rigid) if not rigid.all() else np.argwhere(rigid)
    own = np.argwhere(holes)
    found = places[rng.integers(0, len(places), len(own))]
    around = ~holes & ~fixed
    if not around.any():
        around = ~holes
    if around.any():
        nearest = distance_transform_edt(~around, return_distances=False, return_indices=True)[:, holes].T
        ahead = drawn[nearest[:, 0], nearest[:, 1]] + own - nearest
        fits = np.asarray(((ahead >= 0) & (ahead < rigid.shape)).all(axis=1))
        fits[fits] = ~rigid[ahead[fits, 0], ahead[fits, 1]]
        found[fits] = ahead[fits]
    return found


def _doubled(coarse: Array, size: tuple[int, ...], texture: tuple[int, ...]) -> Array:
    """Sources of all pixels from those of every second one."""
    row, column = np.ogrid[: size[0], : size[1]]
    fine = coarse[row // 2, column // 2].copy()
    fine[..., 0] += (row % 2).astype(np.int32)
    fine[..., 1] += (column % 2).astype(np.int32)
    result: Array = np.minimum(fine, np.array(texture, np.int32) - 1)
    return result


def _correct(
    source: Array, fixed: Array, appearance: Array, sets: Array, charge: Array, spacing: int, passes: int, ctx: Context
) -> None:  # fmt: skip
    """Correct sources in place; pixels of one parity class do not read each other, so bands may run at once."""
    from graphtex_nodes.splicing import coherence_kernels

    candidates = sets.reshape(appearance.shape[0] * appearance.shape[1], -1)
    flags = np.ascontiguousarray(fixed).view(np.uint8)
    steps = source.shape[1] / 4 * candidates.shape[1] * 9 * 4 * appearance.shape[2]
    for number in range(4 * passes):
        down, right = divmod(number % 4, 2)

        def band(first: int, stop: int, down: int = down, right: int = right) -> None:
            coherence_kernels.correct(
                source, flags, appearance, candidates, charge, np.float32(STRAY), spacing, down, right, first, stop
            )

        for_rows(band, source.shape[0], steps, ctx)
