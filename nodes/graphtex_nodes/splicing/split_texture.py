"""The parts of a texture with its elements."""

from typing import NamedTuple

from graphtex import Image, Mask, Points, Texture, node


class Parts(NamedTuple):
    """Picture, foreground and textons."""

    image: Image
    mask: Mask
    points: Points


@node
def split_texture(texture: Texture) -> Parts:
    """Take a texture apart, to look at its picture or to use its mask and points elsewhere.

    Examples
    --------
    >>> import numpy as np
    >>> parts = split_texture(Texture(np.ones((2, 2, 3), np.float32), np.ones((2, 2), bool), np.zeros((1, 2)), "F=d"))
    >>> parts.points.tolist()
    [[0.0, 0.0]]
    """
    return Parts(texture.image, texture.mask, texture.points)
