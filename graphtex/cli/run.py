"""``graphtex run``: run a graph and write its outputs."""

import gc
import os
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from graphtex.cli.terminal import DONE, FAILED, INTERRUPTED, out, print_json, say, trace
from graphtex.errors import Cancelled, GraphError, NodeFailed, Problem

if TYPE_CHECKING:
    import threading

    from graphtex.cli.display import Display
    from graphtex.cli.tally import Tally
    from graphtex.document import Document
    from graphtex.plan import Plan
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
        Where nodes run: serial or threads; by default serial, or threads if there are workers.
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
        Print one JSON object in place of the paths, also if the run fails or is refused.
    quiet
        Tell nothing of the progress; warnings are told.
    """
    from graphtex.cli.arguments import given_inputs, read_graph

    loaded = read_graph(graph)
    values = given_inputs(loaded, set_ or ())
    _check_options(cache, no_cache, seed)
    chosen: Path | bool = cache if cache is not None else not no_cache
    if dry_run:
        from graphtex.cli.forecast import dry_run as forecast

        return forecast(loaded, values, seed=seed, only=only or (), cache=chosen, as_json=json)
    return carry_out(
        Job(
            loaded,
            out if out is not None else default_folder(loaded),
            values,
            seed=seed,
            only=tuple(only or ()),
            executor=executor or ("threads" if workers and workers > 1 else "serial"),
            workers=workers,
            cache=chosen,
            report=report,
            as_json=json,
            quiet=quiet,
        )
    )


def _check_options(cache: Path | None, no_cache: bool, seed: int | None) -> None:
    problems = []
    if cache is not None and no_cache:
        problems.append(Problem("", 0, 0, "--no-cache", "--cache was given too; choose one"))
    if seed is not None and seed < 0:
        problems.append(Problem("", 0, 0, "--seed", f"a seed is a whole number from 0, got {seed}"))
    if problems:
        raise GraphError(problems)


def default_folder(graph: "Document") -> Path:
    """Return where outputs go if nothing is said: ``graphtex-out/`` and the shipped name or the file's name."""
    from graphtex.shipped import graph_identity

    name = Path(graph_identity(graph.file))
    return Path(OUT) / (name.stem if name.is_absolute() else name)


@dataclass(frozen=True)
class Job:
    """A run as it was asked for; see `run`."""

    graph: "Document"
    folder: Path
    values: Mapping[str, Any] = field(default_factory=dict)
    seed: int | None = None
    only: tuple[str, ...] = ()
    executor: str = "serial"
    workers: int | None = None
    cache: Path | bool = True
    report: Path | None = None
    as_json: bool = False
    quiet: bool = False


def carry_out(job: Job) -> int:
    """Run a graph with a display, write what it made, and return the exit status."""
    from graphtex.cli.displays import make_display
    from graphtex.cli.interrupt import Interrupts

    _check_folder(job.folder, "--out")
    if job.report is not None:
        _check_folder(job.report.parent, "--report")
        if job.report.is_dir():
            message = f"{str(job.report)!r} is a folder; the report is a file"
            raise GraphError([Problem("", 0, 0, "--report", message)])
    failure: NodeFailed | None = None
    with make_display(job.quiet) as display:
        interrupts = Interrupts(lambda text: display.note(text) if text else display.close())
        try:
            with interrupts, redirect_stdout(sys.stderr):  # what nodes print is no result
                result = interrupts.run(lambda: _run(job, display, interrupts.cancel))
        except Cancelled:
            display.close()
            if job.as_json:
                from graphtex.cli.summary import stopped_object

                print_json(stopped_object(job.graph, _seed(job), display.tally))
            say(f"interrupted{'' if job.cache is False else '; finished nodes are cached'}", "yellow")
            return INTERRUPTED
        except NodeFailed as error:
            if error.result is None:
                raise
            trace(error)
            failure, result = error, error.result
    if not job.quiet:
        say(display.summary())
    ended_well = _deliver(job, result, display.tally)
    for ended in result.reports.values():
        if ended.status == "failed":
            say(f"failed: {ended.task.id}{_made_of(result.plan, ended.task.id)}: {ended.message}", "bold red")
    return DONE if ended_well and failure is None and not result.failed else FAILED


def _made_of(plan: "Plan", task: str) -> str:
    """Return which files of a list a cell was made of: its number tells nobody."""
    import networkx as nx

    items = [plan.tasks[name] for name in nx.ancestors(plan.dag, task) if "[" in name and plan.tasks[name].files]
    names = sorted({file.name for item in items for file in item.files})
    return f" ({', '.join(names)})" if names and len(names) <= 3 else ""


def _run(job: Job, display: "Display", cancel: "threading.Event") -> "RunResult":
    from graphtex.run import run as run_graph

    if not gc.isenabled():  # see `graphtex.__main__`
        gc.freeze()
        gc.enable()
    return run_graph(
        job.graph,
        job.values,
        seed=job.seed,
        only=job.only,
        executor=job.executor,
        workers=job.workers,
        cache=job.cache,
        emit=display,
        cancel=cancel,
        keep_all=job.report is not None,
    )


def _deliver(job: Job, result: "RunResult", tally: "Tally") -> bool:
    """Write outputs and report, print paths or JSON; return whether all of that could be written."""
    from graphtex.outputs import OutputError, write_outputs

    seconds = tally.seconds
    written: dict[str, list[Path]] = {}
    fine = True
    try:
        written = write_outputs(result, job.folder)
    except OutputError as error:
        written = error.written
        say(str(error), "red")
        fine = False
    if job.report is not None:
        from graphtex.report import write_report

        general = [text for task, text in tally.warnings if not task]
        try:
            write_report(job.report, result, seconds=seconds, outputs=written, warnings=general, inputs=job.values)
            if not job.quiet:
                say(f"report: {job.report}")
        except OutputError as error:
            say(str(error), "red")
            fine = False
    if job.as_json:
        from graphtex.cli.summary import run_object

        print_json(run_object(result, written, _seed(job), seconds, done=fine and not result.failed))
    else:
        for paths in written.values():
            for path in paths:
                out(str(path))
    return fine


def _seed(job: Job) -> int:
    return job.graph.seed if job.seed is None else job.seed


def _check_folder(folder: Path, option: str) -> None:
    """Make a folder before anything runs, so that a wrong one costs no time."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"the folder {str(folder)!r} cannot be made: {error.strerror or error}"
        raise GraphError([Problem("", 0, 0, option, message)]) from error
    if not os.access(folder, os.W_OK):
        raise GraphError([Problem("", 0, 0, option, f"the folder {str(folder)!r} cannot be written to")])
