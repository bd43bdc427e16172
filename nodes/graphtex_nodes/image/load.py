"""Pictures from files: LoadImage, and LoadMask and LoadScale for maps that are kept as pictures."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, FilePath, Image, Mask, ScaleMap, node, opener
from graphtex_nodes.image.files.colour import (
    Alpha,
    Encoding,
    Floats,
    divide_alpha,
    encode_srgb,
    settle_alpha,
    to_floats,
    upright,
)
from graphtex_nodes.image.files.decode import Decoded, decode
from graphtex_nodes.image.files.formats import READABLE

NonFinite = Literal["refuse", "zero"]


@opener(Image, suffixes=READABLE)
@node
def load_image(
    *,
    path: Annotated[FilePath, Field(description="the picture file")],
    alpha: Annotated[Alpha, Field(description="what becomes of transparency")] = "keep",
    encoding: Annotated[Encoding, Field(description="what the file's numbers are")] = "auto",
    nonfinite: Annotated[NonFinite, Field(description="what becomes of NaN and infinite samples")] = "refuse",
    ctx: Context = QUIET,
) -> Image:
    """Read a picture: PNG, JPEG, TIFF, WebP, OpenEXR, Radiance HDR, BMP, GIF (its first frame) or a NumPy array.

    The content decides on the format, not the suffix. Integers are divided by the largest of their type, floating
    point is taken as it is. An EXIF or TIFF orientation is applied. Palettes become RGB, inks (CMYK) too. Of several
    pages, parts or frames the first is read.

    Parameters
    ----------
    alpha
        ``keep`` gives it as the last channel, straight (colour not multiplied by it): what a file holds premultiplied
        is divided. ``drop`` leaves it out, ``over-white`` and ``over-black`` lay the picture over a ground, in encoded
        values as browsers do. A transparent colour of a palette counts as alpha.
    encoding
        ``auto``: an embedded ICC profile is converted to sRGB, EXR and HDR are linear light and become sRGB-encoded,
        all else is sRGB. ``srgb`` and ``linear`` overrule format and profile. ``raw`` is for maps that are not colour
        (normals, height): numbers as they are, no profile, no transfer function, alpha not divided.
    nonfinite
        ``refuse`` is an error, ``zero`` sets NaN and infinite samples to 0.

    Returns
    -------
    Image
        (h, w, c): grey 1 channel, grey and alpha 2, RGB 3, RGBA 4, else as many as the file has, up to 16. Floating
        point beyond [0, 1] is kept (with a warning), so that loading and saving undo each other.

    Raises
    ------
    ValueError
        One line naming the file: missing, a folder, empty, not a picture, damaged or cut off, larger than 2^28
        pixels, more than 16 channels, or NaN or infinite samples.

    Notes
    -----
    The transfer function is for colour alone: in an EXR the channels named R, G, B or Y, else the first one or three
    of pictures with up to four channels. ICC profiles of 8-bit pictures go through LittleCMS (relative colorimetric,
    black point compensation); those of deeper ones through the profile's curves and matrix; a deep picture with a
    table of colours in place of them is left as it is, with a warning. A profile for RGB on a grey picture is not used,
    nor are a PNG's gAMA and cHRM.
    """
    return read_picture(path, alpha=alpha, encoding=encoding, nonfinite=nonfinite, warn=ctx.warn)


def read_picture(
    path: Path,
    *,
    alpha: Alpha = "keep",
    encoding: Encoding = "auto",
    nonfinite: NonFinite = "refuse",
    warn: Callable[[str], None],
) -> Floats:
    """Do what `load_image` says, as a plain function."""
    found = decode(path)
    if found.more:
        warn(f"{path.name}: holds several pages or frames; the first is read")
    if encoding == "raw":
        picture, colours = to_floats(found.samples), found.colours
    else:
        picture, colours = _to_srgb(path, found, encoding, nonfinite, warn)
    picture = _finite(path, picture, nonfinite)
    still = found.premultiplied and encoding == "raw"
    picture = settle_alpha(picture, alpha, colours, found.alpha, premultiplied=still)
    picture = upright(picture, found.orientation)
    low, high = float(picture.min()), float(picture.max())
    if encoding != "raw" and not (low >= 0 and high <= 1):
        warn(f"{path.name}: values from {low:.4g} to {high:.4g} are kept; most nodes expect 0 to 1")
    return picture


def _to_srgb(
    path: Path, found: Decoded, encoding: Encoding, nonfinite: NonFinite, warn: Callable[[str], None]
) -> tuple[Floats, int]:
    """Samples to sRGB-encoded floats with straight alpha, and how many of the channels are colour."""
    found = _resolve_ink(path, found, encoding, warn)
    colours = found.colours
    picture = _finite(path, to_floats(found.samples), nonfinite)
    if found.premultiplied:
        picture = divide_alpha(picture, colours, found.alpha)
    if encoding == "linear" or (encoding == "auto" and found.linear):
        if found.foreign_primaries:
            warn(f"{path.name}: its primaries are not those of sRGB; they are not converted")
        picture = np.concatenate([encode_srgb(picture[..., :colours]), picture[..., colours:]], axis=2)
    elif encoding == "auto" and found.profile is not None and colours:
        picture = np.concatenate([_profiled(path, picture, found, warn), picture[..., colours:]], axis=2)
    return picture, colours


def _resolve_ink(path: Path, found: Decoded, encoding: Encoding, warn: Callable[[str], None]) -> Decoded:
    """CMYK to RGB, by its profile or without one by (1 - ink) (1 - black)."""
    from dataclasses import replace

    from graphtex_nodes.image.files.profiles import to_srgb_8

    if not found.cmyk:
        return found
    if found.profile is not None and encoding == "auto" and found.samples.dtype == np.uint8:
        try:
            return replace(found, samples=to_srgb_8(found.samples, found.profile), colours=3, cmyk=False, profile=None)
        except ValueError as error:
            warn(f"{path.name}: its colour profile is not used: {error}")
    ink = to_floats(found.samples)
    return replace(found, samples=(1 - ink[..., :3]) * (1 - ink[..., 3:]), colours=3, cmyk=False, profile=None)


def _profiled(path: Path, picture: Floats, found: Decoded, warn: Callable[[str], None]) -> Floats:
    from graphtex_nodes.image.files.profiles import to_srgb_8, to_srgb_deep

    assert found.profile is not None
    colour = picture[..., : found.colours]
    if found.colours == 1 and found.profile[16:20] == b"RGB ":
        return colour  # some programs write it, the PNG standard has it ignored
    try:
        if found.samples.dtype == np.uint8 and not found.premultiplied:
            return to_floats(to_srgb_8(found.samples[..., : found.colours], found.profile))
        return to_srgb_deep(colour, found.profile)
    except ValueError as error:
        warn(f"{path.name}: its colour profile is not used: {error}")
        return colour


def _finite(path: Path, picture: Floats, nonfinite: NonFinite) -> Floats:
    bad = ~np.isfinite(picture)
    if not bad.any():
        return picture
    if nonfinite == "refuse":
        found = f"{np.count_nonzero(bad)} of {bad.size} samples are NaN or infinite"
        raise ValueError(f"{path}: {found}; `nonfinite: zero`, of LoadImage or in an input's `open`, sets them to 0")
    return np.where(bad, np.float32(0), picture)


@opener(Mask, suffixes=READABLE)
@node
def load_mask(
    *,
    path: Annotated[FilePath, Field(description="the picture file")],
    threshold: Annotated[float, Field(ge=0, le=1, description="True is at or above it")] = 0.5,
    channel: Annotated[
        Literal["grey", "alpha"], Field(description="brightness over black, or the transparency alone")
    ] = "grey",
    invert: Annotated[bool, Field(description="True is below the threshold")] = False,
    ctx: Context = QUIET,
) -> Mask:
    """Read a mask from a picture: white (at least half grey) is True.

    Colour counts by the mean of its channels, laid over black where it is transparent. Numbers are taken as they
    are stored: no colour profile and no transfer function moves the threshold.

    Raises
    ------
    ValueError
        As `load_image`; or if ``alpha`` is asked of a picture that has none.
    """
    found = decode(path)
    picture = _finite(path, to_floats(found.samples), "refuse")
    if channel == "alpha":
        if found.alpha < 0:
            raise ValueError(f"channel: {path.name} has no alpha; it has {picture.shape[2]} channels: use grey")
        grey = picture[..., found.alpha]
    else:
        if found.cmyk:
            picture = (1 - picture[..., :3]) * (1 - picture[..., 3:])
        colours = max(found.colours, 1)
        flat = settle_alpha(picture, "over-black", colours, found.alpha, premultiplied=found.premultiplied)
        grey = flat.mean(axis=2, dtype=np.float64)
    mask: NDArray[np.bool_] = upright(grey, found.orientation) >= threshold
    return ~mask if invert else mask


@opener(ScaleMap, suffixes=READABLE)
@node
def load_scale(
    *,
    path: Annotated[FilePath, Field(description="a float picture or array, or an 8 or 16-bit view")],
    unit: Annotated[
        float | None, Field(gt=0, description="the grey that means 1: scale = grey / unit; default by the file's depth")
    ] = None,
    ctx: Context = QUIET,
) -> ScaleMap:
    """Read a scale map: floating-point files hold the scale itself, 8-bit ones the view in which 128 is 1.

    Parameters
    ----------
    unit
        In the file's own numbers. By default 1 for floating point, 128 for 8 bit and 32768 for 16 bit.

    Returns
    -------
    ScaleMap
        Clamped to [1/8, 8]; the share of clamped pixels is told.

    Raises
    ------
    ValueError
        As `load_image`; or if the file has colour.
    """
    found = decode(path)
    samples = upright(found.samples, found.orientation)
    if found.alpha >= 0:
        samples = np.delete(samples, found.alpha, axis=2)
    if not np.all(samples == samples[..., :1]):
        raise ValueError(f"{path}: a scale map is grey, the file has {found.samples.shape[2]} channels that differ")
    grey = _finite(path, samples[..., 0].astype(np.float32), "refuse")
    if unit is None:
        unit = {"u1": 128.0, "u2": 32768.0}.get(samples.dtype.str[1:], 1.0)
    scale = grey / np.float32(unit)
    clamped: Floats = np.clip(scale, 1 / 8, 8).astype(np.float32)
    share = np.count_nonzero(clamped != scale) / scale.size
    if share:
        ctx.warn(f"{path.name}: {share:.1%} of the scales lay beyond 1/8 to 8 and were clamped")
    return clamped
