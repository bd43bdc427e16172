"""Checks the two ends of a graph: its inputs and its outputs."""

import re
from dataclasses import replace
from pathlib import PurePosixPath

from graphtex.document import NAMED_AFTER, REQUIRED, Document, Input, Output, Place
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.handlers import DEFAULT_SUFFIX, find_writer, opening_faults
from graphtex.inputs import check_scalar, default_faults, is_list, split_type
from graphtex.links import Links
from graphtex.parameters import validate
from graphtex.references import is_scalar, reference
from graphtex.sockets import TYPES, ValueType


def input_problems(graph: Document) -> list[Problem]:
    """Return what is wrong with the types, ranges, choices and defaults of a graph's inputs."""
    problems = []
    for name, kind in graph.inputs.items():
        place: Place = ("inputs", name)
        try:
            inner, _ = split_type(kind.type)
        except ValueError as error:
            where = (*place, "type") if (*place, "type") in graph.places or kind.type else place
            problems.append(graph.problem(where, str(error)))
            continue
        problems += _bound_problems(graph, place, kind, inner)
        if kind.min is not None and kind.max is not None and kind.min > kind.max:
            problems.append(graph.problem((*place, "min"), f"min {kind.min:g} is above max {kind.max:g}"))
        elif kind.default is not REQUIRED:
            problems += [graph.problem((*place, "default", *at), text) for at, text in default_faults(kind)]
        problems += _opening_problems(graph, (*place, "open"), kind, inner)
    return problems


def _bound_problems(graph: Document, place: Place, kind: Input, inner: str) -> list[Problem]:
    problems = []
    for key in ("min", "max"):
        if getattr(kind, key) is not None and inner not in ("int", "float", "data"):
            problems.append(graph.problem((*place, key), f"{key} is for numbers, not for {kind.type}", key=True))
    if kind.choices is not None and not is_scalar(kind):
        problems.append(
            graph.problem((*place, "choices"), f"choices are for parameters, not for {kind.type}", key=True)
        )
    elif kind.choices is not None:
        for index, choice in enumerate(kind.choices):
            try:
                check_scalar(replace(kind, type=inner, choices=None), choice)
            except ValueError as error:
                problems.append(graph.problem((*place, "choices", index), str(error)))
    return problems


def _opening_problems(graph: Document, place: Place, kind: Input, inner: str) -> list[Problem]:
    if not kind.open:
        return []
    if inner not in TYPES:
        return [graph.problem(place, f"open is for what a file is opened as, not for {kind.type}", key=True)]
    faults = opening_faults(TYPES[inner], kind.open)
    return [graph.problem((*place, key), text, key=text.startswith("nothing")) for key, text in faults]


def output_problems(links: Links) -> list[Problem]:
    """Return what is wrong with a graph's outputs, their files and formats."""
    graph, problems = links.graph, []
    written: dict[str, str] = {}
    for name, output in graph.outputs.items():
        problems += _output_problems(links, ("outputs", name), output)
        file = output.file if output.file is not None else _default_file(links, name, output)
        first = written.setdefault(str(PurePosixPath(file)), name) if file else name
        if first != name:
            place: Place = ("outputs", name, "file") if output.file is not None else ("outputs", name)
            problems.append(graph.problem(place, f"{file} is written by the output {first} too"))
    return problems


def _default_file(links: Links, name: str, output: Output) -> str:
    """Return the file of an output that names none; nothing if it has none or is wrong in itself."""
    path: Place = ("outputs", name)
    try:
        kind = links.type_of(path, reference(links.graph, path, output.source))
    except GraphError:
        return ""
    suffix = DEFAULT_SUFFIX.get(kind.base.name)
    return f"{name}{suffix}" if suffix else ""


def _output_problems(links: Links, path: Place, output: Output) -> list[Problem]:
    graph = links.graph
    place = (*path, "from") if (*path, "from") in graph.places else path
    problems = []
    if output.file is not None and _leaves_the_folder(output.file):
        told = f"expected a file inside of the output folder, which the run chooses; got {output.file!r}"
        problems.append(graph.problem((*path, "file"), told))
    try:
        kind = links.type_of(place, reference(graph, place, output.source))
    except GraphError as error:
        return [*problems, *error.problems]
    problems += [graph.problem((*path, "file"), text) for text in _naming_faults(graph, output.file or "", kind)]
    suffix = PurePosixPath(output.file).suffix if output.file else DEFAULT_SUFFIX.get(kind.base.name)
    if suffix is None:
        told = f"{kind.base.name} is not written, so it has no option"  # it is handed back all the same
        return problems + [graph.problem((*path, key), f"{told} {key!r}", key=True) for key in output.options]
    try:
        entry = find_writer(kind.base, suffix)
    except ValueError as error:
        return [*problems, graph.problem((*path, "file") if output.file else place, str(error))]
    options, faults = validate(entry.options, output.options)
    if options is not None:
        try:
            entry.require(suffix, options)
        except ValueError as error:
            problems.append(graph.problem((*path, "file") if output.file else place, str(error)))
    for where, text in faults:
        unknown = text.startswith("unknown parameter")
        told = text.replace("parameter", "option") if unknown else text
        problems.append(graph.problem((*path, *where), told, key=unknown))
    return problems


def _naming_faults(graph: Document, file: str, kind: ValueType) -> list[str]:
    """Return what is wrong with ``{input}`` in a file's name."""
    found = NAMED_AFTER.findall(file)
    if not found:
        return []
    lists = [name for name, one in graph.inputs.items() if is_list(one) and not is_scalar(one)]
    if found[0] not in lists:
        hint = did_you_mean(found[0], lists, label="such inputs")
        return [f"{{{found[0]}}} is no list input whose files the output's could be named after{hint}"]
    if not kind.many:
        return [f"{{{found[0]}}} names the items of a list, and this output is one {kind.base.name}"]
    return [f"expected one {{input}} in a file's name, got {len(found)}"] if len(found) > 1 else []


def _leaves_the_folder(file: str) -> bool:
    parts = re.split(r"[/\\]", file)
    return parts[0] == "" or ".." in parts or re.match("[A-Za-z]:", file) is not None or "\0" in file
