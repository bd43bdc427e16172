"""A scale map as the grey picture of the paper."""

import numpy as np

from graphtex import Image, ScaleMap, node

GREY_OF_ONE = 128 / 255


@node
def view_scale(scale: ScaleMap) -> Image:
    """Grey picture of a scale map: 128 of 255 is scale 1, brighter is larger (section 3.1 of Dong, Zhou & Paul 2008).

    A view only, not a way to keep the data: scales over 255/128 = 1.99, which planes slanted by more than 60 degrees
    have, are all white.

    Parameters
    ----------
    scale
        (h, w).

    Returns
    -------
    Image
        (h, w, 1) in [0, 1]: scale * 128 / 255, at most 1.

    Examples
    --------
    >>> view_scale(np.array([[0.5, 1.0, 4.0]], np.float32))[0, :, 0] * 255
    array([ 64., 128., 255.], dtype=float32)
    """
    return np.minimum(scale * np.float32(GREY_OF_ONE), np.float32(1))[..., None]
