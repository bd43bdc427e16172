"""``graphtex graphs``: what graphs ship, and what one takes and makes."""

import shutil
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from graphtex.cli.terminal import DONE, count, out, say, table

if TYPE_CHECKING:
    from graphtex.document import Document, Input


def graphs(name: str | None = None, /) -> int:
    """List the graphs that ship, or tell what a graph takes and makes.

    Parameters
    ----------
    name
        The name of a graph that ships with graphtex, or a graph file.
    """
    if name is not None:
        from graphtex.cli.arguments import read_graph

        out(described(name, read_graph(name)))
        return DONE
    from graphtex.files import read_file
    from graphtex.shipped import find_graph, shipped_names

    names = shipped_names()
    found = {name: read_file(find_graph(name))[0] for name in names}
    out(table([(name, graph.title) for name, graph in found.items() if graph is not None]))
    say(f"{count(len(names), 'graph')}; graphtex graphs NAME tells what one takes and makes")
    return DONE


def described(name: str, graph: "Document") -> str:
    """Return a graph's page: what it is for, its inputs and its outputs."""
    from graphtex.links import Links
    from graphtex.references import reference
    from graphtex.show.scene import kind_text

    links = Links(graph)
    kinds = {key: links.type_of((), reference(graph, (), output.source)) for key, output in graph.outputs.items()}
    inputs = [_input_row(key, kind) for key, kind in graph.inputs.items()]
    parts = [
        f"{name}: {graph.title}" if graph.title else name,
        graph.source,
        textwrap.fill(graph.description, shutil.get_terminal_size().columns),
        _section("Inputs, each given by --set NAME=VALUE", inputs),
        _section("Outputs", [(key, kind_text(kind)) for key, kind in kinds.items()]),
    ]
    return "\n\n".join(part for part in parts if part)


def _section(title: str, rows: Sequence[Sequence[str]]) -> str:
    return f"{title}\n{table(rows, indent='  ')}" if rows else ""


def _input_row(name: str, kind: "Input") -> tuple[str, ...]:
    from graphtex.cli.describe import written
    from graphtex.document import REQUIRED
    from graphtex.show.page import bounds
    from graphtex.show.scene import cut

    default = "required" if kind.default is REQUIRED else f"default {cut(written(kind.default), 60)}"
    return (name, ", ".join(part for part in (kind.type, bounds(kind)) if part), default, kind.description)
