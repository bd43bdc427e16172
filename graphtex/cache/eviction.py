"""Keeping the store within its bound: the least recently used records go first, and with them what only they name.

Use is a file's modification time, see `files`. What a live run has touched stays (`leases`), so the bound may be
exceeded while a run needs more than that.
"""

import os
import re
import shutil
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from graphtex.cache.errors import EntryLost
from graphtex.cache.files import now_on, remove, remove_left_over, remove_unless_used
from graphtex.cache.index import Index
from graphtex.cache.leases import protected_since
from graphtex.cache.store import Store

SIZE_VARIABLE = "GRAPHTEX_CACHE_SIZE"
DEFAULT_LIMIT = 10 << 30
SHARE_OF_DISK = 10
KEPT_RUNS = 200
"""How many graphs' last runs are remembered."""
_SIZE = re.compile(r"(\d+(?:\.\d+)?)\s*([kmgt]?)(i?)b?", re.IGNORECASE)


def parse_size(text: str | int) -> int:
    """Return a number of bytes.

    Raises
    ------
    ValueError
        If it is not a size.

    Examples
    --------
    >>> parse_size("1.5 GiB"), parse_size("20 kB"), parse_size("7")
    (1610612736, 20000, 7)
    """
    found = _SIZE.fullmatch(str(text).strip())
    if not found:
        raise ValueError(f"cache size: expected such as '10GiB', '500 MB' or a number of bytes, got {text!r}")
    number, unit, binary = found.groups()
    return int(float(number) * (1024 if binary else 1000) ** " kmgt".index(unit.lower() or " "))


def default_limit(directory: Path) -> int:
    """Return the bound from the environment, else 10 GiB or a tenth of the disk, whichever is less."""
    told = os.environ.get(SIZE_VARIABLE, "")
    if told:
        try:
            return parse_size(told)
        except ValueError as error:
            raise ValueError(f"{SIZE_VARIABLE}: {error}") from None
    for folder in (directory, *directory.parents):
        if folder.is_dir():
            return min(DEFAULT_LIMIT, shutil.disk_usage(folder).total // SHARE_OF_DISK)
    return DEFAULT_LIMIT


@dataclass(frozen=True)
class Pruned:
    """What a pruning did: counts of removed files, bytes freed, bytes that remain."""

    records: int
    objects: int
    freed: int
    bytes: int


@dataclass(frozen=True)
class _Entry:
    """A record with all objects that it names, or an object that no record names."""

    last_use: int
    path: Path
    objects: frozenset[str] = frozenset()


def disk_use(store: Store, index: Index) -> int:
    """Return the bytes of all objects and records."""
    return sum(size for size, _ in (index.files() | store.files()).values())


def prune(store: Store, index: Index, limit: int) -> Pruned:
    """Remove the least recently used entries until at most `limit` bytes remain, apart from pinned ones.

    Records whose objects are gone are removed in any case. Raises `CacheUnavailable` for a read-only store.
    """
    now = now_on(store.scratch)
    remove_left_over(store.scratch, now)
    since = protected_since(store.scratch.parent, now)
    pinned_from = float("inf") if since is None else since * 1e9
    records = index.files()
    objects = store.files()  # listed later than the records: what a listed record names was there before it
    files = records | objects
    entries, doomed = _entries(store, index, records, objects)
    by_digest = {path.stem: path for path in objects}
    users = Counter(digest for entry in entries for digest in entry.objects)
    total = sum(size for size, _ in files.values()) - sum(files[path][0] for path in doomed)
    for entry in sorted(entries, key=lambda entry: (entry.last_use, entry.path)):
        if total <= limit:
            break
        if entry.last_use >= pinned_from:
            continue
        users.subtract(entry.objects)
        unused = [by_digest[digest] for digest in sorted(entry.objects) if users[digest] == 0]
        leaving = [entry.path, *(path for path in unused if files[path][1] < pinned_from)]
        total -= sum(files[path][0] for path in leaving)
        doomed += leaving
    gone = [path for path in doomed if remove_unless_used(path, store.scratch, files[path][1])]
    for path in index.run_paths()[:-KEPT_RUNS]:
        remove(path)
    freed = sum(files[path][0] for path in gone)
    removed_records = sum(path in records for path in gone)
    left = sum(size for size, _ in files.values()) - freed
    return Pruned(removed_records, len(gone) - removed_records, freed, left)


def _entries(
    store: Store, index: Index, records: dict[Path, tuple[int, int]], objects: dict[Path, tuple[int, int]]
) -> tuple[list[_Entry], list[Path]]:
    """Return what may be evicted as one, and the records that are of no use any more."""
    known = {path.stem for path in objects}
    entries, useless = [], []
    for path, (_, last_use) in records.items():
        try:
            outputs = index.check(path).outputs.values()
            named = {digest for output in outputs for digest in store.closure(output.digest)}
        except EntryLost:
            useless.append(path)
            continue
        entries.append(_Entry(last_use, path, frozenset(named & known)))
    in_use = {digest for entry in entries for digest in entry.objects}
    entries += [_Entry(last_use, path) for path, (_, last_use) in objects.items() if path.stem not in in_use]
    return entries, useless
