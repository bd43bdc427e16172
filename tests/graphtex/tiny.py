"""Nodes that count their calls, draw random numbers, fail when told to, and wait: for tests of runs."""

import threading
import weakref
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from graphtex import QUIET, Axes, Context, Elements, FilePath, Gap, Image, Mask, Number, Rng, node

CALLS: list[str] = []
"""What ran, in order; empty before each test that asks for `tiny_nodes`."""
ALIVE: "list[weakref.ref[np.ndarray]]" = []
"""What `tracked` has made."""
ENTERED = threading.Event()
"""Set when `wait` runs."""


class Halves(NamedTuple):
    low: Image
    high: Image


class Spare(NamedTuple):
    used: Image
    spare: Image


def picture(*values: float) -> np.ndarray:
    """One row of grey pixels."""
    return np.array(values, np.float32).reshape(1, -1, 1)


@node
def const(*, value: float = 0, size: Annotated[int, Field(ge=1)] = 2) -> Image:
    """Make an even picture."""
    CALLS.append(f"const {value:g}")
    return np.full((1, size, 1), value, np.float32)


@node
def add(image: Image, *, amount: float = 1) -> Image:
    """Add a number."""
    CALLS.append(f"add {amount:g}")
    return image + np.float32(amount)


@node
def whole(image: Image) -> Image:
    """Round down."""
    CALLS.append("whole")
    return np.floor(image)


@node
def grain(image: Image | None = None, *, size: int = 2, rng: Rng = 0) -> Image:
    """Make white noise."""
    CALLS.append("grain")
    return rng.random((1, size, 1), dtype=np.float32)


@node
def average(image: Image) -> Number:
    """Measure the mean."""
    CALLS.append("average")
    return float(image.mean())


@node
def halves(image: Image) -> Halves:
    """Split in two."""
    CALLS.append("halves")
    return Halves(image / 2, image - image / 2)


@node
def both(image: Image, mask: Image) -> Image:
    """Multiply."""
    CALLS.append("both")
    return image * mask


@node
def total(images: list[Image]) -> Image:
    """Add pictures up."""
    CALLS.append(f"total {len(images)}")
    return np.sum(np.stack(images), axis=0, dtype=np.float32)


@node
def survey(cells: list[Image | Gap]) -> Image:
    """Show the mean of each cell, -1 for a gap."""
    CALLS.append("survey")
    return picture(*(-1 if isinstance(cell, Gap) else float(cell.mean()) for cell in cells))


@node
def reasons(cells: list[Image | Gap]) -> Number:
    """Count the letters that gaps say."""
    CALLS.append("reasons")
    return sum(len(cell.label) + len(cell.reason) for cell in cells if isinstance(cell, Gap))


@node
def fragile(image: Image | None = None, *, value: float = 0, bad: float = 0) -> Image:
    """Fail for one value."""
    CALLS.append(f"fragile {value:g}")
    if value == bad:
        raise ValueError(f"value: {value:g} is bad")
    return picture(value)


@node
def read(*, path: FilePath) -> Image:
    """Read numbers from a file."""
    CALLS.append(f"read {Path(path).name}")
    return picture(*map(float, Path(path).read_text().split()))


@node
def rewrite(*, path: FilePath, text: str) -> Image:
    """Read numbers from a file that somebody changes meanwhile."""
    CALLS.append("rewrite")
    Path(path).write_text(text)
    return picture(*map(float, Path(path).read_text().split()))


@node
def asks_others(image: Image) -> Image:
    """Pass on what a node that warns makes of a picture."""
    return warns(image)


@node
def warns(image: Image, *, ctx: Context = QUIET) -> Image:
    """Warn, and tell of progress."""
    CALLS.append("warns")
    ctx.progress(0.5, "half")
    ctx.warn("it is odd")
    return image


@node
def wait(image: Image | None = None, *, ctx: Context = QUIET) -> Image:
    """Wait until the run is stopped, 20 seconds at most."""
    CALLS.append("wait")
    ENTERED.set()
    for _ in range(2000):
        ctx.check()
        threading.Event().wait(0.01)
    raise AssertionError("nobody stopped this")


@node
def tracked(image: Image | None = None) -> Image:
    """Make a large picture whose life is watched."""
    CALLS.append(f"alive {sum(made() is not None for made in ALIVE)}")
    made = np.full((64, 64, 1), 0 if image is None else image[0, 0, 0] + 1, np.float32)
    ALIVE.append(weakref.ref(made))
    return made


@node
def spares() -> Spare:
    """Make two large pictures whose lives are watched."""
    CALLS.append("spares")
    made = Spare(np.zeros((64, 64, 1), np.float32), np.ones((64, 64, 1), np.float32))
    ALIVE.extend(map(weakref.ref, made))
    return made


@node
def scatter(*, count: int = 3) -> Elements:
    """Place elements on a line."""
    CALLS.append("scatter")
    along = np.arange(count, dtype=np.float64)
    return Elements(np.stack([along, along], axis=1), along * 10, along + 1)


@node
def count(elements: Elements) -> Number:
    """Count elements."""
    CALLS.append("count")
    return len(elements.scales)


@node
def cut(image: Annotated[Image, Axes("h w c")], masks: list[Annotated[Mask, Axes("h w")]]) -> Image:
    """Black out what all masks mark."""
    CALLS.append("cut")
    return image * ~np.logical_and.reduce(masks)[:, :, None]


@node
def liar(image: Image, *, what: str = "dtype") -> Image:
    """Break its own output's type."""
    return {"dtype": image > 0, "rank": image[0], "nan": image * np.nan, "none": None}[what]
