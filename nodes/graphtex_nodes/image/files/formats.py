"""What each picture format can hold. Writers, errors and the table in docs/pictures.md all come from here."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

Depth = Literal[8, 16, "half", "float"]

MOST_PIXELS = 1 << 28  # 16384 x 16384; a header that promises more is refused before anything is decoded
MOST_CHANNELS = 16


@dataclass(frozen=True)
class Format:
    """A picture file format as it is written.

    Attributes
    ----------
    depths
        What a sample may be; the first is the default. Empty: the format has one depth of its own.
    lossless
        Reading gives back exactly the numbers of that depth (for .jpg never, for .webp unless a quality is given).
    linear
        By the format's convention colour is linear light and multiplied by alpha.
    """

    name: str
    suffixes: tuple[str, ...]
    depths: tuple[Depth, ...]
    channels: tuple[int, ...]
    lossless: bool = True
    linear: bool = False
    quality: bool = False
    largest_side: int = 1 << 20
    note: str = ""


_ANY = tuple(range(1, MOST_CHANNELS + 1))

FORMATS = (
    Format("PNG", (".png",), (8, 16), (1, 2, 3, 4)),
    Format("JPEG", (".jpg", ".jpeg"), (8,), (1, 3), lossless=False, quality=True, largest_side=65535,
           note="quality 95 unless given, colour at full resolution (4:4:4)"),
    Format("TIFF", (".tif", ".tiff"), (16, 8, "half", "float"), _ANY, note="deflate"),
    Format("WebP", (".webp",), (8,), (3, 4), quality=True, largest_side=16383, note="lossy only if a quality is given"),
    Format("OpenEXR", (".exr",), ("half", "float"), _ANY, linear=True, note="zip"),
    Format("Radiance HDR", (".hdr",), (), (3,), lossless=False, linear=True,
           note="8-bit mantissas with a shared exponent: steps of 1 % of the largest channel"),
    Format("NumPy", (".npy",), ("float",), _ANY, note="the array itself"),
)  # fmt: skip

WRITABLE = tuple(suffix for entry in FORMATS for suffix in entry.suffixes)
READABLE = (*WRITABLE, ".bmp", ".gif")

_MAGIC = (
    (b"\x89PNG\r\n\x1a\n", "PNG"),
    (b"\xff\xd8\xff", "JPEG"),
    (b"II*\0", "TIFF"),
    (b"MM\0*", "TIFF"),
    (b"II+\0", "TIFF"),  # BigTIFF
    (b"MM\0+", "TIFF"),
    (b"v/1\x01", "OpenEXR"),
    (b"#?RADIANCE", "Radiance HDR"),
    (b"#?RGBE", "Radiance HDR"),
    (b"\x93NUMPY", "NumPy"),
    (b"GIF8", "GIF"),
    (b"BM", "BMP"),
)


def sniff(head: bytes) -> str | None:
    """Return the format of a file by its first bytes (32 will do), or None; its suffix is not asked.

    >>> sniff(b"BM" + bytes(30))
    'BMP'
    """
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "WebP"
    return next((name for magic, name in _MAGIC if head.startswith(magic)), None)


def format_of(suffix: str) -> Format:
    """Return the format that a suffix names; ValueError lists those that can be written."""
    found = next((entry for entry in FORMATS if suffix.lower() in entry.suffixes), None)
    if found is None:
        raise ValueError(f"pictures are written as {_either(WRITABLE)}, got {suffix or 'no suffix'}")
    return found


def require_options(
    suffix: str, *, depth: Depth | None = None, quality: int | None = None, channels: int | None = None
) -> None:
    """Raise ValueError if a format does not hold that depth or knows no quality; `channels` narrows what it advises."""
    entry = format_of(suffix)
    if depth is not None and depth not in entry.depths:
        holds = (
            f"holds {_either([depth_name(each) for each in entry.depths])}"
            if entry.depths
            else "has one depth of its own"
        )
        raise ValueError(f"{entry.name} {holds}; got depth {depth}: write {_others(depth, channels)}")
    if quality is not None and not entry.quality:
        lossy = [other.suffixes[0] for other in FORMATS if other.quality]
        raise ValueError(f"{entry.name} has no quality; got quality {quality}: write {_either(lossy)} or leave it out")


def require(path: Path, shape: tuple[int, int, int], depth: Depth | None, quality: int | None) -> tuple[Format, Depth]:
    """Return the format of a path and the depth to write; for HDR, which has one of its own, ``"float"``.

    Raises
    ------
    ValueError
        If the format does not hold that many channels, that depth, such a size, or knows no quality.
    """
    entry = format_of(path.suffix)
    height, width, channels = shape
    if channels not in entry.channels:
        raise ValueError(
            f"{entry.name} holds {_either(entry.channels)} channels; got {channels}: write {_others(depth, channels)}"
        )
    require_options(path.suffix, depth=depth, quality=quality, channels=channels)
    if max(height, width) > entry.largest_side:
        raise ValueError(f"{entry.name} holds sides up to {entry.largest_side} pixels; got {width} x {height}")
    return entry, depth or (entry.depths[0] if entry.depths else "float")


def depth_name(depth: Depth) -> str:
    """Return "8 bit", "16 bit", "half" or "float"."""
    return depth if isinstance(depth, str) else f"{depth} bit"


def _others(depth: Depth | None, channels: int | None) -> str:
    fitting = [
        entry.suffixes[0]
        for entry in FORMATS
        if (channels is None or channels in entry.channels) and (depth is None or depth in entry.depths)
    ]
    return _either(fitting)


def _either(items: Sequence[object]) -> str:
    """``[1, 2, 3]`` as "1, 2 or 3"; a long run of numbers as "1 to 16"."""
    words = [str(item) for item in items]
    if len(items) > 4 and all(isinstance(item, int) for item in items):
        return f"{items[0]} to {items[-1]}"
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"


def table() -> str:
    """Return what each format holds as a table in Markdown."""
    rows = ["| format | files | depth (first: default) | channels | lossless | remarks |", "|---|---|---|---|---|---|"]
    for entry in FORMATS:
        depths = ", ".join(depth_name(depth) for depth in entry.depths) or "its own"
        lossless = "yes" if entry.lossless else "no"
        remarks = "; ".join(filter(None, ["linear light" if entry.linear else "", entry.note]))
        channels = _either(entry.channels)
        rows.append(f"| {entry.name} | {' '.join(entry.suffixes)} | {depths} | {channels} | {lossless} | {remarks} |")
    return "\n".join(rows)
