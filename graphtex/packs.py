"""Packs of nodes: modules found through the entry-point group ``graphtex.nodes``.

A pack is a module whose public names hold nodes. A pack that does not load is reported and leaves the others alone.
"""

import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from types import ModuleType
from typing import Any

from graphtex.errors import DeclarationError
from graphtex.node import Node

GROUP = "graphtex.nodes"


@dataclass(frozen=True)
class Registry:
    """The nodes at hand, by their names in graph files.

    Attributes
    ----------
    packs
        Which pack each node comes from.
    broken
        What went wrong in packs that could not be loaded, a sentence each.
    """

    nodes: Mapping[str, Node[Any, Any]]
    packs: Mapping[str, str]
    broken: tuple[str, ...]


@functools.cache
def registry() -> Registry:
    """Load all installed packs, once."""
    from graphtex import numbers  # noqa: F401 (registers how numbers are written, as packs do for their types)

    return load_packs(entry_points(group=GROUP))


def load_packs(points: Iterable[EntryPoint]) -> Registry:
    """Load the packs of these entry points; of two nodes with one name the first pack's stays."""
    nodes: dict[str, Node[Any, Any]] = {}
    packs: dict[str, str] = {}
    broken = []
    for point in sorted(points, key=lambda point: (point.name != "graphtex_nodes", point.name)):
        try:
            found = nodes_of(point.load())
        except (Exception, SystemExit) as error:  # noqa: BLE001 (a third party's fault must not take the rest down)
            broken.append(f"pack {point.name!r} ({point.value}) did not load: {type(error).__name__}: {error}")
            continue
        for name, made in found.items():
            if nodes.get(name, made) is not made:
                broken.append(
                    f"pack {point.name!r}: node {name} is left out, pack {packs[name]!r} has one of that name"
                )
            else:
                nodes[name], packs[name] = made, point.name
    return Registry(nodes, packs, tuple(broken))


def nodes_of(module: ModuleType) -> dict[str, Node[Any, Any]]:
    """Return the nodes among a module's public names; DeclarationError if two of them have one name."""
    if not isinstance(module, ModuleType):
        raise TypeError(f"a pack is a module, got {type(module).__name__}")
    found: dict[str, Node[Any, Any]] = {}
    for key, made in sorted(vars(module).items()):
        if isinstance(made, Node) and not key.startswith("_") and found.setdefault(made.name, made) is not made:
            functions = [f"{one.__module__}.{one.__qualname__}" for one in (found[made.name].function, made.function)]
            raise DeclarationError(f"two nodes are named {made.name}: {' and '.join(functions)}")
    return found
