"""``graphtex schema``: the JSON Schema of graph files."""

import json

from graphtex.cli.show import Output, save_text
from graphtex.cli.terminal import DONE, print_json


def schema(*, output: Output = None) -> int:
    """Print the JSON Schema of graph files with all installed nodes.

    Editors check and complete graph files by it.

    Parameters
    ----------
    output
        The file to write in place of printing.
    """
    from graphtex.schema import graph_schema

    made = graph_schema()
    if output is None:
        print_json(made)
    else:
        save_text(output, json.dumps(made, ensure_ascii=False, indent=2) + "\n")
    return DONE
