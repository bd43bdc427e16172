"""Puts the report together and writes it."""

import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

from graphtex.document import REQUIRED, Document
from graphtex.outputs import OutputError
from graphtex.plan import PlannedOutput
from graphtex.references import is_scalar
from graphtex.report.album import BUDGET, Album, size_for
from graphtex.report.parts import Missing, Story
from graphtex.report.style import SCRIPT, STYLE
from graphtex.report.tasks import group_section, source_link
from graphtex.report.words import chip, code, duration, folded, plural, tally, worst
from graphtex.run import RunResult
from graphtex.show.page import drawn, heading, page, table
from graphtex.show.paint import svg
from graphtex.show.scene import brief
from graphtex.show.style import escape
from graphtex.whole import write_text

OUTPUT_SIZE = 640  # longest side of the picture of an output
_LISTED = 4  # warnings and failures that stand at the top unfolded


def report_html(
    result: RunResult,
    *,
    seconds: float,
    outputs: Mapping[str, Sequence[Path]] | None = None,
    warnings: Sequence[str] = (),
    inputs: Mapping[str, Any] | None = None,
    folder: Path | None = None,
    budget: int = BUDGET,
) -> str:
    """Return a run as one HTML page that needs nothing else.

    Parameters
    ----------
    result
        Of a finished run, or of one that failed (``NodeFailed.result``). Without a cache run with ``keep_all``, or only
        the outputs have pictures.
    seconds
        How long the whole run took.
    outputs
        The files that were written, by output.
    warnings
        Of the run itself; those of nodes stand in their reports.
    inputs
        What was asked for, by input; for inputs that are numbers and texts the plan does not keep it.
    folder
        Where the page will stand: the files of outputs become links from there.
    budget
        Bytes of pictures; what does not fit is left out, and the page says so.
    """
    story, album = Story(result), Album(budget)
    shown = [_output(story, album, output, (outputs or {}).get(output.name, ()), folder) for output in
             result.plan.outputs.values()]  # fmt: skip
    sections = [group_section(story, album, group) for group in story.groups.values()]
    parts = [
        heading(story.graph),
        _summary(story, seconds),
        _notes(story, warnings, album),
        drawn(svg(_as_run(story, inputs or {}), marks=story.marks()), "The graph, with what became of each node"),
        f'<section id="outputs"><h2>Outputs</h2><div class="outputs">{"".join(shown)}</div></section>' if shown else "",
        _inputs(story, inputs or {}),
        _contents(story),
        *sections,
    ]
    title = f"{story.graph.title or 'A graph'}: report of a run"
    return page(title, "\n".join(filter(None, parts)), style=STYLE, script=SCRIPT)


def write_report(
    path: Path,
    result: RunResult,
    *,
    seconds: float,
    outputs: Mapping[str, Sequence[Path]] | None = None,
    warnings: Sequence[str] = (),
    inputs: Mapping[str, Any] | None = None,
) -> None:
    """Write `report_html` to a file, whole or not at all; OutputError if that is not possible."""
    text = report_html(result, seconds=seconds, outputs=outputs, warnings=warnings, inputs=inputs, folder=path.parent)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_text(path, text)
    except OSError as error:
        raise OutputError(f"{path}: {error.strerror or error}") from error


def _summary(story: Story, seconds: float) -> str:
    """Return the state of the run, its figures and the versions that made it."""
    tasks = story.result.plan.tasks
    statuses = [story.status(task) for task in tasks]
    state = worst(statuses)
    headline = {"failed": "Ended with failures", "waiting": "Stopped", "skipped": "Ended with failures"}.get(
        state, "Done"
    )
    busy = sum(report.seconds for report in story.result.reports.values() if report.status == "ran")
    facts = [
        ("Tasks", f"{len(tasks)}: {tally(statuses)}"),
        ("Took", f"{duration(seconds)}, nodes {duration(busy)}"),
        ("Seed", escape(story.seed)),
    ]
    if story.graph.file:
        facts.append(("Graph", f"<code>{escape(story.graph.file)}</code>"))
    facts.append(("Versions", escape(", ".join(f"{name} {version}" for name, version in _versions(story).items()))))
    items = "".join(f"<div><dt>{name}</dt><dd>{text}</dd></div>" for name, text in facts)
    return f"<p>{chip('ran' if headline == 'Done' else 'failed', headline)}</p>\n<dl>{items}</dl>"


def _versions(story: Story) -> dict[str, str]:
    """Return the versions of graphtex, of Python and of all that the results' keys depend on."""
    from graphtex import __version__

    found = {"graphtex": __version__, "Python": platform.python_version()}
    for parts in story.result.finished.parts.values():
        found.update(parts.environment)
    found.pop("python", None)  # told in full above
    return found


def _notes(story: Story, warnings: Sequence[str], album: Album) -> str:
    """Return failures and warnings, each with a link to its task."""
    parts = []
    failed, told = [], [escape(text) for text in warnings]
    for task, report in story.result.reports.items():
        link = f'<a href="#{story.anchors[task]}">{escape(task)}</a>'
        if report.status == "failed":
            failed.append(f"<b>{link}</b> {escape(report.message)}")
        told += [f"<b>{link}</b> {escape(text)}" for text in report.warnings]
    for found, status, word in ((failed, "failed", "failure"), (told, "skipped", "warning")):
        lines = [f'<p class="message {status}">{text}</p>' for text in found]
        parts += lines[:_LISTED]
        if lines[_LISTED:]:
            summary = f"{plural(len(lines) - _LISTED, f'more {word}')}"
            parts.append(f"<details><summary>{summary}</summary>{''.join(lines[_LISTED:])}</details>")
    if album.left_out:
        parts.append(
            f'<p class="message waiting">{plural(album.left_out, "picture")} left out: '
            f"this page holds at most {album.budget / (1 << 20):.3g} MiB of pictures.</p>"
        )
    return "\n".join(parts)


def _output(story: Story, album: Album, output: PlannedOutput, files: Sequence[Path], folder: Path | None) -> str:
    """Return what an output of the graph is: its picture or pictures, where it comes from and its files."""
    links = [_file(file, folder) for file in files]
    shown = list(output.slots[:100])
    side = size_for(len(output.slots), OUTPUT_SIZE)
    figures = []
    for slot in shown:
        value = story.value(slot)
        caption = f"from {source_link(story, slot)}"
        if isinstance(value, Missing):
            figures.append(
                f'<figure><div class="told dim">{escape(value.reason)}</div><figcaption>{caption}</figcaption></figure>'
            )
        else:
            figures.append(album.show(story.kind(slot), value, caption, f"{output.name}, from {slot.task}", side))
    more = (
        f'<p class="dim">The first {len(shown)} of {len(output.slots)}.</p>' if len(output.slots) > len(shown) else ""
    )
    where = f'<p class="small">{folded(links, 4, "files")}</p>' if links else ""
    views, wide = ("views grid", " wide") if len(shown) > 4 else ("views", "")
    head = f"<h3>{escape(output.name)}</h3>{where}"
    return f'<div class="output{wide}">{head}<div class="{views}">{"".join(figures)}</div>{more}</div>\n'


def _file(file: Path, folder: Path | None) -> str:
    if folder is None:
        return f"<code>{escape(file)}</code>"
    try:
        near = os.path.relpath(file, folder)
    except ValueError:  # another drive
        return f"<code>{escape(file)}</code>"
    return f'<a href="{escape(quote(Path(near).as_posix()))}"><code>{escape(file)}</code></a>'


def _values(story: Story, asked: Mapping[str, Any]) -> dict[str, Any]:
    """Return what each input was in this run; `REQUIRED` for arrays, of which nothing can be written."""
    given = {slot.task.split("[")[0] for slot in story.result.plan.given}
    values = {}
    for name, kind in story.graph.inputs.items():
        value = asked.get(name, kind.default)
        written = f"${name}" not in given and (is_scalar(kind) or isinstance(value, str | list))
        values[name] = value if written else REQUIRED
    return values


def _as_run(story: Story, asked: Mapping[str, Any]) -> Document:
    """Return the graph with what was asked for in the place of its defaults."""
    values = _values(story, asked)
    inputs = {name: replace(kind, default=values[name]) for name, kind in story.graph.inputs.items()}
    return replace(story.graph, inputs=inputs)


def _inputs(story: Story, asked: Mapping[str, Any]) -> str:
    """Return the graph's inputs: what each was in this run, where that is known."""
    rows = []
    values = _values(story, asked)
    for name, kind in story.graph.inputs.items():
        group, known = story.groups.get(f"${name}"), values[name] is not REQUIRED
        note = '<span class="dim">default</span>' if known and name not in asked else ""
        shown = code(brief(values[name], 200)) if known else '<span class="dim">given</span>'
        title = f'<a href="#{group.anchor}">{escape(name)}</a>' if group else escape(name)
        rows.append((title, escape(kind.type), shown, note, escape(kind.description)))
    heads = ("Name", "Type", "Value", "", "What it is")
    return f'<section id="inputs"><h2>Inputs</h2>{table(heads, rows)}</section>' if rows else ""


def _contents(story: Story) -> str:
    """Return links to all sections."""
    items = []
    for key, group in story.groups.items():
        statuses = [story.status(task) for task in group.tasks]
        state = chip(worst(statuses), tally(statuses) if len(statuses) > 1 else "") if statuses else ""
        items.append(f'<li><a href="#{group.anchor}">{escape(key.removeprefix("$"))}</a> {state}</li>')
    return f'<nav aria-label="Nodes"><h2>Nodes</h2><ul>{"".join(items)}</ul></nav>'
