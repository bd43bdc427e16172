"""Reads numpydoc docstrings: summary, and what is said of each parameter and result."""

import inspect
import re
from itertools import pairwise


def summary(docstring: str | None) -> str:
    """Return the first paragraph as one line.

    >>> summary("Blur a picture.\\n\\nMore.")
    'Blur a picture.'
    """
    return " ".join((inspect.cleandoc(docstring) if docstring else "").split("\n\n")[0].split())


def section(docstring: str | None, name: str) -> dict[str, str]:
    """Return the entries of a numpydoc section: name to text; ``a, b`` gives the same text to both."""
    lines = inspect.cleandoc(docstring or "").splitlines()
    start = next((i for i, (line, rule) in enumerate(pairwise(lines))
                  if line.strip() == name and re.fullmatch(r"-{3,}", rule.strip())), None)  # fmt: skip
    entries: dict[str, str] = {}
    if start is None:
        return entries
    names: list[str] = []
    for index, line in enumerate(lines[start + 2 :], start + 2):
        if index + 1 < len(lines) and line.strip() and re.fullmatch(r"-{3,}", lines[index + 1].strip()):
            break
        if line and not line[0].isspace():
            names = [part.strip() for part in line.split(":")[0].split(",")]
            entries.update(dict.fromkeys(names, ""))
        elif line.strip():
            for key in names:
                entries[key] = f"{entries[key]} {line.strip()}".strip()
    return entries
