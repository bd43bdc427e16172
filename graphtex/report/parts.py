"""The run as the report tells it: tasks grouped by the inputs and nodes of the graph, and links to each."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import PurePath
from typing import Any

from graphtex.cache import CacheUnavailable, EntryLost
from graphtex.document import Document
from graphtex.links import Links
from graphtex.plan import Slot, Task
from graphtex.references import FromNode, reference, unescaped
from graphtex.report.words import duration, tally, worst
from graphtex.reports import Report
from graphtex.run import RunResult
from graphtex.show.scene import Mark, brief
from graphtex.sockets import ValueType
from graphtex.work import Held

_OWNER = re.compile(r"[^\[/.]+")


@dataclass(frozen=True)
class Missing:
    """Stands for a value that cannot be shown, with the reason."""

    reason: str


@dataclass(frozen=True)
class Group:
    """An input ``$name`` or a node of the graph with the tasks that it became, by their ids."""

    key: str
    anchor: str
    tasks: tuple[str, ...]


@dataclass(frozen=True)
class Story:
    """A run's result with what the report asks of it."""

    result: RunResult

    @property
    def graph(self) -> Document:
        """The graph that ran."""
        return self.result.plan.graph

    @cached_property
    def groups(self) -> Mapping[str, Group]:
        """Inputs that were opened or given and nodes, in the graph's order."""
        owned: dict[str, list[str]] = {}
        for name in self.result.plan.tasks:
            owned.setdefault(owner(name), []).append(name)
        given = {owner(slot.task) for slot in self.result.plan.given}
        keys = [key for key in map("${}".format, self.graph.inputs) if key in owned or key in given]
        keys += [key for key in self.graph.nodes if key in owned]
        return {key: Group(key, f"g{i}", tuple(owned.get(key, ()))) for i, key in enumerate(keys, 1)}

    @cached_property
    def anchors(self) -> Mapping[str, str]:
        """The place on the page of each task."""
        return {name: f"t{i}" for i, name in enumerate(self.result.plan.tasks, 1)}

    def report(self, task: str) -> Report | None:
        """Return what became of a task; None if the run ended before it."""
        return self.result.reports.get(task)

    def status(self, task: str) -> str:
        """Return ran, cached, failed, skipped or waiting."""
        found = self.report(task)
        return found.status if found else "waiting"

    def value(self, slot: Slot) -> Any:
        """Return a value or its gap, or `Missing` with the reason."""
        held = self.result.finished.held.get(slot)
        if held is None:
            return Missing("not made")
        if isinstance(held, Held) and not held.in_memory and self.result.cache is None:
            return Missing("not kept: the run had no cache and nobody needed it any more")
        try:
            return self.result.value(slot)
        except (EntryLost, CacheUnavailable) as error:
            return Missing(f"no longer in the cache ({error})")

    def kind(self, slot: Slot) -> ValueType:
        """Return the type of a task's output or of a given value."""
        if slot in self.result.plan.given:
            return self.result.plan.given[slot][0]
        return self.result.plan.tasks[slot.task].node.outputs[slot.socket].type

    def marks(self) -> dict[str, Mark]:
        """Return what the drawing is to tell of each box."""
        marks = {}
        for key, group in self.groups.items():
            statuses = [self.status(task) for task in group.tasks]
            seconds = sum(
                found.seconds for task in group.tasks if (found := self.report(task)) and found.status == "ran"
            )
            text = tally(statuses) if len(statuses) > 1 else worst(statuses).replace("waiting", "not run")
            took = f" · {duration(seconds)}" if "ran" in statuses else ""
            marks[key] = Mark(worst(statuses) if statuses else "ran", f"{text}{took}", f"#{group.anchor}")
        unused = Mark("waiting", "not needed")  # no output that was asked for comes from it
        return {**dict.fromkeys(self.graph.nodes, unused), **marks}

    def cells(self, group: Group) -> dict[str, list[Slot]]:
        """Return the outputs of each cell of an `each:`, by the cell's id; empty for other nodes."""
        entry = self.graph.nodes.get(group.key)
        if entry is None or not entry.each:
            return {}
        signature = Links(self.graph).signature(group.key)
        own = re.compile(re.escape(group.key) + r"\[[\d,]+\]")
        ids = dict.fromkeys(found[0] for task in group.tasks if (found := own.match(task)))
        if signature.node is not None:
            return {cell: [Slot(cell, socket) for socket in signature.outputs] for cell in ids}
        inner = signature.inner
        assert inner is not None
        made = {cell: [inner_slot(inner, f"{cell}/", output) for output in inner.graph.outputs] for cell in ids}
        return {cell: [slot for slot in slots if slot is not None] for cell, slots in made.items()}

    def range_label(self, group: Group, name: str, index: int, sample: str) -> str:
        """Return what one step of a range is: ``slant 30``, or ``textures 2`` where only its number is known.

        Parameters
        ----------
        sample
            The id of a cell at this step.
        """
        items = self.graph.nodes[group.key].each[name]
        if not isinstance(items, str):
            return f"{name} {brief(unescaped(items[index]))}"
        opened = self.result.plan.tasks.get(f"{items}[{index}]")
        cell = self.result.plan.tasks.get(sample)
        if opened is not None and opened.parameters:
            return f"{name} {PurePath(str(next(iter(opened.parameters.values())))).name}"
        if cell is not None and name in cell.parameters:
            return f"{name} {brief(cell.parameters[name])}"
        return f"{name} {index}"

    @property
    def seed(self) -> int:
        """The seed that the run used: the graph's, or what replaced it."""
        tasks: Mapping[str, Task] = self.result.plan.tasks
        return next((t.seed for t in tasks.values() if t.spawn_key and "/" not in t.id), self.graph.seed)


def owner(task: str) -> str:
    """Return the input or node of the graph that a task came from.

    >>> owner("cell[2,3]/warp"), owner("$textures[0]"), owner("cell.elements[1]")
    ('cell', '$textures', 'cell')
    """
    found = _OWNER.match(task)
    return found[0] if found else task


def inner_slot(links: Links, prefix: str, output: str) -> Slot | None:
    """Return the slot that a sub-graph's output comes from; None for the value of an input and for lists of cells."""
    graph, path = links.graph, ("outputs", output)
    source = reference(graph, path, graph.outputs[output].source)
    if not isinstance(source, FromNode) or graph.nodes[source.node].each:
        return None
    inner = links.signature(source.node).inner
    socket, _ = links.find(path, source)
    if inner is not None:
        return inner_slot(inner, f"{prefix}{source.node}/", socket)
    return Slot(f"{prefix}{source.node}", socket)
