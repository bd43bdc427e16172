"""Writes a run's outputs to files: each whole or not at all."""

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from graphtex.errors import GraphtexError
from graphtex.handlers import DEFAULT_SUFFIX, find_writer
from graphtex.parameters import validate
from graphtex.plan import PlannedOutput
from graphtex.run import RunResult
from graphtex.sockets import Gap, ValueType


class OutputError(GraphtexError):
    """An output could not be written; names the file and the cause."""


def write_outputs(result: RunResult, folder: Path) -> dict[str, list[Path]]:
    """Write all outputs of a run into a folder and return the files by output; gaps of failed cells have none.

    Raises
    ------
    OutputError
        If a file cannot be written or its format cannot hold the value; files written before stay.
    """
    written: dict[str, list[Path]] = {}
    for name, output in result.plan.outputs.items():
        items = list(_files(output, result[name]))
        written[name] = [
            write_value(output, value, folder / file) for file, value in items if not isinstance(value, Gap)
        ]
    return written


def _files(output: PlannedOutput, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the file name of each item: lists are numbered."""
    file = output.file or f"{output.name}{DEFAULT_SUFFIX.get(output.type.base.name, '')}"
    if not output.type.many:
        yield file, value
        return
    stem, dot, suffix = file.rpartition(".")
    digits = len(str(max(len(value) - 1, 0)))
    for index, item in enumerate(value):
        yield f"{stem}-{index:0{digits}d}{dot}{suffix}", item


def write_value(output: PlannedOutput, value: Any, path: Path) -> Path:
    """Write one value to one file by way of a temporary one."""
    writer = find_writer(ValueType(output.type.base).base, path.suffix)
    options, problems = validate(writer.options, output.options)
    if options is None:
        raise OutputError(f"{output.name}: {problems[0][1]}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(suffix=path.suffix, prefix=f".{path.stem}-", dir=path.parent)
        os.close(handle)
        scratch = Path(name)
        try:
            writer.function(value, scratch, **{key: getattr(options, key) for key in type(options).model_fields})
            _take_permissions(scratch)
            scratch.replace(path)
        finally:
            scratch.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise OutputError(f"{path}: {reason}") from error
    return path


def _take_permissions(path: Path) -> None:
    """Give a temporary file, which only its owner may read, the permissions that new files get."""
    mask = os.umask(0)
    os.umask(mask)
    path.chmod(0o666 & ~mask)
