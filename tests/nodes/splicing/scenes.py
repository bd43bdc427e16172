"""Small textures and their parts, made by hand."""

import numpy as np

from graphtex import Elements, Texture
from graphtex_nodes import extend_texture
from graphtex_nodes.splicing.values import Extension


def elements(points, angles=0.0, scales=1.0) -> Elements:
    points = np.array(points, np.float64).reshape(-1, 2)
    return Elements(points, np.full(len(points), float(angles)), np.full(len(points), float(scales)))


def discs(points, size=(40, 40), radius=4.0, tag="F=d", seed=0) -> Texture:
    """Bright discs with a gradient on a noisy ground, (h, w, 3)."""
    rng = np.random.default_rng(seed)
    points = np.array(points, np.float64).reshape(-1, 2)
    y, x = np.mgrid[: size[0], : size[1]]
    image = 0.2 + 0.05 * rng.random((*size, 3))
    mask = np.zeros(size, bool)
    for px, py in points:
        inside = np.hypot(x - px, y - py) <= radius
        image[inside] = np.stack([0.7 + 0.04 * (x - px), 0.6 + 0.04 * (y - py), 0.3 + 0 * x], axis=2)[inside]
        mask |= inside
    return Texture(image.clip(0, 1).astype(np.float32), mask, points, tag)


def grid(step=16.0, size=(64, 64), start=8.0):
    """Points of a square lattice inside a picture (height, width)."""
    x, y = np.arange(start, size[1], step), np.arange(start, size[0], step)
    return np.stack(np.meshgrid(x, y), axis=2).reshape(-1, 2)


def whole(texture: Texture) -> Extension:
    """The texture as an extension that is no larger than its window."""
    return extend_texture(texture, factor=1.0)
