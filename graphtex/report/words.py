"""Small pieces of HTML and wording that all parts of the report use."""

from collections import Counter
from collections.abc import Iterable
from typing import Any

from graphtex.show.style import escape

ORDER = ("failed", "skipped", "waiting", "ran", "cached")  # the most telling first
WORDS = {"ran": "ran", "cached": "cached", "failed": "failed", "skipped": "skipped", "waiting": "not run"}


def chip(status: str, text: str = "") -> str:
    """Return a status as a coloured word."""
    return f'<span class="chip {status}">{escape(text or WORDS[status])}</span>'


def tally(statuses: Iterable[str]) -> str:
    """Return such as ``1 failed, 7 ran``.

    >>> tally(["ran", "failed", "ran"])
    '1 failed, 2 ran'
    """
    counts = Counter(statuses)
    return ", ".join(f"{counts[status]} {WORDS[status]}" for status in ORDER if counts[status])


def worst(statuses: Iterable[str]) -> str:
    """Return the status that matters most."""
    return min(statuses, key=ORDER.index, default="waiting")


def duration(seconds: float) -> str:
    """Return a time for people.

    >>> duration(0.0123), duration(3.21), duration(125.3)
    ('12 ms', '3.21 s', '2 min 5 s')
    """
    if seconds < 0.9995:
        return f"{1000 * seconds:.0f} ms" if seconds >= 0.001 else "under 1 ms"
    if seconds < 99.995:
        return f"{seconds:.3g} s"
    return f"{int(seconds) // 60} min {int(seconds) % 60} s"


def plural(count: int, word: str) -> str:
    """Return such as ``1 task`` or ``3 tasks``."""
    return f"{count} {word}{'' if count == 1 else 's'}"


def code(value: Any, limit: int = 600) -> str:
    """Return a text as code; a long one can be folded out."""
    text = str(value)
    if len(text) <= limit:
        return f"<code>{escape(text)}</code>"
    return (
        f"<details><summary><code>{escape(text[:80])}…</code> ({len(text)} characters)</summary>"
        f"<code>{escape(text)}</code></details>"
    )


def folded(items: list[str], shown: int, what: str) -> str:
    """Return items side by side; all but the first few can be folded out."""
    if len(items) <= shown + 1:
        return ", ".join(items)
    rest = f"<details><summary>{len(items) - shown} more {what}</summary>{', '.join(items[shown:])}</details>"
    return ", ".join(items[:shown]) + rest
