"""Signs that what was found is not what a texture is made of."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex import Elements
from graphtex_nodes.splicing._nearness import distances
from graphtex_nodes.splicing._partitions import Even
from graphtex_nodes.splicing._repeats import repeated_share
from graphtex_nodes.splicing._unlit import squared_change

Array = NDArray[Any]

DOUBTFUL = 0.5  # confidence below which automatic results are rarely right
AROUND = 1.25  # times an element's half sizes: its outline lies within
EXPLAINED = 0.8  # share of all changes of colour that right elements have in and around them at least
DIRECTED = 0.75  # how much changes of brightness have one direction: bricks have 0.5, stripes 1
SHOWN, SHOWN_ALONE = 0.2, 0.6  # least share of squared changes at what looks like given elements, and at one alone
REGULAR = 0.6, 0.9  # share of elements that meet others where the picture repeats: none is right, and all may be
UNEVEN = 0.08  # deviation of scores of elements that are alike


def trust(even: Even, elements: Elements, scores: Array, width: float, height: float) -> float:
    """What a confidence is to be multiplied by, 0 to 1, for elements found in a reduced picture.

    It falls where much of what changes in the picture lies off the elements, as where some of them, or parts of them,
    were taken for all; where the picture has stripes and no ends to them; where some are much less alike; and where the
    picture repeats itself and they do not.
    """
    image = even.picture
    last = np.array(image.shape[1::-1]) - 1
    points = elements.points[((elements.points >= 0) & (elements.points <= last)).all(axis=1)]
    repeated = repeated_share(points, even.repeats, image.shape[:2])
    none, all_of_them = REGULAR
    return float(
        min(1.0, _explained(image, elements, width, height) / EXPLAINED) ** 2
        * np.clip((1 - _directed(image, min(width, height))) / (1 - DIRECTED), 0, 1)
        * min(1.0, UNEVEN / max(float(scores.std()), 1e-9))
        * np.clip((repeated - none) / (all_of_them - none), 0, 1)
    )


def hardly_shown(
    image: Array, elements: Elements, width: float, height: float, least: float | None = None
) -> float | None:  # fmt: skip
    """Share of the squared changes of colour in and around elements, if it is too little for what a texture shows.

    That is less than `least`, by default what one alone or several should have. Squares, since a lone element on a
    noisy ground has few pixels that change, but these change most.
    """
    share = _share(squared_change(image), elements, width, height)
    if least is None:
        least = SHOWN if len(elements.points) > 1 else SHOWN_ALONE
    return share if share < least else None


def _explained(image: Array, elements: Elements, width: float, height: float) -> float:
    """Share of the changes of colour that lies in and around the elements."""
    return _share(np.sqrt(squared_change(image)), elements, width, height)


def _share(change: Array, elements: Elements, width: float, height: float) -> float:
    """Share of a map (h, w) that lies in and around the elements."""
    near = distances(change.shape, elements, width, height)[1] < AROUND
    return float(change[near].sum() / max(change.sum(), 1e-9))


def _directed(image: Array, size: float) -> float:
    """Coherence of the structure tensor of the whole picture: 0 for changes in all directions, 1 for stripes."""
    from scipy.ndimage import gaussian_filter

    down, across = np.gradient(gaussian_filter(image.mean(axis=2), max(size / 4, 0.7)))
    vertical, horizontal, mixed = (float((a * b).mean()) for a, b in ((down, down), (across, across), (down, across)))
    return float(np.hypot(horizontal - vertical, 2 * mixed) / max(horizontal + vertical, 1e-12))
