"""Leases: how a run tells the other processes on its store that what it uses must stay.

A live run protects every entry that was touched since it started. It says so by a file in ``runs/`` that names process
and host and is touched each minute; leases of dead processes, and those that nobody has touched for long, are removed.
All times are those of the store's file system, so that clocks of several machines need not agree.
"""

import json
import os
import platform
import sys
import threading
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Self

from graphtex.cache.errors import CacheUnavailable
from graphtex.cache.files import now_on, touch

HEARTBEAT = 60.0
"""Seconds between two signs of life."""
STALE = 600.0
"""Seconds without a sign of life after which a lease does not count any more."""
GRANULARITY = 2.0
"""Seconds: the coarsest time stamps that file systems have."""


class Lease:
    """A context manager: while it is open, nothing that is touched in the store is evicted, by any process."""

    def __init__(self, root: Path) -> None:
        self._path = root / "runs" / f"{os.getpid()}-{uuid.uuid4().hex}.json"
        self._scratch = root / "tmp"
        self._over = threading.Event()
        self._heart = threading.Thread(target=self._beat, name="graphtex-cache-lease", daemon=True)
        self._text = ""

    def __enter__(self) -> Self:
        self._text = json.dumps({"pid": os.getpid(), "host": host_name(), "started": now_on(self._scratch)})
        try:
            self._write()
        except OSError as error:
            raise CacheUnavailable(f"the cache in {self._scratch.parent} cannot be written: {error}") from error
        self._heart.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._heart.join()
        with suppress(OSError):
            self._path.unlink()

    def _beat(self) -> None:
        while not self._over.wait(HEARTBEAT):
            if not touch(self._path):  # somebody took this process for dead, after a suspend for instance
                with suppress(OSError):
                    self._write()

    def _write(self) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._path.write_text(self._text, encoding="utf-8")


def protected_since(root: Path, now: float) -> float | None:
    """Return since when touched entries are protected by live runs (seconds, the store's clock), or None.

    Leases of dead runs are removed.
    """
    started = [live for path in sorted((root / "runs").glob("*.json")) if (live := _live_since(path, now)) is not None]
    return min(started) - GRANULARITY if started else None


def live_runs(root: Path, now: float) -> int:
    """Return how many runs are using the store."""
    return sum(_live_since(path, now) is not None for path in (root / "runs").glob("*.json"))


def _live_since(path: Path, now: float) -> float | None:
    try:
        beat = path.stat().st_mtime
        lease = json.loads(path.read_text(encoding="utf-8"))
        pid, host, started = int(lease["pid"]), lease["host"], float(lease["started"])
    except OSError:
        return None  # it ended just now
    except (ValueError, LookupError, TypeError):
        if now - _mtime(path, now) < HEARTBEAT:  # being written just now: protect what is touched from here on
            return _mtime(path, now)
        pid, host, started, beat = 0, "", 0.0, 0.0
    if now - beat > STALE or (host == host_name() and not _process_exists(pid)):
        with suppress(OSError):
            path.unlink()
        return None
    return started


def _mtime(path: Path, missing: float) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return missing


@cache
def host_name() -> str:
    """Return what tells apart machines, and containers that count processes each from 1."""
    name = platform.node()
    with suppress(OSError):
        name += " " + Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        name += " " + str(Path("/proc/self/ns/pid").readlink())
    return name


def _process_exists(pid: int) -> bool:
    if sys.platform == "win32":  # there os.kill would end the process; the heartbeat alone decides
        return True
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True  # somebody else's process
    return pid > 0
