"""An entry of a texture database: a picture with its foreground, its textons, and what of it is rigid."""

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from graphtex import QUIET, Axes, Context, Image, Mask, Points, Texture, node
from graphtex_nodes.splicing.tags import RigidPart, Tag

Array = NDArray[Any]

CONNECTED = 0.5  # share of the elements in one connected part of the foreground
COMPACT = 0.85  # share of their convex hull that elements fill which only touch
PACKED = 0.5  # share of the picture that elements fill at least which have only joints between them
NARROW = 0.75  # width of a joint at most, over the radius of the largest disc in an element
ROUND = 0.95  # overlap (IoU) of an element with an ellipse; a regular hexagon's is 0.93


@node
def texture_entry(
    image: Annotated[Image, Axes("h w c")],
    mask: Annotated[Mask, Axes("h w")],
    points: Points,
    *,
    tag: Tag | None = None,
    ctx: Context = QUIET,
) -> Texture:
    """Bundle a texture for splicing (Liu et al. 2009, section 3).

    Parameters
    ----------
    mask
        True on the foreground.
    points
        Centres (x, y) of the textons.
    tag
        Without one it is suggested: `suggested_tag` looks at how the foreground hangs together.

    Returns
    -------
    Texture
        For the nodes that splice; `SplitTexture` takes it apart.

    Raises
    ------
    ValueError
        There are no points, some lie outside the picture, or the mask is all or nothing.

    Examples
    --------
    >>> from graphtex_nodes import sample_texture
    >>> image, mask, points, _ = sample_texture(name="tiles")
    >>> texture_entry(image, mask, points).tag
    'B=c'
    """
    if not len(points):
        raise ValueError("points: expected at least one texton, got none")
    last = np.array(mask.shape[::-1]) - 1
    outside = (points < -0.5) | (points > last + 0.5)
    if outside.any():
        row = int(np.flatnonzero(outside.any(axis=1))[0])
        raise ValueError(
            f"points: expected all in the picture (x <= {last[0]}, y <= {last[1]}), got "
            f"{int(outside.any(axis=1).sum())} outside, the first of them ({points[row, 0]:g}, {points[row, 1]:g})"
        )
    if mask.all() or not mask.any():
        raise ValueError(
            f"mask: expected some foreground and some background, got {'only' if mask.all() else 'no'} foreground"
        )
    if tag is None:
        tag = suggested_tag(mask, points)
        ctx.progress(1.0, f"tag {tag}")
    return Texture(image, mask, points, tag)


def suggested_tag(mask: Array, points: Array) -> RigidPart:
    """``B=c`` if textons have only joints between them, ``F=c`` if most of them hang together, else ``F=d``.

    Packed elements cannot go to other places as they are: they would lie on each other and leave gaps. Their joints can
    be kept instead. Discs and other ellipses touch at points alone and have no joints, so they stay what they are.
    Compact elements that touch do not hang together: they keep their shape one by one, where a net or a chain would be
    torn.
    """
    from scipy.ndimage import label
    from skimage.measure import regionprops

    from graphtex_nodes.splicing.texton_labels import texton_labels

    labels = texton_labels(mask, points)
    if jointed(mask, labels):
        return "B=c"
    parts, count = label(mask)
    column, row = np.clip(np.rint(points), 0, np.array(mask.shape[::-1]) - 1).astype(np.intp).T
    held = np.bincount(parts[row, column], minlength=count + 1)[1:]
    if held.max(initial=0) > max(1, CONNECTED * len(points)):
        hulls = [region.solidity for region in regionprops(labels + 1)]
        return "F=d" if np.median(hulls) > COMPACT else "F=c"
    return "F=d"


def jointed(mask: Array, labels: Array) -> bool:
    """Whether the background is a net of narrow joints between elements that are not round."""
    from scipy.ndimage import distance_transform_edt, label, maximum
    from skimage.measure import regionprops
    from skimage.segmentation import watershed

    found = np.unique(labels[labels >= 0])
    if len(found) < 2 or mask.mean() <= PACKED:
        return False
    nets = np.bincount(label(~mask, np.ones((3, 3)))[0][~mask])
    if nets.max() <= CONNECTED * nets.sum():
        return False
    apart = distance_transform_edt(~mask)
    middle = (watershed(apart, labels + 1, watershed_line=True) == 0) & ~mask
    radius = float(np.median(maximum(distance_transform_edt(mask), labels, found)))
    if not middle.any() or 2 * float(np.median(apart[middle])) - 1 > NARROW * radius:
        return False
    regions = regionprops(labels + 1)
    border = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])) + 1
    whole = [region for region in regions if region.label not in border] or regions
    return float(np.median([_roundness(region.image) for region in whole])) < ROUND


def _roundness(element: Array) -> float:
    """Overlap (IoU) of an element (h, w) with the ellipse of the same moments."""
    element = np.pad(element, max(element.shape) // 2)
    places = np.argwhere(element)
    middle = places.mean(axis=0)
    offset = places - middle
    # a pixel is a square of variance 1 / 12, not a point
    inverse = np.linalg.inv(offset.T @ offset / len(places) + np.eye(2) / 12)
    away = np.moveaxis(np.indices(element.shape), 0, -1) - middle
    ellipse = np.einsum("...i,ij,...j", away, inverse, away) <= 4
    return float(np.count_nonzero(ellipse & element) / np.count_nonzero(ellipse | element))
