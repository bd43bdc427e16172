"""``graphtex schema``: the JSON Schema of graph files."""

import json

from graphtex.cli.show import Output, write_text
from graphtex.cli.terminal import DONE, out


def schema(*, output: Output = None) -> int:
    """Print the JSON Schema of graph files with all installed nodes.

    Editors check and complete graph files by it.

    Parameters
    ----------
    output
        The file to write in place of printing.
    """
    from graphtex.schema import graph_schema

    text = json.dumps(graph_schema(), ensure_ascii=False, indent=2)
    if output is None:
        out(text)
    else:
        write_text(output, text + "\n")
    return DONE
