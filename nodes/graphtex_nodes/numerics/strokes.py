"""Brush strokes as plain data, and how strongly they cover each pixel of a picture of any size."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from graphtex import FilePath

Array = NDArray[Any]
Place = tuple[float, float]
Pixels = Annotated[int, Field(ge=1)]


class Measured(BaseModel):
    """Something drawn on a picture: what its coordinates and lengths mean on a picture of another size.

    In ``pixels``, pixel centres are at integers, y down. In ``relative`` units, (0, 0) is the picture's upper left
    corner and (1, 1) its lower right one; lengths are shares of its longer side. `size` (width, height) is that of the
    picture that it was drawn on; none is the size of the picture that it is used on. A picture of another size is taken
    for the same picture resampled: places are stretched with it, lengths by the root of the ratio of areas.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    units: Annotated[Literal["pixels", "relative"], Field(description="what coordinates and lengths count")] = "pixels"
    size: Annotated[
        tuple[Pixels, Pixels] | None, Field(description="width and height of the picture that it was drawn on")
    ] = None

    def places(self, points: Array, width: int, height: int) -> Array:
        """Pixel coordinates (n, 2) on a picture of width x height."""
        if self.units == "relative":
            placed: Array = points * np.array([width, height]) - 0.5
        else:
            drawn = self.size or (width, height)
            placed = (points + 0.5) * np.array([width / drawn[0], height / drawn[1]]) - 0.5
        return placed

    def length(self, value: float, width: int, height: int) -> float:
        """A length in pixels of a picture of width x height."""
        drawn = self.size or (width, height)
        unit = max(drawn) if self.units == "relative" else 1
        return value * unit * float(np.sqrt(width * height / (drawn[0] * drawn[1])))

    def shift(self, value: Place, width: int, height: int) -> tuple[float, float]:
        """A shift (x, y) in pixels of a picture of width x height."""
        drawn = (1, 1) if self.units == "relative" else self.size or (width, height)
        return value[0] * width / drawn[0], value[1] * height / drawn[1]


class Stroke(BaseModel):
    """A polyline drawn with a round brush; a single point is a dab."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    points: Annotated[tuple[Place, ...], Field(min_length=1, description="x, y of the places it goes through")]
    radius: Annotated[float, Field(gt=0, description="half the brush's width")]
    softness: Annotated[float, Field(ge=0, description="width of the soft rim; half of it lies outside the radius")] = 0
    label: Annotated[str, Field(description="what the stroke stands for, where a node tells strokes apart")] = ""


class Strokes(Measured):
    """Strokes, inline or in a JSON file: ``{file: strokes.json}``; the file holds what could stand inline."""

    lines: Annotated[tuple[Stroke, ...], Field(description="the strokes")] = ()
    file: Annotated[FilePath | None, Field(description="JSON file with units, size and lines, instead of these")] = None

    @model_validator(mode="after")
    def _one_source(self) -> "Strokes":
        if self.file is not None and (self.lines or self.size is not None or self.units != "pixels"):
            raise ValueError("expected either a file or lines (with their units and size), got both")
        return self

    def read(self) -> "Strokes":
        """These strokes, or those of the file.

        Raises
        ------
        ValueError
            The file cannot be read, is no JSON of strokes, or names a file in turn.
        """
        if self.file is None:
            return self
        try:
            found = Strokes.model_validate_json(self.file.read_bytes(), strict=True)
        except OSError as error:
            raise ValueError(f"file: {self.file} cannot be read: {error.strerror}") from error
        except ValidationError as error:
            faults = [f"{'.'.join(map(str, fault['loc'])) or 'file'}: {fault['msg']}" for fault in error.errors()]
            raise ValueError(f"file: {self.file} does not hold strokes: {'; '.join(faults)}") from error
        if found.file is not None:
            raise ValueError(f"file: {self.file} should hold strokes, got the name of another file, {found.file}")
        return found


def stroke_weights(strokes: Strokes, width: int, height: int, *, label: str | None = None) -> Array:
    """How strongly strokes cover each pixel: float64 (height, width) in [0, 1]; where they overlap, the stronger.

    Parameters
    ----------
    label
        Only the strokes of this label; none takes all.
    """
    strokes = strokes.read()
    weights = np.zeros((height, width))
    for stroke in strokes.lines:
        if label is not None and stroke.label != label:
            continue
        points = strokes.places(np.array(stroke.points, np.float64), width, height)
        radius = strokes.length(stroke.radius, width, height)
        softness = strokes.length(stroke.softness, width, height)
        distance = polyline_distance(points, width, height, reach=radius + max(softness, 1) / 2)
        np.maximum(weights, soft_step(radius - distance, softness), out=weights)
    return weights


def soft_step(inside: Array, softness: float) -> Array:
    """Weight in [0, 1] of pixels that lie `inside` (pixels, negative is outside) an outline, where it is 1/2.

    It falls over `softness` pixels, but never less than one, so that edges are smooth at the size of pixels.
    """
    share = np.clip(inside / max(softness, 1.0) + 0.5, 0, 1)
    weights: Array = share * share * (3 - 2 * share)
    return weights


def polyline_distance(points: Array, width: int, height: int, *, reach: float) -> Array:
    """Distance (pixels) of each pixel's centre to the nearest place of a polyline, infinite beyond `reach`.

    `points` is (n, 2), x and y. The work grows with the area within reach of each segment.
    """
    squared = np.full((height, width), np.inf)
    ends = points[1:] if len(points) > 1 else points
    for (x0, y0), (x1, y1) in zip(points[: len(ends)], ends, strict=True):
        left, right = _span(x0, x1, reach, width)
        top, bottom = _span(y0, y1, reach, height)
        if left >= right or top >= bottom:
            continue
        x, y = np.arange(left, right) - x0, np.arange(top, bottom)[:, None] - y0
        along_x, along_y = x1 - x0, y1 - y0
        length = along_x**2 + along_y**2
        share = np.clip((x * along_x + y * along_y) / length, 0, 1) if length > 0 else 0.0
        window = squared[top:bottom, left:right]
        np.minimum(window, (x - share * along_x) ** 2 + (y - share * along_y) ** 2, out=window)
    squared[squared > reach * reach] = np.inf
    distance: Array = np.sqrt(squared)
    return distance


def _span(start: float, end: float, reach: float, count: int) -> tuple[int, int]:
    """First and one past the last of `count` pixels within reach of an interval."""
    low, high = np.clip([min(start, end) - reach, max(start, end) + reach + 1], 0, count)
    return int(np.ceil(low)), int(np.ceil(high))
