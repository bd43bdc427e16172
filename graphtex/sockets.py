"""Socket types: nominal types over numpy arrays, numbers and named tuples of them.

A type is an annotated alias, ``Image = Annotated[NDArray, ArrayType("Image", ...)]``: type checkers see the array, the
framework sees the specification. Every type has one name; two types with equal arrays stay different types.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from graphtex.errors import DeclarationError, did_you_mean

TYPES: dict[str, "SocketType"] = {}


@dataclass(frozen=True)
class SocketType:
    """A nominal type of values that flow between nodes."""

    name: str
    summary: str = field(compare=False)

    def __post_init__(self) -> None:
        known = TYPES.setdefault(self.name, self)
        if known != self:
            raise DeclarationError(f"socket type {self.name!r} is declared twice, with different specifications")

    def check(self, value: Any, name: str) -> Any:
        """Return the value in its canonical form: cast where nothing is lost, read-only.

        Raises
        ------
        ValueError
            With the socket's name, what was expected and what was got.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class ArrayType(SocketType):
    """A numpy array of one dtype and rank; `sizes` bounds an axis, `low` and `high` the values."""

    dtype: str
    axes: tuple[str, ...]
    sizes: tuple[tuple[str, int, int], ...] = ()
    low: float | None = None
    high: float | None = None
    hint: str = field(default="", compare=False)

    def check(self, value: Any, name: str) -> NDArray[Any]:
        """See `SocketType.check`; float64 becomes float32 and wider integers int32 where they fit."""
        if not isinstance(value, np.ndarray):
            raise ValueError(f"{name}: expected {self.describe()}, got {type(value).__name__}")
        array = self._cast(value, name)
        if array.ndim != len(self.axes):
            raise ValueError(f"{name}: expected {self.describe()}, got shape {value.shape}{self._hint()}")
        for axis, least, most in self.sizes:
            size = array.shape[self.axes.index(axis)]
            if not least <= size <= most:
                bounds = str(least) if least == most else f"{least} to {most}"
                raise ValueError(f"{name}: axis {axis} of {self.name} has size {bounds}, got shape {value.shape}")
        if array.dtype.kind == "f" and array.size:
            self._check_range(array, name)
        array = np.ascontiguousarray(array).view()
        array.flags.writeable = False
        return array

    def _cast(self, value: NDArray[Any], name: str) -> NDArray[Any]:
        wanted = np.dtype(self.dtype)
        if value.dtype == wanted:
            return value
        same_kind = value.dtype.kind == wanted.kind and wanted.kind != "b"
        if same_kind or (wanted.kind == "i" and value.dtype.kind == "u"):
            if (
                wanted.kind == "i"
                and value.size
                and (value.max() > np.iinfo(wanted).max or value.min() < np.iinfo(wanted).min)
            ):
                raise ValueError(f"{name}: {self.name} is {self.dtype}, got values up to {value.max()}")
            return value.astype(wanted)
        if self.name == "Points" and value.dtype.kind in "iu":
            return value.astype(wanted)
        hint = self._hint()
        if wanted.kind == "f" and value.dtype.kind == "u":
            hint = f"; convert it: x / {np.iinfo(value.dtype).max} as float32"
        elif wanted.kind == "b":
            hint = "; convert it by a comparison: x > 0"
        raise ValueError(f"{name}: {self.name} is {self.dtype}, got {value.dtype}{hint}")

    def _check_range(self, array: NDArray[Any], name: str) -> None:
        low, high = float(array.min()), float(array.max())
        if not (np.isfinite(low) and np.isfinite(high)):
            bad = int(array.size - np.count_nonzero(np.isfinite(array)))
            raise ValueError(f"{name}: {self.name} holds finite numbers, got {bad} NaN or infinite of {array.size}")
        if (self.low is not None and low < self.low) or (self.high is not None and high > self.high):
            raise ValueError(f"{name}: {self.name} lies in [{self.low:g}, {self.high:g}], got {low:g} to {high:g}")

    def _hint(self) -> str:
        return f"; {self.hint}" if self.hint else ""

    def describe(self) -> str:
        """Return such as ``Image: float32 (h, w, c)``."""
        return f"{self.name}: {self.dtype} ({', '.join(self.axes)})"


@dataclass(frozen=True)
class NumberType(SocketType):
    """A finite measured number."""

    def check(self, value: Any, name: str) -> int | float:
        """See `SocketType.check`; numpy scalars become Python's."""
        if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
            value = value.item()
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{name}: expected a number, got {type(value).__name__}")
        if not np.isfinite(value):
            raise ValueError(f"{name}: expected a finite number, got {value}")
        return value

    def describe(self) -> str:
        """Return such as ``Number: float or int``."""
        return f"{self.name}: float or int"


@dataclass(frozen=True)
class StructType(SocketType):
    """A NamedTuple of arrays and scalars."""

    struct: type[tuple] = field(default=tuple, compare=False)
    fields: tuple[tuple[str, Any], ...] = ()

    def check(self, value: Any, name: str) -> Any:
        """See `SocketType.check`; any tuple of the same length will do."""
        if not isinstance(value, tuple) or len(value) != len(self.fields):
            raise ValueError(f"{name}: expected {self.describe()}, got {type(value).__name__}")
        checked = [
            kind.check(item, f"{name}.{key}")
            if isinstance(kind, SocketType)
            else _check_scalar(kind, item, f"{name}.{key}")
            for (key, kind), item in zip(self.fields, value, strict=True)
        ]
        return self.struct(*checked)

    def describe(self) -> str:
        """Return such as ``Elements: (points: Points, angles: Vector)``."""
        inner = ", ".join(
            f"{key}: {kind.name if isinstance(kind, SocketType) else kind.__name__}" for key, kind in self.fields
        )
        return f"{self.name}: ({inner})"


def _check_scalar(kind: type, value: Any, name: str) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type(value) is not kind:
        raise ValueError(f"{name}: expected {kind.__name__}, got {type(value).__name__}")
    return value


def struct_type(summary: str) -> Any:
    """Class decorator: a NamedTuple of socket types, int, float, bool and str becomes a socket type of its own."""

    def declare(cls: type[tuple]) -> type[tuple]:
        fields = []
        for key, hint in get_type_hints(cls, include_extras=True).items():
            kind = hint if hint in (int, float, bool, str) else find_type(hint)
            if kind is None:
                raise DeclarationError(
                    f"{cls.__name__}.{key}: a field is a socket type, int, float, bool or str, got {hint}"
                )
            fields.append((key, kind))
        StructType(cls.__name__, summary, cls, tuple(fields))
        return cls

    return declare


def find_type(hint: Any) -> SocketType | None:
    """Return the socket type that an annotation stands for, or None."""
    if get_origin(hint) is Annotated:
        return next((extra for extra in get_args(hint)[1:] if isinstance(extra, SocketType)), None)
    known = TYPES.get(getattr(hint, "__name__", ""))
    return known if isinstance(known, StructType) and known.struct is hint else None


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
    """Raise ValueError if axes of one name differ in size; values are (socket, axis names, array)."""
    seen: dict[str, tuple[int, str]] = {}
    for socket, axes, array in values:
        for axis, size in zip(axes, array.shape, strict=False):
            known, first = seen.setdefault(axis, (size, socket))
            if known != size:
                got = f"axis {axis} has size {size} (shape {array.shape})"
                raise ValueError(f"{socket}: {got}, but {first} has {known}; they must agree")


_UNIT = "colour is sRGB-encoded in [0, 1] unless a node says otherwise"
Image: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType(
        "Image", f"picture or material maps stacked in channels; {_UNIT}", "float32", ("h", "w", "c"),
        (("h", 1, 1 << 20), ("w", 1, 1 << 20), ("c", 1, 16)), hint="a grey picture is (h, w, 1): image[..., None]",
    ),
]  # fmt: skip
Mask: TypeAlias = Annotated[
    NDArray[Any], ArrayType("Mask", "True marks the feature, foreground or hole that a node names", "bool", ("h", "w"))
]
ScaleMap: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType("ScaleMap", "relative texel scale, 1 = undistorted", "float32", ("h", "w"), low=1 / 8, high=8.0),
]
LabelMap: TypeAlias = Annotated[
    NDArray[Any], ArrayType("LabelMap", "which source each pixel comes from", "int32", ("h", "w"))
]
Points: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType("Points", "(x, y) in pixels, pixel centres at integers, y down", "float64", ("n", "xy"), (("xy", 2, 2),)),
]
Vector: TypeAlias = Annotated[NDArray[Any], ArrayType("Vector", "one number for each element", "float64", ("n",))]
Displacement: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType("Displacement", "shift (x, y) of each pixel, in pixels", "float32", ("h", "w", "xy"), (("xy", 2, 2),)),
]
SourceMap: TypeAlias = Annotated[
    NDArray[Any],
    ArrayType(
        "SourceMap", "for each pixel: exemplar's index, row, column, log2 of the resampling, angle, mirrored or not",
        "float32", ("h", "w", "source"), (("source", 6, 6),),
    ),
]  # fmt: skip
Number: TypeAlias = Annotated[float, NumberType("Number", "a measured value; feeds a parameter by {from: node.socket}")]
Views: TypeAlias = Annotated[
    NDArray[Any], ArrayType("Views", "pictures of one size, stacked", "float32", ("v", "h", "w", "c"), (("c", 1, 16),))
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
