"""Elements of an arrangement turned, sized and left out (Liu et al. 2009, Fig. 9, and beyond)."""

from typing import Annotated

import numpy as np
from pydantic import Field

from graphtex import Elements, Rng, node


@node
def vary_elements(
    target: Elements,
    *,
    angle: Annotated[float, Field(ge=-360, le=360, description="turn of all elements, degrees clockwise")] = 0.0,
    turn: Annotated[float, Field(ge=0, le=180, description="each is turned by up to so much more, at random")] = 0.0,
    scale: Annotated[float, Field(ge=0.1, le=8, description="size of all elements")] = 1.0,
    growth: Annotated[
        float, Field(ge=1, le=4, description="each is up to so many times larger or smaller, at random")
    ] = 1.0,
    keep: Annotated[float, Field(gt=0, le=1, description="share of the places that stay, at random")] = 1.0,
    rng: Rng = 0,
) -> Elements:
    """Turn and size elements, all alike or each by itself, or leave some out.

    Parameters
    ----------
    target
        Places with the angle and scale that elements have so far; both are added to.

    Returns
    -------
    Elements
        At least one place, if there was any. Angles and scales count where the warp holds whole elements.
    """
    count = len(target.points)
    angles = target.angles + angle + rng.uniform(-turn, turn, count)
    scales = target.scales * scale * growth ** rng.uniform(-1, 1, count)
    left = int(np.ceil(keep * count))
    stay = np.sort(rng.permutation(count)[:left])
    return Elements(target.points[stay], angles[stay], scales[stay])
