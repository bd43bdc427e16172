"""A texture as a folder that people can look into and edit: ``image.*``, ``mask.png``, ``points.csv``, ``tag.txt``."""

from pathlib import Path

import numpy as np

from graphtex import Context, Texture, file_digest
from graphtex_nodes.image.files.formats import READABLE
from graphtex_nodes.image.load import load_image, load_mask
from graphtex_nodes.image.load_data import load_points
from graphtex_nodes.image.save import save_image, save_mask, save_points
from graphtex_nodes.splicing.tags import RigidPart, checked_tag
from graphtex_nodes.splicing.texture_entry import texture_entry

MASK, POINTS, TAG = "mask.png", "points.csv", "tag.txt"


def read_texture(folder: Path, ctx: Context) -> Texture:
    """The texture of a folder.

    Raises
    ------
    ValueError
        A file is missing, damaged, or does not fit the others; the message names it.
    """
    image = load_image(path=image_file(folder), ctx=ctx)
    mask, points = load_mask(path=_there(folder / MASK)), load_points(path=_there(folder / POINTS))
    tag = _tag(_there(folder / TAG))
    try:
        return texture_entry(image, mask, points, tag=tag)
    except ValueError as error:
        what, _, reason = str(error).partition(": ")
        raise ValueError(f"{folder / {'mask': MASK, 'points': POINTS}[what]}: {reason}") from error


def write_texture(texture: Texture, folder: Path) -> None:
    """Make the folder of a texture. The picture's numbers are kept: 8 bits if that holds them, else 16, else floats."""
    folder.mkdir()
    picture = folder / "image.png"
    fits = texture.image.shape[2] <= 4 and 0 <= texture.image.min() <= texture.image.max() <= 1
    for depth in (8, 16) if fits else ():
        save_image(texture.image, picture, depth=depth)
        if np.array_equal(load_image(path=picture), texture.image):
            break
        picture.unlink()
    else:
        save_image(texture.image, folder / "image.tiff", depth="float")
    save_mask(texture.mask, folder / MASK)
    save_points(texture.points, folder / POINTS)
    (folder / TAG).write_text(f"{texture.tag}\n", encoding="utf-8")


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of each file that a texture is read from."""
    files = (image_file(folder), *(folder / name for name in (MASK, POINTS, TAG)))
    return {file.name: file_digest(file) for file in files}


def image_file(folder: Path) -> Path:
    """The picture of a folder; ValueError if there is none, or more than one."""
    found = sorted(file for file in folder.glob("image.*") if file.suffix.lower() in READABLE)
    if len(found) != 1:
        names = ", ".join(file.name for file in found) or "none"
        raise ValueError(f"{folder}: expected one picture called image.png, image.jpg or the like, got {names}")
    return found[0]


def _there(file: Path) -> Path:
    if not file.is_file():
        raise ValueError(f"{file}: there is no such file; a texture is image.*, {MASK}, {POINTS} and {TAG}")
    return file


def _tag(file: Path) -> RigidPart:
    try:
        text = file.read_text(encoding="utf-8-sig").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{file}: cannot be read as text: {error}") from error
    return checked_tag(text, str(file))
