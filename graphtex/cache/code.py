"""Code digests: what of a node's own package its result may depend on, found by static analysis.

The digest covers the syntax tree of the node's module and of every module of the same top-level package that it
imports, directly or through others, at the top of a file or within a function. An import through a package's
``__init__`` counts as one of the module that defines the name, so it does not pull in all that the ``__init__``
imports. The code of an ``__init__`` counts where a name is defined in it, or where it cannot be told what is used. No
module is executed.

graphtex itself and other packages do not count by code; `CodeDigest.packages` names the others, for their versions.
What static analysis cannot see: modules whose name is computed at run time, and data files.

API: ``code_digest(function, parsed) -> CodeDigest``, ``module_digest(name, parsed) -> CodeDigest``.
"""

import sys
import threading
from collections.abc import Callable, Iterator
from importlib.machinery import EXTENSION_SUFFIXES
from pathlib import Path
from typing import Any

from graphtex.cache.digest import file_digest
from graphtex.cache.errors import BadSource, NoSource
from graphtex.cache.key import CodeDigest
from graphtex.cache.parsed import ParsedFiles
from graphtex.cache.sources import Source, Sources, find_sources, sources_of
from graphtex.cache.syntax import Import, Syntax, read_syntax

MISSING = "missing"
"""Digest of an own module that is imported but not there (an optional part): it changes when it appears."""

_parsed: dict[tuple[str, Path], tuple[tuple[int, int], Syntax]] = {}
_loaded: dict[str, tuple[object, object, Syntax]] = {}
_lock = threading.Lock()


def code_digest(function: Callable[..., Any], parsed: ParsedFiles | None = None) -> CodeDigest:
    """Return the digest of all own code that a function may run.

    The files as they are now count, except for modules that this process has loaded: these count as they were when
    first seen, until they are reloaded, because the code in memory does not change with the file.

    Parameters
    ----------
    parsed
        Where other processes have left what they found in the same files, which saves parsing them.

    Raises
    ------
    NoSource
        If the function has no source file.
    BadSource
        If a file cannot be read or parsed; with file, line and the reason.
    """
    return _digest(sources_of(function), parsed)


def module_digest(name: str, parsed: ParsedFiles | None = None) -> CodeDigest:
    """Return the digest of a module by its name, as `code_digest` does for a function that is defined in it."""
    sources = find_sources(name)
    if sources is None:
        raise NoSource(f"module {name} has no source file")
    return _digest(sources, parsed)


def _digest(sources: Sources, parsed: ParsedFiles | None) -> CodeDigest:
    resolver = _Resolver(sources, parsed)
    digests: dict[str, str] = {}
    ahead = [sources.entry.name]
    while ahead:
        name = ahead.pop()
        if name in digests:
            continue
        source = sources.find(name)
        if source is None:
            digests[name] = MISSING
        elif _has_text(source):
            syntax = resolver.syntax(source)
            digests[name] = syntax.digest
            ahead += sorted(resolver.dependencies(syntax))
        elif source.path is not None:
            digests[name] = _binary_digest(source.path)
    return CodeDigest.of(digests, resolver.others)


def _has_text(source: Source) -> bool:
    """Tell whether a module is Python text: neither a namespace package nor compiled."""
    return source.path is not None and not source.path.name.endswith(tuple(EXTENSION_SUFFIXES))


def _binary_digest(path: Path) -> str:
    try:
        return file_digest(path)
    except OSError as error:
        raise BadSource(f"{path}: cannot be read: {error.strerror or error}") from error


def _syntax(source: Source, parsed: ParsedFiles | None) -> Syntax:
    """Parse a module, or take what was found before if neither file nor loaded module have changed."""
    assert source.path is not None
    loaded = sys.modules.get(source.name)
    if getattr(loaded, "__file__", None) != str(source.path):
        loaded = None
    with _lock:
        if loaded is not None:
            known = _loaded.get(source.name)
            if known is not None and known[0] is loaded and known[1] is loaded.__spec__:  # a reload makes a new spec
                return known[2]
        syntax = _parse(source, source.path, parsed)
        if loaded is not None:
            _loaded[source.name] = loaded, loaded.__spec__, syntax
        return syntax


def _parse(source: Source, path: Path, parsed: ParsedFiles | None) -> Syntax:
    try:
        if source.text is not None:
            return read_syntax(source.text, str(path), source.package)
        status = path.stat()
        stamp = status.st_mtime_ns, status.st_size
        known = _parsed.get((source.name, path))
        if known is None or known[0] != stamp:
            text = path.read_bytes()
            if parsed is None:
                known = stamp, read_syntax(text, str(path), source.package)
            else:
                known = stamp, parsed.read(source.name, text, str(path), source.package)
            _parsed[source.name, path] = known
        return known[1]
    except (SyntaxError, ValueError) as error:
        line = f"{error.lineno}: " if isinstance(error, SyntaxError) and error.lineno else " "
        what = error.msg if isinstance(error, SyntaxError) else str(error)
        raise BadSource(f"{path}:{line}{what}; a node imports this file, so its result cannot be known") from error
    except OSError as error:
        raise BadSource(f"{path}: cannot be read: {error.strerror or error}") from error


class _Resolver:
    """Finds the own modules that imports lead to; collects the top-level names of others. For one digest."""

    def __init__(self, sources: Sources, parsed: ParsedFiles | None) -> None:
        self._sources = sources
        self._parsed = parsed
        self.others: set[str] = set()
        self._syntax: dict[str, Syntax] = {}
        self._exports: dict[str, frozenset[str]] = {}
        self._found: dict[tuple[str, tuple[str, ...]], set[str]] = {}

    def syntax(self, source: Source) -> Syntax:
        """Return what a module says; the same all through this digest."""
        if source.name not in self._syntax:
            self._syntax[source.name] = _syntax(source, self._parsed)
        return self._syntax[source.name]

    def dependencies(self, syntax: Syntax) -> set[str]:
        """Return the modules that all imports of a module lead to."""
        found: set[str] = set()
        for item in syntax.imports:
            for reference in _references(item, syntax):
                if reference not in self._found:
                    self._found[reference] = self._resolve(*reference, set())
                found |= self._found[reference]
        return found

    def _resolve(self, module: str, chain: tuple[str, ...], seen: set[tuple[str, tuple[str, ...]]]) -> set[str]:
        """Return where ``module.chain`` is defined; empty for other packages."""
        if (module, chain) in seen:  # names that packages import from each other in a circle
            return set()
        seen.add((module, chain))
        if not self._sources.is_own(module):
            self._note_other(module)
            return set()
        source = self._sources.find(module)
        if source is None or source.locations is None or not chain:
            return {module}
        name, rest = chain[0], chain[1:]
        submodule = f"{module}.{name}"
        if source.path is None:  # a namespace package has nothing but submodules
            return self._resolve(submodule, rest, seen)
        syntax = self.syntax(source)
        bound = self._bound(module, syntax, name, rest, seen)
        if bound is not None:
            return bound
        if self._sources.find(submodule) is not None:
            return self._resolve(submodule, rest, seen)
        return {module} | self._on_demand(module, syntax)

    def _bound(
        self, module: str, syntax: Syntax, name: str, rest: tuple[str, ...], seen: set[tuple[str, tuple[str, ...]]]
    ) -> set[str] | None:
        """Return where a name is defined that a package's ``__init__`` binds, or None if it does not bind it."""
        found: set[str] = set()
        binders = syntax.bindings.get(name, frozenset())
        for item in binders:
            if item is None:
                found.add(module)
            elif item.name is None:
                # ``import a.b`` binds a, ``import a.b as c`` binds a.b
                whole = item.local == item.module.partition(".")[0]
                found |= self._resolve(item.local if whole else item.module, rest, seen)
            else:
                found |= self._resolve(item.module, (item.name, *rest), seen)
        starred = [star for star in syntax.stars if name in self._exported(star)]
        for star in starred:
            found |= self._resolve(star, (name, *rest), seen)
        return found if binders or starred else None

    def _exported(self, module: str) -> frozenset[str]:
        """Return all names that ``from module import *`` may bind."""
        if module not in self._exports:
            names: set[str] = set()
            ahead, seen = [module], {module}
            while ahead:
                name = ahead.pop()
                source = self._sources.find(name) if self._sources.is_own(name) else None
                if source is not None and _has_text(source):
                    syntax = self.syntax(source)
                    names |= syntax.bindings.keys()
                    ahead += [star for star in syntax.stars if star not in seen]
                    seen.update(syntax.stars)
            self._exports[module] = frozenset(names)
        return self._exports[module]

    def _on_demand(self, module: str, syntax: Syntax) -> set[str]:
        """Return the submodules that a package's ``__getattr__`` may import: all that a string in it names."""
        named = {f"{module}.{text.lstrip('.')}" for text in syntax.strings} | set(syntax.strings)
        return {
            name
            for name in named
            if all(part.isidentifier() for part in name.split("."))
            and self._sources.is_own(name)
            and self._sources.find(name) is not None
        }

    def _note_other(self, module: str) -> None:
        top = module.partition(".")[0]
        if top not in sys.stdlib_module_names and top not in ("graphtex", "__main__"):
            self.others.add(top)


def _references(item: Import, syntax: Syntax) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield each (module, attributes) that an import and the uses of its name amount to."""
    chains = sorted(syntax.uses.get(item.local, ())) or [()]
    if item.name == "*":
        yield item.module, ()
    elif item.name is not None:
        yield from ((item.module, (item.name, *chain)) for chain in chains)
    elif item.local and item.local != item.module.partition(".")[0]:
        yield from ((item.module, chain) for chain in chains)
    else:  # ``import a.b`` binds a; what follows is reached from there
        top, *rest = item.module.split(".")
        path = tuple(rest)
        yield from ((top, chain) for chain in chains if item.local and chain)
        if not any(chain[: len(path)] == path and len(chain) > len(path) for chain in chains):
            yield item.module, ()
