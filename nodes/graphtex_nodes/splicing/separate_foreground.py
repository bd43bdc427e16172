"""Foreground and background of textons (Liu et al. 2009, section 3.3)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Elements, Image, LabelMap, Mask, node
from graphtex_nodes.numerics.strokes import Strokes

Array = NDArray[Any]

NO_STROKES = Strokes()
CORE, RIM = 0.85, 1.12  # where an element surely is, and where it surely ends, in its half sizes
FARTHEST = 0.35  # share of what lies outside of all elements that surely is background
LEAST_BACKGROUND = 0.02  # share of the picture that background colours are learned from
CAP = 8.0  # of -log p: no pixel is surer than that
HARD = 1e6
SPECK = 0.02  # of an element's area: smaller parts and holes are mistakes
RARE = 0.15  # share of a background colour among elements, over its share outside
ROUNDS = 3  # of learning colours from the last cut


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
        background.
    foreground, background
        Pixels that are known: one element, and scribbles, will do. They stay what they are.
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
    from graphtex_nodes.numerics.illumination import evenly_lit
    from graphtex_nodes.splicing._colours import (
        least_cut,
        mixture_cost,
        nearest_cost,
        sharpened,
        smoothness_costs,
        told_by_hue,
    )
    from graphtex_nodes.splicing.texton_labels import texton_labels

    known = _known(image.shape[:2], foreground, background, strokes)
    picture = (evenly_lit(image) if even_light else image).astype(np.float64)
    pixels = picture.reshape(-1, picture.shape[2])
    if colours == "mixture":
        pixels = told_by_hue(pixels)
    seeds = _seeds(known, elements, width, height, pixels)
    right, down = (smoothness * costs for costs in smoothness_costs(picture, sigma))
    mask = seeds > 0
    for turn in range(ROUNDS if colours == "mixture" else 1):
        ctx.progress(turn / ROUNDS, "learning colours")
        samples = [pixels[(seeds == side).ravel()] for side in (1, -1)]
        if colours == "literal":
            costs = nearest_cost(pixels, samples[0]) - nearest_cost(pixels, samples[1])
        else:
            ours, theirs = (mixture_cost(pixels, each, clusters) for each in samples)
            costs = np.clip(ours - theirs, -CAP, CAP)
        costs = costs.reshape(mask.shape) - HARD * known
        mask = least_cut(costs, right, down)
        if not mask.any() or mask.all():
            break
        seeds = np.where(mask, 1, -1)
    size = width * height if elements is not None else 16.0
    mask = _cleaned(mask, SPECK * size, known)
    if colours == "mixture":
        mask = (sharpened(mask, np.maximum(picture, 0) ** 2.2) | (known > 0)) & ~(known < 0)
    if not mask.any() or mask.all():
        raise ValueError(
            f"image: expected colours that tell elements from what is between them, got "
            f"{'only' if mask.all() else 'no'} foreground; mark some of both by foreground, background or strokes"
        )
    if elements is None:
        from scipy.ndimage import label

        return Foreground(mask, label(mask)[0].astype(np.int32))
    return Foreground(mask, texton_labels(mask, elements.points) + np.int32(1))


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


def _seeds(known: Array, elements: Elements | None, width: float, height: float, pixels: Array) -> Array:
    """Where colours are learned from first: 1 foreground, -1 background, 0 not at all."""
    from graphtex_nodes.splicing._colours import typical_of
    from graphtex_nodes.splicing._nearness import distances

    seeds = known.copy()
    if elements is not None and len(elements.points):
        if width <= 0 or height <= 0:
            raise ValueError(f"width: expected the elements' size above 0, got {width:g} x {height:g}")
        nearness, outside = distances(known.shape, elements, width, height)
        if not (known < 0).any():
            inner = _inner(known.shape, elements, width, height)
            rim = min(RIM, float(np.quantile(outside[inner], 1 - LEAST_BACKGROUND)))
            beyond = inner & (outside >= rim) & (known == 0)
            if beyond.any():
                beyond &= nearness >= np.quantile(nearness[beyond], 1 - FARTHEST)
            ground = typical_of(pixels, beyond.ravel(), (nearness < 1).ravel(), RARE)
            seeds[ground.reshape(seeds.shape)] = -1
        if not (known > 0).any():
            core = typical_of(pixels, ((nearness < CORE) & (seeds == 0)).ravel(), (seeds < 0).ravel(), 1.0)
            seeds[core.reshape(seeds.shape)] = 1
    for name, side in (("foreground", 1), ("background", -1)):
        if not (seeds == side).any():
            raise ValueError(f"{name}: expected some pixels of it, by elements, a mask or strokes, got none")
    return seeds


def _inner(shape: tuple[int, ...], elements: Elements, width: float, height: float) -> Array:
    """Where no element lies whose middle is beyond the picture's border, unseen; everywhere if there is no such place.

    Elements that touch leave little ground: what is farthest from all that were found is then parts of such ones.
    """
    margin = int(np.ceil(max(width, height) * np.median(elements.scales) / 2))
    inner = np.zeros(shape, bool)
    inner[margin : shape[0] - margin, margin : shape[1] - margin] = True
    return inner if inner.any() else ~inner


def _cleaned(mask: Array, least: float, known: Array) -> Array:
    """A mask without parts and holes of less than `least` pixels, but for what is known."""
    from scipy.ndimage import label

    for side in (True, False):
        parts, _ = label(mask == side)
        small = np.bincount(parts.ravel()) < least
        small[0] = False
        mask = np.where(small[parts], not side, mask)
    cleaned: Array = (mask | (known > 0)) & ~(known < 0)
    return cleaned
