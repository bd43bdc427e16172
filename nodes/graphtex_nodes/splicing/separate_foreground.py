"""Foreground and background of textons (Liu et al. 2009, section 3.3)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Elements, Image, LabelMap, Mask, node
from graphtex_nodes.numerics.strokes import Strokes

Array = NDArray[Any]

NO_STROKES = Strokes()


class Foreground(NamedTuple):
    """The foreground mask, and which element each of its pixels belongs to."""

    mask: Mask
    labels: LabelMap


@node
def separate_foreground(
    image: Annotated[Image, Axes("h w c")],
    elements: Elements | None = None,
    foreground: Annotated[Mask, Axes("h w")] | None = None,
    background: Annotated[Mask, Axes("h w")] | None = None,
    *,
    width: Annotated[float, Field(ge=0, description="of an element at scale 1, pixels; needed with elements")] = 0.0,
    height: Annotated[float, Field(ge=0, description="of an element at scale 1, pixels; needed with elements")] = 0.0,
    strokes: Annotated[Strokes, Field(description="scribbles labelled foreground or background")] = NO_STROKES,
    colours: Annotated[
        Literal["mixture", "literal"],
        Field(description="a mixture of Gaussians, or the squared distance to the nearest known colour"),
    ] = "mixture",
    clusters: Annotated[int, Field(ge=1, le=8, description="Gaussians of a mixture")] = 5,
    sigma: Annotated[
        float | None, Field(gt=0, description="contrast that parts neighbours; by default the picture's own")
    ] = None,
    smoothness: Annotated[float, Field(ge=0, le=1000, description="weight of the neighbour term")] = 2.0,
    even_light: Annotated[bool, Field(description="take slow changes of brightness off first")] = True,
    ctx: Context = QUIET,
) -> Foreground:
    r"""Cut a texture into elements and what lies between them.

    The labelling minimises

    .. math:: \sum_p D_p(L_p) + \lambda \sum_{pq} [L_p \ne L_q]\, e^{-|A_p - A_q|^2 / 2 \sigma^2}

    over the 4-neighbourhood (equations 1 and 3), exactly, by a minimum cut. D is the negative log-likelihood of a
    pixel's colour; the colours are those of what is known, and are learned anew from the labelling two times.

    Parameters
    ----------
    image
        Shape (h, w, c).
    elements
        As `FindTextons` gives them: their middles are foreground to begin with, what is outside of all of them
        background. If colours make background of a tenth of the elements' insides, as where these have several colours
        or one of them is the joints', and there are joints, darker or brighter than what is on both sides of them, that
        part the elements and leave them whole, these are the background.
    foreground, background
        Pixels that are known: one element, and scribbles, will do. They stay what they are.
        Of more than a million pixels a reduced picture is cut first, and then bands along the outlines of all of it.
    colours
        ``literal`` is equation 2, with the sign that makes a label cheap where its colours are near: as printed, the
        labels come out exchanged. One wrong sample spoils it.
    sigma
        The paper's 1 makes all neighbours alike where colours lie in [0, 1]. The default is the root of the mean
        squared difference of neighbours.

    Returns
    -------
    mask
        True on the foreground.
    labels
        1 and up for the elements in order, 0 for the background and parts without an element; parts that hold several
        are split where they are narrow. Without elements connected parts are numbered.

    Raises
    ------
    ValueError
        Nothing is known of the foreground or the background, something is known to be both, a size is missing, or all
        of the picture comes out the same.

    Examples
    --------
    >>> from graphtex_nodes import find_textons, textons
    >>> made = textons(width=96, height=96, size=20.0, rng=1)
    >>> found = find_textons(made.image)
    >>> cut = separate_foreground(made.image, found.elements, width=found.width, height=found.height)
    >>> bool((cut.mask == made.mask).mean() > 0.97)
    True
    """
    from scipy.ndimage import label, maximum_filter

    from graphtex_nodes.numerics.illumination import light_trend
    from graphtex_nodes.splicing._cutter import Cutter
    from graphtex_nodes.splicing._detection import reduced
    from graphtex_nodes.splicing._joints import along_joints
    from graphtex_nodes.splicing._nearness import distances
    from graphtex_nodes.splicing._outlines import nearest_indices, reduction, refined_labels, refined_outlines
    from graphtex_nodes.splicing.texton_labels import texton_labels

    known = _known(image.shape[:2], foreground, background, strokes)
    side = min(width, height) if elements is not None else np.inf
    step = reduction(image.shape[:2], side) if side > 0 else 1.0
    ctx.check()
    small = reduced(image, step)
    ctx.check()
    at = np.ix_(*nearest_indices(small.shape[:2], known.shape, 1 / step))
    ours, theirs = (maximum_filter(known == sign, int(np.ceil(step)))[at].astype(np.int8) for sign in (1, -1))
    scaled = None if elements is None else elements._replace(points=elements.points / step)
    trend = None
    if even_light:
        inside = None
        if scaled is not None and side > 0:
            inside = distances(small.shape[:2], scaled, width / step, height / step)[0] < 1
        trend = light_trend(small, inside)
    cutter = Cutter(colours, clusters, sigma, smoothness, trend)
    mask = cutter.cut(small, ours - theirs, scaled, width / step, height / step, ctx)
    labels = label(mask)[0] if scaled is None else texton_labels(mask, scaled.points) + 1
    if step > 1:
        if cutter.joints is not None:
            joints = cutter.joints._replace(step=cutter.joints.step * step)
            mask = along_joints(joints, cutter.evened(image), known, cutter.smoothness_of, ctx)
        else:

            def tile(window: tuple[slice, slice]) -> Array:
                return cutter.evened(image[window], image.shape, window)

            mask = refined_outlines(mask, step, known, tile, cutter.cost, cutter.smoothness_of, ctx)
        labels = refined_labels(labels, mask, step)
    return Foreground(mask, labels.astype(np.int32))


def _known(shape: tuple[int, ...], foreground: Array | None, background: Array | None, strokes: Strokes) -> Array:
    """1 where the foreground is known, -1 where the background is, 0 elsewhere."""
    from graphtex_nodes.numerics.strokes import stroke_weights

    sides = []
    for name, given in (("foreground", foreground), ("background", background)):
        drawn = stroke_weights(strokes, shape[1], shape[0], label=name) > 0.5
        sides.append(drawn if given is None else drawn | given)
    both = int(np.count_nonzero(sides[0] & sides[1]))
    if both:
        raise ValueError(f"background: expected no pixel that foreground has too, got {both} of them")
    known: Array = sides[0].astype(np.int8) - sides[1].astype(np.int8)
    return known
