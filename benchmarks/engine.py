"""What the framework itself costs."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import graphtex as gt
from benchmarks.figures import Figure, in_turns, seconds
from graphtex import Image, node

CHAIN = 1000
FIVE_NODES = """
graphtex: 1
nodes:
  a: {node: Sample, name: brick}
  b: {node: Grey, image: a}
  c: {node: PickChannels, image: b, channels: [0, 0, 0]}
  d: {node: StackMaps, maps: [b, c], kinds: [scalar, colour]}
  e: {node: Grey, image: c}
outputs:
  image: e
"""


@node
def blank() -> Image:
    """A black picture."""
    return np.zeros((64, 64, 1), np.float32)


@node
def brighten(image: Image, *, amount: float = 1.0) -> Image:
    """Add a constant."""
    return image + np.float32(amount)


def chain(length: int) -> gt.Graph:
    """Return a graph of nodes in a row."""
    graph = gt.Graph()
    last = graph.add(blank)
    for index in range(length):
        last = graph.add(brighten, f"step{index}", image=last, amount=1.0)
    graph.output("image", last)
    return graph


def plain_chain(length: int) -> np.ndarray:
    """Do what the chain does without the framework."""
    image = blank.function()
    for _ in range(length):
        image = brighten.function(image, amount=1.0)
    return image


def heavy_imports(*arguments: str) -> int:
    """Return how many heavy libraries a command imports."""
    done = subprocess.run(
        [sys.executable, "-X", "importtime", "-m", "graphtex", *arguments], capture_output=True, text=True, check=True
    )
    modules = {line.rpartition("|")[2].strip().split(".")[0] for line in done.stderr.splitlines()}
    return len(modules & {"numba", "scipy", "skimage", "llvmlite", "OpenImageIO", "PIL", "tifffile"})


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Measure overheads per node, start-up and a fully cached run."""
    graph = chain(CHAIN)
    bare = seconds(lambda: plain_chain(CHAIN), 3) * 1e3 / CHAIN
    yield Figure(
        "ms a node, 1,000 in a row, no cache",
        seconds(lambda: gt.run(graph, cache=False), 3) * 1e3 / CHAIN,
        "<= 1",
        bare,
    )
    with tempfile.TemporaryDirectory() as folder:
        first = seconds(lambda: gt.run(graph, cache=folder), 1) * 1e3 / CHAIN
        yield Figure("ms a node, into an empty cache", first, "", bare)
        yield Figure("ms a node, all cached", seconds(lambda: gt.run(graph, cache=folder), 3) * 1e3 / CHAIN, "", first)
    yield Figure("heavy imports of graphtex --help", heavy_imports("--help"), "<= 0")
    yield Figure("heavy imports of graphtex nodes", heavy_imports("nodes"), "<= 0")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "five.yaml"
        file.write_text(FIVE_NODES, encoding="utf-8")
        command = [sys.executable, "-m", "graphtex"]
        environment = {**os.environ, "GRAPHTEX_CACHE_DIR": folder}

        def call(*arguments: str) -> None:
            subprocess.run([*command, *arguments], check=True, capture_output=True, env=environment)

        run = ("run", str(file), "--out", folder)
        call(*run)
        listing, again = in_turns(lambda: call("nodes"), lambda: call(*run), repeat=7)
        yield Figure("second run of five nodes, over graphtex nodes", again / listing, "<= 2")
