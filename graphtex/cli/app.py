"""The command ``graphtex``: its commands, and what becomes of errors."""

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import App, CycloptsError, Parameter

from graphtex.cli.arguments import spread
from graphtex.cli.cache import cache_app
from graphtex.cli.check import check
from graphtex.cli.demo import demo
from graphtex.cli.graphs import graphs
from graphtex.cli.new import new
from graphtex.cli.nodes import nodes
from graphtex.cli.run import run
from graphtex.cli.schema import schema
from graphtex.cli.show import show
from graphtex.cli.summary import error_object
from graphtex.cli.terminal import DONE, FAILED, INTERRUPTED, WRONG, complain, debug, print_json, say, trace
from graphtex.cli.why import why
from graphtex.errors import GraphError, GraphtexError, Problem

if TYPE_CHECKING:
    from collections.abc import Callable

DEBUG_VARIABLE = "GRAPHTEX_DEBUG"
STATUS_WORDS = {FAILED: "failed", WRONG: "wrong", INTERRUPTED: "interrupted"}
BROKEN_PIPE = 141  # what a shell reports for a program that SIGPIPE ended


def _version() -> str:
    from graphtex import __version__

    return __version__


def make_app() -> App:
    """Return the command line with all its commands."""
    app = App(
        name="graphtex",
        help="Example-based texture synthesis and editing as a node-graph dataflow framework.\n\n"
        "Try `graphtex demo`, then `graphtex graphs`, `graphtex nodes` and `graphtex run GRAPH --dry-run`. GRAPH is a "
        "YAML file, or the name of a graph that ships with graphtex.",
        help_epilogue="Exit status: 0 done, 1 a node failed, 2 the request is wrong, 130 interrupted. "
        f"With --debug (or {DEBUG_VARIABLE}=1) errors show their tracebacks.",
        version=_version,
        version_flags=["--version"],
        help_format="plaintext",
        default_parameter=Parameter(negative=(), show_default=False),
        result_action="return_value",
        suppress_keyboard_interrupt=False,
    )
    commands: tuple[Callable[..., int], ...] = (run, demo, graphs, check, show, nodes, why, schema, new)
    for command in commands:
        app.command(command)
    app.command(cache_app)
    return app


def call(arguments: Sequence[str]) -> int:
    """Carry out a command line and return its exit status; nothing that a user can type ends in a traceback."""
    words = list(arguments)
    end = words.index("--") if "--" in words else len(words)
    token = debug.set("--debug" in words[:end] or os.environ.get(DEBUG_VARIABLE, "") not in ("", "0"))
    words = [word for word in words[:end] if word != "--debug"] + words[end:]
    try:
        status = _carry_out(words, as_json="--json" in words[:end])
        sys.stdout.flush()
        return status
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        _silence(sys.stdout, sys.stderr)
        return BROKEN_PIPE
    finally:
        debug.reset(token)


def _carry_out(words: list[str], *, as_json: bool) -> int:
    app = make_app()

    def fail(status: int, *problems: Problem) -> int:
        if as_json:
            print_json(error_object(STATUS_WORDS[status], problems))
        complain(problems)
        return status

    try:
        status = app(spread(words), print_error=False, exit_on_error=False)
        return status if isinstance(status, int) else DONE
    except CycloptsError as error:
        chain = " ".join(("graphtex", *(error.command_chain or ())))
        return fail(WRONG, Problem("", 0, 0, chain, f"{_one_line(str(error))} (see {chain} --help)"))
    except GraphError as error:
        trace(error)
        return fail(WRONG, *error.problems)
    except BrokenPipeError:
        raise
    except (KeyboardInterrupt, GraphtexError, MemoryError) as error:
        trace(error)
        if isinstance(error, KeyboardInterrupt):
            say("interrupted", "yellow")
            return fail(INTERRUPTED)
        return fail(FAILED, Problem("", 0, 0, "", str(error) or "out of memory"))
    except Exception as error:  # noqa: BLE001 (a fault of ours or of a pack: one line, and how to see the rest)
        trace(error)
        hint = f"a fault in graphtex or a node pack; --debug or {DEBUG_VARIABLE}=1 shows the traceback"
        message = f"{type(error).__name__}: {_one_line(str(error))} ({hint})"
        return fail(FAILED, Problem("", 0, 0, "internal error", message))


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _silence(*streams: "object") -> None:
    """Point streams at nothing, so that flushing them at exit does not complain again."""
    with Path(os.devnull).open("w") as nothing:
        for stream in streams:
            os.dup2(nothing.fileno(), stream.fileno())  # type: ignore[attr-defined]
