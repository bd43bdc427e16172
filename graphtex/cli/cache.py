"""``graphtex cache``: look after the store of results."""

import time
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import App, Parameter

from graphtex.cli.terminal import DONE, FAILED, count, duration, out, say, size, table
from graphtex.errors import GraphError, Problem

if TYPE_CHECKING:
    from graphtex.cache import Cache, Pruned

cache_app = App(
    name="cache",
    help="Look after the cache of results.",
    default_parameter=Parameter(negative=(), show_default=False),
    version_flags=(),
)


def _open(folder: Path | None) -> "Cache":
    from graphtex.run import make_cache

    return make_cache(folder)


@cache_app.command
def info(*, cache: Path | None = None) -> int:
    """Tell where the cache is, what it holds and its bound.

    Parameters
    ----------
    cache
        The cache's folder, by default the user's own.
    """
    told = _open(cache).info()
    rows = [
        ("folder", str(told.directory)),
        ("results", f"{count(told.records, 'node run')}, {count(told.objects, 'stored value')}"),
        ("size", f"{size(told.bytes)} of at most {size(told.limit)}"),
        ("last used", _ago(told.most_recent_use)),
        ("oldest use", _ago(told.least_recent_use)),
        ("in use by", count(told.live_runs, "run")),
    ]
    out(table(rows))
    return DONE


def _ago(moment: float | None) -> str:
    if moment is None:
        return "never"
    seconds = max(time.time() - moment, 0.0)
    if seconds < 3600:
        return f"{duration(seconds)} ago"
    return f"{count(int(seconds // 3600), 'hour')} ago" if seconds < 2 * 86400 else f"{int(seconds // 86400)} days ago"


@cache_app.command
def prune(*, size: str | None = None, cache: Path | None = None) -> int:
    """Remove the least recently used results until the rest is small enough.

    Parameters
    ----------
    size
        What may remain, such as 2GiB or 500MB; by default the cache's own bound.
    cache
        The cache's folder, by default the user's own.
    """
    from graphtex.cache import parse_size

    opened = _open(cache)
    try:
        limit = None if size is None else parse_size(size)
    except ValueError as error:
        raise GraphError([Problem("", 0, 0, "--size", str(error))]) from error
    _tell(opened.prune(limit))
    return DONE


@cache_app.command
def clear(*, cache: Path | None = None) -> int:
    """Remove all results, but for those that a run is using now.

    Parameters
    ----------
    cache
        The cache's folder, by default the user's own.
    """
    _tell(_open(cache).clear())
    return DONE


@cache_app.command
def verify(*, cache: Path | None = None) -> int:
    """Read everything back; remove what is damaged, which will be computed again. Exit status 1 if there was any.

    Parameters
    ----------
    cache
        The cache's folder, by default the user's own.
    """
    found = _open(cache).verify()
    for text in (*found.damaged, *found.dangling):
        say(text, "yellow")
    removed = len(found.damaged) + len(found.dangling)
    out(f"{count(found.checked, 'file')} checked, {removed} removed")
    return FAILED if found.damaged else DONE


def _tell(pruned: "Pruned") -> None:
    removed = f"{count(pruned.records, 'node run')} and {count(pruned.objects, 'stored value')}"
    out(f"removed {removed}: {size(pruned.freed)}; {size(pruned.bytes)} remain")
