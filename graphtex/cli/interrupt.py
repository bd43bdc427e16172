"""Ctrl-C and SIGTERM: the first asks the run to stop, the second ends the process at once."""

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self, TypeVar

from graphtex.cli.terminal import INTERRUPTED

T = TypeVar("T")


class Interrupts:
    """While entered, sets `cancel` at the first SIGINT or SIGTERM.

    Parameters
    ----------
    tell
        Called with a line for the user, and with nothing to say to clean the terminal before the process ends.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        self.cancel = threading.Event()
        self._tell = tell
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():  # elsewhere Python does not allow it
            for number in (signal.SIGINT, signal.SIGTERM):
                self._before[number] = signal.signal(number, self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.cancel.is_set():
            self._tell("")
            os._exit(INTERRUPTED)
        self.cancel.set()
        self._tell("stopping; press Ctrl-C again to end at once")

    def run(self, work: Callable[[], T]) -> T:
        """Carry out `work` in a thread of its own, so that this one is free for signals; return or raise as it does."""
        results: list[T] = []
        errors: list[BaseException] = []

        def body() -> None:
            try:
                results.append(work())
            except BaseException as error:  # noqa: BLE001 (raised again in the caller's thread)
                errors.append(error)

        thread = threading.Thread(target=body, name="graphtex-run", daemon=True)
        thread.start()
        while thread.is_alive():
            thread.join(0.5)  # signals are handled between two waits, on Windows too
        if errors:
            raise errors[0]
        return results[0]
