"""Values of graph inputs: do they fit the input's type, range and choices, and what do path patterns mean."""

import glob
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphtex.document import SCALAR_TYPES, Input
from graphtex.errors import did_you_mean
from graphtex.handlers import find_opener, is_value_file, suffixes_of
from graphtex.parameters import plain, shorten
from graphtex.sockets import TYPES, ValueType, parse_type

_PYTHON = {"int": int, "float": float, "str": str, "bool": bool, "file": str}
_WORDS = {"bool": "true or false"}


def split_type(text: str) -> tuple[str, bool]:
    """Return the inner type's name and whether it is a list; ValueError if the type is unknown."""
    many = text.startswith("list[") and text.endswith("]")
    inner = text[5:-1] if many else text
    if inner not in SCALAR_TYPES and inner not in TYPES:
        raise ValueError(f"unknown type {text!r}{did_you_mean(inner, [*TYPES, *SCALAR_TYPES], label='types')}")
    return inner, many


def is_list(kind: Input) -> bool:
    """Return whether an input takes a list."""
    return kind.type.startswith("list[")


def check_scalar(kind: Input, value: Any) -> Any:
    """Return a scalar input's value as plain data; ValueError if type, range or choices do not admit it."""
    inner, many = split_type(kind.type)
    value = plain(value)
    if not many:
        return _check_item(kind, inner, value)
    if not isinstance(value, list):
        raise ValueError(f"expected a list of {inner}, got {shorten(value)}")
    items = []
    for index, item in enumerate(value):
        try:
            items.append(_check_item(kind, inner, item))
        except ValueError as error:
            raise ValueError(f"item {index}: {error}") from None
    return items


def _check_item(kind: Input, inner: str, value: Any) -> Any:
    wanted = _PYTHON.get(inner)
    if inner == "float" and isinstance(value, int) and not isinstance(value, bool):
        try:
            value = float(value)
        except OverflowError:
            raise ValueError(f"expected float, got {shorten(value)}") from None
    if wanted is not None and (not isinstance(value, wanted) or (wanted is int and isinstance(value, bool))):
        raise ValueError(f"expected {_WORDS.get(inner, inner)}, got {shorten(value)}")
    if isinstance(value, float) and not math.isfinite(value):
        raise ValueError(f"expected a finite number, got {value}")
    if inner == "file" and not value:
        raise ValueError("expected a file, got an empty text")
    if kind.choices is not None and not any(value == one and type(value) is type(one) for one in _floats(kind, inner)):
        choices = [str(choice) for choice in kind.choices]
        raise ValueError(f"{shorten(value)} is no choice{did_you_mean(str(value), choices, label='choices')}")
    if isinstance(value, int | float) and not isinstance(value, bool):
        if kind.min is not None and value < kind.min:
            raise ValueError(f"should be at least {kind.min:g}, got {value:g}")
        if kind.max is not None and value > kind.max:
            raise ValueError(f"should be at most {kind.max:g}, got {value:g}")
    return value


def _floats(kind: Input, inner: str) -> list[Any]:
    """Return the choices; among floats, whole numbers are floats too."""
    return [float(one) if inner == "float" and type(one) is int else one for one in kind.choices or ()]


def check_seed(value: Any) -> int:
    """Return a seed; ValueError if it is none."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 0:
        raise ValueError(f"a seed is a whole number from 0, got {shorten(value)}")
    return value


def read_text(kind: Input, text: str) -> Any:
    """Return what a user typed for an input, as the input's type; ValueError if it cannot be read so."""
    inner, many = split_type(kind.type)
    if inner in TYPES or inner in ("str", "file"):
        if not many:
            return text
        if "," in text or text.startswith("["):
            return [part.strip() for part in text.strip("[]").split(",")]
        return text if inner != "str" else [text]
    from graphtex.files.yamltree import read_scalar

    if many and not text.lstrip().startswith("["):
        text = f"[{text}]"
    return read_scalar(text)


def expand_paths(value: Any, kind: Input, base: Path) -> list[Any]:
    """Return the items of a list input; a folder or a glob gives its files, sorted.

    A folder gives those that can be opened as the input's type, and none whose name begins with a dot.

    Raises
    ------
    ValueError
        If there are none, or the value is no list.
    """
    if isinstance(value, list | tuple):
        return list(value)
    if not isinstance(value, str | Path):
        raise ValueError(f"expected a list, a folder or a pattern such as *.png, got {type(value).__name__}")
    try:
        return _found_paths(str(value), kind, base.absolute())  # the paths that are returned start nowhere else
    except OSError as error:
        raise ValueError(f"{str(value)!r} cannot be read: {error.strerror}") from None


def _found_paths(text: str, kind: Input, base: Path) -> list[str]:
    inner = split_type(kind.type)[0]
    folder = base / text
    if is_value_file(folder) or not (folder.is_dir() or glob.has_magic(text)):
        return [text]
    if folder.is_dir():
        suffixes = suffixes_of(TYPES[inner]) if inner in TYPES else None
        found = [
            path
            for path in folder.iterdir()
            if is_value_file(path)
            and not path.name.startswith(".")
            and (suffixes is None or path.suffix.lower() in suffixes)
        ]
    else:
        matches = glob.glob(text, root_dir=base, recursive=True)  # noqa: PTH207 (Path.glob takes no absolute pattern)
        found = [base / name for name in matches if is_value_file(base / name)]
    if not found:
        what = f"file that opens as {inner}" if inner in TYPES else "file"
        raise ValueError(f"{text!r} holds no {what}" if folder.is_dir() else f"no file matches {text!r}")
    return [str(path) for path in sorted(set(found))]


def check_openable(kind: ValueType, text: Any) -> None:
    """Raise ValueError unless a string names something that can be opened as the type."""
    if not isinstance(text, str) or not text:
        raise ValueError(f"expected a path or scheme:name to open as {kind.base.name}, got {shorten(text)}")
    find_opener(kind.base, text)


def default_faults(kind: Input) -> list[tuple[tuple[int, ...], str]]:
    """Return how an input's default does not fit the input itself: the item's index in a list, and a message."""
    inner, many = split_type(kind.type)
    if not many or not isinstance(kind.default, list):
        if many and (inner in TYPES or inner == "file") and isinstance(kind.default, str):
            return []  # a folder or a pattern, read when the graph is run
        return _faults_of_item(kind, inner, kind.default, ())
    single = replace(kind, type=inner)
    return [
        fault for index, item in enumerate(kind.default) for fault in _faults_of_item(single, inner, item, (index,))
    ]


def _faults_of_item(kind: Input, inner: str, value: Any, place: tuple[int, ...]) -> list[tuple[tuple[int, ...], str]]:
    try:
        if inner in SCALAR_TYPES:
            check_scalar(kind, value)
        else:
            check_openable(parse_type(kind.type), value)
    except ValueError as error:
        return [(place, str(error))]
    return []
