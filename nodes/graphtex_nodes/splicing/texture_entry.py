"""An entry of a texture database: a picture with its foreground, its textons, and what of it is rigid."""

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from graphtex import QUIET, Axes, Context, Image, Mask, Points, Texture, node
from graphtex_nodes.splicing.tags import RigidPart, Tag

Array = NDArray[Any]

CONNECTED = 0.5  # share of the elements in one connected part of the foreground
COMPACT = 0.85  # share of their convex hull that elements fill which only touch
FILLED = 0.85  # share of its box that a brick fills
JOINTS = 0.5  # share of the picture that joints between bricks take at most


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
    """``F=c`` if most textons hang together, ``B=c`` if they are boxes with narrow joints between, else ``F=d``.

    Compact elements that touch do not hang together: they keep their shape one by one, where a net or a chain would be
    torn. Straight joints show when they are bent, so there the background is what must stay rigid.
    """
    from scipy.ndimage import find_objects, label
    from skimage.measure import regionprops

    from graphtex_nodes.splicing.texton_labels import texton_labels

    parts, count = label(mask)
    column, row = np.clip(np.rint(points), 0, np.array(mask.shape[::-1]) - 1).astype(np.intp).T
    held = np.bincount(parts[row, column], minlength=count + 1)[1:]
    if held.max(initial=0) > max(1, CONNECTED * len(points)):
        hulls = [region.solidity for region in regionprops(texton_labels(mask, points) + 1)]
        return "F=d" if np.median(hulls) > COMPACT else "F=c"
    areas = np.bincount(parts.ravel(), minlength=count + 1)[1:]
    boxes = np.array([(r.stop - r.start) * (c.stop - c.start) for r, c in find_objects(parts)])
    single = held == 1
    filled = float(np.median(areas[single] / boxes[single])) if single.any() else 0.0
    return "B=c" if filled > FILLED and mask.mean() > 1 - JOINTS else "F=d"
