"""Row bands on a few threads: the only way in which kernels run in parallel.

Kernels take a range of rows and write only those, so their result cannot depend on how rows are cut into bands or on
the number of threads. There is no numba threading layer: a plain pool calls kernels that release the GIL.
"""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Protocol, TypeVar


class Work(Protocol):
    """What numerical code needs of a node's context; ``graphtex.Context`` is one."""

    @property
    def threads(self) -> int:
        """How many threads may run."""

    def check(self) -> None:
        """Raise if the work was cancelled."""

    def progress(self, fraction: float, message: str = "") -> None:
        """Tell how far the work is, 0 to 1; raise if it was cancelled."""

    def warn(self, message: str) -> None:
        """Tell the user about a doubtful result."""


@dataclass(frozen=True)
class Portion:
    """A part of some work, ``share`` of it from ``first`` on."""

    work: Work
    first: float
    share: float

    @property
    def threads(self) -> int:
        """How many threads may run."""
        return self.work.threads

    def check(self) -> None:
        """Raise if the whole work was cancelled."""
        self.work.check()

    def progress(self, fraction: float, message: str = "") -> None:
        """Tell how far this part is, 0 to 1."""
        self.work.progress(self.first + self.share * fraction, message)

    def warn(self, message: str) -> None:
        """Tell the user about a doubtful result."""
        self.work.warn(message)


@dataclass(frozen=True)
class Alone:
    """One thread that nobody stops or listens to: for what is done :func:`aside`."""

    threads: int = 1

    def check(self) -> None:
        """Go on."""

    def progress(self, fraction: float, message: str = "") -> None:
        """Tell nobody."""

    def warn(self, message: str) -> None:
        """Tell nobody."""


SLICE = 3e7
"""Elementary steps in a band: 0.02 to 0.2 s, so that cancelling is quick."""
BANDS = 4
"""Bands for each thread: whoever is done early takes the next one."""
WORTH_THREADS = 3e5
"""Elementary steps in all, a few tenths of a millisecond, below which waking threads costs more than they save."""


def for_rows(task: Callable[[int, int], object], rows: int, cost: float, work: Work) -> None:
    """Call ``task(first, stop)`` on bands that cover ``range(rows)``, on the calling thread and idle ones of the pool.

    Parameters
    ----------
    task
        Writes the rows ``first <= row < stop`` of its result and reads nothing that another band writes.
    rows
        How many rows there are.
    cost
        Estimated elementary steps (multiply-adds, or one load each) for one row; decides how long bands are.
    work
        ``work.check()`` is called between bands, on the calling thread.
    """
    with begun_rows(task, rows, cost, work) as finish:
        finish()


def for_each(task: Callable[[int], object], count: int, cost: float, work: Work) -> None:
    """Call ``task(number)`` for each number below ``count``, as :func:`for_rows` does for bands of rows."""

    def band(first: int, stop: int) -> None:
        for number in range(first, stop):
            task(number)

    for_rows(band, count, cost, work)


@contextmanager
def begun_rows(
    task: Callable[[int, int], object], rows: int, cost: float, work: Work, lead: float = 0.0
) -> Iterator[Callable[[], None]]:
    """:func:`for_rows` in two steps: idle threads begin at once, the function that is given does what is left.

    In between the caller may do something else that reads and writes nothing that a band writes or reads. If that holds
    the GIL, helpers cannot go from band to band meanwhile: ``lead`` is the share of the rows in the first band.
    """
    band = max(1, min(rows, int(SLICE / max(cost, 1.0))))
    helpers = work.threads - 1 if rows * cost > WORTH_THREADS else 0
    if helpers:
        band = max(1, min(band, -(-rows // (BANDS * work.threads))))
    ahead = max(band, min(int(lead * rows), int(SLICE / max(cost, 1.0)))) if helpers else band
    edges = [*range(0, rows, ahead)[:1], *range(ahead, rows, band), rows]
    left = iter(list(pairwise(edges)))  # one step under the GIL: each band is taken once
    helpers = min(helpers, len(edges) - 2)
    others = [_pool().submit(_take, task, left) for _ in range(helpers)]

    def finish() -> None:
        for first, stop in left:
            work.check()
            task(first, stop)
        for other in others:
            if not other.cancel():
                other.result()
        work.check()

    try:
        yield finish
    finally:  # nobody writes rows any more after this, whatever was raised
        for _ in left:
            pass
        wait([other for other in others if not other.cancel()])


Result = TypeVar("Result")


def aside(task: Callable[[], Result], work: Work) -> Callable[[], Result]:
    """Let another thread do something while the caller goes on; the function that is returned waits for its result.

    The caller does it then if no thread was free, or there is one only. ``task`` reads nothing that is written
    meanwhile and takes tenths of a second at most: nobody stops it.
    """
    if work.threads < 2:
        return task
    future = _pool().submit(task)

    def result() -> Result:
        return task() if future.cancel() else future.result()

    return result


def _take(task: Callable[[int, int], object], left: Iterator[tuple[int, int]]) -> None:
    """Work on bands as long as there are some."""
    for first, stop in left:
        task(first, stop)


@cache
def _pool() -> ThreadPoolExecutor:
    """Threads for all kernels of this process: they stay, since starting some takes as long as many a kernel."""
    return ThreadPoolExecutor(max(1, (os.cpu_count() or 2) - 1), thread_name_prefix="graphtex-kernel")


if hasattr(os, "register_at_fork"):  # a forked child has the pool but not its threads
    os.register_at_fork(after_in_child=_pool.cache_clear)
