"""Pages in one file: the frame and the type that the drawing's page and the run's report share."""

import re
from collections.abc import Iterable, Sequence

from graphtex.document import REQUIRED, Document, Input
from graphtex.links import Links
from graphtex.references import reference
from graphtex.show.paint import svg
from graphtex.show.scene import brief, kind_text
from graphtex.show.style import MONO, SANS, escape

_LEAST_SHARE = 0.75  # to which a drawing shrinks before it scrolls

STYLE = f"""
:root{{color-scheme:light dark;--page:#fff;--ink:#1b1f24;--dim:#57606a;--line:#dfe3e8;--soft:#f6f7f9;--link:#0b5cad}}
@media(prefers-color-scheme:dark){{:root{{--page:#14171b;--ink:#e6e9ec;--dim:#9da7b3;--line:#343b44;--soft:#1c2127;
--link:#7cb8f5}}}}
*{{box-sizing:border-box}}
html{{-webkit-text-size-adjust:100%;scroll-padding-top:1rem}}
body{{margin:0;background:var(--page);color:var(--ink);font:15px/1.5 {SANS}}}
main{{max-width:1180px;margin:0 auto;padding:2rem 1.25rem 5rem}}
h1{{font-size:1.65rem;line-height:1.2;margin:0 0 .35rem;text-wrap:balance;overflow-wrap:anywhere}}
h2{{font-size:1.15rem;margin:2.4rem 0 .7rem;overflow-wrap:anywhere}}
h3{{font-size:.95rem;margin:1.1rem 0 .4rem}}
p{{margin:.3rem 0;max-width:75ch;overflow-wrap:anywhere}}
a{{color:var(--link);text-underline-offset:.15em}}
a:focus-visible,summary:focus-visible{{outline:2px solid var(--link);outline-offset:2px}}
.dim{{color:var(--dim)}} .small{{font-size:.85rem}}
.lines{{white-space:pre-line}}
code{{font:.86em {MONO};overflow-wrap:anywhere}}
.scroll{{overflow-x:auto;max-width:100%}}
table{{border-collapse:collapse;font-size:.9rem}}
th,td{{text-align:left;vertical-align:top;padding:.35rem 1rem .35rem 0;border-bottom:1px solid var(--line)}}
th{{font-weight:600;color:var(--dim);white-space:nowrap}} td{{min-width:4rem}} tbody th{{color:var(--ink)}}
.drawing{{overflow-x:auto;border:1px solid var(--line);border-radius:8px;margin:1.2rem 0}}
.drawing svg{{display:block;margin:0 auto;width:100%;height:auto}}
"""


def html(graph: Document) -> str:
    """Return a page in one file: the drawing, the description, tables of inputs and outputs.

    Raises
    ------
    GraphError
        With all its problems if the graph is faulty.
    """
    inputs = [_input_row(name, kind) for name, kind in graph.inputs.items()]
    links = Links(graph)
    outputs = [_output_row(links, name) for name in graph.outputs]
    parts = [
        heading(graph),
        drawn(svg(graph), "The graph"),
        *_section("Inputs", ("Name", "Type", "Default", "May be", "What it is"), inputs),
        *_section("Outputs", ("Name", "Type", "From", "File"), outputs),
    ]
    return page(graph.title or "A graph", "\n".join(parts))


def page(title: str, body: str, *, style: str = "", script: str = "") -> str:
    """Return a whole page; `body` is HTML, `title` plain text."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n<link rel="icon" href="data:,">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}{style}</style>\n</head>\n<body>\n<main>\n{body}\n</main>\n"
        f"{f'<script>{script}</script>' if script else ''}</body>\n</html>\n"
    )


def heading(graph: Document) -> str:
    """Return a graph's title, source and description."""
    title = graph.title or (graph.file.stem if graph.file else "A graph")
    parts = [f"<h1>{escape(title)}</h1>"]
    if graph.source:
        parts.append(f'<p class="dim">{escape(graph.source)}</p>')
    if graph.description:
        parts.append(f'<p class="lines">{escape(graph.description.strip())}</p>')
    return "\n".join(parts)


def drawn(drawing: str, label: str) -> str:
    """Return a drawing for a page: it shrinks a little to fit, and can be scrolled where that is not enough."""
    found = re.search(r'width="([0-9.]+)"', drawing)
    width = float(found[1]) if found else 0.0
    style = f"min-width:{_LEAST_SHARE * width:g}px;max-width:{width:g}px;margin:0 auto"
    inner = f'<div style="{style}">{drawing}</div>'
    return f'<div class="drawing" tabindex="0" role="group" aria-label="{escape(label)}">{inner}</div>'


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; heads are plain text, cells are HTML, the first of each row is its head."""
    top = "".join(f'<th scope="col">{escape(head)}</th>' for head in heads)
    body = "".join(
        f'<tr><th scope="row">{row[0]}</th>{"".join(f"<td>{cell}</td>" for cell in row[1:])}</tr>\n' for row in rows
    )
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead>\n<tbody>{body}</tbody></table></div>'


def bounds(kind: Input) -> str:
    """Return what an input's value may be, as text."""
    if kind.choices is not None:
        return " · ".join(map(str, kind.choices))
    if kind.min is not None and kind.max is not None:
        return f"{kind.min:g} to {kind.max:g}"
    if kind.min is not None:
        return f"at least {kind.min:g}"
    return f"at most {kind.max:g}" if kind.max is not None else ""


def _section(title: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    return [f"<h2>{title}</h2>", table(heads, rows)] if rows else []


def _input_row(name: str, kind: Input) -> tuple[str, ...]:
    default = "<em>required</em>" if kind.default is REQUIRED else f"<code>{escape(brief(kind.default, 80))}</code>"
    return (escape(name), escape(kind.type), default, escape(bounds(kind)), escape(kind.description))


def _output_row(links: Links, name: str) -> tuple[str, ...]:
    graph, output = links.graph, links.graph.outputs[name]
    kind = links.type_of((), reference(graph, (), output.source))
    return (escape(name), escape(kind_text(kind)), f"<code>{escape(output.source)}</code>", escape(output.file or ""))
