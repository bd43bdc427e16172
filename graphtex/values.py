"""Values that come into a graph: arrays as they are given, paths and names by way of nodes that open them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from graphtex.document import Input
from graphtex.handlers import Opener, find_opener, is_value_file, names_folder
from graphtex.inputs import check_scalar, expand_paths, is_list, split_type
from graphtex.parameters import files_of, validate, with_files
from graphtex.plan import Slot, Task, stream_words
from graphtex.references import is_scalar
from graphtex.sockets import ValueType, parse_type

Bound = Slot | tuple[Slot, ...]
NO_OPTIONS: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True)
class Scalar:
    """A value for parameters: plain data, and the folder that paths in it start from."""

    value: Any
    base: Path


@dataclass
class Values:
    """The tasks and given values of a plan that is being made.

    Attributes
    ----------
    seed
        The run's, for openers that draw random numbers.
    names
        What the items of a list are called: the stems of their files.
    """

    seed: int
    tasks: dict[str, Task] = field(default_factory=dict)
    given: dict[Slot, tuple[ValueType, Any]] = field(default_factory=dict)
    names: dict[str, tuple[str, ...]] = field(default_factory=dict)
    _opened: dict[tuple[str, str], Slot] = field(default_factory=dict)

    def bind(self, task: str, kind: Input, value: Any, base: Path) -> Bound | Scalar:
        """Return what an input with this value is bound to; `task` is the id of what must be opened for it."""
        if is_scalar(kind):
            return scalar(kind, value, base)
        wanted = parse_type(kind.type)
        if not wanted.many:
            return self.open(task, wanted, value, base, kind.open)
        items = expand_paths(value, kind, base)
        one = ValueType(wanted.base)
        slots = tuple(self.open(f"{task}[{i}]", one, item, base, kind.open) for i, item in enumerate(items))
        self.names[task] = tuple(
            Path(find_opener(wanted.base, str(item))[1]).stem if isinstance(item, str | Path) else str(index)
            for index, item in enumerate(items)
        )
        return slots

    def open(self, task: str, kind: ValueType, value: Any, base: Path, options: Mapping[str, Any] = NO_OPTIONS) -> Slot:
        """Return the slot of a given value, or of the node that opens a path or name; ValueError if nothing does.

        The options are parameters of what opens files; those that it does not have, and a name's opener, are spared.
        """
        if not isinstance(value, str | Path):
            slot = Slot(task, "value")
            try:
                self.given[slot] = (kind, kind.check(value, task))
            except ValueError as error:
                raise ValueError(str(error).removeprefix(f"{task}: ")) from None
            return slot
        opener, text = self._opener(kind, str(value), base)
        if opener.suffixes:
            file = absolute(base, Path(text))
            require_file(file)
            text = str(file)
        chosen = {key: value for key, value in options.items() if opener.suffixes and key in opener.options}
        parameters, faults = validate(opener.node.parameters, {**chosen, opener.parameter: text})
        if parameters is None:
            raise ValueError(faults[0][1])
        call = opener.node.name, parameters.model_dump_json()
        if call in self._opened:
            return self._opened[call]
        # what is opened counts for the random stream, not which of several inputs came first
        words = stream_words(f"{opener.node.name}:{text}")
        plain, files = with_files(parameters, str), tuple(files_of(parameters))
        self.tasks[task] = Task(task, opener.node, {}, plain, files, seed=self.seed, spawn_key=words)
        slot = Slot(task, next(iter(opener.node.outputs)))
        return self._opened.setdefault(call, slot)

    def _opener(self, kind: ValueType, text: str, base: Path) -> tuple[Opener, str]:
        try:
            return find_opener(kind.base, text)
        except ValueError:
            if text and absolute(base, Path(text)).is_dir():
                raise ValueError(f"{text!r} is a folder; {kind.base.name} is opened from one file") from None
            raise

    def openers(self) -> set[str]:
        """Return the tasks that open a path or name."""
        return {slot.task for slot in self._opened.values()}


def scalar(kind: Input, value: Any, base: Path) -> Scalar:
    """Return the value of an input for parameters, files absolute; ValueError if the input does not admit it."""
    inner = split_type(kind.type)[0]
    if inner == "file":
        if is_list(kind) and isinstance(value, str | Path):
            value = expand_paths(value, kind, base)
        checked = check_scalar(kind, value)
        many = isinstance(checked, list)
        paths = [str(absolute(base, Path(path))) for path in (checked if many else [checked])]
        return Scalar(paths if many else paths[0], base)
    return Scalar(check_scalar(kind, value), base)


def require_file(file: Path) -> None:
    """Raise ValueError if there is no such file, or none that may be read."""
    try:
        if names_folder(file) and is_value_file(file):
            if file.is_file():
                raise ValueError(f"{str(file)!r} is a file, not a folder")
            next(file.iterdir(), None)
            return
        if file.is_dir():
            raise ValueError(f"{str(file)!r} is a folder, not a file")
        if not file.is_file():
            raise ValueError(f"there is no file {str(file)!r}")
        with file.open("rb"):
            pass
    except OSError as error:
        raise ValueError(f"{str(file)!r} cannot be read: {error.strerror}") from None


def absolute(base: Path, path: Path) -> Path:
    """Return a path relative to `base` as an absolute one; the file need not exist."""
    return path if path.is_absolute() else (base / path).absolute()
