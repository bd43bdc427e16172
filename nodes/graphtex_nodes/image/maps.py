"""Material maps as channels of one picture, so that one synthesis makes them all, and back."""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Image, node
from graphtex_nodes.numerics.materials import (
    CHANNELS,
    UP,
    MapKind,
    doubt_normals,
    map_slices,
    require_channels,
    total_channels,
    unit_normals,
)

MOST_CHANNELS = 16

Kinds = Annotated[
    list[MapKind], Field(min_length=1, max_length=MOST_CHANNELS, description="what each map is, in order")
]

Renormalise = Annotated[
    bool, Field(description="make normals unit vectors again; false gives back the stack's numbers")
]


@node
def stack_maps(maps: list[Image], *, kinds: Kinds, ctx: Context = QUIET) -> Image:
    """Stack material maps (albedo, normals, roughness, height ...) of one size into the channels of one picture.

    A synthesis of the stack copies all maps from the same places, so they stay aligned. `split_maps` with the same
    ``kinds`` undoes it exactly (a normal that is no unit vector, only without ``renormalise``).

    Parameters
    ----------
    maps
        Pictures of one size. ``colour`` has 3 channels, ``colour+alpha`` 4, ``normal`` and ``normal-down`` 3,
        ``height`` and ``scalar`` 1; load maps that are not colour with ``encoding: raw``.
    kinds
        One for each map. A normal is a unit vector encoded as (n + 1) / 2, its first component pointing to the right
        and its second one up (as OpenGL has it), or down in ``normal-down`` (as DirectX has it).

    Returns
    -------
    Image
        (h, w, sum of the channels), at most 16. Write it to a file with ``encoding: raw``: 4 channels would count as
        RGB and alpha.

    Raises
    ------
    ValueError
        If sizes, channels or the numbers of maps and kinds disagree, or there are more than 16 channels.
    """
    if len(maps) != len(kinds):
        raise ValueError(f"kinds: expected one for each of {len(maps)} maps, got {len(kinds)}")
    for i, (image, kind) in enumerate(zip(maps, kinds, strict=True)):
        if image.shape[:2] != maps[0].shape[:2]:
            raise ValueError(f"maps[{i}]: expected the size of maps[0], {maps[0].shape[:2]}, got {image.shape[:2]}")
        if image.shape[2] != CHANNELS[kind]:
            hint = "; Grey makes one channel of it" if CHANNELS[kind] == 1 else ""
            raise ValueError(f"maps[{i}]: {kind} has {CHANNELS[kind]} channels, got {image.shape[2]}{hint}")
        doubt_normals(f"maps[{i}]", image, [kind], ctx.warn)
    total = total_channels(kinds)
    if total > MOST_CHANNELS:
        raise ValueError(f"maps: an Image has up to {MOST_CHANNELS} channels, got {total} in all")
    return np.concatenate(maps, axis=2)


@node
def split_maps(image: Image, *, kinds: Kinds, renormalise: Renormalise = True) -> list[Image]:
    """Split a stack into its maps and make normals unit vectors again.

    Blending pixels shortens normals. A normal whose length is within 1 % of 1 (as 8 bits round it) stays bit for
    bit as it is; one of no length becomes (0, 0, 1).

    Parameters
    ----------
    kinds
        The same as given to `stack_maps`.

    Raises
    ------
    ValueError
        If the kinds do not add up to the picture's channels.
    """
    return [_extract(image, kinds, index, renormalise) for index in range(len(kinds))]


@node
def select_map(
    image: Image,
    *,
    kinds: Kinds,
    index: Annotated[int, Field(ge=0, description="which map, from 0")],
    renormalise: Renormalise = True,
) -> Image:
    """One map of a stack, as `split_maps` gives it.

    Raises
    ------
    ValueError
        If the kinds do not add up to the picture's channels, or the index is beyond them.
    """
    if index >= len(kinds):
        raise ValueError(f"index: expected 0 to {len(kinds) - 1} ({', '.join(kinds)}), got {index}")
    return _extract(image, kinds, index, renormalise)


def _extract(image: NDArray[np.float32], kinds: list[MapKind], index: int, renormalise: bool) -> NDArray[np.float32]:
    require_channels(kinds, image.shape[2])
    part = image[..., map_slices(kinds)[index]]
    return unit_normals(part) if renormalise and kinds[index] in UP else part.copy()
