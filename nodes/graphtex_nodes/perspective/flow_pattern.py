"""Fields of directions by design, for grain, blades or ripples to follow."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from graphtex import AngleMap, node
from graphtex_nodes.perspective._sizes import Pixels

Shape = Literal["constant", "radial", "circular", "wave"]


@node
def flow_pattern(
    *,
    pattern: Annotated[Shape, Field(description="how directions are laid out")] = "circular",
    width: Pixels,
    height: Pixels,
    angle: Annotated[float, Field(ge=-180, le=180, description="turns all directions, degrees clockwise")] = 0.0,
    swing: Annotated[float, Field(ge=0, le=90, description="wave: how far directions turn to either side")] = 40.0,
    waves: Annotated[float, Field(gt=0, le=64, description="wave: number of waves across the picture")] = 1.0,
) -> AngleMap:
    r"""Direction field of a given pattern.

    With (x, y) from the picture's middle, y down, and u the distance along the direction of `angle`, in parts of the
    picture's extent in it,

    ============ =========================================================================================
    ``constant`` `angle` everywhere
    ``radial``   away from the middle, turned by `angle`: :math:`\operatorname{atan2}(y, x)` + angle
    ``circular`` clockwise around the middle, turned by `angle`: with 30, a spiral that winds inwards
    ``wave``     angle + swing :math:`\cos(2\pi\,` waves :math:`u)`: lines that swing to both sides as they go on
    ============ =========================================================================================

    Returns
    -------
    AngleMap
        (height, width), degrees clockwise from right, in [-180, 180].

    Examples
    --------
    >>> flow_pattern(pattern="radial", width=3, height=1)
    array([[180.,   0.,   0.]], dtype=float32)
    """
    x = np.arange(width) - (width - 1) / 2
    y = (np.arange(height) - (height - 1) / 2)[:, None]
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    around = np.degrees(np.arctan2(y, x))
    if pattern == "constant":
        turned = np.full((height, width), angle)
    elif pattern == "wave":
        extent = abs(cos) * width + abs(sin) * height
        turned = angle + swing * np.cos(2 * np.pi * waves * (x * cos + y * sin) / extent)
    else:
        turned = around + angle + (90 if pattern == "circular" else 0)
    return wrapped(turned)


def wrapped(angles: np.ndarray) -> AngleMap:
    """Angles in degrees as a map, from -180 to 180."""
    over = np.ceil((angles - 180) / 360)
    return np.ascontiguousarray(np.clip(angles - 360 * over, -180, 180), np.float32)
