"""How much each place of a texture looks like a given one (Liu et al. 2009, section 3.2)."""

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Image, node

Array = NDArray[Any]
Coordinate = Annotated[float, Field(ge=0, description="place of the element's centre, pixels")]
Size = Annotated[float, Field(ge=3, le=4096, description="size of the element, pixels")]
Measure = Annotated[
    Literal["vector", "literal"],
    Field(description="one coefficient for all channels, or the channel whose map has the least entropy"),
]

BINS = 64  # of the histogram that an entropy is taken of


@node
def self_similarity(
    appearance: Image, *, x: Coordinate, y: Coordinate, width: Size, height: Size,
    measure: Measure = "vector", ctx: Context = QUIET,
) -> Image:  # fmt: skip
    r"""Normalised cross-correlation of one element's neighbourhood with every place.

    Parameters
    ----------
    appearance
        Shape (h, w, c): appearance vectors, or any picture.
    measure
        ``vector`` correlates the vectors of all channels at once,
        :math:`\sum_{c,p} \hat I_c \hat T_c / \sqrt{\sum \hat I_c^2 \sum \hat T_c^2}` each channel less its mean.
        ``literal`` is the paper's: a map for each channel, of which the one with the least entropy is kept. It tends to
        pick channels that hold little but noise.

    Returns
    -------
    Image
        Shape (h, w, 1), in [-1, 1]; 1 at the element itself. At the border only what lies in the picture counts, and
        where too little does the value is -1.

    Raises
    ------
    ValueError
        The element's centre is outside the picture, or the element has no structure.
    """
    from graphtex_nodes.numerics.correlation import Correlator
    from graphtex_nodes.splicing._templates import Example, check_inside, cut_out

    example = Example(x=x, y=y, width=width, height=height)
    check_inside(example, appearance.shape, "x")
    template, mask = cut_out(appearance, example, "x")
    if measure == "vector":
        return Correlator(appearance, mask.shape, ctx.threads).correlate(template, mask)[..., None].astype(np.float32)
    maps = []
    for channel in range(appearance.shape[2]):
        ctx.progress(channel / appearance.shape[2])
        one = slice(channel, channel + 1)
        if template[mask, one].std() > 0:
            maps.append(Correlator(appearance[..., one], mask.shape, ctx.threads).correlate(template[..., one], mask))
    return min(maps, key=entropy)[..., None].astype(np.float32)


def entropy(scores: Array) -> float:
    """Shannon entropy in bits of the distribution of scores."""
    counts = np.histogram(scores, BINS, (-1.0, 1.0))[0]
    share = counts[counts > 0] / scores.size
    return -float((share * np.log2(share)).sum())
