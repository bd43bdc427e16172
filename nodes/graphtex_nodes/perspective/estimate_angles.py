"""Slant and tilt of a textured plane, from its picture or from its scale map (Dong, Zhou & Paul 2008, section 3.2)."""

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Axes, Context, Image, Mask, Number, ScaleMap, node
from graphtex_nodes.numerics.plane import slant_of

Array = NDArray[Any]
View = Annotated[float, Field(gt=0, lt=180, description="camera's angle of view over the longer side, degrees")]

LARGEST = 384  # pixels of a map's longer side that are looked at
DOUBTFUL = 0.3
STEEPEST = 0.95  # loss of scale from the centre to the far end of the tilt; the horizon is at 1


class Angles(NamedTuple):
    """How a plane is turned from the camera, and how far that explains what was measured."""

    slant: Number
    tilt: Number
    confidence: Number


@node
def estimate_angles(
    image: Annotated[Image, Axes("h w c")] | None = None,
    scale: Annotated[ScaleMap, Axes("h w")] | None = None,
    usable: Annotated[Mask, Axes("h w")] | None = None,
    *,
    field_of_view: View | None = None,
    doubtful: Annotated[Literal["keep", "flat"], Field(description="what becomes of angles below confidence 0.3")] = (
        "keep"
    ),
    ctx: Context = QUIET,
) -> Angles:
    r"""Angles for `ScaleFromAngles` that nobody has to guess: slant and tilt of the plane that a picture shows.

    From a picture: a texture that is the same all over a plane has one spectrum everywhere on that plane, and only on
    the right plane do the spectra of windows all over the picture, taken back to it, agree. That plane is searched for
    (see `numerics.homogeneity`). It needs no single elements, no round ones, and no user.

    From a scale map: texel scale is linear in the picture, :math:`S = S_0 (1 - k\,a)` along the tilt. That is fitted
    robustly, with Tukey's biweight.

    Either gives the tilt and the steepness k. The slant follows from k and the camera, :math:`\tan\sigma = k f` with
    the focal length :math:`f` = longer side / (2 tan(β/2)); or without a field of view β from the paper's range of
    scales, :math:`S_{max} / S_{min} = 1/\cos^2\sigma`. So `ScaleFromAngles`, given these angles and the same field of
    view or none, draws the scale that was found.

    Parameters
    ----------
    image
        (h, w, c), at least 48 pixels a side, all or most of it one texture.
    scale
        (h, w), instead of a picture. What `FeatureScale` measures ranks scales well but does not keep their ratios,
        and gives rougher angles than the picture itself.
    usable
        (h, w), True on the ground: a sky, or what stands on the ground, is left out.
    field_of_view
        Of the camera. About 65 for a phone, 40 to 55 for a camera's usual lens; less for a crop.
    doubtful
        ``flat`` takes for a plane seen face on, of slant 0, what is not surely another one. Guided by the noise of a
        flat texture a synthesis is worse than without.

    Returns
    -------
    slant
        Degrees, 0 is face on.
    tilt
        Direction in which texels shrink, degrees clockwise from up, in [-180, 180].
    confidence
        From 0 to 1: the share of the variance of log scale that the plane explains, and of a picture less where its
        spectra agree almost as well face on. Low where nothing varies, as face on, or where what varies is no plane;
        with less than 0.3 there is a warning.

    Raises
    ------
    ValueError
        There is neither a picture nor a map, or both; the picture is too small, or too little of it is usable.

    Notes
    -----
    On rendered planes of slant 30 to 60 (pebbles, bricks, pavers, flowers, cloth, 256 x 256 pixels, field of view 45)
    five of six are within 5 degrees of slant and 10 of tilt. The smaller the slant, the less sure is the tilt. Of
    seventy photographs and planes rendered with photographed textures, none whose confidence reached 0.3 had a tilt
    that was off by more than 21 degrees; of those below, half had. What misleads it with confidence is contrast
    that fades evenly over a picture of few elements.

    Examples
    --------
    >>> ramp = np.linspace(0.5, 2.0, 33, dtype=np.float32)[:, None] * np.ones((1, 33), np.float32)
    >>> slant, tilt, confidence = estimate_angles(scale=ramp)
    >>> round(slant), round(abs(tilt)), confidence > 0.9
    (60, 0, True)
    """
    if (image is None) == (scale is None):
        raise ValueError(
            f"image: expected either an image or a scale map, got {'neither' if image is None else 'both'}"
        )
    if usable is not None and not usable.any():
        raise ValueError(f"usable: expected some pixels (True), got none in shape {usable.shape}")
    if scale is not None:
        height, width = scale.shape
        right, down, confidence = _from_scale(scale.astype(np.float64), usable)
    else:
        assert image is not None
        height, width = image.shape[:2]
        right, down, confidence = _from_image(image, usable, ctx)
    tilt = float(np.degrees(np.arctan2(right, -down))) if right or down else 0.0
    steepness = float(np.hypot(right, down))
    loss = (abs(right) * (width - 1) + abs(down) * (height - 1)) / 2
    if loss > STEEPEST:
        steepness *= STEEPEST / loss
    if loss > STEEPEST - 0.03:
        ctx.warn("the horizon is in the picture or near it: crop it to the ground, or mark the ground as usable")
    if confidence < DOUBTFUL:
        taken = "it is taken for one seen face on" if doubtful == "flat" else "its angles are doubtful"
        ctx.warn(f"the plane explains only {confidence:.0%} of how scale varies: {taken}")
        steepness = 0.0 if doubtful == "flat" else steepness
    return Angles(slant_of(width, height, tilt, steepness, field_of_view), tilt, confidence)


def _from_scale(scale: Array, usable: Array | None) -> tuple[float, float, float]:
    """Relative loss of scale for each pixel to the right and down, and the share of log scale's variance explained."""
    from graphtex_nodes.numerics.continuation import fitted_plane, plane_share

    step = max(1, max(scale.shape) // LARGEST)
    height, width = scale.shape
    known = np.ones(scale.shape, bool) if usable is None else usable
    part, seen = scale[::step, ::step], known[::step, ::step]
    if not seen.any():
        raise ValueError(f"usable: expected more pixels (True), got {int(known.sum())} in shape {known.shape}")
    plane = fitted_plane(part, seen)
    down, right = (float(np.diff(plane, axis=axis).mean()) / step if plane.shape[axis] > 1 else 0.0 for axis in (0, 1))
    centre = float(plane[0, 0]) + right * (width - 1) / 2 + down * (height - 1) / 2
    return -right / centre, -down / centre, plane_share(part[seen], plane[seen])


def _from_image(image: Array, usable: Array | None, ctx: Context) -> tuple[float, float, float]:
    """The same from the picture's local spectra."""
    from graphtex_nodes.numerics.homogeneity import SHORTEST, picture_recession

    if min(image.shape[:2]) < SHORTEST:
        raise ValueError(f"image: expected at least {SHORTEST} pixels a side, got {image.shape[1]} x {image.shape[0]}")
    found = picture_recession(image, usable, ctx)
    if found is None:
        raise ValueError(
            f"usable: expected room for at least 6 windows of {min(image.shape[:2]) // 4} pixels a side, "
            f"got {0 if usable is None else int(usable.sum())} pixels (True) in shape {image.shape[:2]}"
        )
    return found.right, found.down, found.confidence
