"""How a picture uses its exemplar, estimated from the pictures alone, so that every tool is judged alike."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

WINDOW = 7  # pixels, as in `patch_distance`
COMPONENTS = 12  # principal components of a window that are compared
PROBES = 4000  # windows whose two neighbours are looked at for coherence
APART = 0.2  # the window found may be this much further than the nearest; exact copies are found anyway
STEP = 4  # pixels between the windows that count for coverage
SLACK = 0.001  # of the mean variance of windows: what a continued source may be worse than the nearest
FLAT = 0.01  # of the mean variance: a window with less content does not tell where it comes from


@dataclass(frozen=True)
class Likeness:
    """Estimated use of an exemplar.

    Attributes
    ----------
    coherence
        Share of pairs of neighbouring windows (right and down) of which the second fits where the source of the first
        goes on, as well as anywhere: 1 for one piece pasted whole, near 0 for noise.
    coverage
        Share of the exemplar's windows with some content of which, or of whose neighbours, the picture holds a copy.
    """

    coherence: float
    coverage: float


def likeness(image: Array, exemplar: Array, seed: int = 0) -> Likeness:
    """Estimate coherence and coverage from the nearest exemplar window of 7 x 7 pixels to windows of a picture.

    Windows are compared by the exemplar's first 12 principal components. Random sources cover 98 % of an exemplar with
    half the picture's sides, whatever they look like, so coverage tells of lost and of repeated parts only.

    Parameters
    ----------
    image, exemplar
        (h, w, c), equally many channels, any encoding.

    Raises
    ------
    ValueError
        A picture is smaller than a window and its neighbour, or channels disagree.
    """
    from scipy.spatial import cKDTree

    if image.shape[2] != exemplar.shape[2]:
        raise ValueError(f"image: expected {exemplar.shape[2]} channels as in the exemplar, got {image.shape[2]}")
    for name, picture in (("image", image), ("exemplar", exemplar)):
        if min(picture.shape[:2]) <= WINDOW:
            raise ValueError(f"{name}: expected more than {WINDOW} pixels a side, got {picture.shape[:2]}")
    known = _windows(exemplar)
    shape = known.shape[:2]
    sample = known.reshape(-1, known.shape[2])
    mean = sample.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((sample - mean)[:: max(1, len(sample) // 20000)], rowvar=False))
    axes = np.ascontiguousarray(axes[:, ::-1][:, :COMPONENTS])
    known = (known - mean) @ axes
    tree = cKDTree(known.reshape(-1, known.shape[2]))
    spread = float(known.reshape(-1, known.shape[2]).var(axis=0).sum())
    windows = (_windows(image) - mean) @ axes

    def nearest(rows: Array, columns: Array) -> tuple[Array, Array, Array]:
        found = tree.query(windows[rows, columns], eps=APART)
        distance, index = np.asarray(found[0]), np.asarray(found[1])
        return index // shape[1], index % shape[1], distance**2

    coherence = _coherence(windows, known, nearest, SLACK * spread, _content(image), FLAT, seed)
    rows, columns = np.mgrid[: windows.shape[0] : STEP, : windows.shape[1] : STEP].reshape(2, -1)
    rows, columns, _ = nearest(rows, columns)
    used = np.zeros((shape[0] + STEP, shape[1] + STEP), bool)
    for down in range(STEP):
        for right in range(STEP):
            used[rows + down, columns + right] = True
    content = _content(exemplar)
    telling = content > FLAT * content.mean()
    return Likeness(coherence, float(used[: shape[0], : shape[1]][telling].mean()) if telling.any() else 1.0)


def _coherence(
    windows: Array, known: Array, nearest: Any, slack: float, content: Array, flat: float, seed: int
) -> float:
    """Share of probed pairs whose sources go on; windows without content are left out."""
    rng = np.random.default_rng(seed)
    height, width = windows.shape[0] - 1, windows.shape[1] - 1
    probes = rng.permutation(np.flatnonzero(content[:height, :width] > flat * content.mean()))[:PROBES]
    if not len(probes):
        return 1.0
    rows, columns = probes // width, probes % width
    source_rows, source_columns, _ = nearest(rows, columns)
    going_on = 0.0
    for down, right in ((0, 1), (1, 0)):
        window = windows[rows + down, columns + right]
        _, _, best = nearest(rows + down, columns + right)
        r, c = source_rows + down, source_columns + right
        inside = (r < known.shape[0]) & (c < known.shape[1])
        there = known[r.clip(0, known.shape[0] - 1), c.clip(0, known.shape[1] - 1)]
        going_on += float(np.mean(inside & (((window - there) ** 2).sum(axis=1) <= best + slack)))
    return going_on / 2


def _windows(picture: Array) -> Array:
    """All windows (rows, columns, values)."""
    views = np.lib.stride_tricks.sliding_window_view(np.asarray(picture, np.float32), (WINDOW, WINDOW), axis=(0, 1))
    return views.reshape(*views.shape[:2], -1)


def _content(picture: Array) -> Array:
    """Variance of each window over its pixels, summed over channels."""
    windows = _windows(picture)
    values = windows.reshape(*windows.shape[:2], picture.shape[2], -1)
    content: Array = values.var(axis=-1).sum(axis=-1)
    return content
