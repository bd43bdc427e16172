"""What a picture is written as where nothing says so: as the pictures that it was made from."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from graphtex_nodes.image.files.decode import load_npy
from graphtex_nodes.image.files.formats import Depth, format_of, sniff

_SUFFIXES = {"PNG": ".png", "TIFF": ".tif", "OpenEXR": ".exr", "Radiance HDR": ".exr", "NumPy": ".npy"}
_DEPTHS: tuple[Depth, ...] = (8, 16, "half", "float")


def format_like(files: Sequence[Path], suffix: str | None) -> tuple[str, dict[str, Any]]:
    """Suffix and options of `save_image` that keep what files hold: those of the deepest, the first of equal ones.

    Radiance HDR is kept as EXR, which holds alpha and grey too; what has 8 bit and is no TIFF as PNG. A `suffix` that
    is given stays, with as much depth as its format has.
    """
    found = [(name, depth_of(file, name)) for file in files if (name := _name(file))]
    if not found:
        return suffix or ".png", {}
    name, depth = max(found, key=lambda entry: _DEPTHS.index(entry[1]))
    chosen = suffix or _SUFFIXES.get(name, ".png")
    fitting = [each for each in format_of(chosen).depths if _DEPTHS.index(each) <= _DEPTHS.index(depth)]
    if not fitting or (suffix and depth == 8):
        return chosen, {}
    return chosen, {"depth": max(fitting, key=_DEPTHS.index)}


def depth_of(file: Path, name: str) -> Depth:
    """Depth that holds what is in a file of the format `name`, by its header."""
    if name == "PNG":
        with file.open("rb") as opened:
            return 16 if opened.read(25)[24:] == b"\x10" else 8
    if name == "NumPy":
        kind = load_npy(file).dtype
        return _depth(kind.kind, kind.itemsize)
    if name not in ("TIFF", "OpenEXR", "Radiance HDR"):
        return 8
    import OpenImageIO as oiio

    picture = oiio.ImageInput.open(str(file))
    if picture is None:  # the run could read it: it has been damaged since
        oiio.geterror()
        return 8
    sample = picture.spec().format
    picture.close()
    return _depth("f" if str(sample) in ("half", "float", "double") else "u", sample.size())


def _depth(kind: str, size: int) -> Depth:
    if kind == "f":
        return "half" if size == 2 else "float"
    return 8 if size == 1 else 16 if size == 2 else "float"


def _name(file: Path) -> str | None:
    """Format of a file; None if it is gone, or is no picture any more."""
    try:
        with file.open("rb") as opened:
            return sniff(opened.read(32))
    except OSError:
        return None
