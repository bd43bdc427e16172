"""Values of graph inputs: do they fit the input's type, range and choices, and what do path patterns mean."""

import glob
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from graphtex.errors import did_you_mean
from graphtex.graph import SCALAR_TYPES, Input
from graphtex.handlers import OPENERS, find_opener
from graphtex.parameters import plain, shorten
from graphtex.sockets import TYPES, ValueType, parse_type

_PYTHON = {"int": int, "float": float, "str": str, "bool": bool, "file": str}


def split_type(text: str) -> tuple[str, bool]:
    """Return the inner type's name and whether it is a list; ValueError if the type is unknown."""
    many = text.startswith("list[") and text.endswith("]")
    inner = text[5:-1] if many else text
    if inner not in SCALAR_TYPES and inner not in TYPES:
        raise ValueError(f"unknown type {text!r}{did_you_mean(inner, [*TYPES, *SCALAR_TYPES], label='types')}")
    return inner, many


def check_scalar(kind: Input, value: Any) -> Any:
    """Return a scalar input's value as plain data; ValueError if type, range or choices do not admit it."""
    inner, many = split_type(kind.type)
    value = plain(value)
    if many:
        if not isinstance(value, list):
            raise ValueError(f"expected a list of {inner}, got {shorten(value)}")
        return [_check_item(kind, inner, item) for item in value]
    return _check_item(kind, inner, value)


def _check_item(kind: Input, inner: str, value: Any) -> Any:
    wanted = _PYTHON.get(inner)
    if inner == "float" and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if wanted is not None and (not isinstance(value, wanted) or (wanted is int and isinstance(value, bool))):
        raise ValueError(f"expected {inner}, got {shorten(value)}")
    if isinstance(value, float) and not np.isfinite(value):
        raise ValueError(f"expected a finite number, got {value}")
    if kind.choices is not None and value not in kind.choices:
        choices = [str(choice) for choice in kind.choices]
        raise ValueError(f"{shorten(value)} is no choice{did_you_mean(str(value), choices, label='choices')}")
    if isinstance(value, int | float) and not isinstance(value, bool):
        if kind.min is not None and value < kind.min:
            raise ValueError(f"should be at least {kind.min:g}, got {value:g}")
        if kind.max is not None and value > kind.max:
            raise ValueError(f"should be at most {kind.max:g}, got {value:g}")
    return value


def read_text(kind: Input, text: str) -> Any:
    """Return what a user typed for an input, as the input's type; ValueError if it cannot be read so."""
    inner, many = split_type(kind.type)
    if inner in TYPES or inner in ("str", "file"):
        if not many:
            return text
        if "," in text or text.startswith("["):
            return [part.strip() for part in text.strip("[]").split(",")]
        return text if inner in TYPES or inner == "file" else [text]
    from graphtex.files.yamltree import read_scalar

    value = read_scalar(text)
    if many and not isinstance(value, list):
        value = [value]
    return value


def expand_paths(value: Any, kind: ValueType, base: Path) -> list[Any]:
    """Return the items of a list input; a folder or a glob gives its files, sorted. ValueError if there are none."""
    if not isinstance(value, str):
        return list(value)
    suffixes = {suffix for entry in OPENERS if entry.type_name == kind.base.name for suffix in entry.suffixes}
    folder = base / value
    if folder.is_dir():
        found = [p for p in folder.iterdir() if p.is_file() and p.suffix.lower() in suffixes]
    else:
        found = [Path(p) for p in glob.glob(str(folder), recursive=True) if Path(p).is_file()]  # noqa: PTH207 (takes absolute patterns)
        if not found and not glob.has_magic(value):
            return [value]
    if not found:
        raise ValueError(f"no file of type {kind.base.name} matches {value!r}")
    return [str(path) for path in sorted(found)]


def check_openable(kind: ValueType, text: Any) -> None:
    """Raise ValueError unless a string names something that can be opened as the type."""
    if not isinstance(text, str) or not text:
        raise ValueError(f"expected a path or scheme:name to open as {kind.base.name}, got {shorten(text)}")
    find_opener(kind.base, text)


def default_faults(kind: Input) -> list[tuple[tuple[int, ...], str]]:
    """Return how an input's default does not fit the input itself: the item's index in a list, and a message."""
    inner, many = split_type(kind.type)
    if not many or not isinstance(kind.default, list):
        if many and inner in TYPES and isinstance(kind.default, str):
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
