"""What source files say, kept between processes: parsing them takes far longer than all the rest of a cached run.

``syntax/<digest of the module's name>.json`` holds what `read_syntax` found in the version of the module that was read
last. It is used only for exactly the same bytes, read by the same code of graphtex and the same Python, so it can never
be out of date; nothing goes by time stamps. A file that is damaged or does not fit is a miss, and is written anew.
"""

import hashlib
import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from graphtex.cache import syntax
from graphtex.cache.digest import text_digest
from graphtex.cache.errors import CacheUnavailable, DamagedEntry
from graphtex.cache.files import read_checked, remove, write_checked
from graphtex.cache.syntax import Import, Syntax, read_syntax

KEPT_MODULES = 1000
"""How many modules stay when a cache is pruned: those that were written last."""


class ParsedFiles:
    """Parsed modules in a cache's folder, which many processes and threads may share.

    Nothing is kept where there is no cache yet, or where it cannot be written: the modules are parsed then.
    """

    def __init__(self, root: Path) -> None:
        self._root = root
        self._folder = root / "syntax"
        self._writable = True

    def read(self, name: str, source: bytes, filename: str, package: str) -> Syntax:
        """Return what `read_syntax` finds in the module of this name; raises what that raises."""
        path = self._folder / f"{text_digest(name)}.json"
        made_of = _made_of(source, package)
        if made_of is None:
            return read_syntax(source, filename, package)
        found = _kept(path, made_of)
        if found is None:
            found = read_syntax(source, filename, package)
            self._keep(path, made_of, found)
        return found

    def _keep(self, path: Path, made_of: str, found: Syntax) -> None:
        if self._writable and self._root.is_dir():
            try:
                write_checked(path, self._root / "tmp", {"made_of": made_of, "syntax": _to_json(found)})
            except CacheUnavailable:  # the run has its digests all the same, and says so when it stores a result
                self._writable = False

    def paths(self) -> list[Path]:
        """Return all files, least recently written first."""
        told = []
        with suppress(OSError), os.scandir(self._folder) as files:
            for file in files:
                with suppress(FileNotFoundError):  # removed just now
                    told.append((file.stat().st_mtime_ns, file.path))
        return [Path(path) for _, path in sorted(told)]

    def prune(self, kept: int = KEPT_MODULES) -> None:
        """Remove all but the files that were written last."""
        paths = self.paths()
        for path in paths[: max(len(paths) - kept, 0)]:
            remove(path)


@cache
def _reader() -> bytes | None:
    """Return the digest of all that reads a source file, Python too; None if that has no source itself."""
    digest = hashlib.sha256(sys.version.encode())
    try:
        for module in (__file__, syntax.__file__):
            digest.update(hashlib.sha256(Path(module).read_bytes()).digest())
    except OSError:
        return None
    return digest.digest()


def _made_of(source: bytes, package: str) -> str | None:
    reader = _reader()
    if reader is None:
        return None
    digest = hashlib.sha256(reader)
    digest.update(f"{len(package)} {package}".encode("utf-8", "surrogatepass"))
    digest.update(source)
    return digest.hexdigest()


def _kept(path: Path, made_of: str) -> Syntax | None:
    try:
        body = read_checked(path)
    except DamagedEntry:
        return None
    return _from_json(body["syntax"]) if body is not None and body.get("made_of") == made_of else None


def _to_json(found: Syntax) -> dict[str, Any]:
    return {
        "digest": found.digest,
        "imports": _rows(found.imports),
        "uses": {name: sorted(chains) for name, chains in found.uses.items()},
        "bindings": {name: sorted(_rows(bound), key=repr) for name, bound in found.bindings.items()},
        "strings": found.strings,
    }


def _from_json(told: dict[str, Any]) -> Syntax:
    return Syntax(
        told["digest"],
        tuple(Import(*row) for row in told["imports"]),
        {name: frozenset(map(tuple, chains)) for name, chains in told["uses"].items()},
        {name: frozenset(row and Import(*row) for row in rows) for name, rows in told["bindings"].items()},
        tuple(told["strings"]),
    )


def _rows(imports: Iterable[Import | None]) -> list[list[str | None] | None]:
    return [[found.module, found.name, found.local] if found else None for found in imports]
