"""A picture made smaller by averaging."""

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import Image, node

Longest = Annotated[int, Field(ge=0, le=1 << 20, description="pixels of the longer side at most; 0 = as it is")]


@node
def shrink_image(image: Image, *, longest: Longest = 0) -> Image:
    """Shrink a picture so that its longer side has at most so many pixels; a smaller one stays as it is.

    Each pixel of the result is the mean of the part of the picture that it covers, pixels that it covers in part
    counting by that part. Channels are averaged as they are stored.

    Parameters
    ----------
    image
        (h, w, c).

    Returns
    -------
    Image
        Sides keep their ratio, rounded to whole pixels, at least 1. A picture in [0, 1] that was shrunk is rounded to
        steps of 1/65535, so that a 16-bit file holds it exactly.

    Examples
    --------
    >>> shrink_image(np.array([[[0.0], [0.0], [1.0], [1.0]]], np.float32), longest=2).ravel().tolist()
    [0.0, 1.0]
    """
    height, width = image.shape[:2]
    if not longest or max(height, width) <= longest:
        return image
    rows, columns = (max(1, round(side * longest / max(height, width))) for side in (height, width))
    small = _averaged(_averaged(image.astype(np.float64), rows).swapaxes(0, 1), columns).swapaxes(0, 1)
    small = np.clip(small, image.min(), image.max())  # rounding must not leave the range
    if image.min() >= 0 and image.max() <= 1:
        return (np.rint(small * 65535).astype(np.float32) / np.float32(65535)).astype(np.float32)
    return np.ascontiguousarray(small, np.float32)


def _averaged(values: NDArray[Any], count: int) -> NDArray[np.float64]:
    """Means (count, ...) of equal parts of the first axis: differences of its running sum between their borders."""
    total = np.concatenate([np.zeros_like(values[:1]), np.cumsum(values, axis=0)])
    border = np.arange(count + 1) * (len(values) / count)
    before = np.minimum(border.astype(np.intp), len(values) - 1)
    share = (border - before).reshape(-1, *[1] * (values.ndim - 1))
    reached = total[before] * (1 - share) + total[before + 1] * share
    result: NDArray[np.float64] = np.diff(reached, axis=0) * (count / len(values))
    return result
