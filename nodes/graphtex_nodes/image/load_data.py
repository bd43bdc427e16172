"""Maps, points and bundles from the files that their writers make (see save.py)."""

from pathlib import Path
from tokenize import TokenError
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import (
    AngleMap,
    Displacement,
    Elements,
    FilePath,
    LabelMap,
    Points,
    SourceMap,
    Texture,
    ViewStack,
    node,
    opener,
)
from graphtex_nodes.image.files.decode import decode, load_npy
from graphtex_nodes.image.save import DATA_SUFFIXES

File = Annotated[FilePath, Field(description="the file")]


@opener(LabelMap, suffixes=(".tiff", ".tif", ".npy", ".png"))
@node
def load_labels(*, path: File) -> LabelMap:
    """Read labels: whole numbers of any width, or the indices of a palette picture.

    Raises
    ------
    ValueError
        If the file is not a picture of whole numbers in one channel, or beyond int32.
    """
    samples = _palette_indices(path) if path.suffix.lower() == ".png" and path.is_file() else None
    if samples is None:
        samples = decode(path).samples
    if samples.shape[2] != 1 or samples.dtype.kind not in "ui":
        raise ValueError(f"{path}: labels are whole numbers in one channel, got {samples.dtype} {samples.shape}")
    if samples.max() > np.iinfo(np.int32).max or samples.min() < np.iinfo(np.int32).min:
        raise ValueError(f"{path}: labels are int32, got {samples.min()} to {samples.max()}")
    return samples[..., 0].astype(np.int32)


def _palette_indices(path: Path) -> NDArray[np.uint8] | None:
    """Indices (h, w, 1) of a palette PNG; None for another PNG."""
    from PIL import PngImagePlugin

    try:
        with path.open("rb") as file:
            picture = PngImagePlugin.PngImageFile(file)
            return np.array(picture)[..., None] if picture.mode == "P" else None
    except (OSError, SyntaxError, ValueError):
        return None  # no PNG, or damaged: `decode` says so


@opener(Displacement, suffixes=DATA_SUFFIXES)
@node
def load_displacement(*, path: File) -> Displacement:
    """Read the shift (x, y) of each pixel from two channels."""
    return _channels(path, 2, "a displacement")


@opener(AngleMap, suffixes=DATA_SUFFIXES)
@node
def load_angles(*, path: File) -> AngleMap:
    """Read the direction of each pixel, degrees clockwise from right, from one channel."""
    return _channels(path, 1, "an angle map")[..., 0]


@opener(SourceMap, suffixes=DATA_SUFFIXES)
@node
def load_source_map(*, path: File) -> SourceMap:
    """Read a source map, to replay a synthesis on other maps of the same exemplars."""
    return _channels(path, 6, "a source map")


def _channels(path: Path, count: int, what: str) -> NDArray[np.float32]:
    samples = decode(path).samples
    if samples.shape[2] != count or samples.dtype.kind != "f":
        raise ValueError(f"{path}: {what} is floats (h, w, {count}), got {samples.dtype} {samples.shape}")
    if not np.isfinite(samples).all():
        raise ValueError(f"{path}: {what} is finite, got NaN or infinite numbers")
    return samples.astype(np.float32)


@opener(Points, suffixes=(".csv", ".npy"))
@node
def load_points(*, path: File) -> Points:
    """Read points: ``x,y`` on each line, with or without a heading, or a NumPy array (n, 2)."""
    if path.suffix.lower() != ".npy":
        return _table(path, ("x", "y"))
    array = load_npy(path)
    if array.ndim != 2 or array.shape[1] != 2 or array.dtype.kind not in "uif":
        raise ValueError(f"{path}: points are numbers (n, 2), got {array.dtype} {array.shape}")
    return array.astype(np.float64)


@opener(Elements, suffixes=(".csv",))
@node
def load_elements(*, path: File) -> Elements:
    """Read elements: ``x,y,angle,scale`` on each line, with or without a heading."""
    rows = _table(path, ("x", "y", "angle", "scale"))
    return Elements(rows[:, :2], rows[:, 2], rows[:, 3])


def _table(path: Path, columns: tuple[str, ...]) -> NDArray[np.float64]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: no text in UTF-8") from error
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}") from error
    rows = []
    for number, line in enumerate(lines, 1):
        cells = [cell.strip() for cell in line.split(",")]
        if not line.strip() or (number == 1 and tuple(cells) == columns):
            continue
        try:
            row = [float(cell) for cell in cells]
        except ValueError as error:
            raise ValueError(f"{path}:{number}: expected numbers {','.join(columns)}, got {line[:60]!r}") from error
        if len(row) != len(columns) or not np.isfinite(row).all():
            raise ValueError(
                f"{path}:{number}: expected {len(columns)} finite numbers ({','.join(columns)}), got {line[:60]!r}"
            )
        rows.append(row)
    return np.array(rows, np.float64).reshape(-1, len(columns))


@opener(Texture, suffixes=(".npz",))
@node
def load_texture(*, path: File) -> Texture:
    """Read an entry of a texture database."""
    fields = _load_npz(path, {"image": "f", "mask": "b", "points": "f", "tag": "U"})
    return Texture(fields["image"], fields["mask"], fields["points"], str(fields["tag"]))


@opener(ViewStack, suffixes=(".npz",))
@node
def load_view_stack(*, path: File) -> ViewStack:
    """Read aligned views and their directions."""
    fields = _load_npz(path, {"views": "f", "directions": "f"})
    return ViewStack(fields["views"], fields["directions"])


def _load_npz(path: Path, kinds: dict[str, str]) -> dict[str, NDArray[Any]]:
    """Fields of an archive, each of a dtype's kind."""
    import zipfile
    import zlib

    try:
        with zipfile.ZipFile(path) as archive:
            names = {f"{key}.npy" for key in kinds}
            if set(archive.namelist()) != names:
                raise ValueError(f"its fields are {sorted(archive.namelist())}, expected {sorted(names)}")
            found = {}
            for key in kinds:
                with archive.open(f"{key}.npy") as file:
                    found[key] = np.lib.format.read_array(file, allow_pickle=False)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (ValueError, EOFError, SyntaxError, TokenError, zipfile.BadZipFile, zlib.error) as error:
        raise ValueError(f"{path}: not such an archive, or damaged: {error}") from error
    for key, kind in kinds.items():
        if found[key].dtype.kind != kind:
            raise ValueError(f"{path}: field {key} is of kind {kind!r}, got {found[key].dtype}")
        if kind == "f" and not np.isfinite(found[key]).all():
            raise ValueError(f"{path}: field {key}: expected finite numbers, got NaN or infinite ones")
    return found
