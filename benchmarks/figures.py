"""A figure: what was measured, the bound asked for, and what it is compared with."""

import statistics
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Figure:
    """One measured figure.

    Attributes
    ----------
    value
        What was measured, in the unit that the name tells.
    bound
        What is asked for, such as ``"<= 2"``; empty for a figure that is only reported.
    reference
        The same measure of something else in the same run, None if there is nothing to compare with.
    """

    name: str
    value: float
    bound: str = ""
    reference: float | None = None

    @property
    def ok(self) -> bool | None:
        """Whether the bound holds; None without one."""
        if not self.bound:
            return None
        relation, limit = self.bound.split()
        return self.value <= float(limit) if relation == "<=" else self.value >= float(limit)

    @property
    def ratio(self) -> float | None:
        """The value over the reference."""
        return self.value / self.reference if self.reference else None

    def to_json(self) -> dict[str, object]:
        """Return name, value, bound, ok, reference, ratio."""
        return {**asdict(self), "ok": self.ok, "ratio": self.ratio}


def table(figures: Iterable[Figure]) -> str:
    """Return figures as a table of text."""
    rows: list[tuple[str, ...]] = [("figure", "value", "bound", "", "reference", "ratio")]
    for figure in figures:
        state = {True: "ok", False: "MISSED", None: ""}[figure.ok]
        numbers = ("" if x is None else f"{x:.4g}" for x in (figure.reference, figure.ratio))
        rows.append((figure.name, f"{figure.value:.4g}", figure.bound, state, *numbers))
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    )


def seconds(call: Callable[[], object], repeat: int = 5) -> float:
    """Return the median time of some calls."""
    return in_turns(call, repeat=repeat)[0]


def in_turns(*calls: Callable[[], object], repeat: int = 5) -> list[float]:
    """Return the median time of each call, made in turns, so that what else the machine does counts for all."""
    times: list[list[float]] = [[] for _ in calls]
    for _ in range(repeat):
        for call, found in zip(calls, times, strict=True):
            start = time.perf_counter()
            call()
            found.append(time.perf_counter() - start)
    return [statistics.median(found) for found in times]
