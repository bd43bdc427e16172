"""Row bands on a few threads: the only way in which kernels run in parallel.

Kernels take a range of rows and write only those, so their result cannot depend on how rows are cut into bands or on
the number of threads. There is no numba threading layer: a plain pool calls kernels that release the GIL.
"""

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Protocol


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


SLICE = 3e7
"""Elementary steps in a band: 0.02 to 0.2 s, so that cancelling is quick and threads share the rows evenly."""


WORTH_THREADS = 2e6
"""Elementary steps in all, a few milliseconds, below which starting threads costs more than they save."""


def for_rows(task: Callable[[int, int], object], rows: int, cost: float, work: Work) -> None:
    """Call ``task(first, stop)`` on bands that cover ``range(rows)``.

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
    band = max(1, min(rows, int(SLICE / max(cost, 1.0))))
    several = work.threads > 1 and rows * cost > WORTH_THREADS
    if several:
        band = max(1, min(band, -(-rows // (2 * work.threads))))
    starts = range(0, rows, band)
    if not several or len(starts) == 1:
        for first in starts:
            work.check()
            task(first, min(first + band, rows))
        return
    with ThreadPoolExecutor(work.threads) as pool:
        waiting: set[Future[object]] = set()
        try:
            for first in starts:
                if len(waiting) >= 2 * work.threads:
                    waiting = _settle(waiting)
                work.check()
                waiting.add(pool.submit(task, first, min(first + band, rows)))
            while waiting:
                waiting = _settle(waiting)
                work.check()
        finally:
            for future in waiting:
                future.cancel()


def _settle(waiting: set[Future[object]]) -> set[Future[object]]:
    """Wait until a band is done, raise what it raised, and return the others."""
    done, others = wait(waiting, return_when=FIRST_COMPLETED)
    for future in done:
        future.result()
    return others
