"""``graphtex run``: run a graph and write its outputs."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from graphtex.cli.terminal import DONE, FAILED, INTERRUPTED, out, say
from graphtex.errors import Cancelled, GraphError, NodeFailed, Problem

if TYPE_CHECKING:
    from graphtex.cache import Cache
    from graphtex.cli.display import Display
    from graphtex.graph import Graph
    from graphtex.run import RunResult

Set = Annotated[list[str] | None, Parameter(name="--set", negative=())]
OUT = "graphtex-out"


def run(
    graph: str,
    /,
    *,
    set_: Set = None,
    out: Path | None = None,
    seed: int | None = None,
    only: list[str] | None = None,
    executor: str | None = None,
    workers: int | None = None,
    cache: Path | None = None,
    no_cache: bool = False,
    dry_run: bool = False,
    report: Path | None = None,
    json: bool = False,
    quiet: bool = False,
) -> int:
    """Run a graph, write its outputs and print their paths.

    Parameters
    ----------
    graph
        A graph file, or the name of a graph that ships with graphtex, such as perspective/feature-mask.
    set_
        NAME=VALUE: the value of a graph input; again for another. Lists are a,b,c; a list of pictures may be a folder
        or a pattern. Paths start from the current folder.
    out
        The folder to write to, by default graphtex-out/ and the graph's name.
    seed
        Used in place of the graph's own seed.
    only
        The output to make; again for another. By default all.
    executor
        Where nodes run, see the documentation; by default serial, or threads if there are workers.
    workers
        How many nodes run at once.
    cache
        The folder of the cache, by default the user's own.
    no_cache
        Neither read nor write a cache.
    dry_run
        Run nothing; tell which nodes are cached, which would run, and why.
    report
        An HTML file to write: the outputs, what ran and how long it took.
    json
        Print one JSON object in place of the paths.
    quiet
        Tell nothing of the progress.
    """
    from graphtex.cli.arguments import given_inputs, read_graph
    from graphtex.shipped import graph_identity

    loaded = read_graph(graph)
    values = given_inputs(loaded, set_ or ())
    _check_options(cache, no_cache, seed)
    chosen: Path | bool = cache if cache is not None else not no_cache
    if dry_run:
        from graphtex.cli.forecast import dry_run as forecast

        return forecast(loaded, values, seed=seed, only=only or (), cache=chosen, as_json=json)
    folder = out if out is not None else default_folder(loaded)
    return carry_out(
        loaded,
        values,
        folder=folder,
        seed=seed,
        only=only or (),
        executor=executor or ("threads" if workers and workers > 1 else "serial"),
        workers=workers,
        cache=chosen,
        report=report,
        as_json=json,
        quiet=quiet,
        name=graph_identity(loaded.file),
    )


def _check_options(cache: Path | None, no_cache: bool, seed: int | None) -> None:
    problems = []
    if cache is not None and no_cache:
        problems.append(Problem("", 0, 0, "--no-cache", "--cache was given too; choose one"))
    if seed is not None and seed < 0:
        problems.append(Problem("", 0, 0, "--seed", f"a seed is a whole number from 0, got {seed}"))
    if problems:
        raise GraphError(problems)


def default_folder(graph: "Graph") -> Path:
    """Return where outputs go if nothing is said: ``graphtex-out/`` and the shipped name or the file's name."""
    from graphtex.shipped import graph_identity

    name = Path(graph_identity(graph.file))
    return Path(OUT) / (name.stem if name.is_absolute() else name)


def carry_out(
    graph: "Graph",
    values: Mapping[str, Any],
    *,
    folder: Path,
    name: str,
    seed: int | None = None,
    only: Sequence[str] = (),
    executor: str = "serial",
    workers: int | None = None,
    cache: "Cache | Path | bool" = True,
    report: Path | None = None,
    as_json: bool = False,
    quiet: bool = False,
) -> int:
    """Run a graph with a display, write what it made, and return the exit status."""
    from graphtex.cli.display import make_display
    from graphtex.cli.interrupt import Interrupts
    from graphtex.run import run as run_graph

    _check_folder(folder, "--out")
    if report is not None:
        _check_folder(report.parent, "--report")
    log: list[Any] = []
    display = make_display(quiet)

    def emit(event: Any) -> None:
        if report is not None:
            log.append(event)
        display(event)

    failure: NodeFailed | None = None
    with display, Interrupts(lambda text: display.note(text) if text else display.close()) as interrupts:
        try:
            result = interrupts.run(
                lambda: run_graph(
                    graph,
                    values,
                    seed=seed,
                    only=only,
                    executor=executor,
                    workers=workers,
                    cache=cache,
                    emit=emit,
                    cancel=interrupts.cancel,
                    keep_all=report is not None,
                )
            )
        except Cancelled:
            display.close()
            kept = "" if cache is False else "; finished nodes are cached"
            say(f"interrupted{kept}", "yellow")
            return INTERRUPTED
        except NodeFailed as error:
            if error.result is None:
                raise
            failure, result = error, error.result
    if not quiet:
        say(display.summary())
    return _deliver(result, failure, display, folder, name, graph.seed if seed is None else seed, report, log, as_json)


def _deliver(
    result: "RunResult",
    failure: NodeFailed | None,
    display: "Display",
    folder: Path,
    name: str,
    seed: int,
    report: Path | None,
    log: list[Any],
    as_json: bool,
) -> int:
    """Write outputs and report, print paths or JSON, list failures."""
    from graphtex.outputs import OutputError, write_outputs

    status = FAILED if failure is not None or result.failed else DONE
    written: dict[str, list[Path]] = {}
    try:
        written = write_outputs(result, folder)
    except OutputError as error:
        say(str(error), "red")
        status = FAILED
    if as_json:
        from graphtex.cli.summary import run_object

        out(
            json.dumps(
                run_object(result, written, name, seed, display.tally.seconds, status == DONE),
                ensure_ascii=False,
                indent=2,
            )
        )
    else:
        for paths in written.values():
            for path in paths:
                out(str(path))
    if report is not None:
        from graphtex.report import report_html

        report.write_text(report_html(result, events=log), encoding="utf-8")
        say(f"report: {report}")
    for ended in result.reports.values():
        if ended.status == "failed":
            say(f"failed: {ended.task.id}: {ended.message}", "bold red")
    return status


def _check_folder(folder: Path, option: str) -> None:
    """Make a folder before anything runs, so that a wrong one costs no time."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"the folder {str(folder)!r} cannot be made: {error.strerror or error}"
        raise GraphError([Problem("", 0, 0, option, message)]) from error
