"""Writes a run's outputs to files: each whole or not at all."""

import os
import shutil
import uuid
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from graphtex.cache import EntryLost, file_digest
from graphtex.errors import GraphtexError
from graphtex.handlers import fields, find_writer, output_format
from graphtex.parameters import validate
from graphtex.plan import PlannedOutput
from graphtex.run import RunResult
from graphtex.sockets import Gap


class OutputError(GraphtexError):
    """Outputs could not be written; a line for each, which names the file and the cause.

    Attributes
    ----------
    written
        The files of all outputs that could be written.
    """

    def __init__(self, message: str, written: Mapping[str, list[Path]] | None = None) -> None:
        super().__init__(message)
        self.written = dict(written or {})


def write_outputs(result: RunResult, folder: str | os.PathLike[str]) -> dict[str, list[Path]]:
    """Write all outputs of a run into a folder and return the files by output.

    Gaps of failed cells have none, nor has what a run that failed did not reach, nor a type that no file holds.

    Raises
    ------
    OutputError
        If a file cannot be written or its format cannot hold the value; all others are written first.
    """
    written: dict[str, list[Path]] = {}
    faults = []
    for name, output in result.plan.outputs.items():
        written[name] = []
        for path, value, options in _files(output, result, Path(folder)):
            try:
                written[name].append(write_value(output, value, path, options))
            except OutputError as error:
                faults.append(str(error))
    if faults:
        raise OutputError("\n".join(faults), written)
    return written


def _files(output: PlannedOutput, result: RunResult, folder: Path) -> Iterator[tuple[Path, Any, Mapping[str, Any]]]:
    """Yield each file that an output is written to, what it is to hold, and the writer's options."""
    suffix = Path(output.file).suffix if output.file else None
    how = output_format(output.type.base, suffix, output.options, result.plan.sources(output))
    if how is None:
        return
    file = output.file or f"{output.name}{how[0]}"
    try:
        value = result[output.name]
    except EntryLost:  # only after a failure: a run that ends well holds its outputs
        return
    for name, item in _named(file, output.names, value) if isinstance(value, list) else [(file, value)]:
        if not isinstance(item, Gap):
            yield folder / name, item, how[1]


def _named(file: str, names: Sequence[str], items: list[Any]) -> Iterator[tuple[str, Any]]:
    """Yield the file name of each item: ``cells-07.png``, or what the file makes of its own name."""
    if names:
        yield from ((file.replace("{}", name), item) for name, item in zip(names, items, strict=True))
        return
    suffix = Path(file).suffix
    digits = len(str(max(len(items) - 1, 0)))
    for index, item in enumerate(items):
        yield f"{file.removesuffix(suffix)}-{index:0{digits}d}{suffix}", item


def write_value(output: PlannedOutput, value: Any, path: Path, chosen: Mapping[str, Any]) -> Path:
    """Write one value to one file, with the chosen options, by way of a temporary one.

    A folder that was there already and holds something else is kept beside the new one, as ``name.old``: people may
    have worked on it.
    """
    writer = find_writer(output.type.base, path.suffix)
    options, problems = validate(writer.options, chosen)
    if options is None:
        raise OutputError(f"{output.name}: {problems[0][1]}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        scratch = path.parent / f".{path.stem[:40]}-{uuid.uuid4().hex}{path.suffix}"
        try:
            writer.function(value, scratch, **fields(options))
            if writer.folder:
                _swap(scratch, path)
            else:
                scratch.replace(path)
        finally:
            if scratch.is_dir():
                shutil.rmtree(scratch)
            scratch.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        reason = str(error)
        if isinstance(error, OSError):  # numpy's has no number: it tells only how many items were written
            reason = error.strerror or f"not written whole, is the disk full? ({reason})"
        raise OutputError(f"{path}: {reason}") from error
    return path


def _swap(scratch: Path, path: Path) -> None:
    """Put a new folder in the place of an old one, which is kept unless it holds the same."""
    if not path.exists():
        scratch.rename(path)
    elif not path.is_dir():
        raise ValueError("there is a file of this name, and a folder is to be written")
    elif file_digest(scratch) != file_digest(path):
        kept = path.with_name(f"{path.name}.old")
        if kept.exists():
            shutil.rmtree(kept)
        path.rename(kept)
        try:
            scratch.rename(path)
        except OSError:
            kept.rename(path)
            raise
