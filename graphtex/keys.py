"""The cache key of a task, and what a dry run can tell before anything has run."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal

from graphtex.cache import (
    BadSource,
    Cache,
    CodeDigest,
    KeyParts,
    NoSource,
    code_digest,
    digest_value,
    environment,
    file_digest,
    files_below,
)
from graphtex.node import Node
from graphtex.parameters import validate, with_files
from graphtex.plan import Plan, Slot, Task
from graphtex.sockets import TYPES, Gap, ValueType
from graphtex.work import Held

KEY_FORMAT = 1  # raise it when the framework changes what a result depends on
Forecast = Literal["cached", "runs", "maybe"]
_Stamp = tuple[tuple[str, int, int, int], ...]


class Keys:
    """Makes the keys of a run's tasks; each file and each node's code is read once.

    Parameters
    ----------
    warn
        Told of code that cannot be read: its nodes run without the cache.
    cache
        Where what was found in the nodes' code is kept for later runs.
    """

    def __init__(self, warn: Callable[[str], None] = lambda text: None, cache: Cache | None = None) -> None:
        self._warn = warn
        self._parsed = None if cache is None else cache.parsed
        self._files: dict[Path, tuple[str, _Stamp]] = {}
        self._code: dict[Node[Any, Any], CodeDigest | None] = {}

    def parts(self, task: Task, held: Mapping[Slot, Held | Gap]) -> KeyParts | None:
        """Return what a task's result depends on; None if that cannot be told, so that it must always run."""
        code = self._code_of(task.node)
        if code is None:
            return None
        try:
            parameters = self._parameters(task)
        except OSError:
            return None  # a file is gone since it was checked: the node says so itself
        inputs: dict[str, str | list[str]] = {}
        for name, source in task.inputs.items():
            inputs[name] = [_digest(held[s]) for s in source] if isinstance(source, tuple) else _digest(held[source])
        for name, slot in task.measured.items():
            inputs[f"{name} (measured)"] = _digest(held[slot])
        found = environment(code.packages)
        return KeyParts(KEY_FORMAT, task.node.name, task.node.version, code, parameters, inputs, task.entropy, found)

    def still_hold(self, task: Task) -> bool:
        """Tell whether the task's files are those that its key was made of: a node may have read a newer one."""
        return all(_stamp(path) == self._files[path][1] for path in task.files)

    def _code_of(self, node: Node[Any, Any]) -> CodeDigest | None:
        if node not in self._code:
            try:
                self._code[node] = code_digest(node.function, self._parsed)
            except NoSource:
                self._code[node] = None
            except BadSource as error:
                self._code[node] = None
                self._warn(f"{node.name} runs without the cache: {error}")
        return self._code[node]

    def _parameters(self, task: Task) -> Mapping[str, Any]:
        """Return the parameters with the digest of its content for each file."""
        if not task.files:
            return task.parameters
        model, _ = validate(task.node.parameters, task.parameters, unknown=task.measured)
        parameters: dict[str, Any] = with_files(model, self._file)
        return parameters

    def _file(self, path: Path) -> str:
        if path not in self._files:
            stamp = _stamp(path)
            self._files[path] = file_digest(path), stamp
        return self._files[path][0]


def _stamp(path: Path) -> _Stamp:
    """Return what changes with a file or with one of a folder's; nothing if it cannot be read."""
    try:
        files = files_below(path) if path.is_dir() else [path]
        told = [(file.stat(), str(file)) for file in files]
    except OSError:
        return ()
    return tuple((name, status.st_mtime_ns, status.st_size, status.st_ino) for status, name in told)


_UNKNOWN = Held(ValueType(TYPES["Number"]), in_memory=False)  # of a task that has not run; the type does not matter


def _digest(held: Held | Gap) -> str:
    return digest_value("Gap", held) if isinstance(held, Gap) else held.digest


def given_values(plan: Plan, *, digests: bool) -> dict[Slot, Held | Gap]:
    """Return the values that the caller gave, with their digests if a cache is to know them."""
    return {
        slot: Held(kind, value, digest_value(str(kind), value) if digests else "")
        for slot, (kind, value) in plan.given.items()
    }


def found_outputs(task: Task, key: str, cache: Cache) -> tuple[dict[str, Held], tuple[str, ...]] | None:
    """Return a task's outputs as the store holds them, and its warnings; None if they are not all there."""
    record = cache.lookup(key)
    types = {name: str(socket.type) for name, socket in task.node.outputs.items()}
    if record is None or {name: output.type for name, output in record.outputs.items()} != types:
        return None
    outputs = {
        name: Held(task.node.outputs[name].type, None, output.digest, in_memory=False, stored=True)
        for name, output in record.outputs.items()
    }
    return outputs, record.warnings


def forecast(plan: Plan, cache: Cache | None) -> tuple[dict[str, Forecast], dict[str, KeyParts]]:
    """Tell of each task whether it is cached, runs, or runs unless its inputs come out equal ("maybe").

    A task whose key is that of another before it counts as cached: it takes that one's result.

    Returns
    -------
    The forecast of each task, and what its key is made of; inputs that are not known yet have an empty digest there.
    """
    if cache is None:
        return dict.fromkeys(plan.tasks, "runs"), {}
    keys = Keys(cache=cache)
    held = given_values(plan, digests=True)
    told: dict[str, Forecast] = {}
    known: dict[str, KeyParts] = {}
    running: set[str] = set()
    for task in plan.tasks.values():
        unknown = {slot: _UNKNOWN for slot in task.slots if slot not in held}
        parts = keys.parts(task, {**held, **unknown} if unknown else held)
        if parts is None:
            told[task.id] = "runs"
            continue
        known[task.id] = parts
        if unknown:
            told[task.id] = "maybe"
            continue
        key = parts.key()
        found = found_outputs(task, key, cache)
        told[task.id] = "cached" if found is not None or key in running else "runs"
        running.add(key)
        if found is not None:
            held.update({Slot(task.id, name): value for name, value in found[0].items()})
    return told, known
