"""Binds a graph to its inputs: sub-graphs and `each:` are expanded, and what is left is a flat DAG of tasks."""

import hashlib
import itertools
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import networkx as nx
import numpy as np

from graphtex.document import Document
from graphtex.errors import Problem
from graphtex.handlers import opened_files
from graphtex.node import Node
from graphtex.sockets import ValueType


@dataclass(frozen=True)
class Slot:
    """One output of one task, or a value that the caller gave (task ``$name``)."""

    task: str
    socket: str


_NOWHERE = Problem("", 0, 0, "", "")


@dataclass(frozen=True)
class Task:
    """One call of one node.

    Attributes
    ----------
    inputs
        Socket to slot, or to a tuple of slots for a list.
    parameters
        Plain data, complete and canonical but for `measured` ones; files are absolute paths.
    files
        The files among the parameters.
    measured
        Parameters that another task's number feeds.
    seed, spawn_key
        Entropy of the node's random stream.
    cell
        The id of the cell of an `each:` with ``on_error: keep`` that it is in: the run goes on if it fails. What
        opens a file for such cells alone is a cell of its own.
    place
        Where the entry stands: an example problem with file, line and column.
    """

    id: str
    node: Node[Any, Any]
    inputs: Mapping[str, Slot | tuple[Slot, ...]]
    parameters: Mapping[str, Any]
    files: tuple[Path, ...] = ()
    measured: Mapping[str, Slot] = field(default_factory=dict)
    seed: int = 0
    spawn_key: tuple[int, ...] = ()
    cell: str = ""
    place: Problem = field(default=_NOWHERE, compare=False)

    @cached_property
    def slots(self) -> tuple[Slot, ...]:
        """All slots that the task reads, in order."""
        found: list[Slot] = []
        for source in self.inputs.values():
            found += source if isinstance(source, tuple) else (source,)
        return (*found, *self.measured.values())

    @property
    def entropy(self) -> tuple[int, ...] | None:
        """What the task's random stream depends on, None for a node without randomness."""
        return (self.seed, *self.spawn_key) if "rng" in self.node.injected else None

    def generator(self) -> np.random.Generator:
        """Return the task's own random stream."""
        return np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=self.spawn_key))


@dataclass(frozen=True)
class PlannedOutput:
    """One output of the graph: where it comes from and how it is written.

    Attributes
    ----------
    joined
        Each slot is an item of a list.
    file
        Its name, with ``{}`` in the place of each item's of `names`, if there are some.
    """

    name: str
    slots: tuple[Slot, ...]
    type: ValueType
    joined: bool = False
    file: str | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    names: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plan:
    """Tasks in a topological order, values that the caller gave, and outputs."""

    graph: Document
    tasks: Mapping[str, Task]
    given: Mapping[Slot, tuple[ValueType, Any]]
    outputs: Mapping[str, PlannedOutput]

    @cached_property
    def dag(self) -> "nx.DiGraph[str]":
        """Tasks as a networkx DAG."""
        dag: nx.DiGraph[str] = nx.DiGraph()
        dag.add_nodes_from(self.tasks)
        dag.add_edges_from(
            (slot.task, task.id) for task in self.tasks.values() for slot in task.slots if slot not in self.given
        )
        return dag

    def sources(self, output: PlannedOutput) -> tuple[Path, ...]:
        """Return the files of an output's own type that it was made from."""
        ends = {slot.task for slot in output.slots} & self.tasks.keys()
        above = ends.union(*(nx.ancestors(self.dag, task) for task in ends))
        made = (task for name, task in self.tasks.items() if name in above and task.files)
        return tuple(file for task in made for file in opened_files(output.type.base, task.node, task.files))

    def only(self, outputs: Mapping[str, PlannedOutput]) -> "Plan":
        """Return the plan cut down to what some outputs need."""
        ahead = [slot for output in outputs.values() for slot in output.slots]
        needed: set[str] = set()
        while ahead:
            task = ahead.pop().task
            if task in self.tasks and task not in needed:
                needed.add(task)
                ahead += self.tasks[task].slots
        tasks = {key: task for key, task in self.tasks.items() if key in needed}
        read = {slot for task in tasks.values() for slot in task.slots}
        read.update(slot for output in outputs.values() for slot in output.slots)
        return Plan(self.graph, tasks, {slot: value for slot, value in self.given.items() if slot in read}, outputs)


def stream_words(task: str) -> tuple[int, ...]:
    """Return the spawn key of a node's random stream: SHA-256 of its id without each-indices, as eight words.

    >>> stream_words("cell[2,3]/warp") == stream_words("cell/warp")
    True
    """
    plain_id = re.sub(r"\[[\d,]+\]", "", task)
    return tuple(int(word) for word in np.frombuffer(hashlib.sha256(plain_id.encode()).digest(), ">u4"))


def cells_of(ranges: Mapping[str, list[Any]]) -> list[tuple[str, dict[str, Any]]]:
    """Return the product of ranges: index such as ``[2,3]``, and each cell's choice.

    >>> cells_of({"a": [1, 2], "b": ["x"]})
    [('[0,0]', {'a': 1, 'b': 'x'}), ('[1,0]', {'a': 2, 'b': 'x'})]
    """
    indices = itertools.product(*(range(len(items)) for items in ranges.values()))
    return [
        (f"[{','.join(map(str, index))}]", {key: ranges[key][i] for key, i in zip(ranges, index, strict=True)})
        for index in indices
    ]
