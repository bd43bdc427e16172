"""The cache as the scheduler and the command line see it."""

import os
import threading
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from graphtex.cache.errors import CacheUnavailable, EntryLost
from graphtex.cache.eviction import Pruned, default_limit, disk_use, parse_size, prune
from graphtex.cache.files import now_on, remove, touch, write_atomically
from graphtex.cache.index import Index, Output, Record
from graphtex.cache.key import KeyParts
from graphtex.cache.leases import Lease, live_runs
from graphtex.cache.parsed import ParsedFiles
from graphtex.cache.store import Resolver, Store, struct_class

DIRECTORY_VARIABLE = "GRAPHTEX_CACHE_DIR"
_TAG = (
    b"Signature: 8a477f597d28d172789f06886806bc55\n# A cache of graphtex; it may be deleted. See bford.info/cachedir\n"
)


def base_directory() -> Path:
    """Return where graphtex keeps what it can compute again: ``GRAPHTEX_CACHE_DIR``, else the user's cache folder."""
    told = os.environ.get(DIRECTORY_VARIABLE, "")
    if told:
        return Path(told).expanduser().absolute()
    from platformdirs import user_cache_path

    return user_cache_path("graphtex", appauthor=False)


@dataclass(frozen=True)
class Info:
    """The state of a cache; times are seconds since 1970, None if it is empty."""

    directory: Path
    records: int
    objects: int
    bytes: int
    limit: int
    least_recent_use: float | None
    most_recent_use: float | None
    live_runs: int


@dataclass(frozen=True)
class Verified:
    """What `Cache.verify` found: how many files it checked, and the messages about those that it removed."""

    checked: int
    damaged: tuple[str, ...]
    dangling: tuple[str, ...]


class Cache:
    """Results of nodes by key, in a folder that many processes and threads may share.

    Parameters
    ----------
    directory
        The cache's own folder; by default ``results`` in `base_directory`. Nothing is made before something is stored.
    size_limit
        The bound on its size: bytes or such as "20 GiB"; by default ``GRAPHTEX_CACHE_SIZE``, else 10 GiB or a tenth of
        the disk, whichever is less. It is kept at the end of sessions and now and then while values are stored.
    resolve
        Type name -> NamedTuple class, to rebuild composites; by default the registered socket types.

    Examples
    --------
    >>> import tempfile, numpy as np
    >>> cache, key = Cache(tempfile.mkdtemp()), "0" * 64
    >>> with cache.session():
    ...     if cache.lookup(key) is None:
    ...         digest = cache.put("Mask", np.zeros((2, 2), bool))
    ...         record = cache.record(key, node="Blank", outputs={"mask": Output("Mask", digest)}, seconds=0.1)
    ...     cache.load(cache.lookup(key))["mask"].shape
    (2, 2)
    """

    def __init__(
        self,
        directory: str | Path | None = None,
        size_limit: int | str | None = None,
        *,
        resolve: Resolver = struct_class,
    ) -> None:
        self.directory = base_directory() / "results" if directory is None else Path(directory).expanduser().absolute()
        self.size_limit = default_limit(self.directory) if size_limit is None else parse_size(size_limit)
        self._resolve = resolve
        self._store = Store(self.directory, resolve)
        self._index = Index(self.directory)
        self.parsed = ParsedFiles(self.directory)
        self._lock = threading.Lock()
        self._checked = 0

    def __reduce__(self) -> tuple[Any, ...]:
        """Workers get a cache on the same folder."""
        return _remake, (self.directory, self.size_limit, self._resolve)

    def lookup(self, key: str) -> Record | None:
        """Return the record of a key whose outputs are all there, marked as used now; else None."""
        record = self._index.read(key)
        if record is None or not touch(self._index.path(key)):
            return None
        if all(self._store.touch(output.digest) for output in record.outputs.values()):
            return record
        remove(self._index.path(key))
        return None

    def put(self, type_name: str, value: Any) -> str:
        """Store a value and return its digest; raises `CacheUnavailable`, or TypeError for what cannot be stored."""
        digest = self._store.put(type_name, value)
        self._keep_bound(self.size_limit // 16)
        return digest

    def get(self, type_name: str, digest: str) -> Any:
        """Return a stored value, verified, arrays read-only; raises `EntryLost` (`MissingEntry`, `DamagedEntry`)."""
        return self._store.get(type_name, digest)

    def has(self, digest: str) -> bool:
        """Tell whether a value and all its parts are in the store."""
        return self._store.has(digest)

    def load(self, record: Record) -> dict[str, Any]:
        """Return all outputs of a record by socket; raises `EntryLost`."""
        return {socket: self.get(output.type, output.digest) for socket, output in record.outputs.items()}

    def record(
        self, key: str, node: str, outputs: Mapping[str, Output], seconds: float, warnings: tuple[str, ...] = ()
    ) -> Record:
        """Keep under a key what came of a node; its outputs have been `put` before. Raises `CacheUnavailable`."""
        record = Record(key, node, dict(outputs), seconds, tuple(warnings))
        self._store.count(self._index.write(record))
        return record

    def record_run(self, graph: str, nodes: Mapping[str, KeyParts]) -> None:
        """Keep of what the keys of a graph (absolute path, or shipped name) were made. Raises `CacheUnavailable`."""
        self._index.write_run(graph, nodes)

    def last_run(self, graph: str) -> dict[str, KeyParts] | None:
        """Return node id -> parts of the graph's last recorded run, or None."""
        return self._index.read_run(graph)

    def session(self) -> "Session":
        """Return a context manager in which nothing that is used here can be evicted, by any process.

        Entering raises `CacheUnavailable` if the folder cannot be written; leaving keeps the bound on the size.
        """
        return Session(self)

    def info(self) -> Info:
        """Return the state of the cache."""
        records, objects = self._index.files(), self._store.files()
        used = [last_use / 1e9 for _, last_use in (records | objects).values()]
        live = 0
        if self.directory.is_dir():
            with suppress(CacheUnavailable):
                live = live_runs(self.directory, now_on(self._store.scratch))
        total = sum(size for size, _ in (records | objects).values())
        oldest, newest = min(used, default=None), max(used, default=None)
        return Info(self.directory, len(records), len(objects), total, self.size_limit, oldest, newest, live)

    def prune(self, limit: int | str | None = None) -> Pruned:
        """Remove the least recently used entries until at most `limit` bytes remain (by default the cache's bound).

        What live runs have touched stays. Raises `CacheUnavailable` if files cannot be removed.
        """
        self.parsed.prune()
        return prune(self._store, self._index, self.size_limit if limit is None else parse_size(limit))

    def clear(self) -> Pruned:
        """Remove everything that no live run uses, the recorded runs and parsed files. Other files in it stay."""
        self.parsed.prune(kept=0)
        for path in self._index.run_paths():
            remove(path)
        return prune(self._store, self._index, 0)

    def verify(self) -> Verified:
        """Read and check everything; remove what is damaged and the records that name what is not there."""
        damaged, dangling = [], []
        objects, records = sorted(self._store.files()), sorted(self._index.files())
        for path in objects:
            try:
                self._store.check(path)
            except EntryLost as error:
                if not path.exists():
                    damaged.append(str(error))
        for path in records:
            try:
                record = self._index.check(path)
            except EntryLost as error:
                damaged.append(str(error))
                continue
            lost = [name for name, output in record.outputs.items() if not self._store.has(output.digest)]
            if lost:
                remove(path)
                dangling.append(f"{path} was removed: {record.node}'s {', '.join(lost)} is not there")
        return Verified(len(objects) + len(records), tuple(damaged), tuple(dangling))

    def _keep_bound(self, at_least: int) -> None:
        """Prune to nine tenths of the bound if it is exceeded; looks only after so many more bytes were written."""
        with self._lock:
            if self._store.written - self._checked < max(at_least, 1):
                return
            self._checked = self._store.written
        if disk_use(self._store, self._index) > self.size_limit:
            prune(self._store, self._index, self.size_limit * 9 // 10)


class Session:
    """See `Cache.session`."""

    def __init__(self, cache: Cache) -> None:
        self._cache = cache
        self._lease = Lease(cache.directory)

    def __enter__(self) -> Cache:
        tag = self._cache.directory / "CACHEDIR.TAG"  # backups leave such folders out
        try:
            tagged = tag.exists()
        except OSError:  # the folder is somebody else's: writing will say so
            tagged = False
        if not tagged:
            write_atomically(tag, self._cache.directory / "tmp", lambda file: file.write(_TAG))
        self._lease.__enter__()
        return self._cache

    def __exit__(self, *_: object) -> None:
        self._lease.__exit__()
        with suppress(CacheUnavailable):  # it became read-only meanwhile; the run is over and has its results
            self._cache._keep_bound(1)


def _remake(directory: Path, size_limit: int, resolve: Resolver) -> Cache:
    return Cache(directory, size_limit, resolve=resolve)
