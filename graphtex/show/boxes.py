"""Sizes of boxes: where the texts and the ports of each stand inside it."""

from collections.abc import Mapping
from dataclasses import dataclass

from graphtex.show.scene import Box, Mark
from graphtex.show.style import fitted, text_width

TITLE, SMALL, CODE = 13.0, 11.0, 10.5  # font sizes in pixels
PAD = 12.0
ROW = 18.0  # a row of ports
LINE = 15.0  # a line of parameters
STACK = 9.0  # how far the shadow of a stack reaches to the right and below
MAX_WIDTH = 300.0


@dataclass(frozen=True)
class Text:
    """One text; `anchor` as in SVG, `x` and `y` (baseline) from the box's corner."""

    x: float
    y: float
    text: str
    style: str
    anchor: str = "start"


@dataclass(frozen=True)
class Body:
    """A box with its size, without a stack's shadow, and what stands in it; ports as height by name."""

    box: Box
    width: float
    height: float
    texts: tuple[Text, ...]
    ins: Mapping[str, float]
    outs: Mapping[str, float]
    mark: Mark | None = None

    @property
    def margin(self) -> float:
        """How far the shadow reaches beyond the box."""
        return STACK if self.box.stack else 0.0


def body_of(box: Box, mark: Mark | None = None) -> Body:
    """Return a box's size, its texts and its ports."""
    return _pill(box, mark) if box.kind in ("input", "output") else _card(box, mark)


def _pill(box: Box, mark: Mark | None) -> Body:
    """Title, type and default or file in one small box; its one port is halfway down."""
    rows = [(box.title, TITLE, "title"), (box.subtitle, SMALL, "dim"), *((line, CODE, "code") for line in box.lines)]
    texts, width, y = [], 60.0, 8.0
    for text, size, style in rows:
        shown = _cut(text, size, style)
        width = max(width, _width(shown, size, style))
        y += size + 3.5
        texts.append(Text(PAD + 2, y - 3, shown, style))
    height = y + 7
    ends = {"": height / 2}
    ins, outs = ends if box.ins else {}, ends if box.outs else {}
    return Body(box, round(width + 2 * PAD + 4), height, tuple(texts), ins, outs, mark)


def _card(box: Box, mark: Mark | None) -> Body:
    """Title and node name, rows of ports, lines of parameters, and a line for what became of it."""
    stack = text_width(box.stack, SMALL, bold=True)
    title = fitted(box.title, TITLE, MAX_WIDTH - stack, bold=True)
    subtitle = _cut(box.subtitle, SMALL, "dim")
    title_width = _width(title, TITLE, "title") + (stack + 14 if box.stack else 0)
    width = max(title_width, _width(subtitle, SMALL, "dim"), 72.0)
    lines = [fitted(line, CODE, MAX_WIDTH, mono=True) for line in box.lines]
    names = {port.name: fitted(port.name, SMALL, MAX_WIDTH / 2) for port in (*box.ins, *box.outs)}
    rows = max(len(box.ins), len(box.outs))
    for index in range(rows):
        sides = [names[side[index].name] for side in (box.ins, box.outs) if index < len(side)]
        width = max(width, sum(text_width(name, SMALL) for name in sides) + 18 * (len(sides) - 1))
    width = max([width, *(text_width(line, CODE, mono=True) for line in lines)])
    if mark is not None:
        width = max(width, text_width(mark.text, SMALL))
    width = round(width + 2 * PAD)
    texts = [Text(PAD, 20, title, "title"), Text(PAD, 35, subtitle, "dim")]
    if box.stack:
        texts.append(Text(width - PAD, 20, box.stack, "count", "end"))
    top = 44.0
    ins = {port.name: top + ROW * (i + 0.5) for i, port in enumerate(box.ins)}
    outs = {port.name: top + ROW * (i + 0.5) for i, port in enumerate(box.outs)}
    texts += [Text(PAD, y + 4, names[name], "port") for name, y in ins.items()]
    texts += [Text(width - PAD, y + 4, names[name], "port", "end") for name, y in outs.items()]
    y = top + ROW * rows + (4 if lines else 0)
    for line in lines:
        texts.append(Text(PAD, y + 11, line, "code"))
        y += LINE
    if mark is not None:
        texts.append(Text(PAD, y + 14, mark.text, f"mark gx-{mark.status}"))
        y += 18
    return Body(box, width, y + 6, tuple(texts), ins, outs, mark)


def _width(text: str, size: float, style: str) -> float:
    return text_width(text, size, bold=style == "title", mono=style == "code")


def _cut(text: str, size: float, style: str) -> str:
    return fitted(text, size, MAX_WIDTH, bold=style == "title", mono=style == "code")
