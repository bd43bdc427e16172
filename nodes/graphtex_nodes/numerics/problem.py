"""What a synthesis is asked for and what it gives."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.pyramid import masked_pyramid, pyramid
from graphtex_nodes.numerics.structure import grain
from graphtex_nodes.numerics.windows import DIRECTIONS

Array = NDArray[np.float32]
Field = NDArray[np.int32]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Settings:
    """How to synthesise.

    Attributes
    ----------
    exponent
        Power r of a window's distance in the energy.
    histogram
        Gain of histogram matching, 0 = none.
    evenness
        How firmly all parts of the exemplar are used as often as wanted: see ``evenness.charge``; 0 = not at all.
    variance
        Share of the windows' variance that principal components keep.
    directions
        Most principal components.
    detail
        How far components of colour are evened, 0 (not at all) to 1 (whitened).
    passes
        PatchMatch passes of an iteration.
    falloff
        How much the middle of a window weighs more than its border: exp(-falloff) at the middle of a side.
    joint
        Whether the guide's channels share principal components with the colours.
    weights
        How much differences in each channel of the exemplar count; none = all alike.
    replay
        Whether levels at the end of the plan that have no iterations just show the pixels behind what was found before
        them. Only for a problem that is plain.
    """

    exponent: float = 0.8
    histogram: float = 20.0
    evenness: float = 2.0
    variance: float = 0.95
    directions: int = DIRECTIONS
    detail: float = 0.3
    passes: int = 2
    falloff: float = 1.0
    joint: bool = False
    weights: tuple[float, ...] = ()
    replay: bool = False


@dataclass(frozen=True)
class Problem:
    """What to synthesise.

    Attributes
    ----------
    exemplar
        Colours (h, w, c).
    size
        Height and width of the output.
    guide
        More channels of the exemplar (h, w, g) such as scale and direction, already weighted, or None.
    target
        The guide for each output pixel, or None: the guide is then synthesised like a colour.
    hold
        Whether the output's guide stays at ``target``; if not, ``target`` only rules the start.
    importance
        How much of each exemplar pixel the output should hold (h, w), mean 1; None = all alike.
    usable
        Exemplar pixels (h, w) that may be copied; None = all. Some must be.
    start
        Colours of the output to start from; with ``known`` only those of known pixels are read. None = random blocks.
    known
        Output pixels that stay as ``start`` has them; None = none.
    wrap
        Whether the output continues over its lower and upper border, and over its right and left one.
    origin
        Index, row and column (h, w, 3) of what each pixel of the exemplar shows, if it holds copies of one picture that
        together should not be used more often than that; else None.
    """

    exemplar: Array
    size: tuple[int, int]
    guide: Array | None = None
    target: Array | None = None
    hold: bool = True
    importance: Array | None = None
    usable: Flags | None = None
    start: Array | None = None
    known: Flags | None = None
    wrap: tuple[bool, bool] = (False, False)
    origin: Array | None = None

    @property
    def led(self) -> bool:
        """Whether a guide stays at a target."""
        return self.hold and self.target is not None

    @property
    def may(self) -> Flags:
        """Which pixels of the exemplar (h, w) may be shown."""
        return np.ones(self.exemplar.shape[:2], bool) if self.usable is None else self.usable

    @property
    def voted(self) -> int:
        """How many channels the vote fills."""
        return int((self.exemplar if self.led else self.channels).shape[2])

    @property
    def channels(self) -> Array:
        """The exemplar with its guide (h, w, c + g)."""
        return self.exemplar if self.guide is None else np.dstack([self.exemplar, self.guide])

    @property
    def plain(self) -> bool:
        """Whether all of the exemplar may be copied, and all of the output is asked for and does not wrap around."""
        return self.usable is None and self.known is None and not any(self.wrap)

    @property
    def free(self) -> bool:
        """Whether nothing but the exemplar rules what is where."""
        return self.target is None and self.start is None and self.known is None

    @property
    def bounded(self) -> bool:
        """Whether all pixels along the output's border are known."""
        known = self.known
        return known is not None and bool(
            known[0].all() and known[-1].all() and known[:, 0].all() and known[:, -1].all()
        )


@dataclass(frozen=True)
class Result:
    """What a synthesis ends with.

    Attributes
    ----------
    image
        Weighted mean of the last vote (h, w, c), with the guide's channel where there is one. After a replay it is as
        small as on the level of that vote.
    source
        Row and column of the exemplar for each pixel, int32 (h, w, 2); negative for known pixels.
    energies
        Mean over windows of (mean squared difference of a pixel) ** (r / 2) at each search, from coarse to fine.
    """

    image: Array
    source: Field
    energies: tuple[float, ...]


@dataclass(frozen=True)
class Given:
    """All that is given, on one level.

    ``grain`` is 1 where the exemplar is grain, and 0 where it has elements with outlines.
    """

    exemplar: Array
    usable: Flags | None
    importance: Array
    target: Array | None
    start: Array | None
    known: Flags | None
    grain: float


def pyramids(problem: Problem, levels: int) -> list[Given]:
    """Pyramids of what the problem gives: only usable and known pixels count where some are not."""
    importance = np.ones(problem.exemplar.shape[:2], np.float32) if problem.importance is None else problem.importance
    nothing: list[None] = [None] * levels
    usable: Sequence[Flags | None] = nothing
    start: Sequence[Array | None] = nothing
    known: Sequence[Flags | None] = nothing
    if problem.usable is None:
        exemplars, importances = pyramid(problem.channels, levels), pyramid(importance, levels)
    else:
        exemplars, usable = masked_pyramid(problem.channels, problem.usable, levels)
        importances = [
            values * mask
            for values, mask in zip(masked_pyramid(importance, problem.usable, levels)[0], usable, strict=True)
        ]
    if problem.start is not None and problem.known is not None:
        start, known = masked_pyramid(problem.start, problem.known, levels)
    elif problem.start is not None:
        start = pyramid(problem.start, levels)
    targets = nothing if problem.target is None else pyramid(problem.target, levels)
    # noise of single pixels may hide outlines
    first = min(1, levels - 1)
    grains = [grain(exemplars[first][..., : problem.exemplar.shape[2]], usable[first])] * levels
    given = zip(exemplars, usable, importances, targets, start, known, grains, strict=True)
    return [Given(*level) for level in given]
