"""What the framework hands to a running node: progress, cancellation, warnings, random numbers."""

import os
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, TypeAlias

import numpy as np

from graphtex.errors import Cancelled


def _warn(text: str) -> None:
    """Warn in the name of the line that called the node, however deep in it the doubt arose."""
    frame, level, outermost = sys._getframe(), 1, 2
    while frame.f_back is not None:
        if frame.f_globals.get("__name__") == "graphtex.node":
            outermost = level
        frame, level = frame.f_back, level + 1
    warnings.warn(text, stacklevel=outermost + 1)


def _ignore(fraction: float, message: str) -> None:
    pass


@dataclass(frozen=True)
class Context:
    """Given to a node that declares ``ctx: Context = QUIET``.

    Attributes
    ----------
    threads
        How many threads the node may keep busy. It must not change the result.
    """

    threads: int = 1
    on_progress: Callable[[float, str], None] = field(default=_ignore, repr=False)
    on_warning: Callable[[str], None] = field(default=_warn, repr=False)
    cancelled: Callable[[], bool] = field(default=lambda: False, repr=False)

    def check(self) -> None:
        """Raise `Cancelled` if the run was asked to stop."""
        if self.cancelled():
            raise Cancelled("cancelled")

    def progress(self, fraction: float, message: str = "") -> None:
        """Report the share done, 0 to 1, and give the run a chance to stop."""
        self.check()
        self.on_progress(min(max(float(fraction), 0.0), 1.0), message)

    def warn(self, text: str) -> None:
        """Tell the user something that does not stop the node; it is kept in the report."""
        self.on_warning(text)


def usable_cores() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


QUIET = Context(threads=usable_cores())


@dataclass(frozen=True)
class Injected:
    """Marks a parameter that the framework fills in."""

    name: str


# A direct call may pass an int or a Generator; the body always gets a Generator.
Rng: TypeAlias = Annotated[Any, Injected("rng")]


def generator(rng: "int | np.random.Generator | np.random.SeedSequence") -> np.random.Generator:
    """Return a Generator for what a caller passed as `rng`; ValueError for anything else."""
    if isinstance(rng, np.random.Generator):
        return rng
    if isinstance(rng, bool) or not isinstance(rng, int | np.integer | np.random.SeedSequence):
        raise ValueError(f"rng: expected an int or a numpy Generator, got {type(rng).__name__}")
    if isinstance(rng, int | np.integer) and rng < 0:
        raise ValueError(f"rng: a seed is not negative, got {rng}")
    return np.random.default_rng(rng)
