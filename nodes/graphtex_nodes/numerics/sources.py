"""Source maps: which point of which exemplar each output pixel shows, what that looks like, and what it tells.

The exemplar is shown mirrored (right to left), then turned (degrees, clockwise), then enlarged by 2 to the power of the
logarithm.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.materials import MapKind, renormalised, turn, turn_normals

Array = NDArray[np.float32]

INDEX, ROW, COLUMN, LOG, ANGLE, MIRRORED = range(6)
"""Columns of a source map."""


def source_map(source: NDArray[np.integer]) -> Array:
    """Source map (h, w, 6) of plain copies from one exemplar, from rows and columns (h, w, 2)."""
    result = np.zeros((*source.shape[:2], 6), np.float32)
    result[..., ROW : COLUMN + 1] = source
    return result


def own_places(shape: tuple[int, ...]) -> Array:
    """Source map (h, w, 6) of a picture that nothing was done to."""
    return source_map(np.moveaxis(np.indices(shape), 0, -1))


def continued(source: Array, down: Any, right: Any) -> NDArray[np.float64]:
    """Rows and columns (..., 2) in the exemplars of what lies ``down`` and ``right`` of shown pixels (..., 6)."""
    angles, place = np.unique(source[..., ANGLE], return_inverse=True)
    turns = np.array([turn(float(angle)) for angle in angles]).reshape(-1, 2)[place.reshape(source.shape[:-1])]
    cos, sin = turns[..., 0], turns[..., 1]
    size = np.exp2(-source[..., LOG].astype(np.float64))
    rows = source[..., ROW] + size * (down * cos - right * sin)
    columns = source[..., COLUMN] + size * (right * cos + down * sin) * (1 - 2.0 * (source[..., MIRRORED] != 0))
    return np.stack([rows, columns], axis=-1)


class Look:
    """What source maps show of an exemplar (h, w, c), with the ``kinds`` of its channels."""

    def __init__(self, exemplar: Array, kinds: Sequence[MapKind] = ()) -> None:
        self.exemplar = exemplar
        self._kinds = kinds
        self._splines: dict[float, list[Array]] = {}

    def at(self, source: NDArray[Any]) -> Array:
        """What pixels of a source map (n, 6) show: float32 (n, c).

        Whole rows and columns at the exemplar's own size or larger give its pixels; others cubic splines, of the
        exemplar behind a Gaussian where it is shown smaller. Points outside show the border. Normals are turned with
        the picture and made unit vectors again.
        """
        last = np.array(self.exemplar.shape[:2]) - 1
        rows, columns = np.clip(source[:, ROW : COLUMN + 1].astype(np.float64), 0, last).T
        whole = (rows == np.rint(rows)) & (columns == np.rint(columns)) & (source[:, LOG] >= 0)
        result: Array = self.exemplar[np.rint(rows).astype(np.intp), np.rint(columns).astype(np.intp)]
        for log in np.unique(source[~whole, LOG]):
            chosen = ~whole & (source[:, LOG] == log)
            result[chosen] = self._between(rows[chosen], columns[chosen], float(log))
        if self._kinds:
            views = source[:, [ANGLE, MIRRORED]]
            for angle, mirrored in np.unique(views, axis=0).tolist():
                chosen = (views[:, 0] == angle) & (views[:, 1] == mirrored)
                part = result[chosen]
                turn_normals(part, self._kinds, angle, mirrored != 0)
                result[chosen] = renormalised(part, self._kinds)
        return result

    def _between(self, rows: NDArray[Any], columns: NDArray[Any], log: float) -> Array:
        """Values (n, c) between pixels, shown 2 ** log times as large."""
        from scipy.ndimage import map_coordinates

        blur = 0.5 * float(np.sqrt(max(0.0, 4.0**-log - 1)))
        if blur not in self._splines:
            self._splines[blur] = [_spline(channel, blur) for channel in np.moveaxis(self.exemplar, -1, 0)]
        values: list[Any] = []
        for channel, spline in zip(np.moveaxis(self.exemplar, -1, 0), self._splines[blur], strict=True):
            found = map_coordinates(spline, [rows + MARGIN, columns + MARGIN], order=3, mode="nearest", prefilter=False)
            values.append(np.clip(found, channel.min(), channel.max()))
        return np.stack(values, axis=-1).astype(np.float32)


MARGIN = 12
"""Repeated border pixels around a spline's: what lies beyond has no influence inside."""


def _spline(channel: Array, blur: float) -> Array:
    """Coefficients of the cubic spline through a channel (h, w) behind a Gaussian, with a margin."""
    from scipy.ndimage import gaussian_filter, spline_filter

    smooth = gaussian_filter(channel, blur, mode="nearest") if blur > 0 else channel
    coefficients: Array = spline_filter(np.pad(smooth, MARGIN, mode="edge"), 3, np.float32, mode="nearest")
    return coefficients


def coherence(source: NDArray[Any]) -> float:
    """Share of pairs of neighbouring pixels (right and down) whose sources (h, w, 2) are neighbours too.

    Pairs with a negative source, a known pixel, do not count. 1 where there is no pair.
    """
    rows, columns = source[..., 0], source[..., 1]
    stride = int(columns.max(initial=0)) + 2
    small = (int(rows.max(initial=0)) + 1) * stride < 2**31
    numbers = rows * (np.int32(stride) if small else np.int64(stride)) + columns
    right = numbers[:, 1:] == numbers[:, :-1] + 1
    down = numbers[1:] == numbers[:-1] + stride
    if rows.min(initial=0) < 0:
        copied = rows >= 0
        right = right[copied[:, 1:] & copied[:, :-1]]
        down = down[copied[1:] & copied[:-1]]
    pairs = right.size + down.size
    return float((np.count_nonzero(right) + np.count_nonzero(down)) / pairs) if pairs else 1.0


def coverage(source: Array, usable: Sequence[NDArray[np.bool_]]) -> float:
    """Share of the usable pixels (h, w) of all exemplars that pixels of a source map (..., 6) show.

    Pixels of which the index is beyond the exemplars do not count.
    """
    used, total = 0, 0
    for index, mask in enumerate(usable):
        own = source[..., INDEX] == index
        rows, columns = (np.rint(source[..., axis][own]).astype(np.intp) for axis in (ROW, COLUMN))
        seen = np.zeros(mask.size, bool)
        seen[rows * mask.shape[1] + columns] = True
        used += int(np.count_nonzero(seen.reshape(mask.shape) & mask))
        total += int(np.count_nonzero(mask))
    return used / total


def self_match(source: Array, seed: int = 0) -> float:
    """Highest peak off the centre of a source map's self-match: how much of the output repeats at one distance.

    The self-match at a lag is the share of pixels of a source map (h, w, 6), whole places alike, whose source is also
    that of the pixel one lag away. Lags up to half of each side count. 1 for a tiling, 0 where no source serves twice.
    It is the autocorrelation of random phases, one for each source, so the error is about 1 / sqrt(h w).

    Examples
    --------
    >>> rows, columns = np.mgrid[:32, :64]
    >>> tiles = source_map(np.stack([rows, columns % 32], axis=-1))
    >>> bool(self_match(tiles) > 0.999)
    True
    """
    from scipy.fft import fft2, ifft2

    height, width = source.shape[:2]
    places = np.rint(source[..., : COLUMN + 1]).astype(np.int64).reshape(-1, COLUMN + 1)
    code = np.unique(places @ [1 << 40, 1 << 20, 1], return_inverse=True)[1].reshape(height, width)
    phases = np.random.default_rng(seed).random(int(code.max()) + 1)
    down, right = height // 2, width // 2
    waves = np.exp(2j * np.pi * phases[code])
    power = np.abs(fft2(waves, (height + down, width + right))) ** 2
    pairs = ifft2(power).real[: down + 1]
    rows, columns = np.arange(down + 1), np.arange(-right, right + 1)
    overlap = np.outer(height - rows, width - np.abs(columns))
    share = pairs[:, columns] / overlap
    share[0, right] = 0
    return float(np.clip(share.max(), 0, 1))


LATTICE = 4
"""Distance of the pixels that :func:`near_copies` looks at."""


def near_copies(source: Array, reach: float) -> float:
    """Share of pixels whose place is shown again, by another piece, at most ``reach`` pixels away each way.

    Every fourth pixel of each fourth row of a source map (h, w, 6) of plain copies is looked at. Places up to 3 pixels
    apart count as one, and pieces as two if they are shifted by more than twice as much against each other. Where
    sources were chosen at random, each as often as others, the share is 1 - exp(-a) for an exemplar of a times the area
    of the square of 2 ``reach``.

    Examples
    --------
    >>> rows, columns = np.mgrid[:32, :128]
    >>> tiles = source_map(np.stack([rows, columns % 64], axis=-1))
    >>> near_copies(tiles, 50), near_copies(tiles, 70)
    (0.0, 1.0)
    """
    from scipy.spatial import KDTree

    same = LATTICE - 1
    shown = source[::LATTICE, ::LATTICE, : COLUMN + 1].reshape(-1, COLUMN + 1).astype(np.float64)
    at = LATTICE * np.moveaxis(np.indices((-(-source.shape[0] // LATTICE), -(-source.shape[1] // LATTICE))), 0, -1)
    at = at.reshape(-1, 2)
    tree = KDTree(np.column_stack([at / reach, shown[:, ROW:] / same, 2 * shown[:, INDEX]]))
    one, other = tree.query_pairs(1.0, p=np.inf, output_type="ndarray").T
    shift = at - shown[:, ROW:]
    apart = np.abs(shift[one] - shift[other]).max(axis=1, initial=0) > 2 * same
    repeated = np.zeros(len(at), bool)
    repeated[one[apart]] = repeated[other[apart]] = True
    return float(repeated.mean())
