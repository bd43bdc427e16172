"""Texture splicing: all its figures."""

from collections.abc import Iterator
from pathlib import Path

from benchmarks import splicing_detection, splicing_graphs, splicing_warp
from benchmarks.figures import Figure


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Detection and foreground, warp and speed, and graphs from start to end."""
    yield from splicing_detection.figures(pictures)
    yield from splicing_warp.figures(pictures)
    yield from splicing_graphs.figures(pictures)
