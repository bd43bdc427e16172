"""Cache keys: all that a node's result depends on, kept so that it can be told what changed.

API: ``KeyParts(...)`` with ``key()``, ``to_json()``, ``from_json(obj)``; ``environment(packages)``;
``explain(old, new) -> list[Change]``.
"""

import platform
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Self

from graphtex.cache.digest import canonical_json, text_digest

LIBRARIES = ("numpy", "scipy", "numba", "scikit-image", "pillow", "OpenImageIO", "tifffile", "PyMaxflow")
"""Distributions whose version always counts: a pack may use them through another pack."""
ABSENT = "(absent)"
PRESENT = "(present)"
_SHOWN = 60


@dataclass(frozen=True)
class CodeDigest:
    """What the code of a node is: a digest for each module that counts.

    Attributes
    ----------
    digest
        Of all modules.
    modules
        Module name -> digest of its syntax tree.
    packages
        Top-level names of other packages that these modules import, without the standard library and graphtex.
    """

    digest: str
    modules: Mapping[str, str]
    packages: tuple[str, ...] = ()

    @classmethod
    def of(cls, modules: Mapping[str, str], packages: Iterable[str] = ()) -> Self:
        """Return the digest of these modules."""
        ordered = dict(sorted(modules.items()))
        return cls(text_digest(canonical_json(ordered)), ordered, tuple(sorted(packages)))


_COUNTED = ("format", "node", "version", "params", "inputs", "entropy", "environment")


@dataclass(frozen=True)
class KeyParts:
    """All that the result of one node depends on.

    Attributes
    ----------
    format
        graphtex's own version number of what a key means.
    node, version
        YAML name and declared version.
    code
        See `code_digest`.
    params
        Canonical parameters, JSON; files by the digest of their content.
    inputs
        Socket -> digest, or list of digests for a list socket.
    entropy
        Words that seed the random stream, or None if the node draws no random numbers.
    environment
        See `environment`.
    """

    format: int
    node: str
    version: int
    code: CodeDigest
    params: Mapping[str, Any]
    inputs: Mapping[str, str | list[str]]
    entropy: tuple[int, ...] | None
    environment: Mapping[str, str]

    def key(self) -> str:
        """Return the key, 64 hex digits; TypeError if the parameters are not JSON."""
        counted: dict[str, Any] = {name: getattr(self, name) for name in _COUNTED}
        return text_digest(canonical_json(counted | {"code": self.code.digest}))

    def to_json(self) -> dict[str, Any]:
        """Return the parts as a JSON object."""
        return {
            "format": self.format,
            "node": self.node,
            "version": self.version,
            "code": {"modules": dict(self.code.modules), "packages": list(self.code.packages)},
            "params": dict(self.params),
            "inputs": dict(self.inputs),
            "entropy": None if self.entropy is None else list(self.entropy),
            "environment": dict(self.environment),
        }

    @classmethod
    def from_json(cls, obj: Mapping[str, Any]) -> Self:
        """Return the parts of `to_json`; LookupError or TypeError for anything else."""
        code = CodeDigest.of(obj["code"]["modules"], obj["code"]["packages"])
        entropy = None if obj["entropy"] is None else tuple(obj["entropy"])
        return cls(**{**obj, "code": code, "entropy": entropy})


@cache
def environment(packages: tuple[str, ...] = ()) -> Mapping[str, str]:
    """Return the versions that results may depend on: numerical libraries, other packages, Python, the architecture.

    Python counts by its minor version: syntax trees, and so code digests, differ between these anyway.

    Parameters
    ----------
    packages
        Top-level import names besides `LIBRARIES`, see `CodeDigest.packages`. One without a version (a loose folder)
        counts as "unknown".
    """
    versions = {"python": f"{sys.version_info.major}.{sys.version_info.minor}", "machine": platform.machine()}
    for name in LIBRARIES:
        found = _version(name)
        if found is not None:
            versions[name] = found
    for name in packages:
        for distribution in _distributions(name):
            versions.setdefault(distribution, _version(distribution) or "unknown")
    return versions


@cache
def _version(distribution: str) -> str | None:
    from importlib import metadata

    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return None


@cache
def _distributions(package: str) -> tuple[str, ...]:
    """Return the distributions that an import name comes from; the name itself if there are none."""
    if package in _IMPORT_NAMES:
        return (_IMPORT_NAMES[package],)
    if _version(package) is not None:
        return (package,)
    return tuple(sorted(_all_distributions().get(package, ()))) or (package,)


_IMPORT_NAMES = {"skimage": "scikit-image", "PIL": "pillow", "yaml": "PyYAML", "maxflow": "PyMaxflow"}


@cache
def _all_distributions() -> Mapping[str, list[str]]:
    from importlib import metadata

    return metadata.packages_distributions()  # reads every package's list of files: a fifth of a second


@dataclass(frozen=True)
class Change:
    """One thing that differs between two keys; of code, inputs and files both values are `PRESENT`."""

    what: str
    old: str
    new: str

    def __str__(self) -> str:
        if self.old == self.new == PRESENT:
            return f"{self.what} has changed"
        return f"{self.what}: {self.old} -> {self.new}"


def explain(old: KeyParts, new: KeyParts) -> list[Change]:
    """Return what differs between two keys of a node, in the order code, parameters, inputs, seed, environment.

    Empty if and only if the keys are equal. Of another node nothing else is told: all the rest is another's.

    Examples
    --------
    >>> old = KeyParts(1, "Blur", 1, CodeDigest.of({}), {"window": 16}, {}, None, {})
    >>> new = KeyParts(1, "Blur", 2, CodeDigest.of({}), {"window": 32}, {}, None, {})
    >>> [str(change) for change in explain(old, new)]
    ['version of Blur: 1 -> 2', 'parameter window: 16 -> 32']
    """
    if old.node != new.node:
        return [Change("node", old.node, new.node)]
    pairs = [
        ("format of graphtex", old.format, new.format),
        (f"version of {new.node}", old.version, new.version),
        *_pairs("code of ", old.code.modules, new.code.modules, short=True),
        *_nested("parameter ", old.params, new.params),
        *_pairs("input ", old.inputs, new.inputs, short=True),
        ("random stream (seed)", old.entropy, new.entropy),
        *_pairs("", old.environment, new.environment),
    ]
    return [Change(what, _show(a), _show(b)) for what, a, b in pairs if _differ(a, b)]


class _Digest(str):
    """Not shown: its digits tell nobody anything."""


class _Absent:
    """Stands for a parameter, input or module that one of the two keys has not."""


_Pair = tuple[str, Any, Any]


def _pairs(prefix: str, old: Mapping[str, Any], new: Mapping[str, Any], *, short: bool = False) -> Iterator[_Pair]:
    for name in [*new, *(name for name in old if name not in new)]:
        a, b = old.get(name, _Absent), new.get(name, _Absent)
        if short and isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
            yield from (
                (f"{prefix}{name}[{i}]", _Digest(x), _Digest(y)) for i, (x, y) in enumerate(zip(a, b, strict=True))
            )
        else:
            yield f"{prefix}{name}", _brief(a) if short else a, _brief(b) if short else b


def _brief(value: Any) -> Any:
    return _Digest(value) if isinstance(value, str) else value


def _nested(prefix: str, old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[_Pair]:
    for name, a, b in _pairs(prefix, old, new):
        if isinstance(a, dict) and isinstance(b, dict):
            yield from _nested(f"{name}.", a, b)
        elif _is_digest(a) and _is_digest(b):  # of a file
            yield f"content of {name}", _Digest(a), _Digest(b)
        else:
            yield name, a, b


def _is_digest(value: Any) -> bool:
    return isinstance(value, str) and re.fullmatch("[0-9a-f]{64}", value) is not None


def _differ(a: Any, b: Any) -> bool:
    if a is _Absent or b is _Absent:
        return a is not b
    return canonical_json(a) != canonical_json(b)  # not a != b: NaN equals itself here, and 1 differs from 1.0 and True


def _show(value: Any) -> str:
    if value is _Absent:
        return ABSENT
    if isinstance(value, _Digest):
        return PRESENT
    if isinstance(value, list) and value and all(map(_is_digest, value)):
        return f"{len(value)} values"
    text = value if isinstance(value, str) else canonical_json(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
