"""Graph files on disk: what is wrong with a file is said as clearly as what is wrong in it."""

import codecs
import os
from pathlib import Path

from graphtex.document import Document
from graphtex.errors import GraphError, Problem
from graphtex.files.reader import read
from graphtex.files.writer import dumps
from graphtex.files.yamltree import BULK_HINT, MAX_SIZE
from graphtex.whole import write_text

_FOREIGN = ((codecs.BOM_UTF32_LE, "UTF-32"), (codecs.BOM_UTF32_BE, "UTF-32"), (codecs.BOM_UTF16_LE, "UTF-16"),
            (codecs.BOM_UTF16_BE, "UTF-16"))  # fmt: skip


def read_file(path: str | os.PathLike[str]) -> tuple[Document | None, list[Problem]]:
    """Read a graph file as `read` reads its text; a file that cannot be read is a problem too.

    UTF-8 with or without a byte order mark; at most `MAX_SIZE` bytes.
    """
    file = Path(path)
    try:
        with file.open("rb") as stream:
            data = stream.read(MAX_SIZE + 1)
        return read(_decoded(data), file)
    except FileNotFoundError:
        message = "there is no such file"
    except IsADirectoryError:
        message = "a folder; a graph is one file"
    except PermissionError:
        message = "a folder; a graph is one file" if file.is_dir() else "the file may not be read: permission denied"
    except OSError as error:
        message = f"the file cannot be read: {error.strerror or error}"
    except _Unreadable as error:
        return None, [Problem(str(file), error.line, error.column, "", str(error))]
    except ValueError as error:  # a path with a null character
        message = f"no path: {error}"
    return None, [Problem(str(file), 0, 0, "", message)]


class _Unreadable(Exception):
    """Bytes that are no text of a graph file."""

    def __init__(self, message: str, line: int = 0, column: int = 0) -> None:
        self.line, self.column = line, column
        super().__init__(message)


def _decoded(data: bytes) -> str:
    if len(data) > MAX_SIZE:
        raise _Unreadable(f"larger than {MAX_SIZE >> 20} MiB; {BULK_HINT}")
    for mark, name in _FOREIGN:
        if data.startswith(mark):
            raise _Unreadable(f"the file is {name}; save it as UTF-8")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        before = data[: error.start].decode().removeprefix("\ufeff")
        lines = before.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        message = f"not UTF-8: byte 0x{data[error.start]:02x}; save the file as UTF-8"
        if b"\0" in data:
            message = "no text: a graph is a YAML file; a picture is given to one of its inputs"
        raise _Unreadable(message, len(lines), len(lines[-1]) + 1) from None


def save(graph: Document, path: str | os.PathLike[str]) -> None:
    """Write a graph file; a reader sees the old file or the new one, never a part.

    Raises
    ------
    GraphError
        If the graph or the file cannot be written; an existing file is left as it was.
    """
    try:
        write_text(Path(path), dumps(graph))
    except OSError as error:
        raise GraphError([Problem(str(path), 0, 0, "", f"cannot be written: {error.strerror or error}")]) from error
