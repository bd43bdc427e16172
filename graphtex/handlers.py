"""What a pack registers for a socket type: its view (a picture), its writers (files) and its openers (nodes)."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from graphtex.errors import DeclarationError, did_you_mean, listing
from graphtex.node import Node, require_plain_function
from graphtex.parameters import parameters_model, shorten, validate
from graphtex.sockets import Gap, SocketType, ValueType, find_type

F = TypeVar("F", bound=Callable[..., Any])
View = Callable[[Any], NDArray[np.uint8]]
Like = Callable[[Sequence[Path], str | None], tuple[str, dict[str, Any]]]


@dataclass(frozen=True)
class Writer:
    """Writes values of one type to files of some suffixes; `check` refuses options that a suffix does not go with.

    With `folder` what it writes is a folder, in place of a file. What `like` says is told at `writer`.
    """

    type_name: str
    suffixes: tuple[str, ...]
    function: Callable[..., None]
    options: type[BaseModel]
    check: Callable[..., None] | None = None
    folder: bool = False
    like: Like | None = None

    def require(self, suffix: str, options: BaseModel) -> None:
        """Raise ValueError if files of a suffix cannot be written with these options, whatever the value."""
        if self.check is not None:
            self.check(suffix.lower(), **fields(options))


@dataclass(frozen=True)
class Opener:
    """A node with one text parameter that makes a value from a path or a ``scheme:name``.

    With `folder` its paths are those of folders, each of which is one value.
    """

    type_name: str
    node: Node[Any, Any]
    parameter: str
    suffixes: tuple[str, ...] = ()
    scheme: str = ""
    folder: bool = False

    @property
    def options(self) -> tuple[str, ...]:
        """Names of the parameters beside the path or the name."""
        return tuple(key for key in self.node.parameters.model_fields if key != self.parameter)


def fields(model: BaseModel) -> dict[str, Any]:
    """Return a model's values by name, models in it as they are."""
    return {key: getattr(model, key) for key in type(model).model_fields}


VIEWS: dict[str, View] = {}
WRITERS: dict[tuple[str, str], Writer] = {}
DEFAULT_SUFFIX: dict[str, str] = {}
OPENERS: list[Opener] = []


def _origin(function: Any) -> str:
    return f"{function.__module__}.{function.__qualname__}"


def _refuse_second(what: str, known: Any, new: Any) -> None:
    """Raise DeclarationError if something else is registered already; a module that is reloaded may come again."""
    if known is not None and _origin(known) != _origin(new):
        raise DeclarationError(f"{_origin(new)}: there is {what} already, {_origin(known)}")


def _checked_suffixes(suffixes: tuple[str, ...], owner: str) -> tuple[str, ...]:
    for suffix in suffixes:
        if not suffix.startswith(".") or len(suffix) < 2:
            raise DeclarationError(f"{owner}: a suffix begins with a dot, got {suffix!r}")
    return tuple(suffix.lower() for suffix in suffixes)


def _require_positional(function: Callable[..., Any], what: str, names: tuple[str, ...]) -> None:
    """Raise DeclarationError unless a function can be called with just these positional arguments."""
    positional = [p for p in inspect.signature(function).parameters.values() if p.kind is not p.KEYWORD_ONLY]
    if len(positional) != len(names) or any(p.kind is p.VAR_POSITIONAL or p.kind is p.VAR_KEYWORD for p in positional):
        raise DeclarationError(f"{function.__name__}: a {what} is written f({', '.join(names)})")


def _type_of(hint: Any, what: str) -> SocketType:
    kind = find_type(hint)
    if kind is None:
        raise DeclarationError(f"a {what} is for a socket type, got {hint}")
    return kind


def view(hint: Any) -> Callable[[F], F]:
    """Decorate ``f(value) -> uint8 (h, w, 3 or 4)``: the picture of a socket type for reports."""
    kind = _type_of(hint, "view")

    def register(function: F) -> F:
        require_plain_function(function, "view")
        _require_positional(function, "view", ("value",))
        _refuse_second(f"a view of {kind.name}", VIEWS.get(kind.name), function)
        VIEWS[kind.name] = function
        return function

    return register


def writer(
    hint: Any,
    *,
    suffixes: tuple[str, ...],
    default: str | None = None,
    check: Callable[..., None] | None = None,
    folder: bool = False,
    like: Like | None = None,
) -> Callable[[F], F]:
    """Decorate ``f(value, path, *, option=...)``: writes the type to files with these suffixes.

    Keyword-only arguments become keys of an output entry in a graph file. The caller passes a temporary path that
    ends in the right suffix and renames it; ValueError says what the format cannot hold. ``check(suffix, option=...)``
    says so of options alone: it is called when a graph is checked, before anything has run. With ``folder`` the path
    is that of a folder which the writer makes. ``like(files, suffix)`` gives the suffix and the options that keep what
    some files hold which were opened as the type: it is asked where a graph names no options, with the suffix that the
    graph names, if any.
    """
    kind = _type_of(hint, "writer")

    def register(function: F) -> F:
        name = require_plain_function(function, "writer")
        _require_positional(function, "writer", ("value", "path"))
        ends = _checked_suffixes(suffixes, name)
        if default is not None and default not in ends:
            raise DeclarationError(f"{name}: the default suffix is one of {', '.join(ends)}, got {default!r}")
        for suffix in ends:
            known = WRITERS.get((kind.name, suffix))
            _refuse_second(f"a writer of {kind.name} as {suffix}", known.function if known else None, function)
        keywords = [p for p in inspect.signature(function).parameters.values() if p.kind is p.KEYWORD_ONLY]
        options = parameters_model(name, keywords, get_type_hints(function, include_extras=True))
        entry = Writer(kind.name, ends, function, options, check, folder, like)
        WRITERS.update({(kind.name, suffix): entry for suffix in ends})
        if default is not None:
            DEFAULT_SUFFIX[kind.name] = default
        return function

    return register


def opener(
    hint: Any, *, suffixes: tuple[str, ...] = (), scheme: str = "", folder: bool = False
) -> Callable[[Node[Any, Any]], Node[Any, Any]]:
    """Decorate a node whose one required parameter is a path or a name: it opens such strings as the type.

    With ``folder`` the paths are those of folders with these suffixes: each is one value, and counts as a file wherever
    files are looked for.
    """
    kind = _type_of(hint, "opener")

    def register(made: Node[Any, Any]) -> Node[Any, Any]:
        if not isinstance(made, Node):
            raise DeclarationError("an opener is a node: put @opener above @node")
        required = [key for key, info in made.parameters.model_fields.items() if info.is_required()]
        first = next(iter(made.outputs.values()))
        if len(required) != 1 or any(not socket.optional for socket in made.inputs.values()):
            raise DeclarationError(f"{made.name}: an opener has one required parameter and no required socket")
        if first.type != ValueType(kind):
            raise DeclarationError(
                f"{made.name}: its first output is {first.type}, an opener of {kind.name} gives {kind.name}"
            )
        ends = _checked_suffixes(suffixes, made.name)
        if not ends and not scheme:
            raise DeclarationError(f"{made.name}: an opener is for some suffixes or for a scheme")
        others = [entry for entry in OPENERS if _origin(entry.node) != _origin(made)]
        for other in others:
            taken = ([f"{scheme}:"] if scheme and scheme == other.scheme else []) + [
                suffix for suffix in ends if suffix in other.suffixes
            ]
            if other.type_name == kind.name and taken:
                _refuse_second(f"an opener of {taken[0]} as {kind.name}", other.node, made)
        again = [
            e for e in OPENERS if e not in others and (e.type_name, e.scheme, e.suffixes) != (kind.name, scheme, ends)
        ]
        OPENERS[:] = [*others, *again, Opener(kind.name, made, required[0], ends, scheme, folder)]
        return made

    return register


def find_opener(kind: SocketType, text: str) -> tuple[Opener, str]:
    """Return the opener for a string and the text for its parameter; ValueError with what would fit."""
    if not text:
        raise ValueError(f"expected a path or scheme:name to open as {kind.name}, got an empty text")
    mine = [entry for entry in OPENERS if entry.type_name == kind.name]
    scheme, colon, rest = text.partition(":")
    if colon and len(scheme) > 1 and "/" not in scheme:  # one letter is a drive
        for entry in mine:
            if entry.scheme == scheme:
                return entry, rest
        known = [f"{entry.scheme}:" for entry in mine if entry.scheme]
        raise ValueError(
            f"nothing opens {scheme + ':'!r} as {kind.name}{did_you_mean(f'{scheme}:', known, label='schemes')}"
        )
    suffix = Path(text).suffix.lower()
    for entry in mine:
        if suffix in entry.suffixes:
            return entry, text
    suffixes = sorted(suffixes_of(kind))
    found = f"a file ending in {suffix!r}" if suffix else f"{text!r}, which has no file ending,"
    raise ValueError(f"nothing opens {found} as {kind.name}; known: {listing(suffixes, 20) or 'none'}")


def suffixes_of(kind: SocketType) -> frozenset[str]:
    """Return the suffixes of files that open as a type."""
    return frozenset(suffix for entry in OPENERS if entry.type_name == kind.name for suffix in entry.suffixes)


def opening_faults(kind: SocketType, options: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what is wrong with options for opening files as a type: the option and a message."""
    mine = [entry for entry in OPENERS if entry.type_name == kind.name and entry.suffixes]
    known = sorted({option for entry in mine for option in entry.options})
    faults = [
        (key, f"nothing that opens a file as {kind.name} has {key!r}{did_you_mean(key, known, label='options')}")
        for key in options.keys() - known
    ]
    for entry in mine:
        own = {key: value for key, value in options.items() if key in entry.options}
        faults += [
            (str(path[0]), text) for path, text in validate(entry.node.parameters, own, unknown=[entry.parameter])[1]
        ]
    return sorted(set(faults))


def is_value_file(path: Path) -> bool:
    """Return whether there is a file, or a folder that is opened as one value."""
    return path.is_file() or (names_folder(path) and path.is_dir())


def names_folder(path: Path) -> bool:
    """Return whether a path's suffix is that of folders which are opened as one value."""
    return any(entry.folder and path.suffix.lower() in entry.suffixes for entry in OPENERS)


def find_writer(kind: SocketType, suffix: str) -> Writer:
    """Return the writer of a type for a suffix; ValueError with the suffixes that would fit."""
    found = WRITERS.get((kind.name, suffix.lower()))
    if found is None:
        known = sorted(end for name, end in WRITERS if name == kind.name)
        raise ValueError(f"{kind.name} cannot be written as {suffix!r}{did_you_mean(suffix, known, label='formats')}")
    return found


def output_format(
    kind: SocketType, suffix: str | None, options: Mapping[str, Any], files: Sequence[Path]
) -> tuple[str, Mapping[str, Any]] | None:
    """Return the suffix and the options to write a type with, None if no file holds it.

    What a graph names stays; where it leaves something open the writer may follow the `files` of the same type that the
    value was made from.
    """
    chosen = suffix or DEFAULT_SUFFIX.get(kind.name)
    if chosen is None:
        return None
    like = find_writer(kind, chosen).like
    followed, more = like(files, suffix) if like and files else (chosen, {})
    return (chosen, options) if more.keys() & options.keys() else (followed, {**more, **options})


def opened_files(kind: SocketType, node: Node[Any, Any], files: Sequence[Path]) -> Sequence[Path]:
    """Return the files that a call of a node has opened as a type: none unless the node is an opener of it."""
    return files if any(entry.type_name == kind.name and entry.node.name == node.name for entry in OPENERS) else ()


def picture_of(kind: SocketType, value: Any) -> NDArray[np.uint8] | str:
    """Return the view of a value, or a text where the type has none."""
    if isinstance(value, Gap):
        return f"{value.label} failed: {value.reason}"
    if kind.name in VIEWS:
        return VIEWS[kind.name](value)
    if isinstance(value, np.ndarray):
        return f"{kind.name} {value.dtype} {value.shape}"
    return shorten(value, 400)
