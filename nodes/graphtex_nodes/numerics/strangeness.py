"""How strange to its surroundings a hole would look with what a move brings there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.move_search import Level
from graphtex_nodes.numerics.parallel import Work, for_each
from graphtex_nodes.numerics.plane_moves import Move

Array = NDArray[Any]

STRANGE = 0.4
"""Cost of a pixel whose look is one standard deviation of the picture from all that is near. Twice as much keeps even
more lone objects out, but takes elements of another colour from paving and cuts those at the border in two."""
AWAY = 0.5
"""Standard deviations that a look is the less alike which is as far away as the hole is wide."""
SMOOTH = 3.0
"""Standard deviation in pixels of the weights with which colours around a place are averaged."""
MOST = 96
"""Places around the hole with which its pixels are compared."""


@dataclass(frozen=True)
class Strangeness:
    """Costs (k, h, w) of what each move brings to a hole, in a picture that was halved so many times."""

    costs: Array
    halved: int = 0

    @staticmethod
    def of(level: Level, moves: Sequence[Move], spread: float, work: Work) -> "Strangeness":
        """Compare the sources of a level's hole with what is known around it; pixels elsewhere cost nothing.

        Seams tell only that pieces agree where they meet. An object that lies within one piece meets nothing, and where
        two regions border on each other either could fill all of the hole. So the local mean colour and contrast of a
        source are compared with those of places around the hole, in units of ``spread``: the most alike counts, the
        less the farther it is from the pixel. Their mean would ask for what lies between two regions and is nowhere.
        """
        known = ~level.hole
        result = np.zeros((len(moves), *known.shape), np.float32)
        ring = np.argwhere(level.region & known)
        if not len(ring):
            return Strangeness(result)
        ring = ring[:: -(-len(ring) // MOST)]
        looks = _looks(level.picture, known) / np.float32(spread)
        around = looks[ring[:, 0], ring[:, 1]]
        rows, columns = np.nonzero(level.hole)
        away = np.hypot(rows[:, None] - ring[:, 0], columns[:, None] - ring[:, 1])
        # what is nearest costs nothing: else the middle of a hole could not be filled at all
        away = (AWAY / np.sqrt(rows.size) * (away - away.min(axis=1, keepdims=True))).astype(np.float32)

        def compare(number: int) -> None:
            source_rows, source_columns, _ = moves[number].sources(rows, columns)
            shown = looks[_nearest(source_rows, known.shape[0]), _nearest(source_columns, known.shape[1])]
            squares = np.zeros(away.shape, np.float32)
            for one, others in zip(shown.T, around.T, strict=True):
                squares += (one[:, None] - others) ** 2
            result[number, rows, columns] = STRANGE * (np.sqrt(squares) + away).min(axis=1)

        for_each(compare, len(moves), 10.0 * away.size * looks.shape[2], work)
        return Strangeness(result)

    def finer(self) -> "Strangeness":
        """The same in a picture of twice the size."""
        return replace(self, halved=self.halved + 1)

    def of_moves(self, numbers: Array) -> "Strangeness":
        """That of some of the moves."""
        return replace(self, costs=self.costs[numbers])

    def at(self, number: int, rows: Array, columns: Array) -> Array:
        """Costs (n,) of a move at some pixels."""
        result: Array = self.costs[number, rows >> self.halved, columns >> self.halved]
        return result


def _nearest(places: Array, side: int) -> Array:
    """The pixels nearest to places along a side; those outside are given its ends, and not usable anyway."""
    return np.rint(places).clip(0, side - 1).astype(np.intp)


def _looks(picture: Array, known: Array) -> Array:
    """Local mean colour and contrast (h, w, c + 1) of a picture where it is known."""
    from scipy.ndimage import gaussian_filter

    share = np.maximum(gaussian_filter(known.astype(np.float64), SMOOTH), 1e-6)[..., None]
    seen = np.where(known[..., None], picture, 0).astype(np.float64)
    mean, square = (gaussian_filter(each, (SMOOTH, SMOOTH, 0)) / share for each in (seen, seen**2))
    contrast = np.sqrt(np.maximum(square - mean**2, 0).sum(axis=2, keepdims=True))
    return np.concatenate([mean, contrast], axis=2).astype(np.float32)
