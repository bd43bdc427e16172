"""A part of a picture."""

from typing import Annotated

import numpy as np
from pydantic import Field

from graphtex import Image, node

Place = Annotated[int, Field(ge=0, description="first pixel, from the left or from the top")]
Side = Annotated[int, Field(ge=0, description="pixels; 0 = up to the border")]


@node
def crop_image(image: Image, *, x: Place = 0, y: Place = 0, width: Side = 0, height: Side = 0) -> Image:
    """Cut a rectangle out of a picture: the ground without the sky, or a piece to try things on.

    Parameters
    ----------
    image
        (h, w, c).
    x, y
        Column and row of the rectangle's upper left pixel.
    width, height
        Its sides.

    Returns
    -------
    Image
        (height, width, c), pixels as they were.

    Raises
    ------
    ValueError
        If the rectangle reaches over the border.

    Examples
    --------
    >>> picture = np.arange(12, dtype=np.float32).reshape(3, 4, 1)
    >>> crop_image(picture, x=1, width=2, y=2)[..., 0].tolist()
    [[9.0, 10.0]]
    """
    high, wide = image.shape[:2]
    for names, first, side, size in ((("x", "width"), x, width, wide), (("y", "height"), y, height, high)):
        if first >= size:
            raise ValueError(f"{names[0]}: expected less than the picture's {names[1]} of {size}, got {first}")
        if first + side > size:
            raise ValueError(f"{names[1]}: expected at most {size - first} from {names[0]} {first} on, got {side}")
    return np.ascontiguousarray(image[y : y + height if height else high, x : x + width if width else wide])
