"""Colours, text widths and escaping that the drawing and the pages share."""

import colorsys
import hashlib
import re
import unicodedata
from html import escape as _escape

TYPE_COLOURS = {  # on light ground, on dark ground
    "Image": ("#1769aa", "#6cb6ff"),
    "Mask": ("#6b4fbb", "#b9a5ff"),
    "ScaleMap": ("#b45309", "#f2a65a"),
    "AngleMap": ("#5f7161", "#a9c4ac"),
    "LabelMap": ("#2e7d32", "#7cc983"),
    "Points": ("#c2255c", "#ff8fb3"),
    "Displacement": ("#0b7a75", "#4fd1c5"),
    "SourceMap": ("#7a5230", "#d0a679"),
    "Elements": ("#9c36b5", "#e39af5"),
    "Texture": ("#66700f", "#c5cf5a"),
    "ViewStack": ("#3b4cca", "#94a3ff"),
    "Views": ("#0e7490", "#55c8e8"),
    "Directions": ("#a16207", "#e8c34a"),
    "Vector": ("#be4b2f", "#ff9a7d"),
    "Number": ("#c92a2a", "#ff8787"),
}
SCALAR_COLOURS = ("#7b8794", "#8a95a3")
STATUS_COLOURS = {
    "ran": ("#1769aa", "#6cb6ff"),
    "cached": ("#2e7d32", "#7cc983"),
    "failed": ("#c92a2a", "#ff8787"),
    "skipped": ("#a16207", "#e8c34a"),
    "waiting": ("#7b8794", "#8a95a3"),
}
SANS = "system-ui,-apple-system,'Segoe UI',Roboto,'Helvetica Neue',Arial,sans-serif"
MONO = "ui-monospace,SFMono-Regular,Menlo,Consolas,'DejaVu Sans Mono',monospace"

# Widths in em of the widest of the usual sans-serif fonts (those of DejaVu Sans and Verdana), rounded up.
_NARROW = frozenset("fijlrtI.,:;'|!()[]/\\ -`")
_WIDE = frozenset("mwMW%@")
_BOLD = 1.13
_MONO = 0.62
_UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")


def escape(text: object) -> str:
    """Return a text for XML and HTML, in elements and in quoted attributes; what XML forbids becomes U+FFFD.

    >>> escape('<a & "b">')
    '&lt;a &amp; &quot;b&quot;&gt;'
    """
    return _escape(_UNPRINTABLE.sub("\ufffd", str(text)), quote=True)


def colours_of(type_name: str, scalar: bool = False) -> tuple[str, str]:
    """Return a socket type's colours on light and on dark ground; a pack's own type always gets the same ones."""
    if scalar:
        return SCALAR_COLOURS
    if type_name in TYPE_COLOURS:
        return TYPE_COLOURS[type_name]
    hue = int.from_bytes(hashlib.sha256(type_name.encode()).digest()[:2], "big") / 65536
    return _hex(hue, 0.33, 0.65), _hex(hue, 0.72, 0.70)


def _hex(hue: float, lightness: float, saturation: float) -> str:
    return "#" + "".join(f"{round(255 * part):02x}" for part in colorsys.hls_to_rgb(hue, lightness, saturation))


def text_width(text: str, size: float, *, bold: bool = False, mono: bool = False) -> float:
    """Return a width in pixels that a text does not exceed in any usual font."""
    return size * sum(_em(letter, mono) for letter in text) * (_BOLD if bold and not mono else 1)


def _em(letter: str, mono: bool) -> float:
    if ord(letter) > 126:
        wide = unicodedata.east_asian_width(letter) in "WF" or ord(letter) > 0xFFFF
        return 1.25 if wide else _MONO if mono and letter in "…×" else 1.0
    if mono:
        return _MONO
    if letter in _NARROW:
        return 0.42
    if letter in _WIDE:
        return 1.0
    if letter in "=<>+~^#":
        return 0.84
    return 0.79 if letter.isupper() or letter == "&" else 0.65


def fitted(text: str, size: float, limit: float, *, bold: bool = False, mono: bool = False) -> str:
    """Return the text, cut with an ellipsis so that it is no wider than `limit` pixels."""
    if text_width(text, size, bold=bold, mono=mono) <= limit:
        return text
    while text and text_width(f"{text}…", size, bold=bold, mono=mono) > limit:
        text = text[:-1]
    return f"{text}…"
