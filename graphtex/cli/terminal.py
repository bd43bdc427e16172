"""Printing: results to stdout, everything else to stderr; colour on terminals only."""

import json
import shutil
import sys
import textwrap
import traceback
from collections.abc import Iterable, Sequence
from contextvars import ContextVar
from typing import Any

from graphtex.errors import Problem

DONE, FAILED, WRONG, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses: done; a node or an output failed; the request is wrong; stopped by the user."""
debug: ContextVar[bool] = ContextVar("debug", default=False)  # whether errors show their tracebacks
GAP = 2
NARROW = 30  # a last column is not wrapped to less than this


def out(text: str = "") -> None:
    """Print a line of the result."""
    print(text)


def print_json(value: Any) -> None:
    """Print plain data as JSON."""
    out(json.dumps(value, ensure_ascii=False, indent=2))


def say(text: str, style: str = "") -> None:
    """Print a line for people to stderr; the style, in rich's words, counts on terminals only."""
    if style and sys.stderr.isatty():
        from rich.console import Console

        Console(stderr=True, soft_wrap=True, highlight=False).print(text, style=style, markup=False)
    else:
        print(text, file=sys.stderr)


def complain(problems: Iterable[Problem]) -> None:
    """Print each problem on its own line."""
    for problem in problems:
        say(str(problem), "red")


def trace(error: BaseException) -> None:
    """Print an error's traceback if that was asked for."""
    if debug.get():
        traceback.print_exception(error)


def table(rows: Sequence[Sequence[str]], indent: str = "") -> str:
    """Return rows as aligned columns; on a terminal the last column is wrapped to its width.

    >>> print(table([["mask", "runs"], ["s", "cached"]]))
    mask  runs
    s     cached
    """
    if not rows:
        return ""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]) - 1)]
    start = len(indent) + sum(widths) + GAP * len(widths)
    room = shutil.get_terminal_size().columns - start if sys.stdout.isatty() else 0
    lines = []
    for row in rows:
        head = indent + "".join(cell.ljust(width + GAP) for cell, width in zip(row, widths, strict=False))
        last = textwrap.wrap(row[-1], max(room, NARROW)) if room > 0 else [row[-1]]
        lines += [f"{head}{part}" if index == 0 else " " * start + part for index, part in enumerate(last or [""])]
    return "\n".join(line.rstrip() for line in lines)


def duration(seconds: float) -> str:
    """Return a time in words.

    >>> duration(0.004), duration(2.345), duration(75.4)
    ('4 ms', '2.3 s', '1 min 15 s')
    """
    if seconds < 0.1:
        return f"{seconds * 1000:.0f} ms"
    if round(seconds, 1) < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s"


def size(count: int) -> str:
    """Return a number of bytes in words.

    >>> size(512), size(3 << 20)
    ('512 bytes', '3.0 MiB')
    """
    if count < 1024:
        return f"{count} bytes"
    amount = float(count)
    for unit in ("KiB", "MiB", "GiB"):
        amount /= 1024
        if amount < 1024:
            return f"{amount:.1f} {unit}"
    return f"{amount / 1024:.1f} TiB"


def count(number: int, noun: str) -> str:
    """Return a number with its noun.

    >>> count(1, "node"), count(3, "node")
    ('1 node', '3 nodes')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
