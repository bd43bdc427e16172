"""Time and memory of plain synthesis, 256 x 256 to 512 x 512 pixels, beside G'MIC's on the same core.

Every measurement runs in a process of its own that is tied to its cores before anything is imported. On one core the
time is the process's own (so other work on the machine counts for nobody), with more it is the clock's.
"""

import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks import peers
from benchmarks.figures import Figure

REPEAT = 5
CLOCKED = 15
"""Turns of which the least counts: other work on the host slows two threads in most of them."""
SMALL, LARGE = 512, 2048
PIXELS = (LARGE / SMALL) ** 2
QUALITIES = {"fast": 0.5, "preview": 0.1}  # time over G'MIC's that is asked for


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Race on one core; then two threads, a large output, and what compiling costs once."""
    if not hasattr(os, "sched_setaffinity"):
        print("this system does not tie processes to cores: no figures of speed", file=sys.stderr)
        return
    one = measure("race", 1)
    other = one.get("G'MIC")
    if other is None:
        print("G'MIC is not installed (pip install 'graphtex[bench]'): no peer to compare with", file=sys.stderr)
    yield Figure("s, default, one core", one["default"], "" if other is None else f"<= {other:.4g}", other)
    for quality, share in QUALITIES.items():
        bound = "" if other is None else f"<= {share * other:.4g}"
        yield Figure(f"s, {quality}, one core", one[quality], bound, other)
    if len(os.sched_getaffinity(0)) > 1:
        bound = ">= 1.5" if idle() else ""
        if not bound:
            print("this machine is busy: the gain of a second thread is not judged", file=sys.stderr)
        both = measure("clock", 2)
        yield Figure("time by the clock with one thread over two", both["1"] / both["2"], bound)
    large = measure("large", 1)
    yield Figure(
        f"time of a pixel at {LARGE}^2 over that at {SMALL}^2", large["time"] / one["default"] / PIXELS, "<= 1.15"
    )
    yield Figure(f"GiB of memory at {LARGE}^2", large["memory"], "<= 2")
    with tempfile.TemporaryDirectory() as folder:
        yield Figure("s, first run of all, kernels compiled", measure("first", 1, GRAPHTEX_CACHE_DIR=folder)["default"])


def idle() -> bool:
    """Whether the machine does next to nothing else for a second."""

    def ticks() -> list[int]:
        return [int(word) for word in Path("/proc/stat").read_text().splitlines()[0].split()[1:]]

    before = ticks()
    time.sleep(1)
    spent = [now - then for now, then in zip(ticks(), before, strict=True)]
    return spent[3] + spent[4] > 0.9 * sum(spent[:8])


def measure(what: str, cores: int, **environment: str) -> dict[str, float]:
    """Run one of the measurements below in a new process on some cores."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.speed", what, str(cores)],
        env={**os.environ, **threads, **environment},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return found


def race() -> dict[str, float]:
    """Median processor time of each tool and quality, in turns."""
    exemplar, synthesise = _subject()
    calls: dict[str, Callable[[int], Any]] = {"default": partial(synthesise, SMALL)}
    for quality in QUALITIES:
        calls[quality] = partial(synthesise, SMALL, quality=quality)
    for tool, run in peers.synthesisers().items():
        calls[tool] = partial(run, exemplar, (SMALL, SMALL))
    return {name: statistics.median(times) for name, times in _times(calls, time.process_time).items()}


def clock() -> dict[str, float]:
    """Least time by the clock with one thread and with two, in turns, with two cores to run on.

    Whatever else runs on the machine, or on its host, can only add to these: the least is what threads do.
    """
    _, synthesise = _subject()
    calls = {str(count): partial(synthesise, SMALL, threads=count) for count in (1, 2)}
    return {name: min(times) for name, times in _times(calls, time.perf_counter, CLOCKED).items()}


def large() -> dict[str, float]:
    """Processor time and largest memory of one large synthesis."""
    _, synthesise = _subject()
    synthesise(SMALL, 0)
    start = time.process_time()
    synthesise(LARGE, 1)
    seconds = time.process_time() - start
    return {"time": seconds, "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20}


def first() -> dict[str, float]:
    """Processor time of the first synthesis of a process."""
    _, synthesise = _subject()
    start = time.process_time()
    synthesise(SMALL, 0)
    return {"default": time.process_time() - start}


def _times(
    calls: Mapping[str, Callable[[int], Any]], watch: Callable[[], float], repeat: int = REPEAT
) -> dict[str, list[float]]:
    """Times of each call over some seeds, in turns, after one that does not count."""
    times: dict[str, list[float]] = {name: [] for name in calls}
    for seed in range(repeat + 1):
        for name, call in calls.items():
            start = watch()
            call(seed)
            times[name].append(watch() - start)
    return {name: found[1:] for name, found in times.items()}


def _subject() -> tuple[Any, Callable[..., Any]]:
    """An exemplar, and a function of size and seed that synthesises from it."""
    from graphtex import Context
    from graphtex_nodes import optimize, pebbles

    exemplar = pebbles(width=256, height=256, rng=1).image

    def synthesise(side: int, seed: int, threads: int = 1, **parameters: Any) -> Any:
        return optimize(exemplar, width=side, height=side, rng=seed, ctx=Context(threads=threads), **parameters)

    return exemplar, synthesise


if __name__ == "__main__":
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[-int(sys.argv[2]) :])
    print(json.dumps({"race": race, "clock": clock, "large": large, "first": first}[sys.argv[1]]()))
