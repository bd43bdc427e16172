"""Graphs of splicing from start to end: two new pictures, and all pairs of a database."""

import itertools
import statistics
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

import graphtex as gt
from benchmarks.figures import Figure, seconds
from graphtex import Texture
from graphtex_nodes import prepare_texture, textons
from graphtex_nodes.image.save import save_image
from graphtex_nodes.splicing.load_prepared import save_prepared

SIDE = 128
PAIRS = 5
FORMS: tuple[Literal["disc", "leaf", "flower"], ...] = ("disc", "leaf", "flower")
KINDS: tuple[Literal["square", "hexagonal", "random"], ...] = ("square", "hexagonal", "random")


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Seconds of both; no kernel is compiled in them."""
    yield from _two_pictures()
    yield from _matrix()


def drawn(number: int) -> Any:
    """Elements of one of nine forms and arrangements, each number other ones."""
    form, kind = FORMS[number % 3], KINDS[number // 3 % 3]
    return textons(width=SIDE, height=SIDE, size=24.0, form=form, arrangement=kind, jitter=0.05, rng=number)


def _two_pictures() -> Iterator[Figure]:
    """The shipped graph on one thread with an empty cache each time, in a running Python and as a command."""
    graph, run, command = gt.load("splicing/splice-pictures"), [], []
    with TemporaryDirectory() as folder:
        for number in range(PAIRS + 1):
            files = [Path(folder) / f"{name}-{number}.png" for name in ("elements", "arrangement")]
            for file, seed in zip(files, (number, 10 + 2 * number), strict=True):
                save_image(drawn(seed).image, file)
            given = dict(zip(("elements", "arrangement"), files, strict=True))
            run.append(seconds(partial(gt.run, graph, given, cache=Path(folder) / f"run-{number}"), 1))
            sets = itertools.chain.from_iterable(("--set", f"{name}={file}") for name, file in given.items())
            line = [sys.executable, "-m", "graphtex", "run", "splicing/splice-pictures", *sets, "--quiet"]
            line += ["--out", f"{folder}/out", "--cache", f"{folder}/command-{number}"]
            command.append(seconds(partial(subprocess.run, line, check=True, capture_output=True), 1))
    size = f"{SIDE} x {SIDE}"
    yield Figure(f"splice-pictures, two new pictures, {size}, s", statistics.median(run[1:]), "<= 2")
    yield Figure(f"the same as a command, from Python's start to the files, {size}, s", statistics.median(command[1:]))


def _matrix() -> Iterator[Figure]:
    """The graph of all pairs of ten textures, from a database on disk and without a cache, on two threads."""
    graph = gt.load("splicing/splice-matrix")
    with TemporaryDirectory() as folder:
        for seed in range(10):
            made = drawn(seed)
            save_prepared(
                prepare_texture(Texture(made.image, made.mask, made.centres, "F=d")), Path(folder) / f"{seed}.texture"
            )
        run = partial(gt.run, graph, {"textures": folder}, cache=False, executor="threads", workers=2)
        yield Figure(
            f"all pairs of ten textures of a database, {SIDE} x {SIDE}, two threads, s", seconds(run, 1), "<= 30"
        )
