"""The parameters of Optimize: types, ranges, and what each says in one line; what its qualities do, what all need."""

from typing import Annotated, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import Image
from graphtex_nodes.numerics.materials import MapKind

Size = Annotated[
    int, Field(ge=0, le=16384, description="pixels; 0 follows start or the target scale, else twice the exemplar")
]
Sides = Annotated[
    Literal["none", "both", "x", "y"],
    Field(description="sides over which the output continues: x the left and right ones, y the upper and lower ones"),
]


def output_size(
    start: Image | None, target: NDArray[np.float32] | None, exemplar: Image, height: int, width: int
) -> tuple[int, int]:  # fmt: skip
    """Height and width of the output."""
    if start is not None:
        size = start.shape[:2]
        if (height or size[0], width or size[1]) != size:
            raise ValueError(f"start: expected the output's size {height} x {width}, got shape {start.shape}")
        return int(size[0]), int(size[1])
    shape = (2 * exemplar.shape[0], 2 * exemplar.shape[1]) if target is None else target.shape
    return height or shape[0], width or shape[1]


def around(sides: str) -> tuple[bool, bool]:
    """Whether an output continues along its rows (y) and along its columns (x)."""
    return sides in ("y", "both"), sides in ("x", "both")


Levels = Annotated[int, Field(ge=0, le=12, description="levels of the pyramid; 0 chooses them from the exemplar")]
Windows = Annotated[
    tuple[Annotated[int, Field(ge=2, le=64)], ...],
    Field(max_length=4, description="sides of the windows in pixels; none chooses"),
]
Iterations = Annotated[int, Field(ge=1, le=50, description="twice those on the finest level; coarser ones have more")]
ScaleWeight = Annotated[
    float, Field(ge=0, le=10, description="standard deviation of the scale channel over that of the colours; 0 = plain")
]
ScaleMode = Annotated[
    Literal["fixed", "free"], Field(description="fixed: the output's scale is the target; free: it is synthesised")
]
Vote = Annotated[
    Literal["blend", "discrete", "mean"],
    Field(description="blend: pieces fade into each other; discrete: pure copies; mean: the last weighted mean"),
]
Exponent = Annotated[float, Field(gt=0, le=2, description="power of a window's distance in the energy; 2 = no weights")]
Gain = Annotated[float, Field(ge=0, le=100, description="strength of histogram matching; 0 = none")]
Evenness = Annotated[float, Field(ge=0, le=100, description="charge for overused parts of the exemplar; 0 = none")]
Detail = Annotated[float, Field(ge=0, le=1, description="how much lines and fine detail gain on large areas; 0 = none")]
Variance = Annotated[float, Field(gt=0, le=1, description="share of variance that principal components keep")]
Mirror = Annotated[bool, Field(description="whether mirror images of the exemplar (right to left) serve too")]
Largest = Annotated[
    float, Field(ge=1, le=4, description="how far copies are enlarged or shrunk where scales are short; 1 = never")
]
Quality = Annotated[
    Literal["default", "fast", "preview"],
    Field(description="fast: half the time; preview: a tenth, coarse, shows the arrangement"),
]
Components = Annotated[
    Literal["apart", "joint"],
    Field(description="principal components of colours and guides apart, or joint as is printed first"),
]
Kinds = Annotated[list[MapKind], Field(max_length=16, description="what the channels are, as for StackMaps")]
Weights = Annotated[
    tuple[Annotated[float, Field(ge=0, le=100)], ...],
    Field(max_length=16, description="how much each map, or without kinds each channel, counts; 0 = is copied only"),
]
AngleWeight = Annotated[
    float, Field(ge=0, le=10, description="how much direction counts, in standard deviations of the colours; 0 = not")
]
TurnStep = Annotated[
    float, Field(ge=0, le=90, description="degrees between turned copies of the exemplar; 0 = no such copies")
]
Arrows = Annotated[bool, Field(description="whether opposite directions differ; lines have none")]


class Effort(NamedTuple):
    """What a quality leaves out.

    Divisors of the iterations (rounded up) on the ``fine`` levels (0 = they do not search) and on ``coarse`` ones,
    ``passes`` of a search, most ``directions`` in which windows are compared, whether pieces are ``cut`` anew, in how
    many ``moves`` seams move, and whether pieces are bent to meet there (``level``).
    """

    fine: int
    coarse: int
    passes: int
    directions: int
    cut: bool
    moves: int
    level: bool


EFFORT = {
    "default": Effort(1, 1, 2, 48, cut=True, moves=10, level=True),
    "fast": Effort(2, 2, 1, 48, cut=False, moves=10, level=True),
    "preview": Effort(0, 8, 1, 24, cut=False, moves=0, level=False),
}

SYNTHESIS_KERNELS = (
    "window_kernels",
    "search_kernels",
    "copies_kernels",
    "transport_kernels",
    "vote_kernels",
    "cut_kernels",
    "piece_kernels",
    "seam_kernels",
    "membrane_kernels",
)
"""Files of the kernels that a synthesis from windows needs."""
