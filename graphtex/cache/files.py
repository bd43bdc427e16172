"""Small files that are whole or absent: atomic writing, checksums, marks of use, removal that a user can prevent.

The time of last use is a file's modification time, set by `touch` (access times are often off).
"""

import json
import os
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, TypeVar

from graphtex.cache.digest import canonical_json, text_digest
from graphtex.cache.errors import CacheUnavailable, DamagedEntry

T = TypeVar("T")
TEMPORARY_AGE = 3600.0
"""Seconds after which a temporary file counts as left over by a process that died."""


def write_atomically(path: Path, scratch: Path, write: Callable[[IO[bytes]], object]) -> int:
    """Write a file under a temporary name in `scratch` (same file system), then rename it; return its size.

    Nothing is synced: a file that a power cut leaves half-written is found out by its digest.

    Raises
    ------
    CacheUnavailable
        If the folder cannot be written or the disk is full; nothing is left behind.
    """
    temporary = scratch / f"{path.name[:16]}-{uuid.uuid4().hex}"
    try:
        try:
            with _in_folder(scratch, lambda: temporary.open("xb")) as file:
                write(file)
                size = file.tell()
            _in_folder(path.parent, lambda: temporary.replace(path))
        except BaseException:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise CacheUnavailable(f"the cache in {scratch.parent} cannot be written: {error.strerror or error}") from error
    return size


def _in_folder(folder: Path, act: Callable[[], T]) -> T:
    """Do something in a folder that is there nearly always; make it where it is not."""
    try:
        return act()
    except FileNotFoundError:
        folder.mkdir(parents=True, exist_ok=True)
        return act()


def write_checked(path: Path, scratch: Path, body: dict[str, Any]) -> int:
    """Write a JSON object together with its checksum; return the size."""
    text = canonical_json(body)
    return write_atomically(path, scratch, lambda file: file.write(_checked(text)))


def _checked(text: str) -> bytes:
    return f'{{"sha256":"{text_digest(text)}","body":{text}}}\n'.encode()


def read_checked(path: Path) -> dict[str, Any] | None:
    """Return the JSON object, or None if there is no such file.

    Raises
    ------
    DamagedEntry
        If the checksum does not fit; the file has been removed.
    """
    try:
        content = path.read_bytes()
    except OSError:
        return None
    text = content[len(_checked("")) - 2 : -2].decode("ascii", "replace")
    if content == _checked(text):
        body: dict[str, Any] = json.loads(text)
        return body
    remove(path)
    raise DamagedEntry(f"{path} is damaged and was removed")


def touch(path: Path) -> bool:
    """Mark a file as used now; False if it is gone. A read-only store keeps its marks and is still read."""
    try:
        os.utime(path)
    except FileNotFoundError:
        return False
    except OSError:
        return path.exists()
    return True


def remove(path: Path) -> bool:
    """Remove a file; False if it was gone or cannot be removed."""
    try:
        path.unlink()
    except OSError:
        return False
    return True


def remove_unless_used(path: Path, scratch: Path, last_use: int) -> bool:
    """Remove a file if nobody has touched it since `last_use` (its mtime in ns); True if it is gone for good.

    Another process may touch it between the look and the removal. So the file is first renamed out of the way, from
    when on touching it fails and its user stores it anew, and is put back if it was touched just before.
    """
    aside = scratch / f"removing-{uuid.uuid4().hex}"
    try:
        if path.stat().st_mtime_ns != last_use:
            return False
        path.rename(aside)
        if aside.stat().st_mtime_ns != last_use:
            aside.replace(path)
            return False
        aside.unlink()
    except OSError:
        return False
    return True


def listing(folder: Path) -> dict[Path, tuple[int, int]]:
    """Return (bytes, last use in ns) of the files in the two-letter folders of a folder."""
    found = {}
    with suppress(OSError), os.scandir(folder) as shelves:
        for shelf in shelves:
            if len(shelf.name) == 2 and shelf.is_dir():
                with suppress(OSError), os.scandir(shelf) as entries:
                    for entry in entries:
                        with suppress(FileNotFoundError):  # removed just now
                            status = entry.stat()
                            found[Path(entry.path)] = status.st_size, status.st_mtime_ns
    return found


def now_on(scratch: Path) -> float:
    """Return the time by the clock of the store's file system, which may be another machine's."""
    probe = scratch / f"clock-{uuid.uuid4().hex}"
    try:
        scratch.mkdir(parents=True, exist_ok=True)
        probe.touch(exist_ok=False)
        now = probe.stat().st_mtime
        probe.unlink()
    except OSError as error:
        raise CacheUnavailable(f"the cache in {scratch.parent} cannot be written: {error.strerror or error}") from error
    return now


def remove_left_over(scratch: Path, now: float) -> None:
    """Remove temporary files of processes that died."""
    with suppress(OSError):
        for path in list(scratch.iterdir()):
            with suppress(OSError):
                if path.stat().st_mtime < now - TEMPORARY_AGE:
                    path.unlink()


def wait_a_moment() -> None:
    """Let another process finish putting a file back, see `remove_unless_used`."""
    time.sleep(0.005)
