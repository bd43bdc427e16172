"""Similar pixels of a texture, for k-coherent synthesis (Tong et al. 2002; Lefebvre & Hoppe 2006)."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Image, Texture, node, struct_type
from graphtex_nodes.splicing.values import Indices

Array = NDArray[Any]

MASK_WEIGHT = 1.5
APART = 0.05
"""Least distance of a pixel from its similar ones, over the texture's longer side."""
ASKED = 6
"""Nearest windows that are looked at for each similar pixel wanted."""


@struct_type("similar pixels of a texture at two spacings")
class NeighbourSets(NamedTuple):
    """Appearance of each pixel, (h, w, 8), and flat indices of pixels like it, itself first, at two spacings.

    ``fine`` belongs to windows of neighbouring pixels, ``coarse`` to windows of every second one.
    """

    fine_appearance: Image
    fine_sets: Indices
    coarse_appearance: Image
    coarse_sets: Indices


@node
def neighbour_sets(
    texture: Texture,
    *,
    count: Annotated[int, Field(ge=1, le=16, description="pixels of each set, itself included")] = 3,
    ctx: Context = QUIET,
) -> NeighbourSets:
    """Find for each pixel of a texture others whose surroundings look alike.

    Appearance is that of `AppearanceVectors`, of colour and mask together. Similar pixels are the nearest in appearance
    (k-d tree, at most twice as far as the exact ones) that lie apart from the pixel and from each other by 5 % of the
    texture.

    Parameters
    ----------
    texture
        Image (h, w, c) and mask (h, w).

    Returns
    -------
    NeighbourSets
        Depends on the texture alone: made once, it serves every splice of it.
    """
    from graphtex_nodes.splicing.extend_texture import checked

    checked(texture)
    fine = _appearance(texture, 1)
    fine_sets = _sets(fine, count)
    ctx.progress(0.5, "similar pixels")
    coarse = _appearance(texture, 2)
    return NeighbourSets(fine, fine_sets.ravel(), coarse, _sets(coarse, count).ravel())


def _appearance(texture: Texture, spacing: int) -> Array:
    """Appearance vectors (h, w, 8) of every ``spacing``-th pixel's neighbourhood of colour and mask."""
    from scipy.ndimage import gaussian_filter

    from graphtex_nodes.numerics.appearance import appearance_space

    spread = float(np.sqrt(np.var(texture.image, axis=(0, 1), dtype=np.float64).mean()))
    mask = texture.mask[..., None] * np.float32(MASK_WEIGHT * max(spread, 1e-3))
    layers = np.concatenate([texture.image, mask], axis=2)
    if spacing > 1:
        layers = gaussian_filter(layers, (spacing / 2, spacing / 2, 0), mode="reflect")
    space = appearance_space(layers[::spacing, ::spacing])
    result = np.zeros((*texture.mask.shape, space.mean.size), np.float32)
    for down in range(min(spacing, result.shape[0])):
        for right in range(min(spacing, result.shape[1])):
            result[down::spacing, right::spacing] = space.project(layers[down::spacing, right::spacing])
    return result


def _sets(appearance: Array, count: int) -> Array:
    """Flat indices (h * w, count) of pixels that look alike."""
    from scipy.spatial import cKDTree

    height, width, channels = appearance.shape
    size = height * width
    own = np.arange(size)
    sets = np.repeat(own[:, None], count, axis=1).astype(np.int32)
    asked = min(size, ASKED * (count - 1) + 1)
    if asked < 2:
        return sets
    features = appearance.reshape(size, channels)
    near = np.asarray(cKDTree(features).query(features, k=asked, eps=1.0)[1])
    least = (APART * max(height, width)) ** 2
    for number in range(1, count):
        far = np.ones(near.shape, bool)
        for other in range(number):
            rows, columns = np.divmod(sets[:, other], width)
            far &= (near // width - rows[:, None]) ** 2 + (near % width - columns[:, None]) ** 2 >= least
        some = far.any(axis=1)
        sets[some, number] = near[own, far.argmax(axis=1)][some]
    return sets
