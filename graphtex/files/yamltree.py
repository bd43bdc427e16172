"""Strict YAML 1.2: text becomes plain data, with the line and column of every key and value.

Beyond the standard, all that makes a file mean something else than it seems to is refused: duplicate keys, keys that
are no text, tags, anchors and aliases (and with them alias bombs), merge keys, several documents, control characters,
deep nesting.

Events are turned into data by an explicit stack, so no input can exhaust Python's.
"""

import re
from dataclasses import dataclass, field
from typing import Any

import yaml

from graphtex.document import Place
from graphtex.errors import Problem
from graphtex.files.scalars import resolve
from graphtex.files.syntax import explain

MAX_DEPTH = 50
MAX_KEY = 100  # characters; the writer's longest escape makes this fit YAML's limit of 1024 for a key
MAX_TEXT = 100_000  # characters of one scalar
MAX_SIZE = 1 << 20  # bytes of a file

BULK_HINT = "keep strokes and other bulky data in files of their own"
_ALIAS = "anchors and aliases are not part of a graph file; write the value again or make it a graph input"
_UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")
_LINE = re.compile("\r\n|\r|\n")
_SURROGATE = re.compile("[\ud800-\udfff]")
_MOST_UNPRINTABLE = 20  # reported of one text


@dataclass
class Tree:
    """Plain data with marks.

    Attributes
    ----------
    data
        Dicts with text as keys, lists, str, int, float, bool and None.
    places, key_places
        Line and column, from 1, of each value and of each key.
    problems
        What is wrong with the YAML itself.
    complete
        Whether the text was read to its end; if not, `data` is only the beginning.
    """

    data: Any = None
    places: dict[Place, tuple[int, int]] = field(default_factory=dict)
    key_places: dict[Place, tuple[int, int]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    complete: bool = False


def parse(text: str, file: str = "") -> Tree:
    """Read one YAML document; never raises for what the text holds.

    >>> parse("a: [no, 0o17, 1e3]").data
    {'a': ['no', 15, 1000.0]}
    """
    tree = Tree()
    text = text.removeprefix("\ufeff")  # the byte order mark that some editors write
    if len(text) > MAX_SIZE:
        tree.problems.append(Problem(file, 0, 0, "", f"longer than {MAX_SIZE} characters; {BULK_HINT}"))
        return tree
    tree.problems += _unprintable(text, file)
    if not tree.problems:
        builder = _Builder(tree, file)
        loader = yaml.SafeLoader(text)
        try:
            while not tree.complete and loader.check_event():
                builder.take(loader.get_event())
        except yaml.MarkedYAMLError as error:
            line, column, message = explain(error)
            builder.say(line, column, message)
        except (ValueError, OverflowError):  # PyYAML lets chr() raise for \U00110000
            mark = loader.get_mark()
            builder.say(mark.line + 1, mark.column + 1, "an escape that stands for no character")
        except _Stop:
            pass
        finally:
            loader.dispose()
            tree.places.setdefault((), (1, 1))
    return tree


def read_scalar(text: str) -> Any:
    """Return what a text means as a value of a graph file: ``3`` is a number, ``[a, b]`` a list; ValueError if nothing.

    >>> read_scalar("1e3"), read_scalar("no"), read_scalar("[1, 2]")
    (1000.0, 'no', [1, 2])
    """
    tree = parse(text)
    if tree.problems:
        raise ValueError(tree.problems[0].message)
    return tree.data


def _unprintable(text: str, file: str) -> list[Problem]:
    """Find characters that no editor shows; some of them PyYAML would even count as line breaks."""
    problems: list[Problem] = []
    for number, line in enumerate(_LINE.split(text), 1):
        for match in _UNPRINTABLE.finditer(line):
            if len(problems) == _MOST_UNPRINTABLE:
                return problems
            code = ord(match.group())
            escape = f"\\x{code:02x}" if code < 256 else f"\\u{code:04x}"
            message = f"a control character, U+{code:04X}; in double quotes it can be written {escape}"
            if _SURROGATE.match(match.group()):
                message = f"half of a surrogate pair, U+{code:04X}, is no character"
            problems.append(Problem(file, number, match.start() + 1, "", message))
    return problems


class _Stop(Exception):
    """Reading on makes no sense."""


@dataclass
class _Frame:
    """A mapping or list that is being read."""

    value: dict[str, Any] | list[Any]
    path: Place
    kept: bool  # False below a key that is wrong or there twice
    is_key: bool = False
    key: str | None = None  # of the next value
    wants_key: bool = True


class _Builder:
    """Takes the parser's events and fills a tree."""

    def __init__(self, tree: Tree, file: str) -> None:
        self.tree = tree
        self.file = file
        self.stack: list[_Frame] = []
        self.documents = 0

    def say(self, line: int, column: int, message: str, path: Place = ()) -> None:
        shown = ".".join(str(part) for part in path)
        self.tree.problems.append(Problem(self.file, line, column, shown, message))

    def take(self, event: Any) -> None:
        """Handle one event; _Stop where the rest cannot be read."""
        place = (event.start_mark.line + 1, event.start_mark.column + 1)
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(event, place)
        elif isinstance(event, yaml.AliasEvent):
            self._slot(None, place, f"{_ALIAS} (*{event.anchor})")
        elif isinstance(event, yaml.MappingStartEvent):
            self._open({}, event, place)
        elif isinstance(event, yaml.SequenceStartEvent):
            self._open([], event, place)
        elif isinstance(event, yaml.CollectionEndEvent):
            frame = self.stack.pop()
            if frame.is_key:
                self.stack[-1].key, self.stack[-1].wants_key = None, False
        elif isinstance(event, yaml.DocumentStartEvent):
            self.documents += 1
            if self.documents > 1:
                self.say(*place, "a second document begins here; a file holds one")
                self.tree.complete = True
        elif isinstance(event, yaml.StreamEndEvent):
            self.tree.complete = True

    def _scalar(self, event: yaml.ScalarEvent, place: tuple[int, int]) -> None:
        value, fault = resolve(event.value) if event.style is None and event.tag is None else (event.value, "")
        if event.tag is not None or event.anchor is not None:
            fault = _decoration(event)
        elif len(event.value) > MAX_TEXT:
            fault = f"{len(event.value)} characters in one value, at most {MAX_TEXT} may be; {BULK_HINT}"
        elif isinstance(value, str) and _SURROGATE.search(value):
            fault = "half of a surrogate pair is no character; write \\U and eight hexadecimal digits"
        if self.stack and isinstance(self.stack[-1].value, dict) and self.stack[-1].wants_key:
            if event.value == "<<" and event.style is None:
                fault = "merge keys (<<) are not part of YAML 1.2; write the values out"
            self._key(value, place, fault)
        else:
            self._slot(value, place, fault)

    def _open(self, value: dict[str, Any] | list[Any], event: Any, place: tuple[int, int]) -> None:
        fault = _decoration(event) if event.tag is not None or event.anchor is not None else ""
        frame = self.stack[-1] if self.stack else None
        if frame and isinstance(frame.value, dict) and frame.wants_key:
            kind = "mapping" if isinstance(value, dict) else "list"
            hint = "; text with braces needs quotes" if kind == "mapping" else ""
            self.say(*place, f"a key is text, got a {kind}{hint}", frame.path)
            self.stack.append(_Frame(value, frame.path, kept=False, is_key=True))
        else:
            path, kept = self._slot(value, place, fault)
            self.stack.append(_Frame(value, path, kept))
        if len(self.stack) > MAX_DEPTH:
            self.say(*place, f"nested deeper than {MAX_DEPTH} levels", self.stack[-1].path[:5])
            raise _Stop

    def _key(self, key: Any, place: tuple[int, int], fault: str) -> None:
        frame = self.stack[-1]
        frame.key, frame.wants_key = None, False
        assert isinstance(frame.value, dict)
        if not fault and not isinstance(key, str):
            fault = f"a key is text, got {described(key)}" + ("" if key is None else "; quote it")
        elif not fault and len(key) > MAX_KEY:
            fault = f"a key has at most {MAX_KEY} characters, got {len(key)}"
        elif not fault and key in frame.value:
            line, column = self.tree.key_places.get((*frame.path, key), (0, 0))
            fault = f"the key {key!r} is there twice" + (f", first at {line}:{column}" if line and frame.kept else "")
        if fault:
            self.say(*place, fault, frame.path if not isinstance(key, str) else (*frame.path, key[:MAX_KEY]))
            return
        frame.key = key
        if frame.kept:
            self.tree.key_places[*frame.path, key] = place

    def _slot(self, value: Any, place: tuple[int, int], fault: str) -> tuple[Place, bool]:
        """Put a value where it belongs; return its path and whether it is part of the result."""
        path: Place = ()
        kept = True
        if not self.stack:
            self.tree.data = value
        else:
            frame = self.stack[-1]
            kept, path = frame.kept, frame.path
            if isinstance(frame.value, list):
                path = (*frame.path, len(frame.value))
                frame.value.append(value)
            elif frame.wants_key:  # an alias as a key
                frame.key, frame.wants_key, kept = None, False, False
            else:
                frame.wants_key = True
                if frame.key is None:
                    kept = False
                else:
                    path = (*frame.path, frame.key)
                    frame.value[frame.key] = value
        if kept:
            self.tree.places[path] = place
        if fault:
            self.say(*place, fault, path)
        return path, kept


def _decoration(event: Any) -> str:
    if event.tag is not None:
        shown = event.tag.replace("tag:yaml.org,2002:", "!!")
        return f"tags are not part of a graph file, got {shown}; quote text that begins with '!'"
    return f"{_ALIAS} (&{event.anchor})"


def described(value: Any) -> str:
    """Return how a message calls a value.

    >>> described(5), described("x"), described([1, 2])
    ('the number 5', "the text 'x'", 'a list of 2')
    """
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return f"the number {value!r:.40}"
    if isinstance(value, str):
        return f"the text {value!r}" if len(value) <= 60 else f"the text {value[:57]!r}..."
    if isinstance(value, list):
        return f"a list of {len(value)}"
    if isinstance(value, dict):
        return f"a mapping with {', '.join(list(value)[:3])}{', ...' if len(value) > 3 else ''}" if value else "{}"
    return type(value).__name__
