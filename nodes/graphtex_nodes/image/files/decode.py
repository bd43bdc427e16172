"""Files to samples: what a file holds, before any conversion of values."""

import struct
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.image.files.formats import MOST_CHANNELS, MOST_PIXELS, READABLE, sniff

# What Pillow raises on damaged files, beside OSError: its decoders parse with struct, zlib and by index.
_DAMAGED = (OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, TypeError, struct.error, zlib.error)


@dataclass(frozen=True)
class Decoded:
    """Samples of a file with what the format says about them.

    Attributes
    ----------
    samples
        (h, w, c) in the file's own type, palettes and subsampling resolved, not yet upright.
    colours
        How many of the first channels are colour (or grey); the transfer function is for these. 0: all are data.
    alpha
        The channel that is alpha, -1 if none.
    premultiplied
        Colour is multiplied by alpha.
    linear
        By the format's convention colour is linear light (EXR, HDR).
    cmyk
        The four channels are ink, 255 = full.
    profile
        The embedded ICC profile.
    foreign_primaries
        An EXR's chromaticities are not those of Rec. 709.
    more
        Another page, part or frame of the same size follows.
    """

    samples: NDArray[Any]
    colours: int
    alpha: int = -1
    premultiplied: bool = False
    linear: bool = False
    cmyk: bool = False
    orientation: int = 1
    profile: bytes | None = None
    foreign_primaries: bool = False
    more: bool = False


def decode(path: Path) -> Decoded:
    """Read the first picture of a file, by its content and not by its suffix.

    Raises
    ------
    ValueError
        One line that names the file: missing, a folder, empty, no known picture format, damaged or cut off, over
        2^28 pixels or 16 channels.
    """
    if not path.exists():
        raise ValueError(f"{path}: no such file")
    if path.is_dir():
        raise ValueError(f"{path}: a folder, not a picture")
    with path.open("rb") as file:
        head = file.read(32)
    if not head:
        raise ValueError(f"{path}: the file is empty")
    name = sniff(head)
    if name is None:
        raise ValueError(f"{path}: not a picture in a known format ({', '.join(READABLE)})")
    if name == "PNG" and len(head) >= 24:
        _refuse_huge(path, *struct.unpack(">II", head[16:24]))
    if name == "NumPy":
        found = _decode_numpy(path)
    elif name == "PNG" and head[24:25] == b"\x10":
        _refuse_broken_png(path)
        found = _decode_deep(path, name)
    elif name in ("TIFF", "OpenEXR", "Radiance HDR"):
        found = _decode_deep(path, name)
    else:
        found = _decode_pillow(path, name)
    if found.samples.shape[2] > MOST_CHANNELS:
        raise ValueError(
            f"{path}: an Image has up to {MOST_CHANNELS} channels, the file holds {found.samples.shape[2]}"
        )
    return found


def _refuse_huge(path: Path, width: int, height: int) -> None:
    if width * height > MOST_PIXELS:
        raise ValueError(f"{path}: {width} x {height} pixels are more than the {MOST_PIXELS} that are read")
    if width < 1 or height < 1:
        raise ValueError(f"{path}: damaged: its size is {width} x {height}")


def _refuse_channels(path: Path, channels: int) -> None:
    if channels > MOST_CHANNELS:
        raise ValueError(f"{path}: an Image has up to {MOST_CHANNELS} channels, the file holds {channels}")


def _refuse_broken_png(path: Path) -> None:
    """Look at the checksum of each chunk: libpng would print what is wrong with one, and not only report it."""
    with path.open("rb") as file:
        file.seek(8)
        kind = b""
        while kind != b"IEND":
            length, kind = struct.unpack(">I4s", file.read(8).ljust(8, b"\xff"))
            left = file.read(length + 4) if length < 1 << 31 else b""
            if len(left) < length + 4:
                raise ValueError(f"{path}: damaged or cut off: it ends inside of a chunk")
            if zlib.crc32(left[:length], zlib.crc32(kind)) != int.from_bytes(left[length:], "big"):
                raise ValueError(f"{path}: damaged: a chunk does not fit its checksum")


def load_npy(path: Path) -> NDArray[Any]:
    """Map an array from a file; ValueError if it is none, is damaged or holds objects."""
    try:
        array: NDArray[Any] = np.load(path, mmap_mode="r", allow_pickle=False)
    except (*_DAMAGED, TokenError) as error:  # NumPy parses the header as Python
        raise ValueError(f"{path}: no array, or damaged: {_one_line(error)}") from error
    return array


def _decode_numpy(path: Path) -> Decoded:
    array = load_npy(path)
    if array.ndim not in (2, 3) or array.dtype.kind not in "buif" or array.size == 0:
        raise ValueError(f"{path}: a picture is numbers in (h, w) or (h, w, c), got {array.dtype} {array.shape}")
    _refuse_huge(path, array.shape[1], array.shape[0])
    samples = np.array(array.reshape(*array.shape[:2], -1))
    _refuse_channels(path, samples.shape[2])
    return Decoded(samples, *_layout(samples.shape[2]))


def _layout(channels: int) -> tuple[int, int]:
    """(colour channels, index of alpha) of a picture that does not name its channels."""
    return {1: (1, -1), 2: (1, 1), 3: (3, -1), 4: (3, 3)}.get(channels, (0, -1))


def _decode_pillow(path: Path, name: str) -> Decoded:
    """8-bit files. The plugin's class is opened itself: `PIL.Image.open` would set its own limit on the size."""
    from PIL import BmpImagePlugin, GifImagePlugin, JpegImagePlugin, PngImagePlugin, WebPImagePlugin

    plugins: dict[str, Any] = {
        "PNG": PngImagePlugin.PngImageFile,
        "JPEG": JpegImagePlugin.JpegImageFile,
        "WebP": WebPImagePlugin.WebPImageFile,
        "GIF": GifImagePlugin.GifImageFile,
        "BMP": BmpImagePlugin.BmpImageFile,
    }
    try:
        with path.open("rb") as file:
            picture = plugins[name](file)
            _refuse_huge(path, *picture.size)
            picture.load()
            orientation = picture.getexif().get(0x0112, 1)
            profile = picture.info.get("icc_profile")
            transparent = "transparency" in picture.info or picture.mode in ("LA", "PA", "RGBA", "La", "RGBa")
            grey = picture.mode in ("1", "L", "LA", "La")
            cmyk = picture.mode == "CMYK"
            mode = "CMYK" if cmyk else ("L" if grey else "RGB") + ("A" if transparent else "")
            samples = np.array(picture.convert(mode))
            more = getattr(picture, "n_frames", 1) > 1
    except _DAMAGED as error:
        if str(error).startswith(str(path)):
            raise
        raise ValueError(f"{path}: damaged or cut off: {_one_line(error)}") from error
    samples = samples.reshape(*samples.shape[:2], -1)
    if cmyk:
        return Decoded(samples, 4, cmyk=True, orientation=orientation, profile=profile)
    colours, alpha = _layout(samples.shape[2])
    return Decoded(samples, colours, alpha, orientation=orientation, profile=profile, more=more)


def _decode_deep(path: Path, name: str) -> Decoded:
    """TIFF, EXR, HDR and 16-bit PNG, by OpenImageIO in the file's own type."""
    import OpenImageIO as oiio

    try:
        found = _read_oiio(oiio, path, name, raw=False)
    except UnicodeDecodeError as error:  # OpenImageIO quotes the damaged bytes in its message
        raise ValueError(f"{path}: damaged: its header is unreadable") from error
    if found.cmyk:  # read again as ink: OpenImageIO's own conversion knows no profile
        return replace(_read_oiio(oiio, path, name, raw=True), cmyk=True, colours=4, alpha=-1, premultiplied=False)
    return found


def _read_oiio(oiio: Any, path: Path, name: str, *, raw: bool) -> Decoded:
    wish = oiio.ImageSpec()
    wish.attribute("oiio:UnassociatedAlpha", 1)  # no multiplication behind our back: we are told which it was
    wish.attribute("oiio:RawColor", int(raw))
    file = oiio.ImageInput.open(str(path), wish)
    if file is None:
        raise ValueError(f"{path}: damaged or cut off: {_one_line(oiio.geterror())}")
    try:
        spec = file.spec()
        _refuse_huge(path, spec.width, spec.height)
        _refuse_channels(path, spec.nchannels)
        if name == "TIFF" and str(spec.format) == "double":
            samples = _tiff_doubles(path)
        else:
            samples = file.read_image(0, 0, 0, spec.nchannels, "unknown")
        if samples is None:
            raise ValueError(f"{path}: damaged or cut off: {_one_line(file.geterror())}")
        more = file.seek_subimage(1, 0) and (file.spec().width, file.spec().height) == (spec.width, spec.height)
    finally:
        file.close()
    samples = samples.reshape(spec.height, spec.width, spec.nchannels)
    colours, alpha = _layout(spec.nchannels)
    if name == "OpenEXR":
        colours = sum(1 for channel in spec.channelnames if channel in ("R", "G", "B", "Y"))
    if spec.alpha_channel != alpha:
        alpha = spec.alpha_channel
        colours = min(colours, alpha) if alpha >= 0 else colours
    profile = spec.getattribute("ICCProfile")
    return Decoded(
        samples,
        colours,
        alpha,
        premultiplied=alpha >= 0 and (name == "OpenEXR" or not spec.get_int_attribute("oiio:UnassociatedAlpha", 0)),
        linear=name in ("OpenEXR", "Radiance HDR"),
        cmyk=spec.get_string_attribute("tiff:ColorSpace") == "CMYK" and spec.nchannels in (3, 4),
        orientation=spec.get_int_attribute("Orientation", 1),
        profile=None if profile is None else bytes(np.asarray(profile, np.uint8)),
        foreign_primaries=_foreign(spec.getattribute("chromaticities")),
        more=more,
    )


def _tiff_doubles(path: Path) -> NDArray[np.float64]:
    """Samples of a TIFF of doubles: of one row or in tiles, OpenImageIO 3.2 gives memory that it never wrote."""
    import tifffile

    try:
        with tifffile.TiffFile(path) as file:
            page = file.pages.first
            samples: NDArray[np.float64] = page.asarray()
            return np.moveaxis(samples, 0, -1) if samples.ndim == 3 and page.planarconfig == 2 else samples
    except (*_DAMAGED, tifffile.TiffFileError) as error:
        raise ValueError(f"{path}: damaged, cut off, or compressed in a way not known: {_one_line(error)}") from error


def _foreign(chromaticities: Any) -> bool:
    rec709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
    return chromaticities is not None and not np.allclose(chromaticities, rec709, atol=2e-3)


def _one_line(error: object) -> str:
    lines = str(error).strip().splitlines()
    return lines[0][:160] if lines else type(error).__name__
