"""What the report tells of each node of the graph and of each of its tasks."""

import json
import re
from typing import Any

from graphtex.parameters import plain
from graphtex.plan import Slot, Task
from graphtex.report.album import Album, size_for
from graphtex.report.parts import Group, Missing, Story
from graphtex.report.words import chip, code, duration, folded, tally
from graphtex.show.page import table
from graphtex.show.style import escape
from graphtex.sockets import Gap
from graphtex.work import shape_of

SIZE = 512  # longest side of a picture of a node that ran once
_LISTED = 24  # tasks of a node that are listed; more are folded away
_UNFOLDED = 2  # failed tasks of a node that are unfolded
_DEFAULT = '<span class="dim">default</span>'
_USUAL = 6  # parameters with their defaults that are not folded away


def group_section(story: Story, album: Album, group: Group) -> str:
    """Return the section of one input or node."""
    entry = story.graph.nodes.get(group.key)
    title = escape(group.key.removeprefix("$"))
    what = "input" if entry is None else entry.node or entry.graph
    parts = [
        f'<section id="{group.anchor}" class="group"><h2>{title} <span class="dim small">{escape(what)}</span> '
        f"{_chips(story, group)}</h2>"
    ]
    given = [slot for slot in story.result.plan.given if slot.task.split("[")[0] == group.key]
    if given:
        figures = [_output(story, album, slot, size_for(len(given), SIZE)) for slot in given]
        parts.append(f'<p class="dim">Given by the caller.</p><div class="views">{"".join(figures)}</div>')
    if len(group.tasks) == 1 and not (entry and (entry.each or entry.graph)):
        parts.append(f'<div id="{story.anchors[group.tasks[0]]}">{_body(story, album, group.tasks[0], SIZE)}</div>')
    else:
        parts.append(_matrix(story, album, group))
        side = min(size_for(len(group.tasks), SIZE), 256)
        failed = [task for task in group.tasks if story.status(task) == "failed"][:_UNFOLDED]
        tasks = [_folded_task(story, album, task, side, task in failed) for task in group.tasks]
        if len(tasks) > _LISTED:
            tasks = [f"<details><summary>All {len(tasks)} tasks</summary>", *tasks, "</details>"]
        parts += tasks
    parts.append("</section>")
    return "\n".join(parts)


def _chips(story: Story, group: Group) -> str:
    if len(group.tasks) == 1:
        return chip(story.status(group.tasks[0]))
    statuses = [story.status(task) for task in group.tasks]
    return " ".join(chip(status, tally([s for s in statuses if s == status])) for status in sorted(set(statuses)))


def _folded_task(story: Story, album: Album, task: str, size: int, is_open: bool) -> str:
    status = story.status(task)
    report = story.report(task)
    took = f' <span class="dim">{duration(report.seconds)}</span>' if report and status == "ran" else ""
    node = story.result.plan.tasks[task].node.name
    return (
        f'<details id="{story.anchors[task]}" class="task"{" open" if is_open else ""}>'
        f'<summary><code>{escape(task)}</code> <span class="dim">{escape(node)}</span> {chip(status)}{took}</summary>'
        f"{_body(story, album, task, size)}</details>"
    )


def _matrix(story: Story, album: Album, group: Group) -> str:
    """Return all cells of an `each:` at one glance: a table for two ranges, otherwise side by side."""
    cells = story.cells(group)
    if not cells:
        return ""
    side = size_for(4 * len(cells), 160)
    shown = {cell: _cell(story, album, cell, slots, side) for cell, slots in cells.items()}
    indices = [tuple(int(n) for n in re.findall(r"\d+", cell.rpartition("[")[2])) for cell in cells]
    names = list(story.graph.nodes[group.key].each)
    if {len(index) for index in indices} != {2} or max(max(index) for index in indices) >= 40:
        return f'<div class="views grid">{"".join(shown.values())}</div>'
    labels: list[list[str]] = []
    for axis in (0, 1):
        first = {index[axis]: cell for index, cell in reversed(list(zip(indices, cells, strict=True)))}
        labels.append([escape(story.range_label(group, names[axis], i, first[i])) for i in sorted(first)])
    by_index = dict(zip(indices, shown.values(), strict=True))
    head = "".join(f'<th scope="col">{label}</th>' for label in labels[1])
    body = ""
    for row, label in enumerate(labels[0]):
        body += f'<tr><th scope="row">{label}</th>'
        body += "".join(f"<td>{by_index[row, column]}</td>" for column in range(len(labels[1]))) + "</tr>"
    inside = f"<thead><tr><td></td>{head}</tr></thead><tbody>{body}</tbody>"
    return f'<div class="scroll"><table class="matrix">{inside}</table></div>'


def _cell(story: Story, album: Album, cell: str, slots: list[Slot], side: int) -> str:
    """Return the first output of a cell; its caption leads to the task that made it."""
    label = f"<code>{escape(cell)}</code>"
    if not slots:
        return f"<p>{label}</p>"
    anchor = story.anchors.get(slots[0].task)
    caption = f'<a href="#{anchor}">{label}</a>' if anchor else label
    return _figure_of(story, album, slots[0], caption, cell, side)


def _body(story: Story, album: Album, name: str, size: int) -> str:
    """Return all that is known of a task."""
    task, report = story.result.plan.tasks[name], story.report(name)
    status = story.status(name)
    parts = [f"<p>{_marked_up(task.node.summary)}</p>" if task.node.summary else ""]
    if report and report.message:
        parts.append(f'<p class="message {status}"><b>{status.capitalize()}.</b> {escape(report.message)}</p>')
    parts += (
        [f'<p class="message skipped"><b>Warning.</b> {escape(text)}</p>' for text in report.warnings] if report else []
    )
    slots = [slot for slot in (Slot(name, socket) for socket in task.node.outputs) if status in ("ran", "cached")]
    if slots:
        figures = "".join(_output(story, album, slot, size_for(len(slots), size)) for slot in slots)
        parts.append(f'<div class="views">{figures}</div>')
    parts.append(_facts(story, task))
    if task.inputs:
        sockets = [
            (escape(key), escape(task.node.inputs[key].type), _sources(story, slot))
            for key, slot in task.inputs.items()
        ]
        parts += ["<h3>Inputs</h3>", table(("Socket", "Type", "From"), sockets)]
    parts += _parameter_tables(_parameters(story, task))
    return "\n".join(filter(None, parts))


def _marked_up(text: str) -> str:
    """Return a docstring's words as HTML: ``code`` as code."""
    return re.sub(r"``(.+?)``", r"<code>\1</code>", escape(text))


def _facts(story: Story, task: Task) -> str:
    """Return node, why it ran, time, seed and key."""
    report, status = story.report(task.id), story.status(task.id)
    why = {"cached": "its result was in the cache", "waiting": "the run ended before it"}.get(status, "")
    facts = [
        ("Id", f"<code>{escape(task.id)}</code>"),
        ("Node", escape(f"{task.node.name}, version {task.node.version}")),
    ]
    if report and (report.why or why):
        facts.append(("Why it ran" if status in ("ran", "failed") else "Why", escape(report.why or why)))
    elif why:
        facts.append(("Why", why))
    if report and status == "ran":
        facts.append(("Took", duration(report.seconds)))
    if task.entropy is not None:
        facts.append(("Seed", escape(task.seed)))
    if report and report.key:
        facts.append(("Key", f"<code>{escape(report.key)}</code>"))
    return f"<dl>{''.join(f'<div><dt>{name}</dt><dd>{text}</dd></div>' for name, text in facts)}</dl>"


def source_link(story: Story, slot: Slot) -> str:
    """Return where a value comes from, as a link to its task."""
    anchor = story.anchors.get(slot.task)
    if anchor is None:
        kind, value = story.result.plan.given[slot]
        group = story.groups.get(slot.task.split("[")[0])
        text = f"{slot.task.removeprefix('$')}: given, {kind} {shape_of(value)}"
        return f'<a href="#{group.anchor}">{escape(text)}</a>' if group else escape(text)
    several = len(story.result.plan.tasks[slot.task].node.outputs) > 1
    return f'<a href="#{anchor}">{escape(f"{slot.task}.{slot.socket}" if several else slot.task)}</a>'


def _sources(story: Story, source: Slot | tuple[Slot, ...]) -> str:
    if isinstance(source, Slot):
        return source_link(story, source)
    return folded([source_link(story, slot) for slot in source], 6, "items") or '<span class="dim">an empty list</span>'


def _parameter_tables(rows: list[tuple[str, str, str, str]]) -> list[str]:
    """Return the parameters as a table; many that have their defaults are folded away."""
    if not rows:
        return []
    usual = [row for row in rows if row[2] == _DEFAULT]
    shown = [row for row in rows if row not in usual] if len(usual) > _USUAL else rows
    heads = ("Name", "Value", "", "What it is")
    parts = ["<h3>Parameters</h3>", table(heads, shown) if shown else ""]
    if len(usual) > _USUAL:
        inside = table(heads, usual)
        parts.append(f"<details><summary>{len(usual)} have their defaults</summary>{inside}</details>")
    return parts


def _parameters(story: Story, task: Task) -> list[tuple[str, str, str, str]]:
    rows = []
    for name, info in task.node.parameters.model_fields.items():
        doc = escape(info.description or "")
        if name in task.measured:
            value = story.value(task.measured[name])
            shown = "" if isinstance(value, Gap | Missing) else code(_written(value))
            rows.append((escape(name), shown, f"measured by {source_link(story, task.measured[name])}", doc))
            continue
        if name not in task.parameters:
            continue
        value = task.parameters[name]
        default = not info.is_required() and plain(info.get_default(call_default_factory=True)) == value
        rows.append((escape(name), code(_written(value)), _DEFAULT if default else "", doc))
    return rows


def _written(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _output(story: Story, album: Album, slot: Slot, size: int) -> str:
    several = slot.socket not in ("result", "value")
    return _figure_of(story, album, slot, f"<b>{escape(slot.socket)}</b>" if several else "", slot.task, size)


def _figure_of(story: Story, album: Album, slot: Slot, caption: str, name: str, size: int) -> str:
    value = story.value(slot)
    if isinstance(value, Missing):
        status = story.status(slot.task)
        told = escape(value.reason) if status in ("ran", "cached") else chip(status)
        return f'<figure><div class="told dim">{told}</div><figcaption>{caption}</figcaption></figure>\n'
    return album.show(story.kind(slot), value, caption, f"{name}: {slot.socket}", size)
