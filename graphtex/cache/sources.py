"""Where the source of a module is, found without executing anything.

A module counts as a node's own if it belongs to the same top-level package. A node of a loose module (a script, or a
file beside it) has for its own what lies in the same folder, unless that is where packages are installed.
"""

import importlib.machinery
import importlib.util
import inspect
import sys
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from graphtex.cache.errors import NoSource

_MAIN = ("__main__", "__mp_main__")


@dataclass(frozen=True)
class Source:
    """A module of the node's own code.

    `path` is None for a namespace package; `locations` is where its submodules are (None: it is no package);
    `text` is given if there is no file to read (a module in a zip archive).
    """

    name: str
    path: Path | None
    locations: tuple[str, ...] | None = None
    text: str | None = None

    @property
    def package(self) -> str:
        """Return what relative imports start from."""
        return self.name if self.locations is not None else self.name.rpartition(".")[0]


class Sources:
    """Finds the modules that count as one node's own.

    `top` is the name of its top-level package, `home` the folder of a loose module. Exactly one is given.
    """

    def __init__(self, entry: Source, top: str | None, home: Path | None) -> None:
        self.entry = entry
        self._top = top
        self._home = home
        self._known: dict[str, Source | None] = {entry.name: entry}

    def is_own(self, name: str) -> bool:
        """Tell whether a module counts by its code; others count by their version."""
        head = name.partition(".")[0]
        if self._top is not None or name == self.entry.name:
            return head == (self._top or name)
        return self._home is not None and head != "graphtex" and self.find(head) is not None

    def find(self, name: str) -> Source | None:
        """Return where a module is, or None if there is none of this name."""
        if name not in self._known:
            parent, _, last = name.rpartition(".")
            if parent:
                above = self.find(parent)
                found = _in_folders(name, last, above.locations) if above and above.locations else None
            elif self._home is not None:
                found = _in_folders(name, name, (str(self._home),))
                if found is not None and found.path is None:
                    found = None  # any folder beside a script would be a namespace package
            else:
                found = _top_level(name)
            self._known[name] = found
        return self._known[name]


def sources_of(function: Callable[..., Any]) -> Sources:
    """Return the own modules of a function's code.

    Raises
    ------
    NoSource
        If it was typed at a prompt or in a notebook, or made by `exec`, or only its byte code is installed.
    """
    function = inspect.unwrap(function)
    name = function.__module__
    code = getattr(function, "__code__", None)
    if code is None or code.co_filename.startswith("<"):
        raise NoSource(f"{name}.{function.__qualname__} has no source file; its node runs without the cache")
    if name in _MAIN:
        spec = getattr(sys.modules.get(name), "__spec__", None)
        name = "__main__" if spec is None else spec.name  # `python -m pack.module` has one
    if name == "__main__":
        path = Path(code.co_filename).absolute()
        if not path.is_file():
            raise NoSource(f"{path} is not there; nodes of {function.__qualname__} run without the cache")
        return Sources(Source("__main__", path), None, _home_of(path))
    found = find_sources(name)
    if found is None:
        raise NoSource(f"module {name} has no source file; its nodes run without the cache")
    return found


def find_sources(name: str) -> Sources | None:
    """Return the own modules of a module given by name, or None if it has no source."""
    top = name.partition(".")[0]
    source = _top_level(top)
    if source is None:
        return None
    if source.locations is None:
        return None if name != top or source.path is None else Sources(source, None, _home_of(source.path))
    sources = Sources(source, top, None)
    entry = sources.find(name)
    if entry is None or (entry.path is None and entry.text is None):
        return None
    sources.entry = entry
    return sources


def _top_level(name: str) -> Source | None:
    loaded = sys.modules.get(name)
    try:
        spec = getattr(loaded, "__spec__", None) or importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return None
    return None if spec is None else _from_spec(name, spec)


def _in_folders(name: str, last: str, folders: tuple[str, ...]) -> Source | None:
    """Look a module up as the import system does, but always at the disk as it is now, not at a cached listing."""
    portions = []
    for folder in folders:
        package = Path(folder, last)
        if (package / "__init__.py").is_file():
            return Source(name, package / "__init__.py", (str(package),))
        for suffix in (".py", *importlib.machinery.EXTENSION_SUFFIXES):
            module = Path(folder, last + suffix)
            if module.is_file():
                return Source(name, module)
        if package.is_dir():
            portions.append(str(package))
        elif not Path(folder).is_dir():  # a zip archive, or a folder in one
            spec = importlib.machinery.PathFinder.find_spec(name, [folder])
            if spec is not None:
                return _from_spec(name, spec)
    return Source(name, None, tuple(portions)) if portions else None  # a namespace package


def _from_spec(name: str, spec: importlib.machinery.ModuleSpec) -> Source | None:
    locations = None if spec.submodule_search_locations is None else tuple(spec.submodule_search_locations)
    path = Path(spec.origin) if spec.origin and spec.has_location else None
    if path is None or path.suffix == ".pyc":
        return Source(name, None, locations) if locations else None
    if path.is_file():
        return Source(name, path, locations)
    get_source = getattr(spec.loader, "get_source", None)
    text = None if get_source is None else get_source(name)
    return None if text is None else Source(name, path, locations, text)


def _home_of(path: Path) -> Path | None:
    folder = path.parent
    return None if folder in _installed() or {"site-packages", "dist-packages"} & set(folder.parts) else folder


@cache
def _installed() -> frozenset[Path]:
    return frozenset(Path(sysconfig.get_path(name)) for name in ("stdlib", "platstdlib", "purelib", "platlib"))
