"""Samples to files. Every byte depends on the picture alone: no dates, no names of programs."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.image.files.colour import Encoding, decode_srgb, multiply_alpha, to_samples
from graphtex_nodes.image.files.formats import Depth, Format, require

JPEG_QUALITY = 95
PNG_LEVEL = 4
"""Of zlib: pictures with flat parts are written in a third of the time of its default, and are 3 % larger."""
_NO_DATE = "1970:01:01 00:00:00"  # OpenImageIO would write the present time into an EXR


def encode(
    picture: NDArray[Any],
    path: Path,
    *,
    depth: Depth | None = None,
    quality: int | None = None,
    encoding: Encoding = "auto",
) -> None:
    """Write a picture (h, w, c) of sRGB-encoded colour, 2 and 4 channels with straight alpha.

    Parameters
    ----------
    depth
        8 and 16 bit clip to [0, 1]; None is the format's default.
    encoding
        ``linear`` decodes colour to linear light before storing, ``srgb`` does not; ``auto`` does so for .exr and
        .hdr. Colour in an EXR is also multiplied by alpha, unless it is ``raw``: then numbers are stored as they are.
        Pictures of more than 4 channels are maps and always raw.

    Raises
    ------
    ValueError
        For what the format cannot hold, with what can.
    """
    entry, depth = require(path, (picture.shape[0], picture.shape[1], picture.shape[2]), depth, quality)
    channels = picture.shape[2]
    colours = {1: 1, 2: 1, 3: 3, 4: 3}.get(channels, 0)
    linear = encoding == "linear" or (encoding == "auto" and entry.linear)
    if linear and colours:
        picture = np.concatenate([decode_srgb(picture[..., :colours]), picture[..., colours:]], axis=2)
    if entry.name == "OpenEXR" and encoding != "raw" and 0 < colours < channels:
        picture = multiply_alpha(picture, colours, colours)
    if entry.name == "NumPy":
        with path.open("wb") as file:
            np.save(file, np.ascontiguousarray(picture, np.float32), allow_pickle=False)
        return
    samples = np.ascontiguousarray(to_samples(np.maximum(picture, 0) if not entry.depths else picture, depth))
    if entry.name == "TIFF":
        write_tiff(samples, path)
    elif entry.name in ("OpenEXR", "Radiance HDR") or (entry.name == "PNG" and depth == 16):
        write_deep(samples, path, srgb=encoding in ("auto", "srgb"))
    else:
        _write_pillow(samples, path, entry, quality, srgb=encoding in ("auto", "srgb"))


def _write_pillow(samples: NDArray[Any], path: Path, entry: Format, quality: int | None, *, srgb: bool) -> None:
    from PIL import Image, PngImagePlugin

    picture = Image.fromarray(samples[..., 0] if samples.shape[2] == 1 else samples)
    if entry.name == "JPEG":
        picture.save(path, "JPEG", quality=JPEG_QUALITY if quality is None else quality, subsampling=0)
    elif entry.name == "WebP":
        how: dict[str, Any] = {"lossless": True, "exact": True} if quality is None else {"quality": quality}
        picture.save(path, "WEBP", method=4, **how)
    else:
        tags = PngImagePlugin.PngInfo()
        if srgb:
            tags.add(b"sRGB", b"\0")  # rendering intent: perceptual
        picture.save(path, "PNG", pnginfo=tags, compress_level=PNG_LEVEL)


def write_tiff(samples: NDArray[Any], path: Path, *, data: bool = False) -> None:
    """Write (h, w, c) as deflated TIFF; the last of 2 or 4 channels is straight alpha, unless they are `data`."""
    import tifffile

    channels = samples.shape[2]
    colour = channels in (3, 4) and not data
    extra = ["unassalpha"] if channels in (2, 4) and not data else ["unspecified"] * (channels - 1)
    tifffile.imwrite(
        path,
        samples[..., 0] if channels == 1 else samples,
        photometric="rgb" if colour else "minisblack",
        planarconfig=None if channels == 1 else "contig",
        extrasamples=None if channels == 1 or (channels == 3 and colour) else extra,
        compression="zlib",
        predictor=samples.dtype.kind == "u",
        byteorder="<",
        metadata=None,
        software=False,
    )


def write_deep(samples: NDArray[Any], path: Path, *, srgb: bool = False, data: bool = False) -> None:
    """Write (h, w, c) through OpenImageIO in the samples' own type.

    `data`, and more than 4 channels, are called c00, c01, ... in an EXR, which keeps channels in alphabetical order.
    """
    import OpenImageIO as oiio

    height, width, channels = samples.shape
    kind = {"uint16": "uint16", "float16": "half", "float32": "float"}[samples.dtype.name]
    spec = oiio.ImageSpec(width, height, channels, kind)
    named = {1: ("Y",), 2: ("Y", "A"), 3: ("R", "G", "B"), 4: ("R", "G", "B", "A")}
    numbered = tuple(f"c{i:02d}" for i in range(channels))
    spec.channelnames = numbered if data else named.get(channels, numbered)
    if path.suffix.lower() == ".exr":
        spec.attribute("compression", "zip")
        spec.attribute("DateTime", _NO_DATE)
    else:
        spec.attribute("oiio:UnassociatedAlpha", 1)
        spec.attribute("oiio:ColorSpace", "srgb_rec709_scene" if srgb else "data")
    file = oiio.ImageOutput.create(str(path))
    if file is None:
        raise OSError(f"{path}: {oiio.geterror()}")
    try:
        if not file.open(str(path), spec) or not file.write_image(samples):
            raise OSError(f"{path}: {file.geterror()}")
    finally:
        file.close()
