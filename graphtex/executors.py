"""Where calls are carried out. The scheduler knows only the `Executor` protocol."""

from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Protocol, Self

from graphtex.cache import Cache
from graphtex.context import usable_cores
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.work import Call, Monitor, Outcome, execute


class Executor(Protocol):
    """Carries out calls; up to `workers` at once.

    An executor whose workers do not share this process's memory strips the calls' values that the store holds, and
    carries the monitor's messages over by its own means; the scheduler is the same for all.
    """

    workers: int

    def submit(self, call: Call, monitor: Monitor, cache: Cache | None) -> "Future[Outcome]":
        """Start a call; the future holds its outcome or what it raised."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class SerialExecutor:
    """Carries out each call at once, in the caller's thread."""

    workers = 1

    def submit(self, call: Call, monitor: Monitor, cache: Cache | None) -> "Future[Outcome]":
        """Carry out the call; the future is done."""
        future: Future[Outcome] = Future()
        try:
            future.set_result(execute(call, monitor, cache))
        except Exception as error:  # noqa: BLE001 (the future carries it to the scheduler; KeyboardInterrupt goes up)
            future.set_exception(error)
        return future

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass


class ThreadsExecutor:
    """Carries out calls in threads of this process."""

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="graphtex")

    def submit(self, call: Call, monitor: Monitor, cache: Cache | None) -> "Future[Outcome]":
        """Start the call in a thread."""
        return self._pool.submit(execute, call, monitor, cache)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._pool.shutdown(wait=True, cancel_futures=True)


EXECUTORS = ("serial", "threads")


def make_executor(name: str = "serial", workers: int | None = None) -> Executor:
    """Return an executor by name; GraphError if there is none of that name, or it cannot have so many workers.

    Parameters
    ----------
    workers
        Calls at once; without it as many as there are processors.
    """
    if name not in EXECUTORS:
        raise GraphError([Problem("", 0, 0, "executor", f"unknown executor {name!r}{did_you_mean(name, EXECUTORS)}")])
    if workers is not None and workers < 1:
        raise GraphError([Problem("", 0, 0, "workers", f"at least one worker, got {workers}")])
    if name == "serial":
        if workers not in (None, 1):
            raise GraphError([Problem("", 0, 0, "workers", f"the serial executor has one worker, got {workers}")])
        return SerialExecutor()
    return ThreadsExecutor(workers or usable_cores())
