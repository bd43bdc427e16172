"""The last step of a synthesis: where copied pieces meet."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import membrane, seam_kernels
from graphtex_nodes.numerics.materials import bending
from graphtex_nodes.numerics.parallel import Work, for_rows
from graphtex_nodes.numerics.problem import Problem, Result
from graphtex_nodes.numerics.recut import Costs, recut
from graphtex_nodes.numerics.seam_kernels import RADIUS
from graphtex_nodes.numerics.seam_neighbours import Contrast
from graphtex_nodes.numerics.structure import outlined

Array = NDArray[np.float32]
Field = NDArray[np.int32]

PULL, JOIN, BUSY = (0.15, 0.015), (0.03, 0.1), 0.3
"""See :class:`Costs`; the latter two in units of the exemplar's variance. The first of each pair is the rule. The
second is for guided synthesis of elements with outlines: where scales change, the wanted image is a mean of elements
that do not fit each other, while grain and ripples have a mean that does."""
GUIDE_PULL = 1.0
PASSES = 10


@dataclass(frozen=True)
class Steps:
    """What :func:`finish` does, in this order.

    Attributes
    ----------
    cut
        Cut pieces anew, so that large ones take over the scraps between them.
    passes
        Move seams to where they show less, two pixels in each pass at most.
    fade
        Let pieces fade into each other, and bend them to meet known pixels and each other there.
    level
        Bend faded pieces to meet each other where nothing is known.
    bends
        Which channels (c,) are bent to meet each other, see :func:`materials.bending`.
    """

    cut: bool = True
    passes: int = PASSES
    fade: bool = True
    level: bool = True
    bends: NDArray[np.uint8] | None = None


def finish(problem: Problem, result: Result, steps: Steps, work: Work) -> tuple[Array, Field]:
    """Image (h, w, c) and source (h, w, 2) of a synthesis whose seams show as little as ``steps`` can do.

    Known pixels are those of the start and have negative sources.
    """
    colours = problem.exemplar.shape[2]
    exemplar = np.ascontiguousarray(problem.channels)
    usable = np.ascontiguousarray(problem.may).view(np.uint8)
    contrast = Contrast.of([problem.exemplar], problem.usable)
    # an output that wraps around sees the other side as far as a seam can move
    reach = [(2 * PASSES + 2 * RADIUS) * around for around in problem.wrap]
    inside = tuple(slice(more, more + side) for side, more in zip(problem.size, reach, strict=True))

    def around(values: NDArray[Any]) -> NDArray[Any]:
        for axis, (side, more) in enumerate(zip(problem.size, reach, strict=True)):
            values = values.take(np.arange(-more, side + more) % side, axis) if more else values
        return values

    share = 0.0 if problem.guide is None else outlined(problem.exemplar, problem.usable)
    pull, join = (float(first ** (1 - share) * second**share) for first, second in (PULL, JOIN))
    pulls = np.where(np.arange(exemplar.shape[2]) < colours, pull, GUIDE_PULL).astype(np.float32)
    costs = Costs(pulls, join * contrast.variance, BUSY * contrast.variance)
    source = result.source
    if steps.cut:
        source = recut(exemplar, usable, result.image, source, costs, work, problem.wrap)
    if steps.passes:
        moved = move_seams(exemplar, usable, around(result.image), around(source), costs, steps.passes, work)
        source = moved[inside]
    source = np.ascontiguousarray(source)
    if not steps.fade:
        return _with_known(problem, problem.exemplar[source[..., 0], source[..., 1]]), source
    bent = steps.level or problem.known is not None
    image, own = fade_seams(
        exemplar, usable, around(source), channels=colours, work=work, differences=bent, sharpness=contrast.sharpness
    )
    image = _with_known(problem, np.ascontiguousarray(image[inside]))
    if bent:
        own = np.ascontiguousarray(own[:, inside[0], inside[1]])
        image = _bent(problem, image, own, source, contrast, steps.bends, work)
    return image, source


def _with_known(problem: Problem, image: Array) -> Array:
    """The image (h, w, c) with its known pixels."""
    if problem.known is not None and problem.start is not None:
        image[problem.known] = problem.start[problem.known]
    return image


def _bent(
    problem: Problem, image: Array, own: Array, source: Field, contrast: Contrast,
    bends: NDArray[np.uint8] | None, work: Work,
) -> Array:  # fmt: skip
    """The image (h, w, c) of faded pieces, bent to meet each other and what is known.

    ``own`` are the pieces' own differences (2, h, w, c); those beside known pixels are overwritten.
    """
    known = problem.known
    if known is not None:
        for axis, steps in enumerate(own):
            beside = known | np.roll(known, -1, axis)
            steps[beside] = (np.roll(image, -1, axis) - image)[beside]
    bends = bending([], image.shape[2]) if bends is None else bends
    lack = membrane.missing(image, own, contrast.variance, bends, problem.wrap, work)
    if known is not None:
        return membrane.join_known(image, lack, source, problem.exemplar, problem.may, bends, problem.wrap, work)
    membrane.level(image, lack, contrast.limits, contrast.reach, problem.wrap, work)
    return image


def move_seams(
    exemplar: Array, usable: NDArray[np.uint8], image: Array, source: Field, costs: Costs, passes: int, work: Work
) -> Field:
    """Source map (h, w, 2) whose seams have moved to where the pieces agree.

    Parameters
    ----------
    exemplar
        Shape (h, w, c); ``usable`` (h, w) is 0 where a pixel must not be copied.
    image
        What the output should look like, with the exemplar's channels.
    passes
        A seam moves at most two pixels in a pass.

    Where ``source`` is negative, pixels are known: they stay, and pieces beside them pay for how their continuation
    differs from ``image`` there.
    """
    source, image = source.copy(), np.ascontiguousarray(image)
    weights = costs.pull, np.float32(costs.join), np.float32(costs.busy)
    changed = seam_pixels(source, work)
    for _ in range(passes):
        for parity in (0, 1):

            def band(first: int, stop: int, parity: int = parity) -> None:
                seam_kernels.move_seams(exemplar, usable, image, source, changed, *weights, parity, first, stop)

            for_rows(band, source.shape[0], source.shape[1] * 20, work)
    return source


def seam_pixels(source: Field, work: Work) -> NDArray[np.uint8]:
    """1 where one of the four neighbours belongs to another piece (h, w)."""
    flags = np.empty(source.shape[:2], np.uint8)

    def band(first: int, stop: int) -> None:
        seam_kernels.mark_seams(source, flags, first, stop)

    for_rows(band, source.shape[0], 5.0 * source.shape[1], work)
    return flags


def fade_seams(
    exemplar: Array,
    usable: NDArray[np.uint8],
    source: Field,
    *,
    channels: int,
    work: Work,
    differences: bool = True,
    sharpness: float = 0.0,
) -> tuple[Array, Array]:
    """Image (h, w, channels) of a source map in which pieces fade into each other over about :data:`RADIUS` pixels.

    The less the more they differ, see :attr:`Contrast.sharpness`. Pixels farther than that from a seam are the
    exemplar's own. Known pixels (negative source) are 0. The second array (2, h, w, channels) are the pieces' own
    differences to the pixels below and to the right, faded in the same way; it is empty if no ``differences`` are
    wanted.
    """
    place = np.arange(-RADIUS, RADIUS + 1) / RADIUS
    line = np.exp(-2 * place**2)
    falloff = np.outer(line, line).astype(np.float32)
    colours = np.ascontiguousarray(exemplar[..., :channels]).reshape(len(exemplar), -1)
    image = np.empty((*source.shape[:2], channels), np.float32)
    steps = np.empty((2 * differences, *image.shape), np.float32)
    lines, step_lines = image.reshape(len(image), -1), steps.reshape(len(steps), len(image), image.shape[1] * channels)
    seams, sharp = seam_pixels(source, work), np.float32(sharpness)

    def band(first: int, stop: int) -> None:
        seam_kernels.fade_seams(colours, usable, source, seams, falloff, sharp, lines, step_lines, first, stop)

    for_rows(band, source.shape[0], source.shape[1] * falloff.size * (3 + channels) / 5, work)
    return image, steps
