"""From a node's sockets to a problem: sizes, the scale channel and its weight, what may be used and what is known."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import guidance
from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.problem import Array, Flags, Problem

MISSING_WORTH_TELLING = 0.01
"""Share of the output below which a lacking scale is not worth a warning."""


@dataclass(frozen=True)
class Scales:
    """The scale channel: maps of the exemplar and of the output, their weight, and whether the output's is held."""

    exemplar: Array | None
    target: Array | None
    weight: float
    hold: bool


def pose(
    exemplar: Array, size: tuple[int, int], scales: Scales, work: Work, *, usable: Flags | None = None,
    start: Array | None = None, known: Flags | None = None, wrap: tuple[bool, bool] = (False, False),
) -> Problem:  # fmt: skip
    """The problem of filling ``size`` with the usable part of the exemplar, guided by its scale where that can guide.

    Raises
    ------
    ValueError
        If nothing is usable, ``known`` comes without ``start``, or one map of scales without the other.
    """
    usable = None if usable is None or usable.all() else usable
    known = known if known is not None and known.any() else None
    if usable is not None and not usable.any():
        raise ValueError(f"usable: expected at least one True pixel, got none in shape {usable.shape}")
    if known is not None and start is None:
        raise ValueError("start: expected a picture beside known, got none")
    chosen = np.ones(exemplar.shape[:2], bool) if usable is None else usable
    if usable is not None:
        exemplar = np.where(usable[..., None], exemplar, exemplar[usable].mean(axis=0)).astype(np.float32)
    plain = Problem(exemplar, size, usable=usable, start=start, known=known, wrap=wrap)
    if not _can_guide(exemplar, scales, chosen, work):
        return plain
    assert scales.exemplar is not None
    factor = np.float32(guidance.scale_factor(exemplar[chosen], scales.exemplar[chosen], scales.weight))
    guide = np.where(chosen, scales.exemplar, scales.exemplar[chosen].mean()).astype(np.float32) * factor
    if scales.target is None:
        if known is not None:
            raise ValueError("target_scale: expected a map beside known, or scale_weight=0, got none")
        return Problem(exemplar, size, guide, usable=usable, start=start, wrap=wrap)
    have = scales.exemplar[chosen]
    target = guidance.resampled(scales.target, size)
    asked = target if known is None or known.all() else target[~known]
    missing = guidance.missing_share(have, asked)
    if missing > MISSING_WORTH_TELLING:
        work.warn(
            f"{missing:.0%} of the output asks for scales that the exemplar lacks (it has "
            f"{have.min():.2g} to {have.max():.2g}): the nearest are used there"
        )
        target, asked = (np.clip(part, have.min(), have.max()) for part in (target, asked))
    importance = np.zeros(exemplar.shape[:2], np.float32)
    importance[chosen] = guidance.importance(have, asked)
    return Problem(
        exemplar, size, guide, target * factor, scales.hold, importance, usable=usable, start=start, known=known,
        wrap=wrap,
    )  # fmt: skip


def _can_guide(exemplar: Array, scales: Scales, chosen: NDArray[np.bool_], work: Work) -> bool:
    """Whether there are maps of scale that say something; a warning if not, where it was asked for."""
    if scales.weight == 0:
        return False
    if scales.exemplar is None:
        if scales.target is not None:
            raise ValueError("exemplar_scale: expected a map beside target_scale (or scale_weight=0), got none")
        return False
    if scales.target is None and scales.hold:
        raise ValueError('target_scale: expected a map beside exemplar_scale (or scale_mode="free"), got none')
    if guidance.scale_factor(exemplar[chosen], scales.exemplar[chosen], scales.weight) > 0:
        return True
    work.warn("exemplar_scale is the same everywhere: it cannot guide, the synthesis is plain")
    return False
