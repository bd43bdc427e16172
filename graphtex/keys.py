"""The cache key of a task, and what a dry run can tell before anything has run."""

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from graphtex.cache import Cache, KeyParts, NoSource, code_digest, digest_value, environment, file_digest
from graphtex.parameters import validate, with_files
from graphtex.plan import Plan, Slot, Task
from graphtex.sockets import TYPES, Gap, ValueType
from graphtex.work import Held

KEY_FORMAT = 1  # raise it when the framework changes what a result depends on
Forecast = Literal["cached", "runs", "maybe"]


class Keys:
    """Makes the keys of a plan's tasks; each file is read once."""

    def __init__(self) -> None:
        self._files: dict[Path, str] = {}

    def parts(self, task: Task, held: Mapping[Slot, Held | Gap]) -> KeyParts | None:
        """Return what a task's result depends on; None if its code cannot be read, so that it must always run."""
        try:
            code = code_digest(task.node.function)
        except NoSource:
            return None
        model, _ = validate(task.node.parameters, task.parameters, unknown=task.measured)
        parameters = with_files(model, self._file) if model is not None else {}
        inputs: dict[str, str | list[str]] = {}
        for name, source in task.inputs.items():
            inputs[name] = [_digest(held[s]) for s in source] if isinstance(source, tuple) else _digest(held[source])
        for name, slot in task.measured.items():
            inputs[f"{name} (measured)"] = _digest(held[slot])
        found = environment(code.packages)
        return KeyParts(KEY_FORMAT, task.node.name, task.node.version, code, parameters, inputs, task.entropy, found)

    def _file(self, path: Path) -> str:
        if path not in self._files:
            self._files[path] = file_digest(path)
        return self._files[path]


_UNKNOWN = Held(ValueType(TYPES["Number"]), in_memory=False)  # of a task that has not run; the type does not matter


def _digest(held: Held | Gap) -> str:
    return digest_value("Gap", held.label) if isinstance(held, Gap) else held.digest


def given_values(plan: Plan, *, digests: bool) -> dict[Slot, Held | Gap]:
    """Return the values that the caller gave, with their digests if a cache is to know them."""
    return {
        slot: Held(kind, value, digest_value(str(kind), value) if digests else "")
        for slot, (kind, value) in plan.given.items()
    }


def found_outputs(task: Task, key: str, cache: Cache) -> tuple[dict[str, Held], tuple[str, ...], float] | None:
    """Return a task's outputs as the store holds them, its warnings and seconds; None if they are not all there."""
    record = cache.lookup(key)
    if record is None or set(record.outputs) != set(task.node.outputs):
        return None
    outputs = {
        name: Held(task.node.outputs[name].type, None, output.digest, in_memory=False)
        for name, output in record.outputs.items()
    }
    return outputs, record.warnings, record.seconds


def forecast(plan: Plan, cache: Cache | None) -> tuple[dict[str, Forecast], dict[str, KeyParts]]:
    """Tell of each task whether it is cached, runs, or runs unless its inputs come out equal ("maybe").

    Returns
    -------
    The forecast of each task, and what its key is made of; inputs that are not known yet have an empty digest there.
    """
    keys = Keys()
    held = given_values(plan, digests=cache is not None)
    told: dict[str, Forecast] = {}
    known: dict[str, KeyParts] = {}
    for task in plan.tasks.values():
        if cache is None:
            told[task.id] = "runs"
            continue
        unknown = {slot: _UNKNOWN for slot in task.slots if slot not in held}
        parts = keys.parts(task, {**held, **unknown} if unknown else held)
        if parts is not None:
            known[task.id] = parts
        if unknown and parts is not None:
            told[task.id] = "maybe"
            continue
        found = found_outputs(task, parts.key(), cache) if parts is not None else None
        told[task.id] = "runs" if found is None else "cached"
        if found is not None:
            held.update({Slot(task.id, name): value for name, value in found[0].items()})
    return told, known
