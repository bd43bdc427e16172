"""Example-based texture synthesis and editing as a node-graph dataflow framework.

The names below are imported when they are first used, so that the command line starts without numpy and pydantic.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from graphtex.cache import code_digest, file_digest
    from graphtex.context import QUIET, Context, Rng
    from graphtex.errors import Cancelled, DeclarationError, GraphError, GraphtexError, NodeFailed, Problem
    from graphtex.graph import Graph, load, loads
    from graphtex.handlers import opener, view, writer
    from graphtex.node import Node, node
    from graphtex.outputs import write_outputs
    from graphtex.parameters import FilePath
    from graphtex.run import RunResult, run
    from graphtex.sockets import (
        AngleMap,
        ArrayType,
        Axes,
        Directions,
        Displacement,
        Elements,
        Gap,
        Image,
        LabelMap,
        Mask,
        Number,
        Points,
        ScaleMap,
        SourceMap,
        Texture,
        Vector,
        Views,
        ViewStack,
        struct_type,
    )

__version__ = "0.1.0"

__all__ = [
    "QUIET",
    "AngleMap",
    "ArrayType",
    "Axes",
    "Cancelled",
    "Context",
    "DeclarationError",
    "Directions",
    "Displacement",
    "Elements",
    "FilePath",
    "Gap",
    "Graph",
    "GraphError",
    "GraphtexError",
    "Image",
    "LabelMap",
    "Mask",
    "Node",
    "NodeFailed",
    "Number",
    "Points",
    "Problem",
    "Rng",
    "RunResult",
    "ScaleMap",
    "SourceMap",
    "Texture",
    "Vector",
    "ViewStack",
    "Views",
    "code_digest",
    "file_digest",
    "load",
    "loads",
    "node",
    "opener",
    "run",
    "struct_type",
    "view",
    "write_outputs",
    "writer",
]

_HOMES = {
    "graphtex.cache": "code_digest file_digest",
    "graphtex.context": "QUIET Context Rng",
    "graphtex.errors": "Cancelled DeclarationError GraphError GraphtexError NodeFailed Problem",
    "graphtex.graph": "Graph load loads",
    "graphtex.handlers": "opener view writer",
    "graphtex.node": "Node node",
    "graphtex.outputs": "write_outputs",
    "graphtex.parameters": "FilePath",
    "graphtex.run": "RunResult run",
    "graphtex.sockets": "AngleMap ArrayType Axes Directions Displacement Elements Gap Image LabelMap Mask "
    "Number Points ScaleMap SourceMap Texture Vector Views ViewStack struct_type",
}
_HOME = {name: home for home, names in _HOMES.items() for name in names.split()}


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


if not TYPE_CHECKING:  # type checkers would take any name for one of ours

    def __getattr__(name: str) -> Any:
        if name not in _HOME:
            raise AttributeError(f"module 'graphtex' has no attribute {name!r}")
        import_module("graphtex.numbers")  # registers how numbers are written: nobody else would
        value = getattr(import_module(_HOME[name]), name)
        globals()[name] = value
        return value


class _Package(ModuleType):
    """Keeps `node` and `run` the functions: importing their modules of the same names would replace them."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOME and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
