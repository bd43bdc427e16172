"""What a run tells while it goes on: one stream of events, which progress displays, reports and studios read."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Event:
    """Something happened to a task."""

    task: str


@dataclass(frozen=True)
class Planned(Event):
    """The task belongs to the run; told once for each, before anything starts."""

    node: str


@dataclass(frozen=True)
class Cached(Event):
    """The task's outputs were found under its key, or another task of this run has made them."""

    seconds: float


@dataclass(frozen=True)
class Started(Event):
    """The task runs now; `why` says what made it run, where that is known."""

    why: str


@dataclass(frozen=True)
class Progress(Event):
    """The task says how far it is, 0 to 1."""

    fraction: float
    message: str


@dataclass(frozen=True)
class Warned(Event):
    """The task, or with an empty id the run, has something to say that stops nothing."""

    text: str


@dataclass(frozen=True)
class Finished(Event):
    """The task ran to its end."""

    seconds: float


@dataclass(frozen=True)
class Failed(Event):
    """The task raised."""

    message: str


@dataclass(frozen=True)
class Skipped(Event):
    """The task cannot run, because another has failed."""

    cause: str


@dataclass(frozen=True)
class Stopped(Event):
    """The task was cancelled; with an empty id the whole run was."""


def told_once(emit: Callable[[Event], None]) -> Callable[[Event], None]:
    """Return `emit` without what repeats a warning of the run itself."""
    told: set[str] = set()

    def tell(event: Event) -> None:
        if isinstance(event, Warned) and not event.task:
            if event.text in told:
                return
            told.add(event.text)
        emit(event)

    return tell
