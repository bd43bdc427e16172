"""``graphtex new``: a starter graph or node pack."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from graphtex.cli.terminal import DONE, out, say
from graphtex.errors import GraphError, Problem


def new(name: str, /, *, folder: Annotated[Path, Parameter(name="--in")] = Path()) -> int:
    """Write a starter graph or node pack.

    A graph if NAME ends in .yaml, else a pack with a node, a graph and a test.

    Parameters
    ----------
    name
        The graph file's name, such as mine.yaml, or the pack's.
    folder
        Where to write it, by default here.
    """
    from graphtex.scaffold import new_graph, new_pack

    is_graph = name.endswith((".yaml", ".yml"))
    try:
        files = new_graph(name, folder) if is_graph else new_pack(name, folder)
    except OSError as error:
        message = f"cannot be written: {error.strerror or error}"
        raise GraphError([Problem("", 0, 0, str(error.filename or name), message)]) from error
    for file in files:
        out(str(file))
    if is_graph:
        say(f"run it: graphtex run {files[0]}")
    else:
        say(f"make its nodes known: pip install -e {folder / name}; then see them: graphtex nodes")
    return DONE
