"""Elements drawn on the picture that they were found in."""

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import Axes, Elements, Image, Mask, node

Array = NDArray[Any]

LINE = (0.84, 0.15, 0.16)
PALE = 0.75  # how far the ground is faded to white


@node
def draw_elements(
    image: Annotated[Image, Axes("h w c")],
    elements: Elements,
    mask: Annotated[Mask, Axes("h w")] | None = None,
    *,
    width: Annotated[float, Field(ge=0, description="of an element's box at scale 1, pixels; 0 = no boxes")] = 0.0,
    height: Annotated[float, Field(ge=0, description="of an element's box at scale 1, pixels; 0 = no boxes")] = 0.0,
) -> Image:
    """Draw the centre of each element, its box as it is turned and sized, and the ground faded where a mask is given.

    Returns
    -------
    Image
        RGB, as large as the picture.

    Raises
    ------
    ValueError
        The mask has another size than the picture.
    """
    from skimage.draw import disk, line

    channels = [0, 0, 0] if image.shape[2] < 3 else [0, 1, 2]
    drawn = np.clip(image[..., channels], 0, 1)
    if mask is not None:
        drawn = np.where(mask[..., None], drawn, PALE + (1 - PALE) * drawn).astype(np.float32)
    shape = drawn.shape[:2]
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (width / 2, height / 2)
    for (x, y), angle, scale in zip(elements.points, elements.angles, elements.scales, strict=True):
        drawn[disk((y, x), 2, shape=shape)] = LINE
        if width <= 0 or height <= 0:
            continue
        cos, sin = np.cos(np.radians(angle)) * scale, np.sin(np.radians(angle)) * scale
        around = np.rint(corners @ np.array([[cos, sin], [-sin, cos]]) + (x, y)).astype(int)
        for (x0, y0), (x1, y1) in zip(around, np.roll(around, -1, axis=0), strict=True):
            row, column = line(y0, x0, y1, x1)
            inside = (row >= 0) & (column >= 0) & (row < shape[0]) & (column < shape[1])
            drawn[row[inside], column[inside]] = LINE
    return drawn
