"""The index: key -> record of outputs, and the last recorded run of each graph.

``index/ab/<key>.json`` tells which digests a node's outputs had; ``history/<digest of the graph's name>.json`` tells of
what the keys of a graph's last run were made, for ``graphtex why``. Both carry a checksum; a damaged file is a miss and
is removed.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphtex.cache.digest import canonical_json, text_digest
from graphtex.cache.errors import DamagedEntry
from graphtex.cache.files import listing, read_checked, remove, write_checked
from graphtex.cache.key import KeyParts


@dataclass(frozen=True)
class Output:
    """One stored output: its socket type and its digest."""

    type: str
    digest: str


@dataclass(frozen=True)
class Record:
    """What came of one node with one key.

    Attributes
    ----------
    key
        See `KeyParts.key`.
    node
        The node's YAML name, for people.
    outputs
        Socket -> type and digest.
    seconds
        How long it took.
    warnings
        What the node said by ``ctx.warn``, to be told again on a hit.
    """

    key: str
    node: str
    outputs: Mapping[str, Output]
    seconds: float
    warnings: tuple[str, ...] = ()


_KEY = re.compile("[0-9a-f]{64}")


class Index:
    """Records by key, and runs by graph, in the cache's folder."""

    def __init__(self, root: Path) -> None:
        self.records = root / "index"
        self.history = root / "history"
        self.scratch = root / "tmp"

    def path(self, key: str) -> Path:
        """Return the record's file; ValueError if the key is no hex digest."""
        if not _KEY.fullmatch(key):
            raise ValueError(f"key: expected 64 hex digits, got {key[:80]!r}")
        return Path(f"{self.records}/{key[:2]}/{key}.json")

    def write(self, record: Record) -> int:
        """Store a record in place of an older one; return its size. Raises `CacheUnavailable`."""
        outputs = {name: {"type": output.type, "digest": output.digest} for name, output in record.outputs.items()}
        body = {name: getattr(record, name) for name in ("key", "node", "seconds", "warnings")}
        return write_checked(self.path(record.key), self.scratch, body | {"outputs": outputs})

    def read(self, key: str) -> Record | None:
        """Return the record, or None if there is none or it is damaged (then it has been removed)."""
        path = self.path(key)
        try:
            body = read_checked(path)
            return None if body is None else _record(path, body, key)
        except DamagedEntry:
            return None

    def check(self, path: Path) -> Record:
        """Return the record of a file; raises `DamagedEntry` after removing it if it is not one of ours."""
        body = read_checked(path)
        if body is None:
            raise DamagedEntry(f"{path} is gone")
        return _record(path, body, path.stem)

    def files(self) -> dict[Path, tuple[int, int]]:
        """Return (bytes, last use in ns) of all records."""
        return {path: told for path, told in listing(self.records).items() if path.suffix == ".json"}

    def write_run(self, graph: str, nodes: Mapping[str, KeyParts]) -> None:
        """Keep of what each node's key was made, in place of the graph's last run. Raises `CacheUnavailable`."""
        body = {"graph": graph} | _pack(nodes)
        write_checked(self._run_path(graph), self.scratch, body)

    def read_run(self, graph: str) -> dict[str, KeyParts] | None:
        """Return what the last recorded run of the graph was made of, or None."""
        try:
            body = read_checked(self._run_path(graph))
            return None if body is None or body["graph"] != graph else _unpack(body)
        except (DamagedEntry, ValueError, TypeError, LookupError):  # damaged, or written by another version of graphtex
            return None

    def run_paths(self) -> list[Path]:
        """Return the files of the recorded runs, least recent first."""
        return sorted(self.history.glob("*.json"), key=lambda path: (path.stat().st_mtime_ns, path.name))

    def _run_path(self, graph: str) -> Path:
        return self.history / f"{text_digest(graph)}.json"


def _record(path: Path, body: dict[str, Any], key: str) -> Record:
    try:
        outputs = {socket: Output(str(told["type"]), str(told["digest"])) for socket, told in body["outputs"].items()}
        warnings = tuple(map(str, body["warnings"]))
        record = Record(body["key"], body["node"], outputs, float(body["seconds"]), warnings)
    except (LookupError, TypeError, ValueError, AttributeError):
        record = None
    if record is None or record.key != key:  # another layout, or a file that was moved here
        remove(path)
        raise DamagedEntry(f"{path} is not the record of its name and was removed")
    return record


def _pack(nodes: Mapping[str, KeyParts]) -> dict[str, Any]:
    """Write code and environment, which many nodes share, once each."""
    shared: dict[str, Any] = {}
    packed = {}
    for name, parts in nodes.items():
        obj = parts.to_json()
        for field_name in ("code", "environment"):
            digest = text_digest(canonical_json(obj[field_name]))
            shared[digest] = obj[field_name]
            obj[field_name] = digest
        packed[name] = obj
    return {"shared": shared, "nodes": packed}


def _unpack(body: Mapping[str, Any]) -> dict[str, KeyParts]:
    shared = body["shared"]
    return {
        name: KeyParts.from_json(obj | {"code": shared[obj["code"]], "environment": shared[obj["environment"]]})
        for name, obj in body["nodes"].items()
    }
