"""Where the elements of a texture are, and how each is turned and sized (Liu et al. 2009, section 3.2)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, Elements, Image, Number, Points, Vector, node
from graphtex_nodes.splicing._templates import Example, check_inside, mean_size

Array = NDArray[Any]

COVERED = 0.95  # share of the picture at which the literal search stops


class Textons(NamedTuple):
    """Elements with their scores, the size of one at scale 1, the similarity map, and how sure all this is."""

    elements: Elements
    points: Points
    scores: Vector
    width: Number
    height: Number
    similarity: Image
    confidence: Number


@node
def find_textons(
    image: Image,
    *,
    examples: Annotated[
        list[Example],
        Field(max_length=8, description="one element of each kind; none = automatic"),
    ] = [],  # noqa: B006 (never changed)
    turn: Annotated[float, Field(ge=0, le=180, description="elements may be turned by up to this, degrees")] = 0.0,
    growth: Annotated[float, Field(ge=1, le=2, description="elements may be so many times larger or smaller")] = 1.0,
    radius: Annotated[float, Field(ge=0.2, le=2, description="least distance of two elements over their size")] = 0.66,
    least_score: Annotated[
        float | None, Field(ge=-1, le=1, description="of an element; by default where the scores part in two groups")
    ] = None,
    search: Annotated[
        Literal["vector", "literal"],
        Field(description="literal: least-entropy channel, no least score, stop when 95 % is picked or removed"),
    ] = "vector",
    ctx: Context = QUIET,
) -> Textons:
    """Find all that looks like the given elements, or the elements themselves.

    The similarity to each example is one normalised cross-correlation over all channels of the appearance vectors. Its
    maxima are taken from the highest on, each removing weaker ones in an ellipse of `radius` times the element's size,
    down to the least score. Places are then refined against the mean of all that was found.

    Parameters
    ----------
    image
        Shape (h, w, c).
    examples
        Each with ``x``, ``y`` (its centre), ``width`` and ``height`` in pixels. Where joints part all of the picture,
        these are such parts, and most of the others look like none of them, all parts are elements (not with `turn` or
        `growth`). Without any the picture is divided, in halves of its colours and along its dark and its bright
        joints, and each partition judged by how round, even and free its parts are. Of each the typical part, and
        blobs, are tried as examples; the one that explains the picture best is taken (mean correlation x root of the
        share covered once x regularity), and a second kind if that explains more. Where it misses parts of the best
        partition, or these differ in size, and the parts look more like elements than it explains, all parts are
        elements, however unlike: stones of a wall, say. Where this is doubtful and the picture repeats itself, as
        checked cloth does, its cells may be the elements, and one to three parts that are nearly all there is to see.
        Centres of a single kind are moved together to where the outlines tell the colours apart best.
    turn, growth
        Ranges of the search. When any is used, templates every 15 degrees and factor 1.2 are tried, and the matches
        are refined. Angles and scales are relative to the example. Matching then goes by colours' shares of the light
        instead of colours: shading does not turn with an element. In grey pictures there is only the brightness, so
        elements may come out turned to fit their shading.
    search
        ``literal`` follows the paper: noise between the elements is found too. It takes one example and no turn.

    Returns
    -------
    elements, points
        The strongest first. A centre is where the example's given centre would be. `elements` has those too that are
        cut by the border with their centre outside, `points` has not. The scale of a part is the root of its area over
        the typical one, its angle 0.
    scores
        Correlation with the mean element, at most 1; of parts 0 for forked ones to 1 for ellipses.
    width, height
        The (mean) example's size, pixels.
    similarity
        Shape (h, w, 1): the best correlation at each pixel; enlarged where it was searched at a lower resolution.
    confidence
        In automatic mode how well the elements explain the picture or the parts stand apart, 0 to 1; less where much of
        what changes in the picture lies off them, where it has stripes without ends, where their scores differ, and
        where the picture repeats itself and they do not. Noise has up to 0.4, and there is a warning below 0.5. With
        examples the mean score.

    Raises
    ------
    ValueError
        No element is found, an example is outside the picture or all of one colour, or the picture is too large.

    Examples
    --------
    >>> from graphtex_nodes import textons
    >>> made = textons(width=120, height=120, size=20.0, rng=1)
    >>> found = find_textons(made.image)
    >>> bool(np.hypot(*(found.points - made.centres[0]).T).min() < 2)
    True
    """
    from graphtex_nodes.splicing._automatic import as_parts, choose
    from graphtex_nodes.splicing._detection import Search
    from graphtex_nodes.splicing._doubts import DOUBTFUL
    from graphtex_nodes.splicing._partitions import even_and_small
    from graphtex_nodes.splicing._peaks import score_floor

    if search == "literal":
        return _literal(image, examples, turn, growth, radius, ctx)
    for index, example in enumerate(examples):
        check_inside(example, image.shape, f"examples[{index}]")
    sought = Search(image, turn, growth, radius, ctx)
    given, confidence = list(examples), -1.0
    if given:
        found = sought.detect(given)
        floor = score_floor(found.poses.scores)
        even = even_and_small(image)
        ctx.check()
        parted = None if sought.turned else as_parts(even, sought, given, found)
        if parted is not None:
            found, floor = parted.found, parted.floor
    else:
        choice = choose(image, sought)
        if choice is None:
            raise ValueError(
                f"image: expected alike elements, or one alone, found none in {image.shape[1]} x {image.shape[0]} "
                f"pixels; give one in examples"
            )
        given, found, floor, confidence = choice.examples, choice.found, choice.floor, choice.confidence
        if confidence < DOUBTFUL:
            ctx.warn(
                f"confidence {confidence:.2f}: these may not be the elements; if they are not, give one in "
                f"examples: x and y of its centre, width and height, in pixels"
            )
    poses = found.poses.take(found.poses.scores >= (floor if least_score is None else least_score))
    if not len(poses.points):
        raise ValueError(f"least_score: expected at least one element, got none with a score of {least_score}")
    elements = Elements(poses.points, poses.angles, poses.scales)
    width, height = mean_size(given)
    if examples:
        _tell_hardly_shown(even.picture, even.step, elements, width, height, ctx)
    last = np.array(image.shape[1::-1]) - 1
    within = ((poses.points >= 0) & (poses.points <= last)).all(axis=1)
    return Textons(
        elements, poses.points[within], poses.scores.astype(np.float64), width, height,
        _enlarged(found.similarity, found.step, image.shape[:2]),
        float(poses.scores.mean()) if confidence < 0 else confidence,
    )  # fmt: skip


def _tell_hardly_shown(
    image: Array, step: float, elements: Elements, width: float, height: float, ctx: Context
) -> None:  # fmt: skip
    """Warn where what looks like the given elements is little of what a picture, every `step`-th pixel of it, shows."""
    from graphtex_nodes.splicing._doubts import hardly_shown

    share = hardly_shown(image, elements._replace(points=elements.points / step), width / step, height / step)
    if share is not None:
        count = len(elements.points)
        ctx.warn(
            f"examples: {count} found, which {'have' if count > 1 else 'has'} {share:.0%} of what changes in the "
            f"picture: are they whole elements? give x and y of one's centre, and its whole width and height, in pixels"
        )


def _literal(image: Array, examples: list[Example], turn: float, growth: float, radius: float, ctx: Context) -> Textons:
    """The search as the paper has it."""
    from graphtex_nodes.splicing._peaks import cover, local_maxima, suppress
    from graphtex_nodes.splicing.appearance_vectors import appearance_vectors
    from graphtex_nodes.splicing.self_similarity import self_similarity

    if len(examples) != 1 or turn > 0 or growth > 1:
        raise ValueError(
            f"search: literal expects one example, turn 0 and growth 1, got {len(examples)} examples, turn {turn:g} "
            f"and growth {growth:g}"
        )
    one = examples[0]
    similarity = self_similarity(
        appearance_vectors(image).appearance, x=one.x, y=one.y, width=one.width, height=one.height, measure="literal",
        ctx=ctx,
    )  # fmt: skip
    points, scores = local_maxima(similarity[..., 0].astype(np.float64), 1)
    size = np.array([one.width, one.height])
    kept = suppress(points, np.tile(size, (len(points), 1)), np.zeros(len(points)), radius)
    points, scores = points[kept], scores[kept]
    count = cover(points, similarity.shape[:2], radius * size, COVERED)
    points, scores = points[:count], scores[:count]
    elements = Elements(points, np.zeros(count), np.ones(count))
    return Textons(elements, points, scores, one.width, one.height, similarity, float(scores.mean()))


def _enlarged(similarity: Array, step: float, shape: tuple[int, ...]) -> Array:
    """Similarity (h, w, 1) at all pixels, of one at every `step`-th."""
    from scipy.ndimage import map_coordinates

    if step > 1:
        grid = np.meshgrid(*(np.arange(side) / step for side in shape), indexing="ij")
        similarity = map_coordinates(similarity, grid, order=1, mode="nearest")
    return similarity[..., None].astype(np.float32)
