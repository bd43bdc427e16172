"""Masks by name, of the size of the drawn samples."""

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import Mask, node, opener
from graphtex_nodes.image.exemplars.sample import PAVING

SIDE = 256
JOINT = 0.6  # height below which the paving's surface is a joint, far away too where joints are narrower than pixels


@opener(Mask, scheme="sample")
@node
def sample_mask(
    *, name: Annotated[Literal["hole", "holes", "paving-joints", "scratches"], Field(description="which mask")]
) -> Mask:  # fmt: skip
    """A mask that ships with the package: ``sample:hole`` where a graph file wants the path of a mask.

    ``hole`` is one broad ellipse near the middle, ``holes`` are three discs of which one touches the border,
    ``scratches`` are thin lines from border to border. ``paving-joints`` are the joints of the sample ``paving``, lines
    one pixel wide, as one would draw them by hand.

    Returns
    -------
    Mask
        (256, 256), as large as the drawn pictures of `Sample`.

    Examples
    --------
    >>> [round(float(sample_mask(name=name).mean()), 2) for name in ("hole", "holes", "scratches")]
    [0.21, 0.09, 0.05]
    """
    if name == "paving-joints":
        return _paving_joints()
    y, x = np.mgrid[:SIDE, :SIDE].astype(np.float64)
    mask = np.zeros((SIDE, SIDE), bool)
    if name == "hole":
        mask |= ((x - 132) / 84) ** 2 + ((y - 150) / 52) ** 2 < 1
    elif name == "holes":
        for across, below, radius in ((70, 80, 22), (180, 150, 30), (40, 250, 28)):
            mask |= np.hypot(x - across, y - below) < radius
    else:
        for right, down, offset in ((0.9, 0.4, 100.0), (0.2, -1.0, -60.0), (0.7, 0.7, 250.0), (1.0, -0.3, 30.0)):
            mask |= np.abs(right * x + down * y - offset + 4 * np.sin(y / 17)) < 1.6
    return mask


def _paving_joints() -> NDArray[np.bool_]:
    """Middle lines of what lies low in the paving."""
    from skimage.morphology import skeletonize

    height: NDArray[np.float32] = PAVING().height[..., 0]
    joints: NDArray[np.bool_] = skeletonize(height < JOINT)
    return joints
