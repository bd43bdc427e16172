"""Turns a graph and the values of its inputs into a `Plan`: checks both, then expands."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from graphtex.check import check_links
from graphtex.document import NAMED_AFTER, REQUIRED, Document
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.expand import Expander, Scope
from graphtex.inputs import check_seed
from graphtex.links import Links
from graphtex.plan import Plan, PlannedOutput, Task
from graphtex.values import Bound, Scalar, Values


def bind(
    graph: Document, inputs: Mapping[str, Any] | None = None, *, seed: int | None = None, base: Path | None = None
) -> Plan:
    """Check a graph, bind its inputs and expand it.

    Parameters
    ----------
    inputs
        Arrays, numbers, paths or ``scheme:name`` strings by input name; missing ones take their defaults.
    seed
        Replaces the graph's seed.
    base
        Where relative paths in `inputs` start; without it the current folder.

    Raises
    ------
    GraphError
        With all problems of the graph, then with all problems of the inputs.
    """
    links = Links(graph)
    problems = check_links(links)
    if problems:
        raise GraphError(problems)
    seed, problems = _seed(graph, seed)
    values = Values(seed)
    bound, wrong = bind_inputs(graph, values, inputs or {}, base or Path.cwd())
    if problems + wrong:
        raise GraphError(problems + wrong)
    expander = Expander(values)
    outputs = expander.expand(Scope(links, "", bound, seed))
    problems = expander.problems
    outputs = {name: _named(output, values, graph, problems) for name, output in outputs.items()}
    if problems:
        raise GraphError(problems)
    return Plan(graph, _spared(values, outputs), values.given, outputs)


def _named(output: PlannedOutput, values: Values, graph: Document, problems: list[Problem]) -> PlannedOutput:
    """Return an output with the names of its items, if its file asks for them; add what is wrong with them."""
    found = NAMED_AFTER.search(output.file or "")
    if found is None:
        return output
    names = values.names[f"${found[1]}"]
    path = ("outputs", output.name, "file")
    twice = [name for name, count in Counter(names).items() if count > 1]
    if len(names) != len(output.slots):
        text = f"{found[0]} has {len(names)} names, and the output {len(output.slots)} items"
        problems.append(graph.problem(path, text))
    elif twice:
        problems.append(graph.problem(path, f"two files of {found[0]} would be written as {twice[0]!r}"))
    return replace(output, file=NAMED_AFTER.sub("{}", output.file or "", count=1), names=names)


def _spared(values: Values, outputs: Mapping[str, PlannedOutput]) -> dict[str, Task]:
    """Return the tasks; what opens a file for nothing but cells that may fail may fail itself, at the cost of those."""
    needed = {slot.task for task in values.tasks.values() if not task.cell for slot in task.slots}
    needed.update(slot.task for output in outputs.values() for slot in output.slots)
    spared = values.openers() - needed
    return {key: replace(task, cell=key) if key in spared else task for key, task in values.tasks.items()}


def _seed(graph: Document, seed: int | None) -> tuple[int, list[Problem]]:
    if seed is None:
        return graph.seed, []
    try:
        return check_seed(seed), []
    except ValueError as error:
        return 0, [Problem("", 0, 0, "seed", str(error))]


def bind_inputs(
    graph: Document, values: Values, inputs: Mapping[str, Any], base: Path
) -> tuple[dict[str, Bound | Scalar], list[Problem]]:
    """Return what each input of the outermost graph is bound to, and all that is wrong with what was given."""
    problems = [
        Problem("", 0, 0, name, f"the graph has no input {name!r}{did_you_mean(name, graph.inputs, label='inputs')}")
        for name in inputs
        if name not in graph.inputs
    ]
    bound: dict[str, Bound | Scalar] = {}
    for name, kind in graph.inputs.items():
        given = name in inputs
        value = inputs[name] if given else kind.default
        if value is REQUIRED:
            text = f"{name} has no default: a value of type {kind.type} is required"
            problems.append(graph.problem(("inputs", name), text))
            continue
        try:
            bound[name] = values.bind(f"${name}", kind, value, base if given else graph.base)
        except ValueError as error:
            text = str(error)
            at_default = graph.problem(("inputs", name, "default"), text)
            if given and kind.description:  # what the graph's author says of it may tell what to give instead
                text = f"{text} ({kind.description})"
            problems.append(Problem("", 0, 0, name, text) if given else at_default)
    return bound, problems
