"""``graphtex nodes``: what nodes there are, and how each is used."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from graphtex.cli.terminal import DONE, count, out, print_json, say, table
from graphtex.errors import GraphError, Problem, did_you_mean

if TYPE_CHECKING:
    from graphtex.node import Node
    from graphtex.packs import Registry


def nodes(name: str | None = None, /, *, json: bool = False) -> int:
    """List all nodes, or tell all that is needed to use one.

    Parameters
    ----------
    name
        The node's name, as in graph files.
    json
        Print JSON.
    """
    from graphtex.packs import registry

    found = registry()
    for text in found.broken:
        say(f"warning: {text}", "yellow")
    if name is not None:
        made = find_node(found, name)
        if json:
            print_json(node_object(made, found.packs[made.name]))
        else:
            from graphtex.cli.describe import describe

            out(describe(made, found.packs[made.name]))
    elif json:
        print_json([node_object(made, found.packs[key]) for key, made in sorted(found.nodes.items())])
    else:
        out(listing(found))
        say(f"{count(len(found.nodes), 'node')}; graphtex nodes NAME tells how one is used")
    return DONE


def find_node(found: "Registry", name: str) -> "Node[Any, Any]":
    """Return a node by its name, in any case, or its function's; GraphError with the nearest name if there is none."""
    if name in found.nodes:
        return found.nodes[name]
    plain = name.replace("_", "").replace("-", "").lower()
    for key, made in found.nodes.items():
        if plain in (key.lower(), made.function.__name__.replace("_", "")):
            return made
    raise GraphError([Problem("", 0, 0, "", f"unknown node {name!r}{did_you_mean(name, found.nodes, label='nodes')}")])


def group_of(made: "Node[Any, Any]") -> str:
    """Return the subpackage that a node lies in, such as ``perspective``; nothing for one at the top of its pack."""
    parts = made.function.__module__.split(".")
    return parts[1] if len(parts) > 2 else ""


def listing(found: "Registry") -> str:
    """Return the nodes by pack and subpackage, each with its summary."""
    groups: dict[tuple[str, str], list[tuple[str, str]]] = {}
    for name, made in sorted(found.nodes.items()):
        groups.setdefault((found.packs[name], group_of(made)), []).append((name, made.summary))
    width = max((len(name) for name in found.nodes), default=0)
    parts = []
    for pack, group in sorted(groups):
        rows = [(name.ljust(width), summary) for name, summary in groups[pack, group]]
        parts.append(f"{pack}{f' / {group}' if group else ''}\n{table(rows, indent='  ')}")
    return "\n\n".join(parts)


def node_object(made: "Node[Any, Any]", pack: str) -> dict[str, Any]:
    """Return all that is to be known of a node as plain data."""
    from inspect import getdoc

    from graphtex.cli.describe import example

    def sockets(of: Mapping[str, Any]) -> dict[str, Any]:
        return {
            key: {"type": str(socket.type), "optional": socket.optional, "description": socket.doc}
            for key, socket in of.items()
        }

    return {
        "name": made.name,
        "pack": pack,
        "group": group_of(made),
        "module": made.function.__module__,
        "function": made.function.__name__,
        "version": made.version,
        "random": "rng" in made.injected,
        "summary": made.summary,
        "inputs": sockets(made.inputs),
        "outputs": sockets(made.outputs),
        "parameters": made.parameters.model_json_schema(),
        "docstring": getdoc(made.function) or "",
        "example": example(made),
    }
