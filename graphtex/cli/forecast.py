"""What a run would do and why: for ``run --dry-run`` and ``why``."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphtex.cli.terminal import DONE, count, out, print_json, say, table
from graphtex.errors import listing

if TYPE_CHECKING:
    from graphtex.cache import Cache, Change, KeyParts
    from graphtex.document import Document
    from graphtex.keys import Forecast
    from graphtex.plan import Plan

WORDS = {"cached": "cached", "runs": "runs", "maybe": "runs unless its input comes out equal"}


@dataclass(frozen=True)
class Prospect:
    """What is known of a task before it runs.

    Attributes
    ----------
    changes
        What differs from the last recorded run. For "maybe", inputs that are not known yet count as unchanged.
    note
        What else is to be said.
    decided_by
        For "maybe": the nearest tasks upstream that run.
    """

    forecast: "Forecast"
    changes: tuple["Change", ...] = ()
    note: str = ""
    decided_by: tuple[str, ...] = ()

    @property
    def why(self) -> str:
        """Return the reason as a sentence; nothing for what is cached and unchanged."""
        changed = "; ".join(str(change) for change in self.changes)
        if self.forecast == "cached":
            return f"computed before, but not in the last run: {changed}" if changed else ""
        decides = f"{listing(self.decided_by)} decide{'s' if len(self.decided_by) == 1 else ''}"
        return "; ".join(part for part in (changed or self.note, decides if self.decided_by else "") if part)


def prospects(plan: "Plan", cache: "Cache | None", name: str) -> dict[str, Prospect]:
    """Tell of each task whether it would run, and what changed since the last recorded run of the graph `name`."""
    from graphtex.cache import explain
    from graphtex.keys import forecast

    told, parts = forecast(plan, cache)
    last = (cache.last_run(name) or {}) if cache is not None else {}
    decided_by = _deciders(plan, told)
    found: dict[str, Prospect] = {}
    for task in plan.tasks:
        if cache is None:
            found[task] = Prospect("runs", note="no cache")
            continue
        old, new = last.get(task), parts.get(task)
        if new is None:
            found[task] = Prospect("runs", note="its code has no source file to compare")
            continue
        changes = () if old is None else tuple(explain(old, _with_assumed(new, old)))
        note = "not run before" if old is None else "" if told[task] == "maybe" else "its result is not stored"
        found[task] = Prospect(told[task], changes, note, decided_by.get(task, ()))
    return found


def _with_assumed(new: "KeyParts", old: "KeyParts") -> "KeyParts":
    """Return the parts of a key in which inputs that are not known yet are those of the last run."""
    inputs = {
        name: old.inputs.get(name, digest) if not digest or (isinstance(digest, list) and "" in digest) else digest
        for name, digest in new.inputs.items()
    }
    return replace(new, inputs=inputs)


def _deciders(plan: "Plan", told: "Mapping[str, Forecast]") -> dict[str, tuple[str, ...]]:
    """Return the nearest tasks upstream of each that run; those between may turn out to be cached."""
    order = {task: index for index, task in enumerate(plan.tasks)}
    found: dict[str, tuple[str, ...]] = {}
    for task in plan.tasks:  # in this order a task's sources come before it
        if told[task] == "maybe":
            nearest = {
                decider
                for source in plan.dag.predecessors(task)
                for decider in ((source,) if told[source] == "runs" else found.get(source, ()))
            }
            found[task] = tuple(sorted(nearest, key=order.__getitem__))
    return found


def plan_of(graph: "Document", values: Mapping[str, Any], seed: int | None, only: Sequence[str] = ()) -> "Plan":
    """Return what a run would do; GraphError if the request is wrong."""
    from graphtex.bind import bind
    from graphtex.run import restrict

    return restrict(bind(graph, values, seed=seed), only)


def cache_of(choice: Path | bool) -> "Cache | None":
    """Return the cache that an option names: a folder, True for the user's own, False for none."""
    from graphtex.run import make_cache

    return None if choice is False else make_cache(None if choice is True else choice)


def dry_run(
    graph: "Document",
    values: Mapping[str, Any],
    *,
    seed: int | None,
    only: Sequence[str],
    cache: Path | bool,
    as_json: bool,
) -> int:
    """Print what a run would do."""
    from graphtex.shipped import graph_identity

    plan = plan_of(graph, values, seed, only)
    name = graph_identity(graph.file)
    opened = cache_of(cache)
    found = prospects(plan, opened, name)
    if as_json:
        nodes = [
            {"id": task.id, "node": task.node.name, "forecast": found[task.id].forecast, "why": found[task.id].why}
            for task in plan.tasks.values()
        ]
        given = graph.seed if seed is None else seed
        print_json({"graph": name, "seed": given, "status": "done", "nodes": nodes})
        return DONE
    rows = [(task.id, task.node.name, WORDS[found[task.id].forecast], found[task.id].why)
            for task in plan.tasks.values()]  # fmt: skip
    out(table([("id", "node", "forecast", "why"), *rows]))
    totals = [f"{sum(p.forecast == kind for p in found.values())} {text}" for kind, text in _TOTALS.items()]
    say(f"{count(len(rows), 'node')}: {', '.join(totals)}{'; no cache' if opened is None else ''}")
    return DONE


_TOTALS = {"cached": "cached", "runs": "run", "maybe": "may run"}
