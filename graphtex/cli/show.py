"""``graphtex show``: a graph as a picture."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from graphtex.cli.terminal import DONE, out
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.whole import write_text

Output = Annotated[Path | None, Parameter(name=("-o", "--output"))]
KINDS = {".svg": "svg", ".mmd": "mermaid", ".html": "html"}


def show(graph: str, /, *, output: Output = None) -> int:
    """Draw a graph: its inputs, nodes, wires and outputs.

    Without -o, Mermaid text is printed.

    Parameters
    ----------
    graph
        A graph file, or the name of a graph that ships with graphtex.
    output
        The file to write: .svg, .mmd (Mermaid) or .html.
    """
    from graphtex import show as pictures
    from graphtex.cli.arguments import read_graph

    kind = KINDS.get(output.suffix.lower()) if output is not None else "mermaid"
    if kind is None:
        assert output is not None
        hint = did_you_mean(output.suffix, KINDS, label="suffixes")
        raise GraphError([Problem("", 0, 0, "-o", f"nothing draws {output.suffix or str(output)!r}{hint}")])
    text: str = getattr(pictures, kind)(read_graph(graph))
    if output is None:
        out(text.rstrip("\n"))
    else:
        save_text(output, text)
    return DONE


def save_text(file: Path, text: str) -> None:
    """Write a file and print its path; GraphError if it cannot be written."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_text(file, text)
    except OSError as error:
        message = f"{str(file)!r} cannot be written: {error.strerror or error}"
        raise GraphError([Problem("", 0, 0, "-o", message)]) from error
    out(str(file))
