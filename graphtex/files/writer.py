"""From a graph to the text of its file: one canonical form, so that equal graphs give equal bytes.

A value is written on one line in flow style where that fits in `WIDTH` columns, and as an indented block where not.
Text is left unquoted only where every YAML reader, 1.1 or 1.2, takes it for text.
"""

import math
import re
from collections.abc import Mapping, Set
from typing import Any

from graphtex.document import FORMAT, REQUIRED, Document, Entry, Input, Output
from graphtex.errors import GraphError, Problem
from graphtex.files.reader import read
from graphtex.files.scalars import MAX_DIGITS
from graphtex.files.yamltree import MAX_DEPTH, MAX_KEY
from graphtex.node import RESERVED
from graphtex.parameters import shorten

WIDTH = 120
_WORDS = frozenset({"null", "true", "false", "yes", "no", "on", "off", "y", "n"})  # no text in YAML 1.1 or 1.2
_FLOW_MARKS = re.compile(r"[,?\[\]{}]")
_ESCAPES = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}


def dumps(graph: Document) -> str:
    """Return a graph as the text of a graph file; `graphtex.files.read` gives the same graph back.

    Raises
    ------
    GraphError
        If the graph holds what no file can: other objects than plain data, keys that are no text, reserved words
        as arguments, characters or nesting that a reader would refuse.
    """
    text = _render(graph)
    again, problems = read(text)
    if again is None or problems:
        raise GraphError(Problem("", 0, 0, p.path, f"cannot be written: {p.message}") for p in problems)
    return text


def _render(graph: Document) -> str:
    head: dict[str, Any] = {"graphtex": FORMAT, "title": graph.title, "source": graph.source}
    head |= {"description": graph.description, "seed": graph.seed}
    document = {key: value for key, value in head.items() if value != "" and (key, value) != ("seed", 0)}
    if graph.inputs:
        document["inputs"] = {name: _input(kind) for name, kind in graph.inputs.items()}
    document["nodes"] = {name: _entry(name, entry) for name, entry in graph.nodes.items()}
    if graph.outputs:
        document["outputs"] = {name: _output(name, output) for name, output in graph.outputs.items()}
    lines: list[str] = []
    for key, value in document.items():
        _require_plain(value, (key,))
        if key in ("inputs", "nodes", "outputs") and value:  # always one line or more for each name
            lines.append(f"{key}:")
            lines += _block_mapping(value, 2)
        else:
            lines += _block_mapping({key: value}, 0)
    return "\n".join(lines) + "\n"


def _input(kind: Input) -> dict[str, Any]:
    written: dict[str, Any] = {"type": kind.type}
    if kind.default is not REQUIRED:
        written["default"] = kind.default
    written |= {key: value for key, value in (("min", kind.min), ("max", kind.max)) if value is not None}
    if kind.choices is not None:
        written["choices"] = list(kind.choices)
    written |= {"open": dict(kind.open)} if kind.open else {}
    return written | ({"description": kind.description} if kind.description else {})


def _entry(name: str, entry: Entry) -> dict[str, Any]:
    written: dict[str, Any] = {"node": entry.node} if entry.node else {}
    written |= {"graph": entry.graph} if entry.graph else {}
    end: dict[str, Any] = {"each": dict(entry.each)} if entry.each else {}
    end |= {"seed": entry.seed} if entry.seed is not None else {}
    end |= {"on_error": entry.on_error} if entry.on_error != "stop" else {}
    return _joined(("nodes", name), written, entry.arguments, RESERVED) | end


def _output(name: str, output: Output) -> Any:
    if output.file is None and not output.options:
        return output.source
    written = {"from": output.source} | ({} if output.file is None else {"file": output.file})
    return _joined(("outputs", name), written, output.options, {"from", "file"})


def _joined(
    path: tuple[str, str], written: dict[str, Any], own: Mapping[str, Any], reserved: Set[str]
) -> dict[str, Any]:
    taken = sorted(reserved & set(own))
    if taken:
        raise GraphError([Problem("", 0, 0, ".".join(path), f"{taken[0]!r} is a reserved word and no argument's name")])
    return written | dict(own)


def _require_plain(value: Any, path: tuple[Any, ...]) -> None:
    """Raise GraphError at the first part of a value that YAML would not keep as it is."""
    fault = ""
    if len(path) >= MAX_DEPTH:
        fault, path = f"nested deeper than {MAX_DEPTH} levels", path[:5]
    elif isinstance(value, Mapping):
        for key, item in value.items():
            if not isinstance(key, str) or len(key) > MAX_KEY:
                wanted = f"a key is text of at most {MAX_KEY} characters"
                raise GraphError([Problem("", 0, 0, _shown(path), f"{wanted}, got {shorten(key)}")])
            _require_plain(item, (*path, key))
    elif isinstance(value, list | tuple):
        for index, item in enumerate(value):
            _require_plain(item, (*path, index))
    elif isinstance(value, int) and abs(value) >= 10**MAX_DIGITS:
        fault = f"a number of more than {MAX_DIGITS} digits"
    elif value is not None and type(value) not in (str, bool, int, float):
        fault = f"no plain data: {type(value).__name__} cannot be written in a graph file"
    if fault:
        raise GraphError([Problem("", 0, 0, _shown(path), fault)])


def _shown(path: tuple[Any, ...]) -> str:
    return ".".join(str(part) for part in path)


def _block_mapping(value: Mapping[str, Any], indent: int) -> list[str]:
    lines = []
    for key, item in value.items():
        start = f"{' ' * indent}{_scalar(key, flow=False)}:"
        lines += _after(start, item, indent)
    return lines


def _after(start: str, value: Any, indent: int) -> list[str]:
    """Return the lines of a value that follows `start`, which ends in ``:``."""
    if isinstance(value, str) and _fits_literal_block(value):
        head = "|" if value.endswith("\n") else "|-"
        body = value.removesuffix("\n").split("\n")
        return [f"{start} {head}", *(f"{' ' * (indent + 2)}{line}" if line else "" for line in body)]
    if not isinstance(value, Mapping | list | tuple) or not value:
        return [f"{start} {_scalar(value, flow=False)}"]
    flow = f"{start} {_flow(value)}"
    if len(flow) <= WIDTH:
        return [flow]
    return [start, *_block(value, indent + 2)]


def _block(value: Any, indent: int) -> list[str]:
    if isinstance(value, Mapping):
        return _block_mapping(value, indent)
    lines = []
    for item in value:
        start = " " * indent
        flow = f"{start}- {_flow(item)}"
        if len(flow) <= WIDTH or not isinstance(item, Mapping | list | tuple) or not item:
            lines.append(flow)
        else:
            first, *rest = _block(item, indent + 2)
            lines += [f"{start}- {first[indent + 2 :]}", *rest]
    return lines


def _flow(value: Any) -> str:
    if isinstance(value, Mapping) and value:
        return "{" + ", ".join(f"{_scalar(key, flow=True)}: {_flow(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple) and value:
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    return _scalar(value, flow=True)


def _scalar(value: Any, *, flow: bool) -> str:
    if isinstance(value, str):
        return value if _is_plain_text(value, flow) else _quoted(value)
    if isinstance(value, float):
        return _float(value)
    if isinstance(value, Mapping):
        return "{}"
    if isinstance(value, list | tuple):
        return "[]"
    return "null" if value is None else str(value).lower()  # true, false, or an integer


def _float(value: float) -> str:
    if math.isnan(value):
        return ".nan"
    if math.isinf(value):
        return ".inf" if value > 0 else "-.inf"
    text = repr(value)
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}.0e{exponent}" if e and "." not in mantissa else text  # YAML 1.1 needs the dot


def _is_plain_text(text: str, flow: bool) -> bool:
    if not text or not (text[0].isalpha() or text[0] in "_$/") or text[-1] == " " or text.lower() in _WORDS:
        return False
    if not text.isprintable() or ":" in text or "#" in text:
        return False
    return not (flow and _FLOW_MARKS.search(text))


def _fits_literal_block(text: str) -> bool:
    """Return whether these are lines that a literal block keeps as they are, without indicators."""
    body = text.removesuffix("\n")
    if "\n" not in text or not body or body[0] in " \n" or body[-1] == "\n":
        return False
    return body.replace("\n", "").isprintable()


def _quoted(text: str) -> str:
    return '"' + "".join(_escaped(letter) for letter in text) + '"'


def _escaped(letter: str) -> str:
    if letter in _ESCAPES:
        return _ESCAPES[letter]
    if letter.isprintable():
        return letter
    code = ord(letter)
    return f"\\x{code:02x}" if code < 256 else f"\\u{code:04x}" if code < 65536 else f"\\U{code:08x}"
