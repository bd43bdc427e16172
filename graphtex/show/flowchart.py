"""The drawing as a Mermaid flowchart, for places that draw such text themselves (GitHub's Markdown among them)."""

import re

from graphtex.document import SCALAR_TYPES, Document
from graphtex.show.scene import Box, Link, scene
from graphtex.show.style import colours_of

_SHAPES = {"input": ("([", "])"), "node": ("[", "]"), "graph": ("[[", "]]"), "output": ("([", "])")}
_SAFE = re.compile(r"[^\w \u0080-\U0010ffff.,()×=+/-]")
_CLASSES = "classDef each stroke-width:3px", "classDef port stroke-dasharray:2 2"


def mermaid(graph: Document) -> str:
    """Return a flowchart of a graph; GraphError with all its problems if the graph is faulty.

    Links carry the names of their ports and the colour of their type; measured numbers are dotted, sub-graphs have
    double borders, nodes with `each:` thick ones.
    """
    found = scene(graph)
    names = {box.key: f"n{i}" for i, box in enumerate(found.boxes)}
    lines = ["flowchart LR"]
    for box in found.boxes:
        opening, closing = _SHAPES[box.kind]
        group = ":::each" if box.stack else ":::port" if box.kind in ("input", "output") else ""
        lines.append(f'  {names[box.key]}{opening}"{_label(box)}"{closing}{group}')
    for link in found.links:
        arrow = "-.->" if link.measured else "==>" if link.many else "-->"
        lines.append(f'  {names[link.source]} {arrow}|"{_ports(link)}"| {names[link.target]}')
    for i, link in enumerate(found.links):
        lines.append(f"  linkStyle {i} stroke:{colours_of(link.type, link.type in SCALAR_TYPES)[0]}")
    return "\n".join([*lines, *(f"  {line}" for line in _CLASSES)]) + "\n"


def _label(box: Box) -> str:
    head = f"{box.title} {box.stack}".strip()
    return "<br/>".join(f"{_escaped(line)}" for line in (head, box.subtitle, *box.lines))


def _ports(link: Link) -> str:
    return _escaped(" → ".join(filter(None, (link.out, link.into))) or link.type)


def _escaped(text: str) -> str:
    """Return a text for a quoted label: all that Mermaid or HTML could take for syntax as a character's number."""
    return _SAFE.sub(lambda found: f"#{ord(found[0])};", text)
