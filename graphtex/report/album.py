"""Pictures on the page: views of values as PNG inside the HTML, within a budget of bytes."""

import base64
import io
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex.handlers import picture_of
from graphtex.report.words import code
from graphtex.show.scene import cut
from graphtex.show.style import escape
from graphtex.sockets import Gap, SocketType, ValueType

BUDGET = 24 << 20  # bytes of PNG on one page
MAX_ITEMS = 64  # items of a list that are shown
_REASON = 90  # characters of why a value is missing; its task tells it all
_TINY = 96  # smaller pictures are enlarged by a whole factor


@dataclass
class Album:
    """Makes figures until the budget is used up; then it says so in their place."""

    budget: int = BUDGET
    used: int = 0
    left_out: int = 0
    _numbers: "count[int]" = field(default_factory=lambda: count(1))

    def show(self, kind: ValueType, value: Any, caption: str, name: str, size: int) -> str:
        """Return a figure of a value, or a gallery of a list.

        Parameters
        ----------
        caption
            HTML below the picture.
        name
            What the picture is of, as plain text for those who cannot see it.
        size
            The longest side on the page, in pixels.
        """
        if not isinstance(value, list):
            return self.figure(kind.base, value, caption, name, size)
        items = value[:MAX_ITEMS]
        small = size_for(len(items), size)
        parts = [
            self.figure(kind.base, item, f"{caption} [{i}]", f"{name}, item {i}", small) for i, item in enumerate(items)
        ]
        if len(value) > len(items):
            parts.append(f'<p class="dim">{caption}: {len(value) - len(items)} of {len(value)} items are not shown</p>')
        return "".join(parts) or f'<p class="dim">{caption}: an empty list</p>'

    def figure(self, kind: SocketType, value: Any, caption: str, name: str, size: int) -> str:
        """Return one figure with its caption: a picture that grows on a click, a text, or why there is nothing."""
        if isinstance(value, Gap):
            return _figure(f'<div class="gap" role="img" aria-label="a gap">{escape(value.label)} failed</div>',
                           "<br>".join(filter(None, (caption, escape(cut(value.reason, _REASON))))))  # fmt: skip
        picture = _view(kind, value)
        if isinstance(picture, str):
            return _figure(f'<div class="told">{code(picture)}</div>', _with_type(caption, kind))
        inner, shown = self.picture(picture, name, size)
        array = isinstance(value, np.ndarray)
        told = [f"{value.dtype} {value.shape}" if array else ""]
        if not array or value.shape[:2] != picture.shape[:2]:  # else the array's shape says it
            told.append(f"view {picture.shape[1]} × {picture.shape[0]}")
        if shown not in (None, picture.shape[1::-1]):
            told.append("shown at {} × {}".format(*shown))
        details = escape(" · ".join(filter(None, told)))
        return _figure(inner, f'{_with_type(caption, kind)}<br><span class="dim">{details}</span>')

    def picture(self, picture: NDArray[np.uint8], name: str, size: int) -> tuple[str, tuple[int, int] | None]:
        """Return a picture as a link that enlarges it, and its width and height on the page; None if it is left out."""
        height, width = picture.shape[:2]
        data, shown = _png(picture, size)
        if self.used + len(data) > self.budget:
            self.left_out += 1
            return f'<div class="told dim">{width} × {height}, left out: the page is full</div>', None
        self.used += len(data)
        factor = max(1, _TINY // max(shown))
        style = ' class="tiny"' if factor > 1 else ""
        uri = base64.b64encode(data).decode("ascii")
        anchor = f"p{next(self._numbers)}"
        image = (
            f'<img{style} src="data:image/png;base64,{uri}" alt="{escape(name)}" loading="lazy" '
            f'width="{shown[0] * factor}" height="{shown[1] * factor}">'
        )
        zoom = f'<a class="zoom" id="{anchor}" href="#{anchor}" aria-label="Enlarge {escape(name)}">{image}</a>'
        return f'{zoom}<a class="close" href="#close" aria-label="Close">×</a>', shown


def size_for(number: int, size: int) -> int:
    """Return the longest side of pictures when there are so many of one kind."""
    for least, side in ((100, 72), (24, 128), (4, 256)):
        if number > least:
            return min(size, side)
    return size


def _figure(inner: str, caption: str) -> str:
    return f"<figure>{inner}<figcaption>{caption}</figcaption></figure>\n"


def _with_type(caption: str, kind: SocketType) -> str:
    return " · ".join(filter(None, (caption, escape(kind.name))))


def _view(kind: SocketType, value: Any) -> NDArray[np.uint8] | str:
    try:
        picture = picture_of(kind, value)
    except Exception as error:  # noqa: BLE001 (a pack's broken view must not cost the whole report)
        return f"the view of {kind.name} failed: {type(error).__name__}: {error}"
    if isinstance(picture, str):
        return picture
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] not in (3, 4) or picture.size == 0:
        return f"the view of {kind.name} gave {picture.dtype} {picture.shape}, no picture"
    return picture


def _png(picture: NDArray[np.uint8], size: int) -> tuple[bytes, tuple[int, int]]:
    """Return a picture as PNG, no longer than `size`, and its width and height."""
    from PIL import Image as Pictures

    image = Pictures.fromarray(np.ascontiguousarray(picture))
    image.thumbnail((size, size), Pictures.Resampling.LANCZOS)
    file = io.BytesIO()
    image.save(file, "PNG", compress_level=3)  # hardly larger than the smallest, in a tenth of the time
    return file.getvalue(), image.size
