"""Embedded ICC profiles to sRGB: 8 bit through LittleCMS (Pillow), deeper samples by the profile's own matrix."""

import io
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.image.files.colour import Floats, encode_srgb

# Linear sRGB from XYZ relative to D50: inverse of the columns rXYZ, gXYZ, bXYZ that sRGB's own profiles hold.
_TO_SRGB = np.linalg.inv(
    np.array([[0.43607, 0.38515, 0.14307], [0.22249, 0.71687, 0.06061], [0.01392, 0.09708, 0.71410]])
)
_SAME = 1.6 / 255  # a profile whose conversion moves no probe colour further is sRGB itself


def to_srgb_8(samples: NDArray[np.uint8], profile: bytes) -> NDArray[np.uint8]:
    """Convert 8-bit grey, RGB or CMYK (h, w, 1, 3 or 4) to sRGB grey or RGB, relative colorimetric with black point.

    A profile that is sRGB itself (by what it does, not by its name) leaves every sample as it is.

    Raises
    ------
    ValueError
        If the profile is damaged, or for another kind of colour than the picture's.
    """
    from PIL import Image, ImageCms

    mode = {1: "L", 3: "RGB", 4: "CMYK"}[samples.shape[2]]
    try:
        source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        change = ImageCms.buildTransform(
            source,
            ImageCms.createProfile("sRGB"),
            mode,
            "RGB",
            renderingIntent=ImageCms.Intent.RELATIVE_COLORIMETRIC,
            flags=ImageCms.Flags.BLACKPOINTCOMPENSATION,
        )
    except (ImageCms.PyCMSError, OSError) as error:
        raise ValueError(f"it does not fit a {mode} picture, or is damaged ({error})") from error

    def convert(array: NDArray[np.uint8]) -> NDArray[np.uint8]:
        picture = Image.fromarray(array[..., 0] if mode == "L" else array, mode=None if mode != "CMYK" else mode)
        return np.array(ImageCms.applyTransform(picture, change))

    if mode != "CMYK":
        levels = np.arange(0, 256, 17, dtype=np.uint8)
        probe = (
            levels[:, None, None]
            if mode == "L"
            else np.stack(np.meshgrid(levels, levels, levels), -1).reshape(-1, 1, 3)
        )
        if np.abs(convert(probe).astype(int) - probe).max() <= _SAME * 255:
            return samples
    converted = convert(np.ascontiguousarray(samples))
    return converted[..., 1:2] if mode == "L" else converted


def to_srgb_deep(picture: Floats, profile: bytes) -> Floats:
    """Convert floats (h, w, 1 or 3) by the profile's curves and matrix; nothing is clipped above 1.

    Raises
    ------
    ValueError
        If the profile holds no such curves (it is a table of colours), is damaged or for another kind of colour.
    """
    tags = _tags(profile)
    names: tuple[str, ...]
    if picture.shape[2] == 1:
        names, matrix = ("kTRC",), None
    else:
        names = ("rTRC", "gTRC", "bTRC")
        columns = [_xyz(tags, key) for key in ("rXYZ", "gXYZ", "bXYZ")]
        matrix = _TO_SRGB @ np.stack(columns, axis=1)
    values = np.stack([_curve(tags, key, picture[..., i].astype(np.float64)) for i, key in enumerate(names)], axis=2)
    converted = encode_srgb(values if matrix is None else values @ matrix.T)
    return picture if np.abs(converted - picture).max() <= _SAME and _is_srgb(tags, names, matrix) else converted


def _is_srgb(tags: dict[str, bytes], names: tuple[str, ...], matrix: NDArray[Any] | None) -> bool:
    ramp = np.linspace(0, 1, 52)
    same = all(np.abs(encode_srgb(_curve(tags, key, ramp)) - ramp).max() <= _SAME / 4 for key in names)
    return same and (matrix is None or bool(np.abs(matrix - np.eye(3)).max() < 2e-3))


def _tags(profile: bytes) -> dict[str, bytes]:
    try:
        (count,) = struct.unpack_from(">I", profile, 128)
        table = [struct.unpack_from(">4sII", profile, 132 + 12 * i) for i in range(min(count, 1000))]
    except struct.error as error:
        raise ValueError("it is damaged") from error
    return {name.decode("latin-1"): profile[start : start + size] for name, start, size in table}


def _xyz(tags: dict[str, bytes], key: str) -> NDArray[np.float64]:
    body = tags.get(key, b"")
    if body[:4] != b"XYZ " or len(body) < 20:
        raise ValueError("it has no matrix for RGB")
    return np.array(struct.unpack_from(">3i", body, 8)) / 65536


def _curve(tags: dict[str, bytes], key: str, encoded: NDArray[np.float64]) -> NDArray[np.float64]:
    """Apply a tone curve (ICC.1:2022, sections 10.6 and 10.18): samples to linear light."""
    body = tags.get(key, b"")
    try:
        if body[:4] == b"curv":
            (count,) = struct.unpack_from(">I", body, 8)
            table = np.array(struct.unpack_from(f">{count}H", body, 12), np.float64)
            if count <= 1:
                return np.maximum(encoded, 0) ** (table[0] / 256 if count else 1.0)
            return np.interp(encoded, np.linspace(0, 1, count), table / 65535)
        if body[:4] == b"para":
            kind = struct.unpack_from(">H", body, 8)[0]
            numbers = struct.unpack_from(f">{(1, 3, 4, 5, 7)[kind]}i", body, 12)
            return _parametric(kind, [number / 65536 for number in numbers], encoded)
    except (struct.error, IndexError) as error:
        raise ValueError("it is damaged") from error
    raise ValueError("it is a table of colours without curves")


def _parametric(kind: int, numbers: list[float], x: NDArray[np.float64]) -> NDArray[np.float64]:
    g = numbers[0]
    a, b = (numbers[1], numbers[2]) if kind else (1.0, 0.0)
    power = np.maximum(a * x + b, 0) ** g
    if kind == 0:
        return power
    if kind == 1:
        return np.where(x >= -b / a, power, 0)
    if kind == 2:
        return np.where(x >= -b / a, power + numbers[3], numbers[3])
    c, d = numbers[3], numbers[4]
    e, f = (numbers[5], numbers[6]) if kind == 4 else (0.0, 0.0)
    return np.where(x >= d, power + e, c * x + f)
