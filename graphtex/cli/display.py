"""Progress of a run on stderr: plain lines, a live display on terminals, or warnings alone."""

import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Self, TextIO

from graphtex import events
from graphtex.cli.tally import Tally
from graphtex.cli.terminal import count, duration

INTERVAL = 2.0  # seconds between two lines of progress of one node
MOST_OF_WHY = 100  # characters


class Display:
    """Shows nothing; what the others share.

    Parameters
    ----------
    clock
        Tells seconds; for tests.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self.tally = Tally()
        self.clock = clock

    def __call__(self, event: events.Event) -> None:
        """Take the next event of the run; from any thread, one at a time."""
        if self.tally.see(event):
            self.show(event)

    def show(self, event: events.Event) -> None:
        """Show an event that is news."""

    def note(self, text: str) -> None:
        """Show a line of the command itself."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leave the terminal as it was; may be called twice."""

    def summary(self) -> str:
        """Return such as ``5 nodes: 2 ran, 3 cached; 4.1 s``."""
        tally = self.tally
        return f"{count(len(tally.nodes), 'node')}: {tally.counts()}; {duration(tally.seconds)}"


class QuietDisplay(Display):
    """Shows warnings alone: what they tell of a result is not told by the result."""

    def show(self, event: events.Event) -> None:
        """Print a warning."""
        if isinstance(event, events.Warned):
            print(told(event), file=sys.stderr, flush=True)


class PlainDisplay(Display):
    """A line when a node starts and when it ends, and now and then of its progress."""

    def __init__(self, stream: TextIO | None = None, clock: Callable[[], float] = time.perf_counter) -> None:
        super().__init__(clock)
        self._stream = stream or sys.stderr
        self._told: dict[str, float] = {}

    def note(self, text: str) -> None:
        """Print a line."""
        print(text, file=self._stream, flush=True)

    def show(self, event: events.Event) -> None:
        """Print what a log should tell; progress of one node at most every `INTERVAL` seconds."""
        now = self.clock()
        match event:
            case events.Started(task, why):
                self._told[task] = now
                reason = f" ({shortened(why)})" if why else ""
                self.note(f"{task}: {self.tally.nodes.get(task, 'node')} runs{reason}")
            case events.Progress(task, 0.0, message) if message:  # what a node says before it starts is always told
                self._told[task] = now
                self.note(f"{task}: {message}")
            case events.Progress(task, fraction, message) if now - self._told.get(task, now) >= INTERVAL:
                self._told[task] = now
                self.note(f"{task}: {fraction:.0%}{f' {message}' if message else ''}")
            case _:
                line = told(event)
                if line:
                    self.note(line)


def shortened(why: str) -> str:
    """Return a reason that fits into a line; ``graphtex why`` tells all of it."""
    return why if len(why) <= MOST_OF_WHY else f"{why[: MOST_OF_WHY - 3]}..."


def told(event: events.Event) -> str:
    """Return the line that tells of an end or a warning; nothing for other events."""
    match event:
        case events.Cached(task, _):
            return f"{task}: cached"
        case events.Finished(task, seconds):
            return f"{task}: done in {duration(seconds)}"
        case events.Failed(task, message):
            return f"{task}: failed: {message}"
        case events.Skipped(task, cause):
            return f"{task}: skipped, it needs {cause}"
        case events.Warned(task, text):
            return f"warning: {f'{task}: ' if task else ''}{text}"
        case events.Stopped(task) if task:
            return f"{task}: stopped"
    return ""
