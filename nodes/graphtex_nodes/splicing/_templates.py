"""Given elements of a picture as templates, turned and sized."""

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

Array = NDArray[Any]


class Example(BaseModel):
    """One element of a texture: where its centre is and how large it is, in pixels."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    x: Annotated[float, Field(ge=0, description="column of its centre")]
    y: Annotated[float, Field(ge=0, description="row of its centre")]
    width: Annotated[float, Field(ge=3, le=4096)]
    height: Annotated[float, Field(ge=3, le=4096)]


def mean_size(examples: Sequence[Example]) -> tuple[float, float]:
    """Mean width and height of examples."""
    width, height = (float(np.mean([getattr(each, side) for each in examples])) for side in ("width", "height"))
    return width, height


class OneColourError(ValueError):
    """There is nothing but one colour in an element's box."""


def check_inside(example: Example, shape: tuple[int, ...], name: str) -> None:
    """ValueError for an element whose centre is not in a picture of that shape."""
    height, width = shape[:2]
    if example.x > width - 1 or example.y > height - 1:
        raise ValueError(
            f"{name}: expected an element with its centre in the picture (x <= {width - 1}, y <= {height - 1}), got "
            f"x = {example.x:g}, y = {example.y:g}"
        )


def cut_out(
    image: Array, example: Example, name: str, *, angle: float = 0.0, scale: float = 1.0, step: float = 1.0,
    margin: int = 0, round_mask: bool = False,
) -> tuple[Array, Array]:  # fmt: skip
    """Template (rows, columns, c) of an element and where it counts (rows, columns); both sides are odd.

    Parameters
    ----------
    angle, scale
        The template shows the element turned clockwise by so many degrees and so many times larger.
    step
        Pixels of the picture between pixels of the template.
    margin
        Pixels more on each side.
    round_mask
        Only the ellipse in the element's box counts (as wide as the longer side in both directions), which is the same
        at every angle.

    Raises
    ------
    OneColourError
        There is nothing but one colour in the element.
    """
    from scipy.ndimage import map_coordinates

    height, width = image.shape[:2]
    sides = (max(example.width, example.height),) * 2 if round_mask else (example.height, example.width)
    half = [max(1, round(side * scale / step / 2)) + margin for side in sides]
    y, x = (np.arange(-k, k + 1) * (step / scale) for k in half)
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    column = example.x + cos * x[None, :] + sin * y[:, None]
    row = example.y - sin * x[None, :] + cos * y[:, None]
    template = np.stack(
        [map_coordinates(channel, [row, column], order=1, mode="mirror") for channel in np.moveaxis(image, -1, 0)], -1
    )
    mask = (row > -0.5) & (row < height - 0.5) & (column > -0.5) & (column < width - 0.5)
    if round_mask:
        mask &= (x[None, :] * 2 / sides[1]) ** 2 + (y[:, None] * 2 / sides[0]) ** 2 <= 1.1
    if np.ptp(template[mask], axis=0).max() <= 1e-6:
        raise OneColourError(
            f"{name}: expected an element that stands out from what is around it, got a box of one colour: give x and "
            f"y of its centre, and its whole width and height, in pixels"
        )
    return template, mask
