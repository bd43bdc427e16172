"""What has become of a run so far, read from its events."""

import time
from dataclasses import dataclass, field

from graphtex import events

ENDS = ("ran", "cached", "failed", "skipped")
"""How a node can end; one that was not reached, or was at work when the run was stopped, is ``waiting``."""


@dataclass
class Running:
    """A node at work."""

    began: float
    fraction: float = 0.0
    message: str = ""


@dataclass
class Tally:
    """Counts of a run; `see` takes each event."""

    began: float = field(default_factory=time.perf_counter)
    nodes: dict[str, str] = field(default_factory=dict)  # task -> node's name
    running: dict[str, Running] = field(default_factory=dict)
    ended: dict[str, str] = field(default_factory=dict)  # task -> ran, cached, failed, skipped
    warnings: dict[tuple[str, str], None] = field(default_factory=dict)  # (task, text), each once, in order

    def see(self, event: events.Event) -> bool:
        """Count an event; return whether it is news: a warning that was told before is none."""
        match event:
            case events.Planned(task, node):
                self.nodes[task] = node
            case events.Started(task, _):
                self.running[task] = Running(time.perf_counter())
            case events.Progress(task, fraction, message):
                if task not in self.running:
                    return False
                self.running[task].fraction = fraction
                self.running[task].message = message or self.running[task].message
            case events.Warned(task, text):
                if (task, text) in self.warnings:
                    return False
                self.warnings[task, text] = None
            case events.Stopped(task):
                self.running.pop(task, None)
            case _:
                self.running.pop(event.task, None)
                self.ended[event.task] = _STATUS[type(event)]
        return True

    @property
    def seconds(self) -> float:
        """How long the run has taken so far."""
        return time.perf_counter() - self.began

    def number(self, status: str) -> int:
        """Return how many tasks ended so."""
        return sum(ended == status for ended in self.ended.values())

    def counts(self) -> str:
        """Return such as ``2 ran, 3 cached``."""
        shown = [f"{self.number(s)} {s}" for s in ENDS if self.number(s)]
        return ", ".join(shown) or "nothing ran"


_STATUS: dict[type[events.Event], str] = {
    events.Cached: "cached",
    events.Finished: "ran",
    events.Failed: "failed",
    events.Skipped: "skipped",
}
