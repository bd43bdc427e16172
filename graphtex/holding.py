"""The values of a run: which of them are in memory, and until when."""

from collections.abc import Mapping

from graphtex.cache import Cache, EntryLost
from graphtex.keys import given_values
from graphtex.plan import Plan, Slot, Task
from graphtex.sockets import Gap
from graphtex.work import Held

_ALWAYS = 1 << 60


class Holding:
    """Holds what tasks have made; drops from memory what nobody reads any more.

    Parameters
    ----------
    keep_all
        Drop nothing.
    """

    def __init__(self, plan: Plan, cache: Cache | None, *, keep_all: bool) -> None:
        self._plan, self._cache = plan, cache
        self.held = given_values(plan, digests=cache is not None)
        self._readers: dict[Slot, int] = {}  # how many tasks still want the value; outputs are wanted for ever
        for task in plan.tasks.values():
            for slot in task.slots:
                self._readers[slot] = self._readers.get(slot, 0) + 1
            if keep_all:
                self._readers.update({Slot(task.id, name): _ALWAYS for name in task.node.outputs})
        self._readers.update(dict.fromkeys(self._outputs(), _ALWAYS))

    def _outputs(self) -> list[Slot]:
        return list(dict.fromkeys(slot for output in self._plan.outputs.values() for slot in output.slots))

    def inputs(self, task: Task) -> dict[str, Held | Gap | tuple[Held | Gap, ...]]:
        """Return what a task reads, by socket and measured parameter."""
        return {
            name: tuple(self.held[slot] for slot in source) if isinstance(source, tuple) else self.held[source]
            for name, source in (*task.inputs.items(), *task.measured.items())
        }

    def keep(self, task: Task, outputs: Mapping[str, Held | Gap]) -> None:
        """Hold a task's outputs, in memory only if somebody wants them."""
        for name, held in outputs.items():
            slot = Slot(task.id, name)
            self.held[slot] = held
            if self._readers.get(slot, 0) == 0:
                self._drop(slot)

    def release(self, task: Task) -> None:
        """Note that a task will not read its inputs any more; to be said once."""
        for slot in task.slots:
            self._readers[slot] -= 1
            if self._readers[slot] == 0 and slot not in self._plan.given:
                self._drop(slot)

    def _drop(self, slot: Slot) -> None:
        held = self.held.get(slot)
        if isinstance(held, Held) and held.in_memory:
            self.held[slot] = held.dropped()

    def load_outputs(self) -> tuple[Slot, ...]:
        """Read the values of the plan's outputs; return those that the store has lost."""
        lost = []
        for slot in self._outputs():
            held = self.held[slot]
            if isinstance(held, Held) and not held.in_memory:
                try:
                    self.held[slot] = Held(held.type, held.load(self._cache), held.digest, stored=held.stored)
                except EntryLost:
                    lost.append(slot)
        return tuple(lost)

    def broken_input(self, task: Task) -> str:
        """Return the failed task that a task cannot do without, or nothing; gaps fill lists that take them."""
        for name, source in (*task.inputs.items(), *task.measured.items()):
            takes_gaps = isinstance(source, tuple) and name in task.inputs and task.node.inputs[name].type.gaps
            for slot in source if isinstance(source, tuple) else (source,):
                if not takes_gaps and isinstance(self.held.get(slot), Gap):
                    return slot.task
        return ""
