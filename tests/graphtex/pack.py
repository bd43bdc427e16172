"""A small pack of nodes for tests of graphs: little is computed, but every kind of socket and parameter occurs."""

from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from graphtex import FilePath, Image, Mask, Number, Rng, ScaleMap, node, opener, writer

Pixels = Annotated[int, Field(ge=1, le=4096, description="size in pixels")]


class Stroke(BaseModel):
    """A painted line."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    points: list[tuple[float, float]] = Field(description="(x, y) in pixels")
    radius: float = Field(default=1.0, gt=0, description="half the width")


class Layers(NamedTuple):
    """A coarse and a fine part."""

    base: Image
    detail: Image


@node
def noise(*, width: Pixels, height: Pixels = 4, rng: Rng = 0) -> Image:
    """Make white noise.

    Returns
    -------
    Image
        Uniform in [0, 1].
    """
    return rng.random((height, width, 1), dtype=np.float32)


@opener(Image, scheme="made")
@node
def made(*, name: str) -> Image:
    """Make a picture by its name."""
    return np.full((2, 2, 1), len(name) / 100, np.float32)


@opener(Image, suffixes=(".tex",))
@node
def open_text(*, path: FilePath, gain: Annotated[float, Field(gt=0)] = 1.0) -> Image:
    """Read a picture from numbers in a text file."""
    return np.loadtxt(path, dtype=np.float32, ndmin=2)[:, :, None] * np.float32(gain)


@writer(Image, suffixes=(".tex",))
def save_text(value: np.ndarray, path: Path, *, digits: Annotated[int, Field(ge=1, le=9)] = 6) -> None:
    """Write the first channel as numbers in a text file."""
    np.savetxt(path, value[:, :, 0], fmt=f"%.{digits}f")


@node
def threshold(
    image: Image,
    *,
    level: Annotated[float, Field(ge=0, le=1, description="what is above it is True")] = 0.5,
    method: Annotated[Literal["fixed", "adaptive"], Field(description="how the level is used")] = "fixed",
) -> Mask:
    """Mark what is bright.

    Parameters
    ----------
    image
        The picture whose first channel counts.
    """
    return image[:, :, 0] > (level if method == "fixed" else level * image.mean())


@node
def spread(mask: Mask, *, window: Annotated[int, Field(ge=2, le=64)] = 8) -> ScaleMap:
    """Turn a mask into a scale map."""
    return np.where(mask, np.float32(window / 8), np.float32(1))


@node
def average(image: Image) -> Number:
    """Measure the mean."""
    return float(image.mean())


@node
def split(image: Image) -> Layers:
    """Split a picture in two."""
    base = np.full_like(image, image.mean())
    return Layers(base, image - base)


@node
def blend(images: list[Image], mask: Mask | None = None, *, weights: list[float] | None = None) -> Image:
    """Average pictures."""
    return np.average(np.stack(images), axis=0, weights=weights).astype(np.float32)


@node
def paint(image: Image, *, strokes: list[Stroke], closed: bool = False) -> Image:
    """Paint over a picture."""
    return image


@node
def label(image: Image, *, text: str, tags: dict[str, str] | None = None) -> Image:
    """Label a picture."""
    return image
