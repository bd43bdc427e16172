"""Pictures of a plane moved over that plane: elements keep their true size, so they get larger as they come nearer."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

ORDER: Final = 5
"""Degree of the splines between pixels: cubic ones take off so much fine contrast that texture looks coarser."""


@dataclass(frozen=True)
class Slope:
    r"""How the texel scale of a plane changes around a place of its picture.

    With scale :math:`S = 1 + d\,(row - row_0) + r\,(column - column_0)`, the coordinates

    .. math:: v = (row - row_0) / S,\quad u = (column - column_0) / S

    are those of the plane itself but for an affine map: what is moved over the plane is shifted in (v, u), whatever
    slant and view are. The vanishing line, S = 0, fixes everything that is needed.

    Attributes
    ----------
    row, column
        The place, where S is 1.
    down, right
        d and r, relative change of scale for each pixel.
    """

    row: float
    column: float
    down: float = 0.0
    right: float = 0.0

    @property
    def flat(self) -> bool:
        """Whether the scale is the same everywhere: moves are then plain shifts."""
        return self.down == 0 and self.right == 0

    def scale(self, rows: Array, columns: Array) -> Array:
        """Scale relative to that at the place."""
        result: Array = 1 + self.down * (rows - self.row) + self.right * (columns - self.column)
        return result

    def to_plane(self, rows: Array, columns: Array) -> tuple[Array, Array]:
        """Plane coordinates v, u; infinite or beyond on the far side of the vanishing line."""
        scale = self.scale(rows, columns)
        return (rows - self.row) / scale, (columns - self.column) / scale

    def to_picture(self, v: Array, u: Array) -> tuple[Array, Array]:
        """Rows and columns of plane coordinates: the inverse of `to_plane`."""
        scale = 1 / (1 - self.down * v - self.right * u)
        return self.row + v * scale, self.column + u * scale

    def halved(self, times: int) -> "Slope":
        """The same in the picture of half the size, each of whose pixels is made of two by two of this."""
        factor = 2.0**times
        row, column = ((place + 0.5) / factor - 0.5 for place in (self.row, self.column))
        return Slope(row, column, self.down * factor, self.right * factor)


@dataclass(frozen=True)
class Move:
    """A shift over the plane: what is at (v, u) is taken from (v + down, u + right)."""

    slope: Slope
    down: float
    right: float

    @property
    def plain(self) -> bool:
        """Whether it is a shift by whole pixels of the picture."""
        return self.slope.flat and self.down % 1 == self.right % 1 == 0

    def sources(self, rows: Array, columns: Array) -> tuple[Array, Array, Array]:
        """Row and column that pixels are taken from, and how many times as large as there they are shown.

        Where the source would lie beyond the vanishing line, rows and columns are -1.
        """
        if self.slope.flat:
            return rows + self.down, columns + self.right, np.ones(rows.shape)
        v, u = self.slope.to_plane(rows, columns)
        there = 1 - self.slope.down * (v + self.down) - self.slope.right * (u + self.right)
        seen = there > 1e-3
        v, u = np.where(seen, v + self.down, 0), np.where(seen, u + self.right, 0)
        source_rows, source_columns = self.slope.to_picture(v, u)
        enlarged = self.slope.scale(rows, columns) * np.where(seen, there, 1)
        return np.where(seen, source_rows, -1), np.where(seen, source_columns, -1), enlarged

    def halved(self, times: int) -> "Move":
        """The same move in the picture of half the size; a negative number doubles it."""
        return Move(self.slope.halved(times), self.down / 2**times, self.right / 2**times) if times else self


@dataclass(frozen=True)
class Views:
    """A picture as it can be looked up between pixels.

    ``colours`` (h, w, c) are its own, ``splines`` (h, w, c) their coefficients, ``usable`` (h, w) what may be copied.
    """

    colours: Array
    splines: Array
    usable: Array

    @staticmethod
    def of(colours: Array, usable: Array) -> "Views":
        """The usable part of a picture; the rest may hold anything finite."""
        from scipy.ndimage import distance_transform_edt, spline_filter

        if not usable.all():  # splines ring: what may not be read must not be far from what is beside it
            rows, columns = distance_transform_edt(~usable, return_distances=False, return_indices=True)
            colours = colours[rows, columns]
        splines = [
            spline_filter(channel, order=ORDER, output=np.float32, mode="mirror")
            for channel in np.moveaxis(colours, -1, 0)
        ]
        return Views(colours, np.stack(splines, axis=-1), usable)

    def moved(self, move: Move, rows: Array, columns: Array) -> tuple[Array, Array, Array]:
        """Colours (n, c), which of them are usable (n,), and how much they are enlarged (n,), at some pixels."""
        from graphtex_nodes.numerics.spline_kernels import look_up

        source_rows, source_columns, enlarged = move.sources(rows, columns)
        height, width = self.usable.shape
        inside = (
            (source_rows >= 0) & (source_columns >= 0) & (source_rows <= height - 1) & (source_columns <= width - 1)
        )
        source_rows, source_columns = np.where(inside, source_rows, 0.0), np.where(inside, source_columns, 0.0)
        if move.plain:
            at = source_rows.astype(np.intp), source_columns.astype(np.intp)
            return self.colours[at], inside & self.usable[at], enlarged
        usable = inside.copy()
        for corner_row in (np.floor(source_rows), np.ceil(source_rows)):
            for corner_column in (np.floor(source_columns), np.ceil(source_columns)):
                usable &= self.usable[corner_row.astype(np.intp), corner_column.astype(np.intp)]
        colours = np.empty((source_rows.size, self.colours.shape[2]), np.float32)
        look_up(self.splines, source_rows, source_columns, colours)
        return colours, usable, enlarged

    def looked_up(self, moves: Sequence[Move], labels: Array, rows: Array, columns: Array) -> tuple[Array, Array]:
        """Colours (n, c) and whether usable (n,) of pixels that are taken by the moves of their labels (n,)."""
        colours = np.zeros((labels.size, self.colours.shape[2]), np.float32)
        usable = np.zeros(labels.size, bool)
        for label, move in enumerate(moves):
            at = np.flatnonzero(labels == label)
            if at.size:
                colours[at], usable[at], _ = self.moved(move, rows[at], columns[at])
        return colours, usable
