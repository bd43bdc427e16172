"""Specifications of socket types: arrays, numbers, and named tuples of them.

Every type has one name; two types with equal arrays stay different types.
"""

import math
from dataclasses import dataclass, field
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from graphtex.errors import DeclarationError

TYPES: dict[str, "SocketType"] = {}


@dataclass(frozen=True)
class SocketType:
    """A nominal type of values that flow between nodes."""

    name: str
    summary: str = field(compare=False)

    def __post_init__(self) -> None:
        if TYPES.get(self.name, self) != self:
            raise DeclarationError(f"socket type {self.name!r} is declared twice, with different specifications")
        TYPES[self.name] = self  # the newer one where a module is reloaded

    def describe(self) -> str:
        """Return the name and what a value is made of."""
        raise NotImplementedError

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
        if not isinstance(value, np.ndarray) or isinstance(value, np.ma.MaskedArray):
            hint = "; fill it first" if isinstance(value, np.ndarray) else ""
            raise ValueError(f"{name}: expected {self.describe()}, got {type(value).__name__}{hint}")
        array = self._cast(value, name)
        if array.ndim != len(self.axes):
            raise ValueError(f"{name}: expected {self.describe()}, got shape {value.shape}{self._hint()}")
        for axis, least, most in self.sizes:
            size = array.shape[self.axes.index(axis)]
            if not least <= size <= most:
                bounds = str(least) if least == most else f"{least} to {most}"
                raise ValueError(f"{name}: axis {axis} of {self.name} has size {bounds}, got shape {value.shape}")
        if array.size and (array.dtype.kind == "f" or self.low is not None or self.high is not None):
            self._check_range(array, name)
        array = np.ascontiguousarray(array).view()
        array.flags.writeable = False
        return array

    def _cast(self, value: NDArray[Any], name: str) -> NDArray[Any]:
        wanted, got = np.dtype(self.dtype), value.dtype
        if got == wanted:
            return value
        whole = wanted.kind == "i" and got.kind in "iu"
        if whole or (wanted.kind == "f" and got.kind == "f"):
            if whole and value.size and not np.iinfo(wanted).min <= value.min() <= value.max() <= np.iinfo(wanted).max:
                raise ValueError(f"{name}: {self.name} is {self.dtype}, got {value.min()} to {value.max()}")
            with np.errstate(over="ignore"):  # what becomes infinite is refused with the rest
                return value.astype(wanted)
        if wanted == np.float64 and got.kind in "iu":  # coordinates and counts are often written as whole numbers
            return value.astype(wanted)
        raise ValueError(f"{name}: {self.name} is {self.dtype}, got {got}{self._cast_hint(got)}")

    def _cast_hint(self, got: "np.dtype[Any]") -> str:
        if self.dtype == "bool":
            return "; convert it by a comparison: x > 0"
        if self.dtype == "float32" and got.kind == "u" and self.low is None:
            return f"; convert it: x / {np.iinfo(got).max} as float32"
        return f"; convert it: x.astype({self.dtype!r})" if got.kind in "biu" and self.dtype != "bool" else ""

    def _check_range(self, array: NDArray[Any], name: str) -> None:
        if self.low is None and self.high is None:
            with np.errstate(all="ignore"):  # a sum that is finite tells as much as both ends, and reads half as much
                if math.isfinite(array.sum()):
                    return
        low, high = array.min().item(), array.max().item()
        if not (math.isfinite(low) and math.isfinite(high)):
            bad = int(array.size - np.count_nonzero(np.isfinite(array)))
            raise ValueError(f"{name}: {self.name} holds finite numbers, got {bad} NaN or infinite of {array.size}")
        least = -math.inf if self.low is None else self.low
        most = math.inf if self.high is None else self.high
        if low < least or high > most:
            raise ValueError(f"{name}: {self.name} lies in [{least:g}, {most:g}], got {low:g} to {high:g}")

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
        if isinstance(value, float) and not math.isfinite(value):
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
        cls._socket_type = StructType(cls.__name__, summary, cls, tuple(fields))  # type: ignore[attr-defined]
        return cls

    return declare


def find_type(hint: Any) -> SocketType | None:
    """Return the socket type that an annotation stands for, or None."""
    if get_origin(hint) is Annotated:
        return next((extra for extra in get_args(hint)[1:] if isinstance(extra, SocketType)), None)
    declared = vars(hint).get("_socket_type") if isinstance(hint, type) else None
    return declared if isinstance(declared, StructType) else None
