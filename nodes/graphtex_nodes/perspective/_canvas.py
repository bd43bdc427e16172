"""A photo that is being completed, and the two ways in which a part of its hole can be filled."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics import hole_pieces, levels, seams
from graphtex_nodes.numerics.move_search import Level
from graphtex_nodes.numerics.parallel import Portion, Work
from graphtex_nodes.numerics.plane_moves import Slope
from graphtex_nodes.numerics.problem import Settings
from graphtex_nodes.numerics.request import Scales, pose
from graphtex_nodes.numerics.sources import COLUMN, ROW
from graphtex_nodes.numerics.synthesis import synthesise
from graphtex_nodes.perspective import _hole_scale as hole_scale

Array = NDArray[Any]
Box = tuple[slice, slice]

TELLING = 0.2
"""Spread of log scale from which the scale counts fully."""
LOG = 3
"""Column of a source map: log2 of the resampling."""


@dataclass(frozen=True)
class Canvas:
    """Arrays that are written part by part: ``image`` (h, w, c), source map ``places`` (h, w, 6), ``scales`` (h, w).

    ``hole`` (h, w) are all pixels to fill, ``usable`` (h, w) those that may be copied; ``bends`` (c,) tells which
    channels are bent to meet at seams, see :func:`materials.bending`.
    """

    image: Array
    places: Array
    scales: Array
    hole: Array
    usable: Array
    bends: Array

    def level(self, part: Array, box: Box) -> Level:
        """A box of the picture with the mean colour in place of what is not known."""
        return Level(hole_scale.hidden(self.image[box], self.hole[box]), self.usable[box], part[box])

    def continue_scale(self, box: Box, harmonic: bool, work: Work) -> None:
        """Scales in the part of the hole within a box from those around."""
        self.scales[box] = hole_scale.continued_scale(self.scales[box], self.hole[box], harmonic, work)

    def measure_scale(self, part: Array, box: Box, harmonic: bool, work: Work) -> None:
        """Scales in a box from the picture there."""
        level = self.level(part, box)
        self.scales[box] = hole_scale.measured_scale(level.picture, self.hole[box], harmonic, work)

    def put_pieces(self, part: Array, box: Box, scaled: bool, work: Work) -> Array:
        """Fill a part with pieces; what is left of it (h, w)."""
        halvings, count = hole_pieces.halvings(self.level(part, box))
        slope = hole_scale.slope_of(self.scales[box], part[box]).halved(count)
        slopes, log = [Slope(slope.row, slope.column)], None
        if scaled:
            log = np.log2(self.scales[box][:: 1 << count, :: 1 << count])
            slopes += [] if slope.flat else [slope]
        moves = hole_pieces.choose(halvings[count], slopes, log, Portion(work, 0, 0.2))
        if not moves:
            return part
        found = hole_pieces.fill(halvings, moves, count, self.bends, Portion(work, 0.2, 0.8))
        done = np.argwhere(part)[found.filled]
        rows, columns = done[:, 0], done[:, 1]
        self.image[rows, columns] = found.colours[found.filled]
        corner = np.array([box[0].start, box[1].start])
        self.places[rows, columns, ROW : COLUMN + 1] = found.source[found.filled] + corner
        self.places[rows, columns, LOG] = found.log[found.filled]
        rest = part.copy()
        rest[rows, columns] = False
        return rest

    def put_windows(
        self, part: Array, rest: Array, box: Box, taken: Box, weight: float, plan: tuple[int, Settings],
        rng: np.random.Generator, work: Work,
    ) -> None:  # fmt: skip
        """Fill the rest of a part by texture optimisation, with windows from the box ``taken``."""
        spread = float(np.std(np.log(self.scales[taken][self.usable[taken]]), dtype=np.float64))
        weight = 0.0 if spread < 1e-3 else weight * min(1.0, spread / TELLING)
        known = ~self.hole | (part & ~rest)
        problem = pose(
            self.image[taken], (box[0].stop - box[0].start, box[1].stop - box[1].start),
            Scales(self.scales[taken], self.scales[box], weight, True, name="scale", more=""), work,
            usable=self.usable[taken], start=self.image[box], known=known[box],
        )  # fmt: skip
        iterations, settings = plan
        stages = levels.plan(problem.exemplar, problem.usable, 0, (), iterations)
        result = synthesise(problem, stages, settings, rng, work)
        filled, found = seams.finish(problem, result, seams.Steps(bends=self.bends), work)
        self.image[rest] = filled[rest[box]]
        self.places[rest, ROW : COLUMN + 1] = found[rest[box]] + np.array([taken[0].start, taken[1].start])
