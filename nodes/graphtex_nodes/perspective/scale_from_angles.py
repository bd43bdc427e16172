"""Texel scale of a plane seen in perspective, from its slant and tilt (Dong, Zhou & Paul 2008, section 3.2)."""

from typing import Annotated

import numpy as np
from pydantic import Field

from graphtex import QUIET, Context, Image, ScaleMap, node
from graphtex_nodes.numerics.plane import seen_plane
from graphtex_nodes.perspective._sizes import MOST

Slant = Annotated[float, Field(ge=0, lt=90, description="angle between the view axis and the plane's normal, degrees")]
Tilt = Annotated[float, Field(ge=-180, le=180, description="where texels shrink to, degrees clockwise from up")]
View = Annotated[float, Field(gt=0, lt=180, description="camera's angle of view over the longer side, degrees")]
Pixels = Annotated[int, Field(ge=0, le=MOST, description="pixels; 0 takes the picture's")]

SMALLEST, LARGEST = 1 / 8, 8.0


@node
def scale_from_angles(
    image: Image | None = None,
    *,
    width: Pixels = 0,
    height: Pixels = 0,
    slant: Slant = 45.0,
    tilt: Tilt = 0.0,
    field_of_view: View | None = None,
    mirror: Annotated[bool, Field(description="exchange left and right of the finished map")] = False,
    flip: Annotated[bool, Field(description="exchange top and bottom of the finished map")] = False,
    ctx: Context = QUIET,
) -> ScaleMap:
    r"""Scale map of a plane, linear along the tilt direction.

    The inverse depth of a plane is linear in its picture, and texels are as large as the inverse depth:

    .. math:: S(p) = S_{max} - (y_p + Y) \frac{S_{max} - S_{min}}{2 Y},\quad y_p = x \sin\tau + y \cos\tau

    with (x, y) the pixel's centre measured from the picture's centre, y up, and Y the largest :math:`y_p`. The ends are
    :math:`1/\cos\sigma` and :math:`\cos\sigma`, or, if the camera's field of view :math:`\beta` is given, the true:

    .. math:: S_{max} / S_{min} = (1 + k) / (1 - k),\quad k = \tan\sigma\,Y / f,\quad S_{max} S_{min} = 1

    with the focal length :math:`f` = longer side / (2 tan(β/2)), all in pixels.

    Parameters
    ----------
    image
        Nothing is read of it but its size, which the map takes where ``width`` and ``height`` give none.
    slant
        0 is a plane seen face on (S = 1 everywhere).
    tilt
        0 makes texels shrink upwards, 90 to the right, 180 downwards.
    field_of_view
        None takes the paper's ends, which do not depend on the camera. They understate strong perspective: at slant 55
        a camera of 45 degrees sees a range of 3.9 where 1/cos²(slant) is 3.0. A map shows tan(slant) tan(view/2) only.
    mirror, flip
        The paper wants the largest texel at the bottom left and turns the picture until it is there. Here any tilt from
        -180 to 180 is taken as it is; these two turn the map where a picture was turned.

    Returns
    -------
    ScaleMap
        (height, width). The product of both ends is 1. Ends beyond [1/8, 8] (slants over 82.8) are clamped, with a
        warning that tells the share of pixels.

    Raises
    ------
    ValueError
        There is neither a size nor a picture. With a field of view: the horizon is in the picture, tan(slant)
        tan(view/2) >= 1 in a square picture of tilt 0; what counts in general is the corner that is furthest along the
        tilt.

    Notes
    -----
    Equation 4 of the paper prints Y_max where S_max is meant. Its centre, w/2 and h/2, lies half a pixel off the middle
    of the pixels, with which S would exceed S_max: the centre here is ((w - 1)/2, (h - 1)/2).

    Examples
    --------
    >>> scale_from_angles(width=1, height=3, slant=60.0)[:, 0]
    array([0.5 , 1.25, 2.  ], dtype=float32)
    """
    for name, given in (("width", width), ("height", height)):
        if not given and image is None:
            raise ValueError(f"{name}: expected at least 1 pixel, or an image to take the size from, got {given}")
    if image is not None:
        width, height = width or image.shape[1], height or image.shape[0]
    scale = seen_plane(width, height, slant, tilt, field_of_view).scale()
    clamped = np.clip(scale, SMALLEST, LARGEST)
    share = float(np.mean(np.abs(scale - clamped) > 1e-6 * clamped))  # rounding is not worth a warning
    if share:
        ctx.warn(f"slant: {share:.1%} of the scales lie outside [1/8, 8] and are clamped: a smaller slant has fewer")
    if mirror:
        clamped = clamped[:, ::-1]
    if flip:
        clamped = clamped[::-1]
    return np.ascontiguousarray(clamped, np.float32)
