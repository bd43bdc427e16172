"""Digests of values: SHA-256 over a canonical form that holds type, structure and bytes.

A value is an array; a number, bool or string; a NamedTuple of values; or a list of values. Like git, the digest of a
composite covers the digests of its parts:

- array: the line ``{"dtype":"<f4","shape":[2,3],"type":"Image"}`` and a newline, then the bytes in C order,
- anything else: its canonical JSON, with scalars tagged by their type and other parts named by type and digest.

API: ``digest_value(type_name, value)``, ``parts(type_name, value)`` (what the store writes), ``canonical_json(obj)``,
``file_digest(path)``, ``text_digest(text)``.
"""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphtex.sockets import Gap

_JSON_LEAVES = (str, int, float, bool, type(None))


class ArrayHeader(NamedTuple):
    """What an array is besides its bytes."""

    type: str
    dtype: str
    shape: tuple[int, ...]

    def line(self) -> bytes:
        """Return the line that the digest covers before the bytes."""
        return canonical_json({"type": self.type, "dtype": self.dtype, "shape": self.shape}).encode() + b"\n"


@dataclass(frozen=True, eq=False)
class ArrayPart:
    """An array ready to be stored: C order, little-endian."""

    digest: str
    header: ArrayHeader
    array: NDArray[Any]


@dataclass(frozen=True)
class TreePart:
    """Canonical JSON of a composite, a list or a scalar; its SHA-256 is the digest."""

    digest: str
    text: str


def canonical_json(obj: Any) -> str:
    """Return JSON that is equal for equal parameters only: sorted keys, ASCII, shortest exact floats.

    1, 1.0, True and "1" stay different, as do 0.0 and -0.0. NaN and infinities are written as Python's JSON does.
    Tuples are written as lists.

    Raises
    ------
    TypeError
        For keys that are not strings and for values that JSON has no form for.

    Examples
    --------
    >>> canonical_json({"b": (1, 1.0), "a": float("nan")})
    '{"a":NaN,"b":[1,1.0]}'
    """
    _refuse_other_than_json(obj)
    return json.dumps(obj, sort_keys=True, separators=(",", ":"), ensure_ascii=True)


def _refuse_other_than_json(obj: Any) -> None:
    ahead = [obj]
    while ahead:
        one = ahead.pop()
        if isinstance(one, _JSON_LEAVES):
            continue
        if isinstance(one, dict):
            for key in one:
                if not isinstance(key, str):  # json would write 1 and "1" alike
                    raise TypeError(f"canonical JSON: a key is a string, got {key!r}")
            ahead += one.values()
        elif isinstance(one, list | tuple):
            ahead += one
        else:
            raise TypeError(f"canonical JSON: expected a number, string, list or dict, got {type(one).__name__}")


def text_digest(text: str) -> str:
    """Return the SHA-256 of a text's UTF-8 bytes, in hex."""
    return hashlib.sha256(text.encode("utf-8")).hexdigest()


def file_digest(path: str | Path) -> str:
    """Return the SHA-256 of a file's content, in hex; OSError if it cannot be read.

    That of a folder covers the names and contents of all files in it, but for hidden ones.
    """
    if Path(path).is_dir():
        found = [[file.relative_to(path).as_posix(), file_digest(file)] for file in files_below(Path(path))]
        return text_digest(canonical_json(found))
    with Path(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def files_below(folder: Path) -> list[Path]:
    """Return the files of a folder and of those in it, sorted by path, without hidden ones."""
    shown = (path for path in folder.rglob("*") if not any(part[0] == "." for part in path.relative_to(folder).parts))
    return sorted(path for path in shown if path.is_file())


def digest_value(type_name: str, value: Any) -> str:
    """Return the SHA-256 (hex) of a value of a socket type such as ``Image`` or ``list[Image]``.

    Arrays that differ in type, dtype, shape or bytes differ in digest (so do NaNs with different payloads); memory
    layout and byte order do not count.

    Raises
    ------
    TypeError
        For values that cannot be stored: objects, strings or structures in arrays, masked arrays, plain tuples, dicts.

    Examples
    --------
    >>> digest_value("Number", 1) == digest_value("Number", 1.0)
    False
    """
    digest = ""
    for part in parts(type_name, value):
        digest = part.digest  # the last part is the value itself
    return digest


def parts(type_name: str, value: Any) -> Iterator[ArrayPart | TreePart]:
    """Yield what has to be stored for a value, inner parts first and the value itself last."""
    if isinstance(value, np.ndarray):
        yield array_part(type_name, value)
        return
    if isinstance(value, Gap):
        value = _GapFields(value.label, value.reason)
    if isinstance(value, list):
        items: list[dict[str, str]] = []
        for item, name in zip(value, (_item_type(type_name, item) for item in value), strict=True):
            yield from _inner(items, name, item)
        tree: dict[str, Any] = {"type": type_name, "items": items}
    elif isinstance(value, tuple) and hasattr(value, "_fields"):
        fields: list[dict[str, str]] = []
        for key, item in zip(value._fields, value, strict=True):
            yield from _inner(fields, _field_type(type_name, key, item), item)
        tree = {"type": type_name, "fields": dict(zip(value._fields, fields, strict=True))}
    else:
        tree = {"type": type_name} | _scalar(type_name, value)
    text = canonical_json(tree)
    yield TreePart(text_digest(text), text)


def array_part(type_name: str, value: NDArray[Any]) -> ArrayPart:
    """Return an array in the form that is hashed and stored; nothing is copied if it has that form already."""
    if isinstance(value, np.ma.MaskedArray):
        raise TypeError(f"{type_name}: a masked array cannot be stored; fill it first")
    if value.dtype.kind not in "biufc" or value.dtype.char in "gG":
        raise TypeError(
            f"{type_name}: an array of bool, integers or floats up to 64 bits can be stored, got {value.dtype}"
        )
    array = np.asarray(value, dtype=value.dtype.newbyteorder("<"), order="C")
    header = ArrayHeader(type_name, array.dtype.newbyteorder("<").str, array.shape)
    return ArrayPart(array_digest(header, array), header, array)


def array_digest(header: ArrayHeader, array: NDArray[Any]) -> str:
    """Return the digest of a little-endian array in C order."""
    sha = hashlib.sha256(header.line())
    sha.update(raw_bytes(array))
    return sha.hexdigest()


def raw_bytes(array: NDArray[Any]) -> memoryview:
    """Return the memory of an array in C order as bytes, without a copy; may be empty."""
    return array.reshape(-1).view(np.uint8).data


class _GapFields(NamedTuple):
    label: str
    reason: str


def _inner(entries: list[dict[str, str]], name: str, item: Any) -> Iterator[ArrayPart | TreePart]:
    """Yield the parts of an inner value and append its entry in the tree: a tagged scalar, or type and digest."""
    if not isinstance(item, np.ndarray | list | tuple | Gap):
        entries.append(_scalar(name, item))
        return
    digest = ""
    for part in parts(name, item):
        digest = part.digest
        yield part
    entries.append({"type": name, "digest": digest})


def _item_type(type_name: str, item: Any) -> str:
    if isinstance(item, Gap):
        return "Gap"
    if type_name.startswith("list[") and type_name.endswith("]"):
        return type_name[5:-1]
    return type(item).__name__ if isinstance(item, tuple) else f"{type_name}[]"


def _field_type(type_name: str, key: str, item: Any) -> str:
    """A NamedTuple in a field goes by its class, so that it can be rebuilt; arrays by the field they are in."""
    return type(item).__name__ if isinstance(item, tuple) else f"{type_name}.{key}"


def _scalar(type_name: str, value: Any) -> dict[str, str]:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return {"bool": "true" if value else "false"}
    if isinstance(value, int):
        return {"int": int.__repr__(value)}
    if isinstance(value, float):
        return {"float": float.__repr__(value)}
    if isinstance(value, str):
        return {"str": str(value)}
    raise TypeError(
        f"{type_name}: a {type(value).__name__} cannot be stored; expected an array, number, string or list"
    )


def scalar_from(entry: dict[str, str]) -> int | float | bool | str:
    """Return the scalar of a tagged entry such as ``{"float": "0.5"}``; ValueError if it is none."""
    match entry:
        case {"bool": "true" | "false" as text}:
            return text == "true"
        case {"int": str(text)}:
            return int(text)
        case {"float": str(text)}:
            return float(text)
        case {"str": str(text)}:
            return text
    raise ValueError(f"no scalar: {entry!r}")
