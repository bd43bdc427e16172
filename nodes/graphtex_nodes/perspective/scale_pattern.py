"""Scale maps by design: from a pattern or from a grey picture (Dong, Zhou & Paul 2008, section 5 and Fig. 13)."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Image, ScaleMap, node
from graphtex_nodes.perspective._sizes import Pixels

Array = NDArray[Any]
Low = Annotated[float, Field(ge=1 / 8, le=8, description="smallest scale")]
High = Annotated[float, Field(ge=1 / 8, le=8, description="largest scale")]
Spacing = Annotated[
    Literal["log", "linear"], Field(description="log: equal ratios for equal steps; linear: equal differences")
]
Shape = Literal["ramp", "radial", "s_curve", "waves"]


@node
def scale_pattern(
    *,
    pattern: Annotated[Shape, Field(description="how scales are laid out")] = "ramp",
    width: Pixels,
    height: Pixels,
    low: Low = 0.5,
    high: High = 2.0,
    spacing: Spacing = "log",
    angle: Annotated[float, Field(ge=-360, le=360, description="turns the pattern, degrees clockwise from up")] = 0.0,
    waves: Annotated[float, Field(gt=0, le=64, description="number of waves across the picture")] = 2.0,
) -> ScaleMap:
    r"""Scale map of a given pattern, from the smallest to the largest scale.

    With a the distance along the direction of `angle` and b the distance to the right of it, both from the picture's
    middle and divided by their largest value in the picture (so they lie in [-1, 1]),

    =========== ======================================================================================
    ``ramp``    largest at a = -1, smallest at a = 1: what a plane shows that recedes towards `angle`
    ``radial``  largest in the middle, smallest in the corners
    ``s_curve`` largest along an S, :math:`b = -\frac{1}{2} \sin(\pi a)`, smallest far from it
    ``waves``   a cosine along a with `waves` periods, largest in the middle
    =========== ======================================================================================

    Parameters
    ----------
    low, high
        Both are reached (by ``waves``, if there is half a wave at least; by ``s_curve`` in pictures of some pixels).
        ``high`` below ``low`` turns the pattern round.
    spacing
        ``linear`` suits a ramp that is to be a plane: its scale is linear in the picture.

    Returns
    -------
    ScaleMap
        (height, width), within [low, high]. A picture of one pixel is in the middle of every pattern.

    Examples
    --------
    >>> scale_pattern(width=1, height=3, low=0.5, high=2.0)[:, 0]
    array([0.5, 1. , 2. ], dtype=float32)
    """
    right = np.arange(width) - (width - 1) / 2
    up = ((height - 1) / 2 - np.arange(height))[:, None]
    sin, cos = np.sin(np.radians(angle)), np.cos(np.radians(angle))
    along, across = _normed(right * sin + up * cos), _normed(right * cos - up * sin)
    if pattern == "ramp":
        share = (1 - along) / 2
    elif pattern == "radial":
        share = 1 - _normed(np.hypot(right, up))
    elif pattern == "s_curve":
        # 1.25: the S at its widest is 1/2 off the middle, and from there to the far side it is 3/2
        share = (1 + np.cos(np.pi * np.minimum(np.abs(across + np.sin(np.pi * along) / 2) / 1.25, 1))) / 2
    else:
        share = (1 + np.cos(np.pi * waves * along)) / 2
    return _scaled(share, low, high, spacing)


@node
def scale_from_image(
    image: Image,
    *,
    low: Low = 0.5,
    high: High = 2.0,
    spacing: Spacing = "log",
    stretch: Annotated[bool, Field(description="the picture's darkest value counts as black, its brightest white")] = (
        False
    ),
    ctx: Context = QUIET,
) -> ScaleMap:
    """Scale map of a grey picture: black becomes the smallest scale, white the largest.

    Unlike `LoadScale` this reads the picture as a drawing, not as the 8-bit view of a scale map (128 = 1).

    Parameters
    ----------
    image
        (h, w, c); of several channels the mean counts. Values beyond [0, 1] are clamped, with a warning.
    low, high
        ``high`` below ``low`` makes white the smallest.

    Returns
    -------
    ScaleMap
        (h, w), within [low, high]. With `stretch`, a picture of one grey has the scale in the middle.

    Examples
    --------
    >>> scale_from_image(np.array([[[0.0], [0.5], [1.0]]], np.float32), low=0.25, high=4.0)
    array([[0.25, 1.  , 4.  ]], dtype=float32)
    """
    grey = image.mean(axis=2, dtype=np.float64)
    if stretch:
        darkest, brightest = grey.min(), grey.max()
        grey = (grey - darkest) / (brightest - darkest) if brightest > darkest else np.full_like(grey, 0.5)
    share = float(np.mean((grey < 0) | (grey > 1)))
    if share:
        ctx.warn(f"{share:.1%} of the picture lies outside [0, 1] and was clamped: stretch fits it in")
    return _scaled(np.clip(grey, 0, 1), low, high, spacing)


def _normed(values: Array) -> Array:
    """Values over the largest of them."""
    largest = np.abs(values).max()
    result: Array = values / largest if largest > 1e-9 else np.zeros_like(values)
    return result


def _scaled(share: Array, low: float, high: float, spacing: str) -> Array:
    """Scales at shares (0 to 1) of the way from low to high."""
    share = np.clip(share, 0, 1)
    scale = low * (high / low) ** share if spacing == "log" else low + (high - low) * share
    return np.ascontiguousarray(np.clip(scale, min(low, high), max(low, high)), np.float32)
