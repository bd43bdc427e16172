"""Picture files made by hand, for what no writer at hand makes."""

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

ADAM7 = ((0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1))


def chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def png(
    samples: NDArray, colour_type: int, *, extra: tuple[tuple[bytes, bytes], ...] = (), interlaced: bool = False
) -> bytes:
    """PNG of uint8 or uint16 (h, w, c); `extra` chunks stand before the samples."""
    height, width = samples.shape[:2]
    raw = b""
    for y, x, dy, dx in ADAM7 if interlaced else ((0, 0, 1, 1),):
        part = samples[y::dy, x::dx]
        if part.size:
            raw += b"".join(b"\0" + row.astype(row.dtype.newbyteorder(">")).tobytes() for row in part)
    head = struct.pack(">IIBBBBB", width, height, samples.dtype.itemsize * 8, colour_type, 0, 0, int(interlaced))
    body = b"".join(chunk(*each) for each in extra)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + body + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


# Columns of sRGB's own profiles: its primaries relative to D50.
PRIMARIES = ((0.43607, 0.22249, 0.01392), (0.38515, 0.71687, 0.09708), (0.14307, 0.06061, 0.71410))


def profile(gamma: float, order: tuple[int, ...] = (0, 1, 2), *, parametric: bool = False) -> bytes:
    """ICC profile of a display with sRGB's primaries in another order, and one curve; grey for an empty order."""

    def fixed(*numbers: float) -> bytes:
        return struct.pack(f">{len(numbers)}i", *(round(number * 65536) for number in numbers))

    curve = struct.pack(">4s4xIH", b"curv", 1, round(gamma * 256)) + b"\0\0"
    if parametric:
        curve = struct.pack(">4s4xHH", b"para", 0, 0) + fixed(gamma)
    tags = [(b"wtpt", b"XYZ \0\0\0\0" + fixed(0.9642, 1.0, 0.8249))]
    if order:
        tags += [
            (name + b"XYZ", b"XYZ \0\0\0\0" + fixed(*PRIMARIES[i]))
            for name, i in zip((b"r", b"g", b"b"), order, strict=True)
        ]
        tags += [(name + b"TRC", curve) for name in (b"r", b"g", b"b")]
    else:
        tags += [(b"kTRC", curve)]
    table, data, start = b"", b"", 132 + 12 * len(tags)
    for name, body in tags:
        table += struct.pack(">4sII", name, start + len(data), len(body))
        data += body
    space = b"RGB " if order else b"GRAY"
    head = struct.pack(">I4sI4s4s4s", start + len(data), b"none", 0x02100000, b"mntr", space, b"XYZ ")
    head += struct.pack(">6H4s", 2026, 1, 1, 0, 0, 0, b"acsp") + bytes(28) + fixed(0.9642, 1.0, 0.8249)
    return head.ljust(128, b"\0") + struct.pack(">I", len(tags)) + table + data


def noise(*shape: int, dtype: str = "uint8", seed: int = 0) -> NDArray:
    """Random samples over the whole range of an integer type, or in [0, 1)."""
    rng = np.random.default_rng(seed)
    if dtype.startswith("float"):
        return rng.random(shape).astype(dtype)
    bounds = np.iinfo(dtype)
    return rng.integers(bounds.min, bounds.max, shape, dtype=dtype, endpoint=True)
