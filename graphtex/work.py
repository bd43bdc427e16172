"""One call of one node, as an executor carries it out: inputs from memory or from the store, outputs into the store."""

import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from graphtex.cache import Cache, CacheUnavailable, EntryLost, digest_value
from graphtex.context import Context
from graphtex.errors import Cancelled, DeclarationError, NodeFailed
from graphtex.parameters import validate
from graphtex.plan import Slot, Task
from graphtex.sockets import Gap, ValueType


@dataclass(frozen=True)
class Held:
    """A value as the scheduler knows it: in memory, in the store under its digest, or both.

    Attributes
    ----------
    stored
        Whether it was put into the store, so that another process can read it there; it may be gone since.
    """

    type: ValueType
    value: Any = None
    digest: str = ""
    in_memory: bool = True
    stored: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        return _received, (self.type, self.value, self.digest, self.in_memory, self.stored)

    def dropped(self) -> "Held":
        """Return the same without what is in memory."""
        return Held(self.type, None, self.digest, in_memory=False, stored=self.stored)

    def stripped(self) -> "Held":
        """Return what has to travel to another process on the same store."""
        return self.dropped() if self.stored else self

    def load(self, cache: Cache | None) -> Any:
        """Return the value; `EntryLost` if it is in neither place."""
        if self.in_memory:
            return self.value
        assert cache is not None  # without a cache a value is in memory as long as somebody needs it
        return cache.get(str(self.type), self.digest)


def _received(kind: ValueType, value: Any, digest: str, in_memory: bool, stored: bool) -> Held:
    """Return what came from another process; arrays lose on the way that they are read-only."""
    _protect(value)
    return Held(kind, value, digest, in_memory, stored)


def _protect(value: Any) -> None:
    if isinstance(value, np.ndarray):
        value.flags.writeable = False
    elif isinstance(value, list | tuple):
        for item in value:
            _protect(item)


@dataclass(frozen=True)
class Call:
    """A task with its inputs: all that a worker needs."""

    task: Task
    inputs: Mapping[str, Held | Gap | tuple[Held | Gap, ...]]
    threads: int = 1

    def stripped(self) -> "Call":
        """Return the call without the values that the store holds, for another process."""
        inputs = {
            name: tuple(map(_stripped, held)) if isinstance(held, tuple) else _stripped(held)
            for name, held in self.inputs.items()
        }
        return replace(self, inputs=inputs)


def _stripped(held: Held | Gap) -> Held | Gap:
    return held if isinstance(held, Gap) else held.stripped()


@dataclass(frozen=True)
class Monitor:
    """The way back from a worker to the scheduler."""

    on_progress: Callable[[str, float, str], None]
    on_warning: Callable[[str, str], None]
    cancelled: Callable[[], bool]


@dataclass(frozen=True)
class Outcome:
    """What came of a call."""

    outputs: Mapping[str, Held]
    seconds: float
    warnings: tuple[str, ...]

    def stripped(self) -> "Outcome":
        """Return the outcome without the values that the store holds, for another process."""
        return replace(self, outputs={name: held.stripped() for name, held in self.outputs.items()})


class InputLost(Exception):
    """An input's stored value is gone or damaged; its task must run again."""

    def __init__(self, slots: tuple[Slot, ...]) -> None:
        super().__init__(", ".join(f"{slot.task}.{slot.socket}" for slot in slots))
        self.slots = slots

    def __reduce__(self) -> tuple[Any, ...]:
        return InputLost, (self.slots,)


def execute(call: Call, monitor: Monitor, cache: Cache | None) -> Outcome:
    """Run a node.

    Raises
    ------
    InputLost
        If stored inputs cannot be read.
    NodeFailed
        With the task's id, the shapes of its inputs and the cause.
    Cancelled
        If the run was stopped meanwhile.
    """
    task, node = call.task, call.task.node
    values = load_inputs(call, cache)
    warnings: list[str] = []

    def warn(text: str) -> None:
        warnings.append(text)
        monitor.on_warning(task.id, text)

    context = Context(
        call.threads, lambda share, text: monitor.on_progress(task.id, share, text), warn, monitor.cancelled
    )
    injected: dict[str, Any] = {"ctx": context} if "ctx" in node.injected else {}
    if "rng" in node.injected:
        injected["rng"] = task.generator()
    measured = {name: values.pop(name) for name in task.measured}
    parameters, problems = validate(node.parameters, {**task.parameters, **measured})
    if parameters is None:
        raise NodeFailed(task.id, "; ".join(f"{'.'.join(map(str, path))}: {text}" for path, text in problems))
    context.check()
    start = time.perf_counter()
    try:
        outputs = node.run(values, parameters, injected)
    except Cancelled:
        raise
    except Exception as error:
        raise NodeFailed(task.id, describe_failure(error, values)) from error
    seconds = time.perf_counter() - start
    held = {name: keep(node.outputs[name].type, value, cache, monitor) for name, value in outputs.items()}
    return Outcome(held, seconds, tuple(warnings))


def keep(kind: ValueType, value: Any, cache: Cache | None, monitor: Monitor) -> Held:
    """Return a value held in memory, and with a cache in the store too; a store that fails is told of, no more."""
    if cache is None:
        return Held(kind, value)
    try:
        return Held(kind, value, cache.put(str(kind), value), stored=True)
    except CacheUnavailable as error:
        monitor.on_warning("", str(error))
        return Held(kind, value, digest_value(str(kind), value))


def load_inputs(call: Call, cache: Cache | None) -> dict[str, Any]:
    """Return the inputs' values; `InputLost` names all that cannot be read."""
    lost: list[Slot] = []

    def load(held: Held | Gap, slot: Slot) -> Any:
        if isinstance(held, Gap):
            return held
        try:
            return held.load(cache)
        except EntryLost:
            lost.append(slot)
            return None

    values: dict[str, Any] = {}
    sources = {**call.task.inputs, **call.task.measured}
    for name, held in call.inputs.items():
        source = sources[name]
        if isinstance(held, tuple):
            assert isinstance(source, tuple)
            values[name] = [load(item, slot) for item, slot in zip(held, source, strict=True)]
        else:
            assert isinstance(source, Slot)
            values[name] = load(held, source)
    if lost:
        raise InputLost(tuple(lost))
    return values


def describe_failure(error: Exception, values: Mapping[str, Any]) -> str:
    """Return the cause, and the shapes of what the node was given."""
    cause = str(error) or type(error).__name__
    if not isinstance(error, ValueError | DeclarationError):  # these say themselves what is wrong, and where
        frame = traceback.extract_tb(error.__traceback__)[-1]
        cause = f"{type(error).__name__}: {cause} ({frame.filename}:{frame.lineno})"
    shapes = ", ".join(f"{name} {shape_of(value)}" for name, value in values.items())
    return f"{cause} [inputs: {shapes}]" if shapes else cause


def shape_of(value: Any) -> str:
    """Return such as ``float32 (4, 4, 3)``, ``list of 3`` or ``2.5``."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, list):
        return f"list of {len(value)}"
    if isinstance(value, tuple):
        return type(value).__name__
    return repr(value)
