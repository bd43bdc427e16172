"""Socket types: nominal types over numpy arrays, numbers and named tuples of them.

A type is an annotated alias, ``Image = Annotated[NDArray, ArrayType("Image", ...)]``: type checkers see the array, the
framework sees the specification.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple, TypeAlias

from numpy.typing import NDArray

from graphtex.errors import did_you_mean
from graphtex.kinds import TYPES, ArrayType, NumberType, SocketType, StructType, find_type, struct_type

__all__ = [
    "TYPES",
    "AngleMap",
    "ArrayType",
    "Axes",
    "Directions",
    "Displacement",
    "Elements",
    "Gap",
    "Image",
    "LabelMap",
    "Mask",
    "Number",
    "NumberType",
    "Points",
    "ScaleMap",
    "SocketType",
    "SourceMap",
    "StructType",
    "Texture",
    "ValueType",
    "Vector",
    "ViewStack",
    "Views",
    "check_axes",
    "find_type",
    "parse_type",
    "struct_type",
]


@dataclass(frozen=True)
class ValueType:
    """What a socket or a graph input takes: a socket type, or a list of it, perhaps with gaps."""

    base: SocketType
    many: bool = False
    gaps: bool = field(default=False, compare=False)

    def __str__(self) -> str:
        return f"list[{self.base.name}]" if self.many else self.base.name

    def check(self, value: Any, name: str) -> Any:
        """Return the value or each item of the list in canonical form; ValueError names the item."""
        if not self.many:
            return self.base.check(value, name)
        if not isinstance(value, list | tuple):
            raise ValueError(f"{name}: expected {self}, got {type(value).__name__}")
        return [
            item if self.gaps and isinstance(item, Gap) else self.base.check(item, f"{name}[{i}]")
            for i, item in enumerate(value)
        ]


def parse_type(text: str) -> ValueType:
    """Return the type written as ``Image`` or ``list[Image]``; ValueError with the known names.

    >>> str(parse_type("list[Image]"))
    'list[Image]'
    """
    inner = text[5:-1] if text.startswith("list[") and text.endswith("]") else text
    if inner not in TYPES:
        raise ValueError(f"unknown type {text!r}{did_you_mean(inner, TYPES)}")
    return ValueType(TYPES[inner], many=inner != text)


@dataclass(frozen=True)
class Axes:
    """Names axes of an array socket; equal names must have equal sizes within one call.

    ``Annotated[Mask, Axes("h w")]``.
    """

    names: str

    def split(self) -> tuple[str, ...]:
        """Return the names, one for each axis."""
        return tuple(self.names.split())


@dataclass(frozen=True)
class Gap:
    """Stands in a list for a cell of an `each:` that failed."""

    label: str
    reason: str


def check_axes(values: Sequence[tuple[str, tuple[str, ...], Any]]) -> None:
    """Raise ValueError if axes of one name differ in size; values are (socket, axis names, array or list of them)."""
    seen: dict[str, tuple[int, str]] = {}
    for socket, axes, value in values:
        for index, array in enumerate(value if isinstance(value, list) else [value]):
            if isinstance(array, Gap):
                continue
            name = f"{socket}[{index}]" if isinstance(value, list) else socket
            for axis, size in zip(axes, array.shape, strict=True):
                known, first = seen.setdefault(axis, (size, name))
                if known != size:
                    got = f"axis {axis} has size {size} (shape {array.shape})"
                    raise ValueError(f"{name}: {got}, but {first} has {known}; they must agree")


_UNIT = "colour is sRGB-encoded in [0, 1] unless a node says otherwise"
_SIDES = (("h", 1, 1 << 20), ("w", 1, 1 << 20))
Image: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType(
        "Image", f"picture or material maps stacked in channels; {_UNIT}", "float32", ("h", "w", "c"),
        (*_SIDES, ("c", 1, 16)), hint="a grey picture is (h, w, 1): image[..., None]",
    ),
]  # fmt: skip
Mask: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType("Mask", "True marks the feature, foreground or hole that a node names", "bool", ("h", "w"), _SIDES),
]
ScaleMap: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType("ScaleMap", "relative texel scale, 1 = undistorted", "float32", ("h", "w"), _SIDES, 1 / 8, 8.0),
]
AngleMap: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType(
        "AngleMap", "direction of each pixel's texels in degrees, clockwise; 0 points right", "float32", ("h", "w"),
        _SIDES, -360.0, 360.0,
    ),
]  # fmt: skip
LabelMap: TypeAlias = Annotated[
    NDArray[Any], ArrayType("LabelMap", "which source each pixel comes from", "int32", ("h", "w"), _SIDES)
]
Points: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType("Points", "(x, y) in pixels, pixel centres at integers, y down", "float64", ("n", "xy"), (("xy", 2, 2),)),
]
Vector: TypeAlias = Annotated[NDArray[Any], ArrayType("Vector", "one number for each element", "float64", ("n",))]
Displacement: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType(
        "Displacement", "shift (x, y) of each pixel, in pixels", "float32", ("h", "w", "xy"), (*_SIDES, ("xy", 2, 2))
    ),
]
SourceMap: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType(
        "SourceMap", "for each pixel: exemplar's index, row, column, log2 of the resampling, angle, mirrored or not",
        "float32", ("h", "w", "source"), (*_SIDES, ("source", 6, 6)),
    ),
]  # fmt: skip
Number: TypeAlias = Annotated[float, NumberType("Number", "a measured value; feeds a parameter by {from: node.socket}")]
Views: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType("Views", "pictures of one size, stacked", "float32", ("v", "h", "w", "c"), (*_SIDES, ("c", 1, 16))),
]
Directions: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType(
        "Directions", "viewing and lighting slant and tilt, degrees", "float64", ("v", "angle"), (("angle", 4, 4),)
    ),
]


@struct_type("where texture elements are, and how each is turned and sized")
class Elements(NamedTuple):
    """Texton placement: points with the angle (degrees, clockwise) and the relative scale of each."""

    points: Points
    angles: Vector
    scales: Vector


@struct_type("an entry of a texture database")
class Texture(NamedTuple):
    """A texture with its foreground mask, texton points and rigidity tag."""

    image: Image
    mask: Mask
    points: Points
    tag: str


@struct_type("aligned views of a rough surface")
class ViewStack(NamedTuple):
    """Views of one surface, with the viewing and lighting directions of each."""

    views: Views
    directions: Directions
