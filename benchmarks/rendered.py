"""Planes rendered with photographed textures, and photographs of grounds: can the angles that are found be trusted?"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure
from benchmarks.marked import MARKED, SURE
from graphtex import Context
from graphtex_nodes import estimate_angles, load_image
from graphtex_nodes.numerics.plane import Region, photograph, seen_plane

Array = NDArray[Any]

# seen face on, of every kind; each is tiled over its plane
FLAT = (
    "regular-brickpavement.jpg", "regular-hexpaving.jpg", "regular-herringbone.jpg", "regular-checkweave.jpg",
    "elements-flagstones.jpg", "stochastic-gravel.png", "stochastic-grass.png", "material-stonewall-albedo.jpg",
)  # fmt: skip
SLANTS = (30.0, 45.0, 58.0)
WIDTH, HEIGHT, VIEW = 320, 240, 50.0
WRONG = 30.0  # degrees of tilt


def figures(textures: Path) -> Iterator[Figure]:
    """Errors of EstimateAngles where it is sure of the angles, and how often it is not."""
    slants, tilts, confidences = [], [], []
    for image, slant, tilt in _planes(textures):
        found = estimate_angles(image, field_of_view=VIEW, ctx=Context(on_warning=lambda text: None))
        slants.append(abs(found.slant - slant))
        tilts.append(abs((found.tilt - tilt + 180) % 360 - 180))
        confidences.append(found.confidence)
    if not tilts:
        return
    slant_errors, tilt_errors, sure = np.array(slants), np.array(tilts), np.array(confidences) >= SURE
    close = (slant_errors <= 5) & (tilt_errors <= 10)
    known = np.isfinite(slant_errors)
    yield Figure("EstimateAngles, photographs: share of which it is sure", float(sure.mean()))
    yield Figure(
        "EstimateAngles, photographs: largest error of tilt of these, degrees (reference: of the others)",
        float(tilt_errors[sure].max(initial=0)), f"<= {WRONG:g}", float(tilt_errors[~sure].max(initial=0)),
    )  # fmt: skip
    if known.any():
        share = float(close[known].mean())
        yield Figure("EstimateAngles, rendered photographs: share within 5 degrees of slant and 10 of tilt", share)


def _planes(textures: Path) -> Iterator[tuple[Array, float, float]]:
    """Pictures with their slants (NaN: not known) and tilts."""
    for marks in MARKED.values():
        if (textures / marks.file).is_file():
            yield marks.picture(textures), np.nan, 0.0
    for number, name in enumerate(FLAT):
        if not (textures / name).is_file():
            print(f"{name} is not in {textures}: passed over", file=sys.stderr)
            continue
        texture = load_image(path=textures / name)[..., :3]
        for turn, slant in enumerate(SLANTS):
            tilt = (137.5 * (len(SLANTS) * number + turn)) % 360 - 180
            yield rendered(texture, slant, tilt), slant, tilt


def rendered(texture: Array, slant: float, tilt: float) -> Array:
    """A plane that is tiled with a texture (h, w, c), one pixel of it for one of the picture where the scale is 1."""
    from scipy.ndimage import gaussian_filter, map_coordinates

    height, width = texture.shape[:2]

    def paint(region: Region) -> Array:
        blur = 0.5 * np.sqrt(max(region.density**-2 - 1, 0))  # a texel of this grid covers several of the texture
        soft = gaussian_filter(texture, (blur, blur, 0), mode="wrap")
        u, v = np.meshgrid(region.u + width / 2, height / 2 - region.v)
        places = [v % height, u % width]
        return np.stack(
            [map_coordinates(part, places, order=1, mode="grid-wrap") for part in np.moveaxis(soft, -1, 0)], -1
        )

    return photograph(seen_plane(WIDTH, HEIGHT, slant, tilt, VIEW), paint).astype(np.float32)
