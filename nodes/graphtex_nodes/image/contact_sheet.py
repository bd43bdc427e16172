"""Several pictures on one sheet."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import Gap, Image, node

Level = Annotated[float, Field(ge=0, le=1)]
Words = list[str | float]
Labels = Annotated[Words | None, Field(description="a line of text or a number below each picture")]
Padding = Annotated[int, Field(ge=0, le=1000, description="pixels around each picture")]
Background = Annotated[tuple[Level, Level, Level], Field(description="red, green and blue, 0 to 1")]
FontSize = Annotated[
    int | None, Field(ge=6, le=200, description="height of the text in pixels; default: by the widest picture")
]
Align = Annotated[Literal["centre", "top-left"], Field(description="where a picture smaller than its place sits")]

_BEYOND_ASCII = "«»‘’“”±·"  # what Pillow's own font draws beside ASCII
_TEXT = 14  # height of text under small pictures
_GAP_SIDE = 96  # a gap with no picture to take its size from


@node
def contact_sheet(
    images: list[Image | Gap],
    *,
    columns: Annotated[int | None, Field(ge=1, description="pictures in a row; default: about square")] = None,
    labels: Labels = None,
    column_labels: Annotated[Words | None, Field(description="a heading above each column")] = None,
    row_labels: Annotated[Words | None, Field(description="a heading left of each row")] = None,
    padding: Padding = 8,
    background: Background = (1.0, 1.0, 1.0),
    align: Align = "centre",
    font_size: FontSize = None,
) -> Image:
    """Lay pictures of any sizes and channel counts out in rows, in order; pixels are copied, never resampled.

    A column is as wide as its widest picture, a row as high as its highest. Grey becomes RGB, alpha is laid over the
    background, of more than 4 channels the first three are shown, and values are clipped to [0, 1]. Text is dark or
    light, whichever stands out from the background; what does not fit is cut off with an ellipsis. The font has the
    characters of ASCII: accents are left off, others become a question mark.

    Parameters
    ----------
    images
        A `Gap` (a cell of an ``each:`` that failed) is drawn as a hatched field with its label and reason.
    labels
        One for each picture, empty ones included. Without it gaps alone are labelled.

    Returns
    -------
    Image
        RGB.

    Raises
    ------
    ValueError
        Without any picture, or if a list of labels has another length than what it labels.

    Examples
    --------
    >>> one, two = np.zeros((2, 3, 1), np.float32), np.zeros((4, 5, 3), np.float32)
    >>> contact_sheet([one, two], columns=2, padding=1).shape  # 1 + 3 + 1 + 5 + 1 wide, 1 + 4 + 1 high
    (6, 11, 3)
    """
    if not images:
        raise ValueError("images: expected at least one, got an empty list")
    columns = min(columns or int(np.ceil(np.sqrt(len(images)))), len(images))
    rows = -(-len(images) // columns)
    for name, given, count in (
        ("labels", labels, len(images)),
        ("column_labels", column_labels, columns),
        ("row_labels", row_labels, rows),
    ):
        if given is not None and len(given) != count:
            raise ValueError(f"{name}: expected {count}, got {len(given)}")
    widest = max((image.shape[1] for image in images if not isinstance(image, Gap)), default=0)
    style = Style(padding, background, align, font_size or min(max(_TEXT, widest // 40), 200))
    return lay_out(images, columns, _texts(labels), _texts(column_labels), _texts(row_labels), style)


def _texts(labels: Words | None) -> list[str]:
    """Labels as they are written; the values of a sweep are numbers."""
    return [label if isinstance(label, str) else f"{label:g}" for label in labels or ()]


@dataclass(frozen=True)
class Style:
    """How a sheet looks."""

    padding: int
    background: tuple[float, float, float]
    align: str
    font_size: int

    @property
    def ink(self) -> tuple[int, int, int]:
        """Black or white, whichever differs more from the background."""
        light = float(np.dot(self.background, (0.2126, 0.7152, 0.0722))) > 0.5
        return (20, 20, 20) if light else (235, 235, 235)


def lay_out(
    images: Sequence[NDArray[Any] | Gap],
    columns: int,
    labels: Sequence[str],
    column_labels: Sequence[str],
    row_labels: Sequence[str],
    style: Style,
) -> NDArray[np.float32]:
    """Place the pictures as a table and write the labels; see `contact_sheet`."""
    widths, heights = _table_sizes(images, columns)
    pad, line = style.padding, style.font_size + style.font_size // 2
    below = line if labels else 0
    left = pad + (_widest(row_labels, style) + pad if row_labels else 0)
    top = pad + (line if column_labels else 0)
    x_of = left + np.concatenate([[0], np.cumsum(np.array(widths) + pad)])
    y_of = top + np.concatenate([[0], np.cumsum(np.array(heights) + pad + below)])
    sheet = np.empty((int(y_of[-1]), int(x_of[-1]), 3), np.float32)
    sheet[:] = style.background
    for i, image in enumerate(images):
        row, column = divmod(i, columns)
        place = (int(x_of[column]), int(y_of[row]), widths[column], heights[row])
        picture = _draw_gap(image, place[2:], style) if isinstance(image, Gap) else flatten(image, style.background)
        x, y = place[:2]
        if style.align == "centre":
            x += (place[2] - picture.shape[1]) // 2
            y += (place[3] - picture.shape[0]) // 2
        sheet[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
        if labels:
            _write(sheet, labels[i], (place[0], place[1] + place[3], place[2], below), style)
    for column, text in enumerate(column_labels):
        _write(sheet, text, (int(x_of[column]), pad, widths[column], line), style)
    for row, text in enumerate(row_labels):
        _write(sheet, text, (pad, int(y_of[row]), left - 2 * pad, heights[row]), style)
    return sheet


def flatten(image: NDArray[Any], background: tuple[float, float, float]) -> NDArray[np.float32]:
    """RGB in [0, 1] of an Image of any number of channels."""
    clipped = np.clip(image, 0, 1)
    channels = clipped.shape[2]
    colour: NDArray[np.float32] = clipped[..., [0, 0, 0]] if channels <= 2 else clipped[..., :3]
    if channels not in (2, 4):
        return colour
    cover = clipped[..., -1:]
    laid: NDArray[np.float32] = colour * cover + np.array(background, np.float32) * (1 - cover)
    return laid


def _table_sizes(images: Sequence[NDArray[Any] | Gap], columns: int) -> tuple[list[int], list[int]]:
    """Width of each column and height of each row; a gap fits in, or has the size of the largest picture."""
    shapes = [None if isinstance(image, Gap) else image.shape[:2] for image in images]
    known = [shape for shape in shapes if shape is not None]
    fallback = (max((h for h, _ in known), default=_GAP_SIDE), max((w for _, w in known), default=_GAP_SIDE))
    rows = -(-len(images) // columns)
    widths = [max((s[1] for s in shapes[i::columns] if s), default=fallback[1]) for i in range(columns)]
    heights = [
        max((s[0] for s in shapes[i * columns : (i + 1) * columns] if s), default=fallback[0]) for i in range(rows)
    ]
    return widths, heights


def _font(size: int) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size)


def _widest(texts: Sequence[str], style: Style) -> int:
    font = _font(style.font_size)
    return int(np.ceil(max(font.getlength(_one_line(text)) for text in texts)))


def _one_line(text: str) -> str:
    """Fold a text to the characters that the font has: no line breaks, no accents, "?" for all further ones."""
    import unicodedata

    folded = "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))
    return " ".join("".join(c if c.isascii() or c in _BEYOND_ASCII else "?" for c in folded).split())


def _shorten(text: str, width: int, font: Any) -> str:
    """Cut a line off with an ellipsis so that it is at most `width` pixels long; empty if not even that fits."""
    if font.getlength(text) <= width:
        return text
    kept = len(text)
    while kept and font.getlength(text[:kept].rstrip() + "…") > width:
        kept -= 1
    return text[:kept].rstrip() + "…" if kept or font.getlength("…") <= width else ""


def _write(sheet: NDArray[np.float32], text: str, box: tuple[int, int, int, int], style: Style) -> None:
    """Write one line in the middle of a box (x, y, width, height)."""
    x, y, width, height = box
    if width < 1 or height < 1 or not _one_line(text):
        return
    font = _font(style.font_size)
    shade = _paint_text([_shorten(_one_line(text), width, font)], (width, height), font, style.font_size)
    part = sheet[y : y + height, x : x + width]
    shade = shade[: part.shape[0], : part.shape[1], None]
    part[:] = part * (1 - shade) + np.array(style.ink, np.float32) / 255 * shade


def _paint_text(lines: Sequence[str], size: tuple[int, int], font: Any, font_size: int) -> NDArray[np.float32]:
    """Cover (height, width) in [0, 1] of lines of text in the middle of a field."""
    from PIL import Image as Pictures
    from PIL import ImageDraw

    picture = Pictures.new("L", size)
    draw = ImageDraw.Draw(picture)
    step = font_size + font_size // 4
    first = size[1] / 2 - step * (len(lines) - 1) / 2
    for i, line in enumerate(lines):
        draw.text((size[0] / 2, round(first + i * step)), line, fill=255, font=font, anchor="mm")
    return np.asarray(picture, np.float32) / np.float32(255)


def _draw_gap(gap: Gap, size: tuple[int, int], style: Style) -> NDArray[np.float32]:
    """Draw a hatched field with the gap's label, and below it as much of the reason as there is room for."""
    width, height = size
    ground = np.array(style.background, np.float32)
    ink = np.array(style.ink, np.float32) / 255
    rows, columns = np.mgrid[:height, :width]
    hatched = ((rows + columns) % 12 < 2) | (rows == 0) | (columns == 0) | (rows == height - 1) | (columns == width - 1)
    field = np.where(hatched[..., None], ground * 0.8 + ink * 0.2, ground * 0.95 + ink * 0.05).astype(np.float32)
    font = _font(style.font_size)
    room = max((height - 8) // (style.font_size + style.font_size // 4), 1)
    lines = [*_wrap(gap.label or "failed", width - 8, font), *_wrap(gap.reason, width - 8, font)]
    if len(lines) > room:
        lines = [*lines[: room - 1], _shorten(lines[room - 1] + " …", width - 8, font)]
    shade = _paint_text(lines, size, font, style.font_size)[..., None]
    halo = np.maximum.reduce([np.roll(shade, (dy, dx), (0, 1)) for dy in (-1, 0, 1) for dx in (-1, 0, 1)])
    drawn: NDArray[np.float32] = (field * (1 - halo) + ground * halo) * (1 - shade) + ink * shade
    return drawn


def _wrap(text: str, width: int, font: Any) -> list[str]:
    """Break a text into lines of at most `width` pixels, at spaces; longer words are cut off."""
    lines: list[str] = []
    for word in _one_line(text).split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and font.getlength(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(_shorten(word, width, font))
    return [line for line in lines if line]
