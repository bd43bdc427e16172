"""What became of the tasks of a run."""

from dataclasses import dataclass, field
from typing import Literal

from graphtex.cache import KeyParts
from graphtex.errors import NodeFailed
from graphtex.plan import Slot, Task
from graphtex.sockets import Gap
from graphtex.work import Held

Status = Literal["ran", "cached", "failed", "skipped"]


@dataclass
class Report:
    """What became of one task."""

    task: Task
    status: Status
    seconds: float = 0.0
    key: str = ""
    why: str = ""
    message: str = ""
    warnings: tuple[str, ...] = ()


@dataclass
class Finished:
    """What became of a plan: a report for each task that was reached, and the values that are still held."""

    reports: dict[str, Report] = field(default_factory=dict)
    held: dict[Slot, Held | Gap] = field(default_factory=dict)
    parts: dict[str, KeyParts] = field(default_factory=dict)
    failure: NodeFailed | None = None
