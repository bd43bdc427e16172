"""From a node's sockets to a problem: sizes, the scale channel and its weight, what may be used and what is known."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import guidance
from graphtex_nodes.numerics.atlas import Atlas, original
from graphtex_nodes.numerics.materials import MapKind, map_slices
from graphtex_nodes.numerics.parallel import Work
from graphtex_nodes.numerics.problem import Array, Flags, Problem

DOUBTFUL = 0.5
"""Trust in a map of scales below which a warning tells that it counts less."""
MISSING_WORTH_TELLING = 0.01
"""Share of the output below which a lacking scale is not worth a warning."""


@dataclass(frozen=True)
class Scales:
    """The scale channel: maps of the exemplar and of the output, their weight, and whether the output's is held.

    If the exemplar is a sheet of several and of copies, ``parts`` are those which it was made from. Warnings call the
    exemplar's map by its ``name`` and tell what provides ``more`` scales, if something does.
    """

    exemplar: Array | None
    target: Array | None
    weight: float
    hold: bool
    parts: Sequence[Atlas] = ()
    name: str = "exemplar_scale"
    more: str = "; resample makes copies of other sizes"


@dataclass(frozen=True)
class Directions:
    """The channels of direction: angles of the exemplar and of the output (degrees), and their weight.

    Without a target or a weight they say nothing; without ``arrows`` opposite directions are alike.
    """

    exemplar: Array | None
    target: Array | None
    weight: float
    arrows: bool


Maps = Sequence[NDArray[Any] | None]


def require_moderate(name: str, picture: Array) -> None:
    """Raise ValueError for numbers whose squares single precision cannot hold or tell from 0."""
    most = float(np.abs(picture).max())
    if most > 1e15 or 0 < most < 1e-15:
        raise ValueError(f"{name}: expected the largest number, unless all are 0, from 1e-15 to 1e15, got {most:.3g}")


def gathered(pictures: Sequence[Array], scale: Maps | None, usable: Maps, angle: Maps | None) -> list[Atlas]:
    """The exemplars with what is known of each: maps of the first one and of further ones; None = nothing counts.

    Without masks of further exemplars all of them is usable, without their directions they point to the right.

    Raises
    ------
    ValueError
        If numbers, sizes or channels disagree, numbers are too large or small, or nothing of an exemplar is usable.
    """
    for number, picture in enumerate(pictures):
        require_moderate(_name("exemplar", number), picture)
        if picture.shape[2] != pictures[0].shape[2]:
            wanted = f"{pictures[0].shape[2]} channels as exemplar has"
            raise ValueError(f"{_name('exemplar', number)}: expected {wanted}, got shape {picture.shape}")
    scales = _completed("scale", scale, pictures, None)
    masks = _completed("usable", usable, pictures, np.True_)
    angles = _completed("angle", angle, pictures, np.float32(0))
    for number, mask in enumerate(masks):
        if mask is not None and not mask.any():
            raise ValueError(f"{_name('usable', number)}: expected at least one True pixel, got none in {mask.shape}")
    return [original(*parts) for parts in zip(pictures, scales, masks, angles, range(len(pictures)), strict=True)]


def _completed(kind: str, maps: Maps | None, pictures: Sequence[Array], blank: Any) -> Maps:
    """A map for each exemplar, ``blank`` where none is given and there may be none; or None for each."""
    if maps is None or (kind != "angle" and all(values is None for values in maps)):
        return [None] * len(pictures)
    if len(maps) == 1 and blank is not None:
        maps = [*maps, *[None] * (len(pictures) - 1)]
    if len(maps) != len(pictures):
        expected = f"one for each of {len(pictures) - 1} further exemplars"
        raise ValueError(f"more_{kind}: expected {expected}, got {len(maps) - 1}")
    result = []
    for number, (values, picture) in enumerate(zip(maps, pictures, strict=True)):
        if values is None and blank is None:
            raise ValueError(f"{_name(kind, number)}: expected a map beside those of further exemplars, got none")
        if values is not None and values.shape != picture.shape[:2]:
            wanted = f"the size of its exemplar, {picture.shape[:2]}"
            raise ValueError(f"{_name(kind, number)}: expected {wanted}, got shape {values.shape}")
        result.append(np.full(picture.shape[:2], blank) if values is None else values)
    return result


def _name(kind: str, number: int) -> str:
    """Socket of a kind of map of an exemplar."""
    if number > 0:
        return f"more[{number - 1}]" if kind == "exemplar" else f"more_{kind}[{number - 1}]"
    return {"scale": "exemplar_scale", "angle": "exemplar_angle"}.get(kind, kind)


def channel_weights(weights: Sequence[float], kinds: Sequence[MapKind], channels: int) -> tuple[float, ...]:
    """How much differences in each channel count, from weights of maps (with kinds) or of channels; none = all alike.

    Raises
    ------
    ValueError
        If numbers disagree, or all weights are 0.
    """
    if not weights:
        return ()
    expected = len(kinds) or channels
    if len(weights) != expected or not any(weights):
        what = f"one for each of {expected} {'maps' if kinds else 'channels'}, and not all 0"
        raise ValueError(f"map_weights: expected {what}, got {list(weights)}")
    if not kinds:
        return tuple(weights)
    sizes = [part.stop - part.start for part in map_slices(kinds)]
    return tuple(weight for weight, size in zip(weights, sizes, strict=True) for _ in range(size))


def pose(
    exemplar: Array, size: tuple[int, int], scales: Scales, work: Work, *, directions: Directions | None = None,
    usable: Flags | None = None, start: Array | None = None, known: Flags | None = None,
    wrap: tuple[bool, bool] = (False, False), weights: Sequence[float] = (), origin: Array | None = None,
) -> Problem:  # fmt: skip
    """The problem of filling ``size`` with the usable part of the exemplar, guided by what scale and direction tell.

    ``weights`` of the exemplar's channels are those that differences of colour will have; ``origin`` is the problem's.

    Raises
    ------
    ValueError
        If nothing is usable, ``known`` comes without ``start``, or one map of scales without the other.
    """
    usable = None if usable is None or usable.all() else usable
    known = known if known is not None and known.any() else None
    if usable is not None and not usable.any():
        raise ValueError(f"usable: expected at least one True pixel, got none in shape {usable.shape}")
    if start is not None:
        require_moderate("start", start)
    if known is not None and start is None:
        raise ValueError("start: expected a picture beside known, got none")
    chosen = np.ones(exemplar.shape[:2], bool) if usable is None else usable
    if usable is not None:
        exemplar = np.where(usable[..., None], exemplar, exemplar[usable].mean(axis=0)).astype(np.float32)
    asked = np.ones(size, bool) if known is None or known.all() else ~known
    colours = exemplar.reshape(-1, exemplar.shape[2]) if usable is None else exemplar[usable]
    colours = colours * np.array(weights, np.float32) if weights else colours
    guides = []
    if _can_guide(colours, scales, chosen, work):
        if scales.target is None and known is not None:
            raise ValueError("target_scale: expected a map beside known, or scale_weight=0, got none")
        guides.append(_scale_guide(colours, size, scales, chosen, asked, work))
    if directions is not None and directions.target is not None and directions.weight > 0:
        if guides and not scales.hold:
            raise ValueError('scale_mode: expected "fixed" beside target_angle, got "free"')
        guides.append(_direction_guide(colours, size, directions, chosen, asked, work))
    if not guides:
        return Problem(exemplar, size, usable=usable, start=start, known=known, wrap=wrap, origin=origin)
    channels, targets, shares = zip(*guides, strict=True)
    importance = None
    if targets[0] is not None:
        importance = np.zeros(exemplar.shape[:2], np.float32)
        share = np.prod(shares, axis=0)
        importance[chosen] = share / share.mean(dtype=np.float64)
    return Problem(
        exemplar, size, np.dstack(channels), None if targets[0] is None else np.dstack(targets), scales.hold,
        importance, usable=usable, start=start, known=known, wrap=wrap, origin=origin,
    )  # fmt: skip


Guide = tuple[Array, Array | None, Array | None]
"""Channels of the exemplar and of the output, and how much of each chosen pixel of the exemplar is wanted."""


def _scale_guide(
    colours: Array, size: tuple[int, int], scales: Scales, chosen: Flags, asked: Flags, work: Work
) -> Guide:
    assert scales.exemplar is not None
    have = scales.exemplar[chosen]
    planes = [(part.scale, part.usable) for part in scales.parts if part.scale is not None]
    trust = guidance.trust(scales.exemplar, chosen, planes)
    if trust < DOUBTFUL:
        work.warn(
            f"{scales.name} varies by {float(np.std(np.log(have), dtype=np.float64)):.0%} only, and not like a plane: "
            f"it is taken for noise and followed with {trust:.2g} of the weight (a larger scale_weight makes up for it)"
        )
    factor = np.float32(guidance.scale_factor(colours, have, scales.weight * trust))
    guide = np.where(chosen, scales.exemplar, have.mean()).astype(np.float32) * factor
    if scales.target is None:
        return guide, None, None
    target = guidance.resampled(scales.target, size)
    missing = guidance.missing_share(have, target[asked])
    if missing > MISSING_WORTH_TELLING:
        work.warn(
            f"{missing:.0%} of the output asks for scales that the exemplar lacks (it has "
            f"{have.min():.2g} to {have.max():.2g}): the nearest are used there{scales.more}"
        )
        target = np.clip(target, have.min(), have.max())
    share = guidance.importance(have, target[asked])
    return guide, target * factor, 1 + np.float32(trust) * (share - 1)  # noise must not leave parts unused


def _direction_guide(
    colours: Array, size: tuple[int, int], directions: Directions, chosen: Flags, asked: Flags, work: Work
) -> Guide:
    assert directions.exemplar is not None
    assert directions.target is not None
    channels, target = (
        guidance.direction_channels(angles, directions.arrows) for angles in (directions.exemplar, directions.target)
    )
    target = np.dstack([guidance.resampled(channel, size) for channel in np.moveaxis(target, -1, 0)])
    target /= np.maximum(np.hypot(target[..., :1], target[..., 1:]), np.float32(1e-3))
    share, missing = guidance.direction_importance(channels[chosen], target[asked])
    if missing > MISSING_WORTH_TELLING:
        work.warn(
            f"{missing:.0%} of the output asks for directions that the exemplar and its turned copies lack: the "
            "nearest are used there"
        )
    factor = np.float32(directions.weight) * np.sqrt(np.var(colours, axis=0, dtype=np.float64).sum()).astype(np.float32)
    factor = factor if factor > 0 else np.float32(directions.weight)
    return np.where(chosen[..., None], channels, 0).astype(np.float32) * factor, target * factor, share


def _can_guide(colours: Array, scales: Scales, chosen: Flags, work: Work) -> bool:
    """Whether there are maps of scale that say something; a warning if not, where it was asked for."""
    if scales.weight == 0:
        return False
    if scales.exemplar is None:
        if scales.target is not None:
            raise ValueError("exemplar_scale: expected a map beside target_scale (or scale_weight=0), got none")
        return False
    if scales.target is None and scales.hold:
        raise ValueError('target_scale: expected a map beside exemplar_scale (or scale_mode="free"), got none')
    if guidance.scale_factor(colours, scales.exemplar[chosen], scales.weight) > 0:
        return True
    work.warn(f"{scales.name} is the same everywhere: it cannot guide, the synthesis is plain{scales.more}")
    return False
