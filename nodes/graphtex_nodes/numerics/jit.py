"""Compiled kernels: one decorator, and a cache that sees every change.

numba's own cache looks at the file of the kernel alone: a constant that changed in *another* kernel file leaves the old
machine code in use. Here the cache folder is named by a digest of all kernel files of the package (every
``*_kernels.py``), this file, Python, numba and the processor, so any change starts a new folder.

A kernel file holds nothing but kernels and constants and is imported by the function that runs them, never at the top
of a node's module. Kernels are compiled (or read from the cache) when their file is imported.

What makes compiling slow: to assign an array to a slice of another (three to five seconds, for the message of shapes
that disagree) and ``inline="always"``, for which ``forceinline=True`` does the same later. Loops and calls cost little.
"""

import hashlib
import os
import shutil
import sys
import tempfile
import threading
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

KEPT_VERSIONS = 4
"""Folders of earlier digests that stay: a user may go back and forth between two checkouts."""

_PACKAGE = Path(__file__).resolve().parent.parent
_lock = threading.RLock()


class Announcing(Protocol):
    """What :func:`announce` needs of a node's context."""

    def progress(self, fraction: float, message: str = "") -> None:
        """Tell how far the work is."""


@cache
def kernel_files(package: Path = _PACKAGE) -> list[Path]:
    """All kernel files of the package, sorted by path."""
    return sorted(package.rglob("*_kernels.py"))


@cache
def kernel_digest() -> str:
    """Digest of everything that the machine code depends on."""
    import numba
    from llvmlite import binding  # type: ignore[import-untyped]

    digest = hashlib.sha256()
    facts = (sys.version, numba.__version__, binding.get_host_cpu_name(), sys.platform)
    digest.update(repr(facts).encode())
    for path in [Path(__file__), *kernel_files()]:
        digest.update(path.name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:24]


def cache_base() -> Path:
    """Folder of all kernel caches: below ``GRAPHTEX_CACHE_DIR``, else in the user's cache folder."""
    base = os.environ.get("GRAPHTEX_CACHE_DIR")
    if base:
        return Path(base) / "kernels"
    from platformdirs import user_cache_dir

    return Path(user_cache_dir("graphtex")) / "kernels"


@cache
def cache_folder() -> Path | None:
    """Folder of the present digest, made when missing; None when nothing can be written there."""
    base = cache_base()
    folder = base / kernel_digest()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        return None
    os.utime(folder)
    _remove_old(base, folder)
    return folder


def _remove_old(base: Path, present: Path) -> None:
    """Delete all but the newest folders; a file that another process holds open stays for the next time."""
    others = [path for path in base.iterdir() if path.is_dir() and path != present]
    others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    for path in others[KEPT_VERSIONS:]:
        shutil.rmtree(path, ignore_errors=True)


def kernel(*signatures: str, fastmath: bool | set[str] = False) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile a function for the given signatures: no GIL, no Python objects, kept in the cache folder.

    In a signature ``f4``, ``i4``, ``u1``, ``u8``, ``i8`` and ``f8`` are scalars; ``f4[:,:]`` is a C-contiguous array
    that the kernel writes and ``const f4[:,:]`` one that it only reads, so that read-only arrays fit. The result is
    always ``void``.

    Raises
    ------
    ValueError
        If the function's file is not named ``*_kernels.py``: the digest would not see it.
    """

    def compile_function(function: Callable[..., Any]) -> Callable[..., Any]:
        if not function.__module__.endswith("_kernels"):
            raise ValueError(
                f"kernel {function.__name__}: expected a file named *_kernels.py, got {function.__module__}"
            )
        import numba

        config: Any = numba.config
        types = [_signature(text) for text in signatures]
        with _lock:
            folder = cache_folder()
            before = config.CACHE_DIR
            config.CACHE_DIR = str(folder) if folder else before
            try:
                compiled = numba.njit(types, cache=folder is not None, nogil=True, fastmath=fastmath)(function)
            finally:
                config.CACHE_DIR = before
        return compiled

    return compile_function


def _signature(text: str) -> Any:
    """The numba signature of a text such as ``const f4[:,:,:], i8, f4[:,:]``."""
    from numba import types

    def argument(word: str) -> Any:
        word = word.strip()
        scalar = getattr(types, word.removeprefix("const ").split("[")[0])
        if "[" not in word:
            return scalar
        return types.Array(scalar, word.count(":"), "C", readonly=word.startswith("const "))

    words = text.replace("[:,:,:,:]", "[::::]").replace("[:,:,:]", "[:::]").replace("[:,:]", "[::]").split(",")
    return types.void(*(argument(word) for word in words))


def is_cold(*modules: str) -> bool:
    """Whether any kernel of the named files (``"search_kernels"``) must still be compiled."""
    folder = cache_folder()
    for path in kernel_files():
        if path.stem in modules:
            if folder is None:
                return _module_of(path) not in sys.modules
            wanted = path.read_text(encoding="utf-8").count("\n@kernel(")
            if len(list(folder.rglob(f"{path.stem}.*.nbi"))) < wanted:
                return True
    return False


def _module_of(path: Path) -> str:
    return ".".join([_PACKAGE.name, *path.relative_to(_PACKAGE).with_suffix("").parts])


def announce(ctx: Announcing, *modules: str) -> None:
    """Compile the kernels of some files where that is still to be done, and say so; call it before importing them.

    The run can be stopped between two files: the compiler, which cannot be interrupted, takes one to four seconds each.
    """
    named = [path for path in kernel_files() if path.stem in modules]
    cold = [path for path in named if _module_of(path) not in sys.modules and is_cold(path.stem)]
    for number, path in enumerate(cold, 1):
        ctx.progress(0.0, f"compiling kernels, once ({number} of {len(cold)})")
        import_module(_module_of(path))
