"""Nodes for tests of the command line: quick ones, a slow one, one that warns and one that fails."""

import time
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, FilePath, Gap, Image, Mask, Number, Rng, node, opener, writer

Array = NDArray[Any]


class Parts(NamedTuple):
    """A picture in two parts."""

    dark: Image
    bright: Mask


@node
def flat(*, value: Annotated[float, Field(ge=0, description="its grey")] = 0.5, width: int = 2) -> Image:
    """Make a picture of one grey.

    Longer text about greys.
    """
    return np.full((2, width, 1), value, np.float32)


@node(version=3)
def noise(*, width: int = 2, rng: Rng = 0) -> Image:
    """Make noise."""
    return rng.random((2, width, 1), dtype=np.float32)


@node
def brighten(image: Image, *, by: float = 0.1, ctx: Context = QUIET) -> Image:
    """Add to a picture; warn where it becomes too bright."""
    if image.max() + by > 1:
        ctx.warn("too bright")
    return image + np.float32(by)


@node
def parity(image: Image) -> Image:
    """Make 0 or 1 of a picture: its output often stays equal while its input changes."""
    return np.full_like(image, float(image.mean() > 0.5))


@node
def fussy(image: Image, *, limit: float = 1.0) -> Image:
    """Fail for what is brighter than the limit."""
    if image.max() > limit:
        raise ValueError(f"image: at most {limit} wanted, got {image.max():g}")
    return image


@node
def faulty(image: Image) -> Image:
    """Fail by a mistake of its own."""
    return image / {}["nothing"]


@node
def slow(image: Image, *, seconds: float = 10.0, ctx: Context = QUIET) -> Image:
    """Take its time."""
    for step in range(100):
        ctx.progress(step / 100, f"step {step}")
        time.sleep(seconds / 100)
    return image


@node
def chatty() -> Image:
    """Print while it works."""
    print("chatter")
    return np.zeros((2, 2, 1), np.float32)


@node
def deaf(image: Image, *, seconds: float = 10.0) -> Image:
    """Take its time and hear nothing meanwhile."""
    time.sleep(seconds)
    return image


@node
def parts(
    image: Image,
    mask: Mask | None = None,
    *,
    method: Annotated[Literal["hard", "soft"], Field(description="how it is parted")] = "hard",
    levels: Annotated[list[int], Field(min_length=1)],
    folder: FilePath | None = None,
) -> Parts:
    """Part a picture.

    Parameters
    ----------
    image
        What is parted.
    levels
        At which greys.

    Returns
    -------
    dark
        The dark part.
    bright
        True where it is bright.
    """
    return Parts(image * np.float32(0.5), image[:, :, 0] > 0.5)


@node
def row(images: list[Image | Gap]) -> Image:
    """Set pictures side by side; failed ones are black."""
    black = np.zeros((2, 2, 1), np.float32)
    return np.concatenate([black if isinstance(each, Gap) else each for each in images], axis=1)


@node
def mean(image: Image) -> Number:
    """Measure the mean."""
    return float(image.mean())


@opener(Image, suffixes=(".num",))
@node
def open_num(*, path: FilePath) -> Image:
    """Read a picture from numbers in a text file."""
    return np.loadtxt(path, dtype=np.float32, ndmin=2)[:, :, None]


@writer(Image, suffixes=(".num",))
def save_num(value: Array, path: Path) -> None:
    """Write the first channel as numbers in a text file."""
    np.savetxt(path, value[:, :, 0], fmt="%.4f")
