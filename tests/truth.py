"""Ground truth for tests, by other means than the library's own."""

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.measures import element_sizes, patch_distance, scale_slope, source_scale_correlation

__all__ = ["element_sizes", "patch_distance", "rendered_plane", "scale_slope", "source_scale_correlation"]


def rendered_plane(
    size: int | tuple[int, int], slant: float, tilt: float = 0.0, field_of_view: float = 45.0
) -> NDArray[np.float64]:
    """Texel scale of a plane under a pin-hole camera, by casting a ray through every pixel.

    The camera looks along z with x to the right and y up; the plane passes through (0, 0, 1). Starting face on, its far
    side is turned away from the camera by `slant` about the axis at right angles to the direction `tilt` (degrees
    clockwise from up). The scale is the inverse of the depth where a ray meets the plane, times a factor that makes the
    largest and the smallest multiply to 1. `size` is the side of a square or (height, width); the field of view spans
    the longer side.
    """
    height, width = (size, size) if isinstance(size, int) else size
    slant, tilt, view = np.radians([slant, tilt, field_of_view])
    axis = np.array([np.cos(tilt), -np.sin(tilt), 0.0])  # the line in the plane that stays face on
    normal = np.array([0.0, 0.0, -1.0])
    # Rodrigues' formula, with the sense of turn that tips the far side away
    normal = normal * np.cos(slant) + np.cross(axis, normal) * np.sin(slant)
    pixel = 2 * np.tan(view / 2) / max(width, height)
    x = (np.arange(width) + 0.5 - width / 2) * pixel
    y = -(np.arange(height) + 0.5 - height / 2) * pixel
    rays = np.stack([*np.broadcast_arrays(x[None, :], y[:, None]), np.ones((height, width))], axis=-1)
    depth = (normal @ np.array([0.0, 0.0, 1.0])) / (rays @ normal)
    if not (depth > 0).all():
        raise ValueError("the horizon is in the picture")
    scale = 1 / depth
    return scale / np.sqrt(scale.min() * scale.max())
