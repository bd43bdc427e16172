"""A plane seen by a pin-hole camera: its texel scale, and the way between picture and plane."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


@dataclass(frozen=True)
class Plane:
    r"""A textured plane in a picture of `width` x `height` pixels.

    The inverse depth of a plane is linear in the picture, and so is its texel scale,

    .. math:: S = S_0 (1 - k\,a),\quad a = x \sin\tau + y \cos\tau,

    with (x, y) measured from the picture's centre ((w - 1)/2, (h - 1)/2), y up. The plane has coordinates of its own:
    *across* u and *along* v the direction in which it recedes, in units that measure one pixel where S = 1:
    u = b / S and v = a / (S cos(slant)), with b the picture's coordinate at right angles to a (a turned clockwise).

    Attributes
    ----------
    tilt
        Direction in which texels shrink: 0 is up, 90 is to the right (degrees, clockwise).
    foreshortening
        cos(slant).
    centre_scale
        S0: scale at the picture's centre. The largest and the smallest scale of the picture multiply to 1.
    steepness
        k: relative loss of scale for each pixel in the direction of the tilt.
    """

    width: int
    height: int
    tilt: float
    foreshortening: float
    centre_scale: float
    steepness: float

    def rotate(self, x: Array, y: Array) -> tuple[Array, Array]:
        """(across, along) of picture coordinates x, y, where x, y are array coordinates (pixel centres, y down)."""
        sin, cos = np.sin(np.radians(self.tilt)), np.cos(np.radians(self.tilt))
        right, up = x - (self.width - 1) / 2, (self.height - 1) / 2 - y
        return right * cos - up * sin, right * sin + up * cos

    def scale_at(self, along: Array) -> Array:
        """Texel scale at a distance `along` the tilt from the picture's centre, in pixels."""
        return self.centre_scale * (1 - self.steepness * along)

    def scale(self) -> Array:
        """Texel scale at all pixels, float64 of shape (height, width)."""
        y, x = np.mgrid[: self.height, : self.width]
        return self.scale_at(self.rotate(x, y)[1])

    def to_plane(self, across: Array, along: Array) -> tuple[Array, Array]:
        """Plane coordinates u, v of picture coordinates as `rotate` gives them."""
        scale = self.scale_at(along)
        return across / scale, along / (scale * self.foreshortening)

    def to_picture(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Array coordinates x, y of plane coordinates: the inverse of `rotate` and `to_plane` together."""
        near = self.centre_scale * v * self.foreshortening
        along = near / (1 + self.steepness * near)
        across = u * self.scale_at(along)
        sin, cos = np.sin(np.radians(self.tilt)), np.cos(np.radians(self.tilt))
        right, up = across * cos + along * sin, along * cos - across * sin
        return right + (self.width - 1) / 2, (self.height - 1) / 2 - up

    def stretch(self, scale: Array) -> tuple[Array, Array]:
        """Plane units across and along that a pixel covers where the texel scale is `scale`: 1/S and S0 / (S² cos)."""
        return 1 / scale, self.centre_scale / (scale**2 * self.foreshortening)


def seen_plane(width: int, height: int, slant: float, tilt: float, field_of_view: float | None) -> Plane:
    """The plane at `slant` and `tilt` (degrees) under a camera whose view spans the picture's longer side.

    Without a field of view (None) the scales reach from 1/cos(slant) to cos(slant), the convention of Dong, Zhou & Paul
    (2008), section 3.2: the camera is then the one whose picture has just these scales at its ends.

    Raises
    ------
    ValueError
        The horizon is in the picture: tan(slant) tan(view / 2) reaches 1 (for the picture's side; the corner of a
        tilted plane is further out and is what counts).
    """
    reach = tilt_reach(width, height, tilt)
    foreshortening = float(np.cos(np.radians(slant)))
    if reach < 1e-9 or slant == 0:  # no depth to vary along, or none to see
        return Plane(width, height, tilt, foreshortening, 1.0, 0.0)
    if field_of_view is None:
        loss = (1 - foreshortening**2) / (1 + foreshortening**2)
    else:
        loss = np.tan(np.radians(slant)) * reach / focal_length(width, height, field_of_view)
        if loss >= 1:
            raise ValueError(
                f"field_of_view: the horizon is in the picture: tan(slant) tan(field_of_view / 2) must stay below 1 "
                f"out to the picture's far corner, got {loss:.3g} for slant {slant:g}, tilt {tilt:g} and field_of_view "
                f"{field_of_view:g}"
            )
    return Plane(width, height, tilt, foreshortening, float(1 / np.sqrt(1 - loss**2)), float(loss / reach))


def slant_of(width: int, height: int, tilt: float, steepness: float, field_of_view: float | None) -> float:
    """Slant (degrees) of the plane that `seen_plane` would give this steepness: its inverse."""
    if field_of_view is None:
        loss = min(steepness * tilt_reach(width, height, tilt), 1.0)
        return float(np.degrees(np.arccos(np.sqrt((1 - loss) / (1 + loss)))))
    return float(np.degrees(np.arctan(steepness * focal_length(width, height, field_of_view))))


def tilt_reach(width: int, height: int, tilt: float) -> float:
    """Pixels from the picture's centre to its far end along the tilt."""
    turn = np.radians(tilt)
    return float((width - 1) / 2 * abs(np.sin(turn)) + (height - 1) / 2 * abs(np.cos(turn)))


def focal_length(width: int, height: int, field_of_view: float) -> float:
    """Distance (pixels) of the camera from the picture, if its view spans the longer side."""
    return float(max(width, height) / 2 / np.tan(np.radians(field_of_view) / 2))


@dataclass(frozen=True)
class Region:
    """A rectangle of the plane on a grid: texel (row, column) is at u0 + column / density, v0 + row / density."""

    u0: float
    v0: float
    rows: int
    columns: int
    density: float

    @property
    def u(self) -> Array:
        """Across coordinate of each column."""
        return self.u0 + np.arange(self.columns) / self.density

    @property
    def v(self) -> Array:
        """Along coordinate of each row."""
        return self.v0 + np.arange(self.rows) / self.density


def photograph(plane: Plane, paint: Callable[[Region], Array], *, oversampling: float = 1.5) -> Array:
    """Picture (height, width, channels) of what `paint` draws on the plane.

    The plane is painted in strips whose scale falls by half, each on a grid as fine as its nearest row needs
    (`oversampling` texels for a pixel), and averaged over each pixel's footprint by summed-area tables: a footprint is
    a box in plane coordinates but for a shear, which two boxes for each pixel, one behind the other, follow.

    `paint` must draw the same plane whatever the region and its density are.
    """
    scale = plane.scale()
    picture: Array | None = None
    y, x = np.mgrid[: plane.height, : plane.width]
    across, along = plane.rotate(x, y)
    nearest = float(scale.max())
    while True:
        strip = (scale <= nearest * (1 + 1e-12)) & (scale > nearest / 2)
        if strip.any():
            colours = _photograph_strip(plane, paint, across[strip], along[strip], oversampling * nearest)
            if picture is None:
                picture = np.zeros((plane.height, plane.width, colours.shape[1]))
            picture[strip] = colours
        nearest /= 2
        if nearest < scale.min():
            break
    assert picture is not None
    return picture


def _photograph_strip(
    plane: Plane, paint: Callable[[Region], Array], across: Array, along: Array, density: float
) -> Array:
    """Colours (n, channels) of the pixels at (across, along), from one grid of the given density."""
    corners = [plane.to_plane(across + dx, along + dy) for dx in (-0.71, 0.71) for dy in (-0.71, 0.71)]
    u = np.array([corner[0] for corner in corners])
    v = np.array([corner[1] for corner in corners])
    margin = 2 / density
    u0, v0 = u.min() - margin, v.min() - margin
    rows = int(np.ceil((v.max() + margin - v0) * density)) + 1
    columns = int(np.ceil((u.max() + margin - u0) * density)) + 1
    texels = paint(Region(u0, v0, rows, columns, density))
    summed = np.zeros((rows + 1, columns + 1, texels.shape[2]))
    np.cumsum(np.cumsum(texels, axis=0, dtype=np.float64), axis=1, out=summed[1:, 1:])
    total = np.zeros((across.size, texels.shape[2]))
    for dy in (-0.25, 0.25):
        u_at, v_at = plane.to_plane(across, along + dy)
        wide, deep = plane.stretch(plane.scale_at(along + dy))
        # half of the pixel's footprint, but never less than a texel: nothing is gained inside one
        half_u, half_v = np.maximum(wide * density, 1) / 2, np.maximum(deep * density / 2, 1) / 2
        column, row = (u_at - u0) * density + 0.5, (v_at - v0) * density + 0.5
        total += _box_means(summed, row - half_v, row + half_v, column - half_u, column + half_u)
    return total / 2


def _box_means(summed: Array, top: Array, bottom: Array, left: Array, right: Array) -> Array:
    """Means over boxes given in texel edges (fractions interpolate the summed-area table linearly, which is exact)."""
    rows, columns = summed.shape[0] - 1, summed.shape[1] - 1
    top, bottom = np.clip(top, 0, rows), np.clip(bottom, 0, rows)
    left, right = np.clip(left, 0, columns), np.clip(right, 0, columns)
    total = _at(summed, bottom, right) - _at(summed, top, right) - _at(summed, bottom, left) + _at(summed, top, left)
    means: Array = total / ((bottom - top) * (right - left))[:, None]
    return means


def _at(table: Array, row: Array, column: Array) -> Array:
    """Bilinear values (n, channels) of a table (rows, columns, channels)."""
    i = np.minimum(row.astype(np.intp), table.shape[0] - 2)
    j = np.minimum(column.astype(np.intp), table.shape[1] - 2)
    down, right = (row - i)[:, None], (column - j)[:, None]
    flat = table.reshape(-1, table.shape[2])
    first = i * table.shape[1] + j
    upper = flat[first] * (1 - right) + flat[first + 1] * right
    lower = flat[first + table.shape[1]] * (1 - right) + flat[first + table.shape[1] + 1] * right
    values: Array = upper * (1 - down) + lower * down
    return values
