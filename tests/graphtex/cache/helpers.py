"""What several tests of the cache need."""

import os
from pathlib import Path
from typing import NamedTuple

import numpy as np

from graphtex.cache import Cache, Output


class Pair(NamedTuple):
    left: np.ndarray
    right: np.ndarray
    label: str
    weight: float


class Nest(NamedTuple):
    pair: Pair
    pairs: list
    count: int


CLASSES = {"Pair": Pair, "Nest": Nest}


def key(n: int) -> str:
    return f"{n:064x}"


def keep(cache: Cache, n: int, *values, node: str = "Node") -> list[str]:
    """Store arrays and a record of them under key(n)."""
    digests = [cache.put("Map", value) for value in values]
    cache.record(key(n), node, {f"out{i}": Output("Map", d) for i, d in enumerate(digests)}, 0.5)
    return digests


def block(value: int, kilobytes: int = 1) -> np.ndarray:
    return np.full((kilobytes, 1024), value, np.uint8)


def file_of(cache: Cache, digest: str) -> Path:
    return next(cache.directory.glob(f"objects/??/{digest}.*"))


def record_of(cache: Cache, n: int) -> Path:
    return cache.directory / "index" / key(n)[:2] / f"{key(n)}.json"


def grow_old(cache: Cache, *, seconds: float = 3600, only: list[Path] | None = None) -> None:
    """Move the last use of entries into the past."""
    for path in (
        only if only is not None else [*cache.directory.glob("objects/??/*"), *cache.directory.glob("index/??/*")]
    ):
        status = path.stat()
        os.utime(path, (status.st_atime, status.st_mtime - seconds))


def same(a, b) -> bool:
    """Equal in type and value all the way down; NaN equals itself, 0.0 differs from -0.0."""
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()
    if isinstance(a, list | tuple):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    return type(a) is type(b) and repr(a) == repr(b)
