"""Writers: every socket type that holds an array to files.

The defaults lose nothing but the rounding of a picture's 8 bits; what a format cannot hold is a ValueError. Equal
values give equal bytes.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import (
    AngleMap,
    Displacement,
    Elements,
    Image,
    LabelMap,
    Mask,
    Points,
    ScaleMap,
    SourceMap,
    Texture,
    Vector,
    ViewStack,
    writer,
)
from graphtex_nodes.image.files.colour import Encoding
from graphtex_nodes.image.files.encode import encode, write_deep, write_tiff
from graphtex_nodes.image.files.follow import format_like
from graphtex_nodes.image.files.formats import WRITABLE, Depth, require_options
from graphtex_nodes.image.files.labels import palette

DATA_SUFFIXES = (".npy", ".tiff", ".tif", ".exr")


def _check_image(
    suffix: str, *, depth: Depth | None = None, quality: int | None = None, encoding: Encoding = "auto"
) -> None:
    require_options(suffix, depth=depth, quality=quality)


def _only_png(suffix: str, *, depth: int | None = None) -> None:
    if depth is not None and suffix != ".png":
        raise ValueError(f"depth is for .png, the other formats hold the data itself; got {depth}: leave it out")


@writer(Image, suffixes=WRITABLE, default=".png", check=_check_image, like=format_like)
def save_image(
    value: NDArray[Any],
    path: Path,
    *,
    depth: Annotated[
        Depth | None, Field(description="bits of a sample, or half or float; default: as what it is made from")
    ] = None,
    quality: Annotated[int | None, Field(ge=1, le=100, description="of .jpg (default 95) and lossy .webp")] = None,
    encoding: Annotated[
        Encoding, Field(description="what the file's numbers are; auto: linear in .exr and .hdr")
    ] = "auto",
) -> None:
    """Write a picture; `load_image` with the same ``encoding`` undoes it. See `encode` for what is stored."""
    encode(value, path, depth=depth, quality=quality, encoding=encoding)


@writer(Mask, suffixes=(".png", ".npy"), default=".png", check=_only_png)
def save_mask(
    value: NDArray[np.bool_],
    path: Path,
    *,
    depth: Annotated[Literal[1, 8] | None, Field(description="bits of a .png; default 8")] = None,
) -> None:
    """Write a mask: True is white."""
    _only_png(path.suffix.lower(), depth=depth)
    if path.suffix.lower() == ".npy":
        _save_npy(value, path)
        return
    from PIL import Image as Pictures

    picture = Pictures.fromarray(value.astype(np.uint8) * 255)
    (picture.convert("1", dither=Pictures.Dither.NONE) if depth == 1 else picture).save(path, "PNG")


@writer(ScaleMap, suffixes=(".tiff", ".tif", ".exr", ".npy", ".png"), default=".tiff", check=_only_png)
def save_scale(
    value: NDArray[np.float32],
    path: Path,
    *,
    depth: Annotated[Literal[8, 16] | None, Field(description="bits of a .png; default 8")] = None,
) -> None:
    """Write a scale map: the scale itself as float32; a .png is a view, grey 128 (16 bit: 32768) where it is 1.

    The view rounds to steps of 1/128 (1/32768) and clips from 255/128 (65535/32768) on.
    """
    _only_png(path.suffix.lower(), depth=depth)
    if path.suffix.lower() != ".png":
        _save_data(value[..., None], path)
    elif depth == 16:
        grey = np.rint(np.clip(value * 32768.0, 0, 65535)).astype(np.uint16)
        write_deep(grey[..., None], path)
    else:
        from PIL import Image as Pictures

        Pictures.fromarray(np.rint(np.clip(value * 128.0, 0, 255)).astype(np.uint8)).save(path, "PNG")


@writer(LabelMap, suffixes=(".tiff", ".tif", ".npy", ".png"), default=".tiff")
def save_labels(value: NDArray[np.int32], path: Path) -> None:
    """Write labels as int32; a .png holds labels from 0 to 255 as the indices of a palette of distinct colours."""
    if path.suffix.lower() != ".png":
        _save_data(value[..., None], path)
        return
    from PIL import Image as Pictures

    if value.size and (value.min() < 0 or value.max() > 255):
        raise ValueError(f"PNG holds labels from 0 to 255; got {value.min()} to {value.max()}: write .tiff or .npy")
    picture = Pictures.fromarray(value.astype(np.uint8))
    picture.putpalette(palette(np.arange(256)).tobytes())
    picture.save(path, "PNG")


@writer(AngleMap, suffixes=DATA_SUFFIXES, default=".npy")
def save_angles(value: NDArray[np.float32], path: Path) -> None:
    """Write the degrees of each pixel as one float32 channel."""
    _save_data(value[..., None], path)


@writer(Displacement, suffixes=DATA_SUFFIXES, default=".npy")
def save_displacement(value: NDArray[np.float32], path: Path) -> None:
    """Write the shifts (x, y) of each pixel as two float32 channels."""
    _save_data(value, path)


@writer(SourceMap, suffixes=DATA_SUFFIXES, default=".npy")
def save_source(value: NDArray[np.float32], path: Path) -> None:
    """Write the six float32 channels of a source map."""
    _save_data(value, path)


@writer(Points, suffixes=(".csv", ".npy"), default=".csv")
def save_points(value: NDArray[np.float64], path: Path) -> None:
    """Write one line ``x,y`` for each point, below a heading, with all digits that matter."""
    if path.suffix.lower() == ".npy":
        _save_npy(value, path)
    else:
        _save_csv("x,y", value.tolist(), path)


@writer(Vector, suffixes=(".csv", ".npy"), default=".csv")
def save_vector(value: NDArray[np.float64], path: Path) -> None:
    """Write one number on each line, below the heading ``value``."""
    if path.suffix.lower() == ".npy":
        _save_npy(value, path)
    else:
        _save_csv("value", value[:, None].tolist(), path)


@writer(Elements, suffixes=(".csv",), default=".csv")
def save_elements(value: Elements, path: Path) -> None:
    """Write one line ``x,y,angle,scale`` for each element, below a heading."""
    rows = np.column_stack([value.points, value.angles, value.scales])
    _save_csv("x,y,angle,scale", rows.tolist(), path)


@writer(Texture, suffixes=(".npz",))
def save_texture(value: Texture, path: Path) -> None:
    """Write the fields ``image``, ``mask``, ``points`` and ``tag`` as a NumPy archive, without pickles."""
    _save_npz(path, image=value.image, mask=value.mask, points=value.points, tag=np.array(value.tag))


@writer(ViewStack, suffixes=(".npz",), default=".npz")
def save_views(value: ViewStack, path: Path) -> None:
    """Write the fields ``views`` and ``directions`` as a NumPy archive, without pickles."""
    _save_npz(path, views=value.views, directions=value.directions)


def _save_data(value: NDArray[Any], path: Path) -> None:
    """Channels (h, w, c) as they are: numbers, no colour."""
    suffix = path.suffix.lower()
    if suffix == ".npy":
        _save_npy(value[..., 0] if value.shape[2] == 1 else value, path)
    elif suffix == ".exr":
        write_deep(np.ascontiguousarray(value), path, data=value.shape[2] > 1)
    else:
        write_tiff(np.ascontiguousarray(value), path, data=True)


def _save_npy(value: NDArray[Any], path: Path) -> None:
    with path.open("wb") as file:
        np.save(file, value, allow_pickle=False)


def _save_csv(heading: str, rows: Iterable[Iterable[float]], path: Path) -> None:
    lines = [heading, *(",".join(repr(number) for number in row) for row in rows)]
    path.write_bytes("".join(f"{line}\n" for line in lines).encode())


def _save_npz(path: Path, **fields: NDArray[Any]) -> None:
    """As `numpy.savez_compressed`, but with one fixed date in the archive whatever the clock says."""
    import zipfile

    with zipfile.ZipFile(path, "w") as archive:
        for name, value in fields.items():
            entry = zipfile.ZipInfo(f"{name}.npy", date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(entry, "w", force_zip64=True) as file:
                np.lib.format.write_array(file, np.asanyarray(value), allow_pickle=False)
