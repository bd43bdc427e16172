"""How an exemplar is looked at: the parameters that all kinds share, and what they return."""

from typing import Annotated, NamedTuple

from pydantic import Field

from graphtex import Image, Points, ScaleMap
from graphtex_nodes.numerics.plane import Plane, seen_plane

Width = Annotated[int, Field(ge=8, le=4096, description="width of the picture in pixels")]
Height = Annotated[int, Field(ge=8, le=4096, description="height of the picture in pixels")]
Slant = Annotated[
    float, Field(ge=0, le=80, description="angle between view axis and plane's normal, degrees; 0 is face on")
]
Tilt = Annotated[
    float, Field(ge=-180, le=180, description="direction in which elements shrink, degrees clockwise from up")
]
FieldOfView = Annotated[float, Field(gt=0, lt=180, description="camera's angle of view over the longer side, degrees")]

LARGEST_SCALE = 8.0  # what a scale map holds


class Exemplar(NamedTuple):
    """A generated picture with its ground truth."""

    image: Image
    scale: ScaleMap
    centres: Points


class PlainExemplar(NamedTuple):
    """A generated picture of a material without separate elements, with its ground truth."""

    image: Image
    scale: ScaleMap


def framed_plane(width: int, height: int, slant: float, tilt: float, field_of_view: float) -> Plane:
    """The plane that an exemplar is drawn on; ValueError if its scales leave the range of a scale map."""
    plane = seen_plane(width, height, slant, tilt, field_of_view)
    largest = float(plane.scale().max())
    if largest > LARGEST_SCALE:
        raise ValueError(
            f"field_of_view: scales from 1/{largest:.3g} to {largest:.3g} leave what a scale map holds (1/8 to 8): "
            f"expected a smaller slant or field_of_view, got slant {slant:g} and field_of_view {field_of_view:g}"
        )
    return plane
