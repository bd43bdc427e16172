"""The direction of a texture's grain, found in its picture."""

from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from graphtex import QUIET, AngleMap, Context, Image, Number, node

NO_DIRECTION = 0.1  # anisotropy below which the direction found is chance


class Flow(NamedTuple):
    """Direction of the grain, and how much it stands out."""

    angle: AngleMap
    anisotropy: Number


@node
def flow_from_image(
    image: Image,
    *,
    window: Annotated[
        float, Field(ge=0, le=512, description="pixels over which the direction is averaged; 0 = the whole picture")
    ] = 0.0,
    sigma: Annotated[float, Field(gt=0, le=32, description="smoothing before anything else, pixels")] = 1.5,
    ctx: Context = QUIET,
) -> Flow:
    r"""Direction in which lines, grain or blades run, by the structure tensor (Bigün & Granlund 1987).

    It is the direction in which the picture changes least: half the angle of the mean of the squared gradient, taken as
    a complex number, turned by 90 degrees.

    Parameters
    ----------
    image
        (h, w, c), any channels.
    window
        Standard deviation of the Gaussian that averages. 0 suits an exemplar with one direction throughout; the size of
        an element, about 8, one whose elements lie in all directions, such as blades of grass.

    Returns
    -------
    Flow
        ``angle`` (h, w) in degrees clockwise from right, [0, 180): lines have no heads. ``anisotropy`` is the share of
        the gradient that agrees, from 0 (no direction, the angles tell nothing) to 1 (parallel lines). Below 0.1 the
        node warns.

    Examples
    --------
    >>> columns = np.tile(np.float32([0, 0, 1, 1]), (16, 4))[..., None]
    >>> flow = flow_from_image(columns)
    >>> float(flow.angle[5, 5]), round(flow.anisotropy, 3)
    (90.0, 1.0)
    """
    from graphtex_nodes.numerics.orientation import structure

    angles, clear, energy = structure(image, sigma, window)
    total = float(energy.sum())
    anisotropy = float(clear.sum()) / total if total > 0 else 0.0
    if anisotropy < NO_DIRECTION:
        hint = "; a window of the size of an element, about 8, may find those of its parts" if window == 0 else ""
        ctx.warn(f"no direction stands out in the picture, its anisotropy is {anisotropy:.2g}{hint}")
    return Flow(angles.astype(np.float32), anisotropy)
