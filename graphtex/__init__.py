"""Example-based texture synthesis and editing as a node-graph dataflow framework."""

from graphtex import numbers as _numbers  # noqa: F401 (registers the handlers of Number)
from graphtex.context import QUIET, Context, Rng
from graphtex.errors import Cancelled, DeclarationError, GraphError, GraphtexError, NodeFailed, Problem
from graphtex.files import load, loads
from graphtex.graph import Graph
from graphtex.handlers import opener, view, writer
from graphtex.node import Node, node
from graphtex.parameters import FilePath
from graphtex.run import RunResult, run
from graphtex.sockets import (
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
    "load",
    "loads",
    "node",
    "opener",
    "run",
    "struct_type",
    "view",
    "writer",
]
