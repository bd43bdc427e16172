"""The drawing as SVG: plain shapes and style classes, readable on light and dark ground, also without CSS media."""

from collections.abc import Iterable, Mapping, Sequence

from graphtex.document import SCALAR_TYPES, Document
from graphtex.show.boxes import SMALL, Body, body_of
from graphtex.show.layout import Layout, Placed, Route, layout
from graphtex.show.scene import Link, Mark, Scene, scene
from graphtex.show.style import MONO, SANS, STATUS_COLOURS, colours_of, escape, text_width

MARGIN = 24.0
_LEGEND_ROW = 22.0
_SAMPLE = 26.0  # length of a line in the legend

_GROUND = (
    # class, light, dark
    ("page", "fill:#ffffff", "fill:#14171b"),
    ("box", "fill:#f6f7f9;stroke:#b4bcc6", "fill:#20252b;stroke:#4d5763"),
    ("inner", "fill:none;stroke:#b4bcc6", "fill:none;stroke:#4d5763"),
    ("pill", "fill:#ffffff;stroke:#8a94a0", "fill:#14171b;stroke:#6b7683"),
    ("title", "fill:#1b1f24", "fill:#eceff2"),
    ("dim", "fill:#57606a", "fill:#9da7b3"),
    ("port", "fill:#2f363d", "fill:#d3d9df"),
    ("code", "fill:#57606a", "fill:#a9b3be"),
    ("count", "fill:#1b1f24", "fill:#eceff2"),
    ("rim", "stroke:#ffffff", "stroke:#14171b"),
)
_FONTS = (
    f".gx-title{{font:600 13px {SANS}}}.gx-dim,.gx-port{{font:{SMALL:g}px {SANS}}}"
    f".gx-count{{font:600 {SMALL:g}px {SANS}}}.gx-mark{{font:600 {SMALL:g}px {SANS}}}.gx-code{{font:10.5px {MONO}}}"
    ".gx-edge{fill:none;stroke-width:1.6}.gx-scalar{stroke-width:1.1}.gx-many{stroke-width:3.2}"
    ".gx-measured{stroke-dasharray:5 4}.gx-halo{fill:none;stroke-width:5;opacity:.75}"
    "a:hover .gx-box{stroke-width:2}"
)


def svg(graph: Document, *, marks: Mapping[str, Mark] | None = None) -> str:
    """Draw a graph.

    Parameters
    ----------
    marks
        What became of each node (or ``$input``) in a run; without it the graph alone is drawn.

    Returns
    -------
    str
        One ``<svg>`` element, the same text for the same graph.

    Raises
    ------
    GraphError
        With all its problems if the graph is faulty.
    """
    found = scene(graph)
    told = marks or {}
    bodies = [body_of(box, told.get(box.key)) for box in found.boxes]
    drawn = layout(bodies, found.links)
    legend, legend_width, legend_height = _legend(found, max(drawn.width, 420.0))
    width = max(drawn.width, legend_width) + 2 * MARGIN
    height = drawn.height + 2 * MARGIN + legend_height
    title = graph.title or "A graph"
    about = f"{len(graph.inputs)} inputs, {len(graph.nodes)} nodes, {len(graph.outputs)} outputs"
    role = "group" if told else "img"  # an image's links could not be reached
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="gx" width="{width:g}" height="{height:g}" '
        f'viewBox="0 0 {width:g} {height:g}" role="{role}" aria-label="{escape(f"{title}: {about}")}">',
        f"<title>{escape(title)}</title><desc>{escape(about)}</desc>",
        f"<style>{_style(found, bodies)}</style>",
        f'<rect class="gx-page" width="{width:g}" height="{height:g}" rx="8"/>',
        f'<g transform="translate({MARGIN:g},{MARGIN:g})">',
        *(_shadow(placed) for placed in drawn.boxes if placed.body.box.stack),
        *_lines(drawn),
        *(_box(placed) for placed in drawn.boxes),
        "</g>",
        f'<g class="gx-legend" transform="translate({MARGIN:g},{drawn.height + 1.6 * MARGIN:g})">',
        *legend,
        "</g></svg>",
    ]
    return "\n".join(parts) + "\n"


def _style(found: Scene, bodies: Sequence[Body]) -> str:
    light, dark = [], []
    for name, bright, dim in _GROUND:
        light.append(f".gx-{name}{{{bright}}}")
        dark.append(f".gx-{name}{{{dim}}}")
    kinds = [port.type for box in found.boxes for port in (*box.ins, *box.outs)] + [link.type for link in found.links]
    for kind in dict.fromkeys(kinds):
        for rules, colour in zip((light, dark), colours_of(kind, kind in SCALAR_TYPES), strict=True):
            rules.append(f".{_class(kind)}{{stroke:{colour}}}.gx-dot.{_class(kind)}{{fill:{colour}}}")
    for status in dict.fromkeys(body.mark.status for body in bodies if body.mark):
        for rules, colour in zip((light, dark), STATUS_COLOURS[status], strict=True):
            rules.append(f".gx-text.gx-{status},.gx-bar.gx-{status}{{fill:{colour}}}")
            rules.append(f".gx-box.gx-{status}{{stroke:{colour}}}")
    return f"{''.join(light)}{_FONTS}@media(prefers-color-scheme:dark){{{''.join(dark)}}}"


def _class(kind: str) -> str:
    return f"gx-t-{kind}"


def _line_class(link: Link) -> str:
    extra = " gx-scalar" if link.type in SCALAR_TYPES else " gx-many" if link.many else ""
    return f"gx-edge {_class(link.type)}{extra}{' gx-measured' if link.measured else ''}"


def _lines(drawn: Layout) -> list[str]:
    """Draw links, each with a rim in the page's colour, so that crossings read as one line above another."""
    parts = []
    for group, routes in _grouped(drawn.routes):
        parts.append(f'<g data-from="{escape(group)}">')
        parts += [f'<path class="gx-halo gx-rim" d="{route.path}"/>' for route in routes]
        for route in routes:
            link = route.link
            start, end = _end(link.source, link.out), _end(link.target, link.into)
            parts.append(
                f'<path class="{_line_class(link)}" data-source="{escape(start)}" data-target="{escape(end)}" '
                f'd="{route.path}"><title>{escape(f"{start} → {end}: {link.type}")}</title></path>'
            )
        parts.append("</g>")
    return parts


def _grouped(routes: Iterable[Route]) -> list[tuple[str, list[Route]]]:
    """Return the links of each port together: they share a line, which must not rub itself out."""
    groups: dict[str, list[Route]] = {}
    for route in routes:
        groups.setdefault(_end(route.link.source, route.link.out), []).append(route)
    return list(groups.items())


def _end(key: str, port: str) -> str:
    return f"{key}.{port}" if port else key


def _shadow(placed: Placed) -> str:
    """Draw the boxes that stand behind that of a node with `each:`."""
    body = placed.body
    status = f" gx-{body.mark.status}" if body.mark else ""
    return "".join(
        f'<rect class="gx-box{status}" x="{placed.x + shift:g}" y="{placed.y + shift:g}" '
        f'width="{body.width:g}" height="{body.height:g}" rx="6"/>'
        for shift in (body.margin, body.margin / 2)
    )


def _box(placed: Placed) -> str:
    body, box = placed.body, placed.body.box
    size = f'width="{body.width:g}" height="{body.height:g}"'
    status = f" gx-{body.mark.status}" if body.mark else ""
    parts = [
        f'<g class="gx-{box.kind}" data-id="{escape(box.key)}" transform="translate({placed.x:g},{placed.y:g})">',
        f"<title>{escape(': '.join(filter(None, (box.title, box.about))))}</title>" if box.about else "",
    ]
    if box.kind in ("input", "output"):
        parts.append(f'<rect class="gx-pill gx-frame" {size} rx="{min(body.height / 2, 18):g}"/>')
    else:
        parts.append(f'<rect class="gx-box gx-frame{status}" {size} rx="6"/>')
    if box.kind == "graph":
        parts.append(
            f'<rect class="gx-inner" x="3" y="3" width="{body.width - 6:g}" height="{body.height - 6:g}" rx="4"/>'
        )
    if body.mark and box.kind in ("node", "graph"):
        parts.append(f'<rect class="gx-bar{status}" y="6" width="4" height="{body.height - 12:g}"/>')
    for text in body.texts:
        anchor = "" if text.anchor == "start" else f' text-anchor="{text.anchor}"'
        extra = " gx-text" if text.style.startswith("mark") else ""
        parts.append(
            f'<text class="gx-{text.style}{extra}" x="{text.x:g}" y="{text.y:g}"{anchor}>{escape(text.text)}</text>'
        )
    for side, ports, heights, x in (("in", box.ins, body.ins, 0.0), ("out", box.outs, body.outs, body.width)):
        for port in ports:
            parts.append(_dot(port.name, port.type, port.many, side, x, heights[port.name]))
    inner = "".join([*parts, "</g>"])
    return f'<a href="{escape(body.mark.href)}">{inner}</a>' if body.mark and body.mark.href else inner


def _dot(name: str, kind: str, many: bool, side: str, x: float, y: float) -> str:
    """Draw a port: a disc, or a square for a list."""
    told = f'class="gx-dot {_class(kind)}" data-port="{side}:{escape(name)}"'
    label = f"<title>{escape(f'{name}: ' if name else '')}{'list of ' if many else ''}{escape(kind)}</title>"
    if many:
        return f'<rect {told} x="{x - 4:g}" y="{y - 4:g}" width="8" height="8">{label}</rect>'
    return f'<circle {told} cx="{x:g}" cy="{y:g}" r="4">{label}</circle>'


def _legend(found: Scene, limit: float) -> tuple[list[str], float, float]:
    """Return the legend's rows, their width and their height: each type that occurs, and each kind of line and box."""
    entries: list[tuple[str, str]] = []
    kinds = dict.fromkeys(link.type for link in found.links)
    for kind in kinds:
        if kind not in SCALAR_TYPES:
            entries.append((f'<path class="gx-edge {_class(kind)}" d="M0,0H{_SAMPLE:g}"/>', kind))
    scalars = [kind for kind in kinds if kind in SCALAR_TYPES]
    if scalars:
        line = f'<path class="gx-edge gx-scalar {_class(scalars[0])}" d="M0,0H{_SAMPLE:g}"/>'
        entries.append((line, ", ".join(scalars)))
    first = next((link.type for link in found.links if link.many), "")
    if first:
        entries.append((f'<path class="gx-edge gx-many {_class(first)}" d="M0,0H{_SAMPLE:g}"/>', "a list"))
    measured = next((link.type for link in found.links if link.measured), "")
    if measured:
        line = f'<path class="gx-edge gx-measured {_class(measured)}" d="M0,0H{_SAMPLE:g}"/>'
        entries.append((line, "a measured number feeds a parameter"))
    if any(box.stack for box in found.boxes):
        stack = "".join(
            f'<rect class="gx-box" x="{4 + s}" y="{s - 8}" width="16" height="10" rx="2"/>' for s in (6, 3, 0)
        )
        entries.append((stack, "runs once for each item"))
    if any(box.kind == "graph" for box in found.boxes):
        double = (
            '<rect class="gx-box" x="2" y="-7" width="22" height="14" rx="3"/>'
            '<rect class="gx-inner" x="5" y="-4" width="16" height="8" rx="2"/>'
        )
        entries.append((double, "another graph file"))
    parts, x, y, widest = [], 0.0, 0.0, 0.0
    for sample, text in entries:
        width = _SAMPLE + 8 + text_width(text, SMALL)
        if x > 0 and x + width > limit:
            x, y = 0.0, y + _LEGEND_ROW
        parts.append(
            f'<g transform="translate({x:g},{y + 10:g})">{sample}'
            f'<text class="gx-dim" x="{_SAMPLE + 8:g}" y="4">{escape(text)}</text></g>'
        )
        widest = max(widest, x + width)
        x += round(width + 22)
    return parts, widest, y + _LEGEND_ROW if entries else 0.0
