"""What unquoted words mean: the core schema of YAML 1.2.2 (section 10.3.2).

``no``, ``on``, ``12:30``, ``0b1`` and ``2024-01-01`` are text, ``0777`` is 777, ``0o17`` and ``0x1F`` are integers,
``1e3`` is a float.
"""

import math
import re
from typing import Any

MAX_DIGITS = 250  # so that every whole number fits a float

_WORDS: dict[str, bool | None] = {"": None, "~": None}
_WORDS.update({form("null"): None for form in (str.lower, str.capitalize, str.upper)})
_WORDS.update({form("true"): True for form in (str.lower, str.capitalize, str.upper)})
_WORDS.update({form("false"): False for form in (str.lower, str.capitalize, str.upper)})
_INTEGERS = ((re.compile("[-+]?[0-9]+"), 10), (re.compile("0o[0-7]+"), 8), (re.compile("0x[0-9a-fA-F]+"), 16))
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_INFINITE = re.compile(r"[-+]?\.(inf|Inf|INF)")
_NAN = re.compile(r"\.(nan|NaN|NAN)")


def resolve(text: str) -> tuple[Any, str]:
    """Return what an unquoted scalar means by the core schema, and what is wrong with it or "".

    >>> resolve("0x1F"), resolve("on")
    ((31, ''), ('on', ''))
    """
    if text in _WORDS:
        return _WORDS[text], ""
    for pattern, base in _INTEGERS:
        if pattern.fullmatch(text):
            if len(text) > MAX_DIGITS:
                return 0, f"a number of {len(text)} digits; quote it if it is text"
            return int(text, base), ""
    if _FLOAT.fullmatch(text):
        value = float(text)
        if math.isinf(value):
            return 0.0, f"{text[:40]} is too large for a number; infinity is written .inf"
        return value, ""
    if _INFINITE.fullmatch(text):
        return -math.inf if text[0] == "-" else math.inf, ""
    return (math.nan, "") if _NAN.fullmatch(text) else (text, "")
