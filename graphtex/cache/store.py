r"""The store: digest -> bytes, under ``objects/ab/<digest>.npy`` for arrays and ``.json`` for everything else.

Files are written under a temporary name and renamed. Reading recomputes the digest; a file that is truncated, changed,
of another type or not ours is removed and never used. Arrays are ``.npy`` files that `numpy.load` reads too, with one
more line at their end: the ``{"dtype", "shape", "type"}`` that the digest covers. Nothing is ever unpickled.

API: ``Store(root, resolve)`` with ``put(type_name, value) -> digest``, ``get(type_name, digest)``, ``has(digest)``,
``touch(digest)``, ``closure(digest)``, ``check(path)``, ``files()``.
"""

import json
import re
import threading
from collections.abc import Callable, Iterator
from io import BufferedReader
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from graphtex.cache.digest import (
    ArrayHeader,
    ArrayPart,
    TreePart,
    array_digest,
    parts,
    raw_bytes,
    scalar_from,
    text_digest,
)
from graphtex.cache.errors import DamagedEntry, EntryLost, MissingEntry
from graphtex.cache.files import listing, remove, touch, wait_a_moment, write_atomically
from graphtex.sockets import TYPES, Gap, StructType

Resolver = Callable[[str], Callable[..., Any] | None]
_DIGEST = re.compile(r"[0-9a-f]{64}")
_LONGEST_LINE = 4096


def struct_class(type_name: str) -> Callable[..., Any] | None:
    """Return the NamedTuple class of a registered socket type, or None."""
    kind = TYPES.get(type_name)
    return kind.struct if isinstance(kind, StructType) else None


class Store:
    """Values by digest in a folder that many processes may share.

    Parameters
    ----------
    root
        The cache's folder; it is made when the first value is stored.
    resolve
        Type name -> NamedTuple class, to rebuild composites; by default the registered socket types.
    """

    def __init__(self, root: Path, resolve: Resolver = struct_class) -> None:
        self.objects = root / "objects"
        self.scratch = root / "tmp"
        self.written = 0
        self._resolve = resolve
        self._lock = threading.Lock()

    def put(self, type_name: str, value: Any) -> str:
        """Store a value unless it is there, mark it as used and return its digest.

        Raises
        ------
        CacheUnavailable
            If the folder cannot be written or the disk is full.
        TypeError
            If the value is of a kind that cannot be stored, see `digest_value`.
        """
        digest = ""
        for part in parts(type_name, value):
            self._put_part(part)
            digest = part.digest
        return digest

    def _put_part(self, part: ArrayPart | TreePart) -> None:
        path = self._path(part.digest, ".npy" if isinstance(part, ArrayPart) else ".json")
        if isinstance(part, ArrayPart):
            pieces: list[bytes | memoryview] = [
                npy_header(part.header),
                raw_bytes(part.array),
                b"\n" + part.header.line(),
            ]
        else:
            pieces = [part.text.encode()]
        size = sum(len(piece) for piece in pieces)
        try:
            whole = path.stat().st_size == size
        except OSError:
            whole = False
        if whole and touch(path):
            return

        def write(file: IO[bytes]) -> None:
            for piece in pieces:
                file.write(piece)

        self.count(write_atomically(path, self.scratch, write))

    def count(self, size: int) -> None:
        """Add to the bytes that were written by this object's user."""
        with self._lock:
            self.written += size

    def get(self, type_name: str, digest: str) -> Any:
        """Return a stored value; arrays are read-only.

        Raises
        ------
        MissingEntry
            If it is not in the store.
        DamagedEntry
            If it, or a part of it, is not what was stored; the damaged file has been removed.
        """
        try:
            found = self._find(digest)
        except MissingEntry:
            wait_a_moment()
            found = self._find(digest)
        touch(found)
        if found.suffix == ".npy":
            header, array = self._read_array(found, digest)
            self._expect(found, header.type == type_name, f"holds a {header.type}, not a {type_name}")
            array.flags.writeable = False
            return array
        tree = self._read_tree(found, digest)
        self._expect(found, tree["type"] == type_name, f"holds a {tree['type']}, not a {type_name}")
        if "items" in tree:
            return [self._get_entry(found, entry) for entry in tree["items"]]
        if "fields" in tree:
            return self._rebuild(found, type_name, {k: self._get_entry(found, e) for k, e in tree["fields"].items()})
        return self._get_entry(found, tree)

    def _get_entry(self, path: Path, entry: dict[str, str]) -> Any:
        if "digest" in entry:
            return self.get(entry["type"], entry["digest"])
        try:
            return scalar_from(entry)
        except ValueError as error:
            raise self._damaged(path, str(error)) from None

    def _rebuild(self, path: Path, type_name: str, fields: dict[str, Any]) -> Any:
        make = Gap if type_name == "Gap" else self._resolve(type_name)
        if make is None:
            raise MissingEntry(f"{path} holds a {type_name}; no pack that is loaded declares this type")
        try:
            return make(**fields)
        except TypeError:  # stored before the type got other fields
            raise self._damaged(path, f"has the fields {', '.join(fields)}, unlike {type_name}") from None

    def has(self, digest: str) -> bool:
        """Tell whether a value and all its parts are there; their content is only verified on reading."""
        try:
            return all(True for _ in self.closure(digest))
        except EntryLost:
            return False

    def touch(self, digest: str) -> bool:
        """Mark a value and all its parts as used now; False if one is gone."""
        try:
            return all(touch(self._find(inner)) for inner in self.closure(digest))
        except EntryLost:
            return False

    def closure(self, digest: str) -> Iterator[str]:
        """Yield the digest and those of all parts; raises `MissingEntry` or `DamagedEntry` like `get`."""
        yield digest
        path = self._find(digest)
        if path.suffix == ".json":
            tree = self._read_tree(path, digest)
            for entry in [*tree.get("items", ()), *tree.get("fields", {}).values()]:
                if "digest" in entry:
                    yield from self.closure(entry["digest"])

    def check(self, path: Path) -> None:
        """Verify one file of the store; raises `DamagedEntry` after removing it."""
        self._expect(path, self._path(path.stem, path.suffix) == path, "does not belong here")
        if path.suffix == ".npy":
            self._read_array(path, path.stem)
        else:
            self._read_tree(path, path.stem)

    def files(self) -> dict[Path, tuple[int, int]]:
        """Return (bytes, last use in ns) of all stored objects."""
        found = listing(self.objects)
        return {p: told for p, told in found.items() if p.suffix in (".npy", ".json") and _DIGEST.fullmatch(p.stem)}

    def _path(self, digest: str, suffix: str) -> Path:
        if not _DIGEST.fullmatch(digest):  # a digest from a damaged file must not lead out of the store
            raise MissingEntry(f"no digest: {digest[:80]!r}")
        return Path(f"{self.objects}/{digest[:2]}/{digest}{suffix}")

    def _find(self, digest: str) -> Path:
        for suffix in (".npy", ".json"):
            path = self._path(digest, suffix)
            if path.exists():
                return path
        raise MissingEntry(f"{self.objects.parent} does not hold {digest}")

    def _read_tree(self, path: Path, digest: str) -> dict[str, Any]:
        try:
            text = path.read_bytes().decode("ascii")
            tree: dict[str, Any] = json.loads(text) if text_digest(text) == digest else {}
        except FileNotFoundError:
            raise MissingEntry(f"{path} is gone") from None
        except (OSError, ValueError):
            tree = {}
        self._expect(path, bool(tree), "is damaged")
        return tree

    def _read_array(self, path: Path, digest: str) -> tuple[ArrayHeader, NDArray[Any]]:
        try:
            with path.open("rb") as file:
                return _read_npy(file, digest)
        except FileNotFoundError:
            raise MissingEntry(f"{path} is gone") from None
        except (OSError, ValueError, MemoryError) as error:
            raise self._damaged(path, str(error)) from error

    def _expect(self, path: Path, right: bool, what: str) -> None:
        if not right:
            raise self._damaged(path, what)

    def _damaged(self, path: Path, what: str) -> DamagedEntry:
        remove(path)
        return DamagedEntry(f"{path} was removed: {what}")


def npy_header(header: ArrayHeader) -> bytes:
    """Return the start of a version 1.0 ``.npy`` file, always in the same form (numpy's own padding varies)."""
    shape = f"({header.shape[0]},)" if len(header.shape) == 1 else f"({', '.join(map(str, header.shape))})"
    text = f"{{'descr': '{header.dtype}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    length = -(-(10 + len(text) + 1) // 64) * 64 - 10
    return b"\x93NUMPY\x01\x00" + length.to_bytes(2, "little") + text.ljust(length - 1) + b"\n"


def _read_npy(file: BufferedReader, digest: str) -> tuple[ArrayHeader, NDArray[Any]]:
    """Read an array; ValueError and its kin for any file that `Store.put` would not have written for the digest.

    The last line says what the file must hold, so that nothing is parsed or allocated on an untrusted header's word.
    """
    size = file.seek(0, 2)
    file.seek(max(0, size - _LONGEST_LINE))
    try:
        told = json.loads(file.read().rsplit(b"\n", 2)[-2])
        header = ArrayHeader(told["type"], told["dtype"], tuple(told["shape"]))
        dtype = np.dtype(header.dtype)
        start, end = npy_header(header), b"\n" + header.line()
        count = int(np.prod([int(n) for n in header.shape], dtype=object))
    except (ValueError, TypeError, LookupError, RecursionError) as error:
        raise ValueError("it does not end as it must") from error
    if dtype.kind not in "biufc" or size != len(start) + count * dtype.itemsize + len(end):
        raise ValueError("its size does not fit what it says it holds")
    file.seek(0)
    if file.read(len(start)) != start:
        raise ValueError("its start does not fit its end")
    array = np.empty(header.shape, dtype)
    raw = raw_bytes(array)
    done = 0
    while done < len(raw):
        got = file.readinto(raw[done:])
        if not got:
            raise ValueError("it is cut short")
        done += got
    if file.read() != end or array_digest(header, array) != digest:
        raise ValueError("its digest is another")
    return header, array
