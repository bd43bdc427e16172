"""The last step of a synthesis: where copied pieces meet."""

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import seam_kernels
from graphtex_nodes.numerics.parallel import Work, for_rows
from graphtex_nodes.numerics.synthesis import Problem, Result

Array = NDArray[np.float32]
Field = NDArray[np.int32]


PULL, JOIN = 0.2, 0.02
"""Cost of leaving the wanted image, and of a pair of pixels across a seam in units of the exemplar's variance."""
PASSES = 10
RADIUS = 2


def finish(problem: Problem, result: Result, *, fade: bool, work: Work) -> tuple[Array, Field]:
    """Image (h, w, c) and source (h, w, 2) of a synthesis: seams moved, and softened if ``fade``."""
    exemplar = problem.exemplar if problem.guide is None else np.dstack([problem.exemplar, problem.guide])
    usable = np.ones(exemplar.shape[:2], np.uint8)
    channels = problem.exemplar.shape[2]
    variance = float(np.var(problem.exemplar, axis=(0, 1), dtype=np.float64).sum())
    join = JOIN * variance
    source = move_seams(
        exemplar, usable, result.image, result.source, pull=PULL, join=join, passes=PASSES, work=work
    )  # fmt: skip
    if not fade:
        return problem.exemplar[source[..., 0], source[..., 1]], source
    return fade_seams(exemplar, usable, source, radius=RADIUS, channels=channels, work=work), source


def move_seams(
    exemplar: Array, usable: NDArray[np.uint8], image: Array, source: Field, *, pull: float, join: float, passes: int,
    work: Work,
) -> Field:  # fmt: skip
    """Source map (h, w, 2) whose seams have moved to where the pieces agree.

    Parameters
    ----------
    exemplar
        Shape (h, w, c); ``usable`` (h, w) is 0 where a pixel must not be copied.
    image
        What the output should look like, with the exemplar's channels: ``pull`` weighs its squared differences.
    join
        Cost of each pair of neighbouring pixels from different pieces, beside their colour differences.
    passes
        A seam moves at most two pixels in a pass.
    """
    source, image = source.copy(), np.ascontiguousarray(image)
    for _ in range(passes):
        for parity in (0, 1):

            def band(first: int, stop: int, parity: int = parity) -> None:
                seam_kernels.move_seams(
                    exemplar, usable, image, source, np.float32(pull), np.float32(join), parity, first, stop
                )

            for_rows(band, source.shape[0], source.shape[1] * 60, work)
    return source


def fade_seams(
    exemplar: Array, usable: NDArray[np.uint8], source: Field, *, radius: int, channels: int, work: Work
) -> Array:
    """Image (h, w, channels) of a source map in which pieces fade into each other over about ``radius`` pixels.

    Pixels farther than ``radius`` from a seam are the exemplar's own.
    """
    place = np.arange(-radius, radius + 1) / max(1, radius)
    line = np.exp(-2 * place**2)
    falloff = np.outer(line, line).astype(np.float32)
    image = np.empty((*source.shape[:2], channels), np.float32)

    def band(first: int, stop: int) -> None:
        seam_kernels.fade_seams(exemplar, usable, source, falloff, image, first, stop)

    for_rows(band, source.shape[0], source.shape[1] * falloff.size * (3 + channels), work)
    return image
