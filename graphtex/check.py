"""Checks a whole graph before anything runs, and tells all that is wrong at once."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import networkx as nx

from graphtex import links
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.graph import REQUIRED, Entry, Graph, Output, Place
from graphtex.handlers import DEFAULT_SUFFIX, find_writer
from graphtex.inputs import check_default, check_openable, check_scalar, split_type
from graphtex.links import Chain, FromInput, Literal, Measured, Signature
from graphtex.packs import registry
from graphtex.parameters import shorten, validate
from graphtex.sockets import ValueType


def check(graph: Graph, chain: Chain = ()) -> list[Problem]:
    """Return all problems of a graph and of the graphs that it includes, in order of place."""
    registry()  # packs register the openers and writers too
    problems = _check_inputs(graph)
    for name, entry in graph.nodes.items():
        problems += _check_entry(graph, name, entry, chain)
    problems += _check_cycles(graph)
    for name, output in graph.outputs.items():
        problems += _check_output(graph, ("outputs", name), output, chain)
    if not graph.nodes:
        problems.append(graph.problem(("nodes",), "a graph has at least one node"))
    return sorted(set(problems))


def _check_inputs(graph: Graph) -> list[Problem]:
    problems = []
    for name, kind in graph.inputs.items():
        place: Place = ("inputs", name)
        try:
            split_type(kind.type)
        except ValueError as error:
            problems.append(graph.problem((*place, "type"), str(error)))
            continue
        if kind.min is not None and kind.max is not None and kind.min > kind.max:
            problems.append(graph.problem((*place, "min"), f"min {kind.min:g} is above max {kind.max:g}"))
        elif kind.default is not REQUIRED:
            try:
                check_default(kind)
            except ValueError as error:
                problems.append(graph.problem((*place, "default"), str(error)))
    return problems


def _check_entry(graph: Graph, name: str, entry: Entry, chain: Chain) -> list[Problem]:
    path: Place = ("nodes", name)
    try:
        signature = links.entry_signature(graph, path, entry, chain)
    except GraphError as error:
        return list(error.problems)
    problems: list[Problem] = []
    if signature.graph is not None:
        problems += check(signature.graph, (*chain, graph.file.resolve() if graph.file else graph.base))
    problems += _check_each(graph, path, entry, signature)
    known = (*signature.sockets, *signature.parameters)
    for key in entry.arguments:
        if key not in known:
            hint = did_you_mean(key, known, label="arguments")
            problems.append(graph.problem((*path, key), f"{signature.title} has no argument {key!r}{hint}", key=True))
    for key, socket in signature.sockets.items():
        if key in entry.arguments:
            problems += _check_socket(graph, (*path, key), entry.arguments[key], socket, chain)
        elif not socket.optional and key not in entry.each:
            problems.append(graph.problem(path, f"{signature.title} needs {key}: a reference to {socket.type}"))
    return problems + _check_parameters(graph, path, entry, signature, chain)


def _check_socket(graph: Graph, path: Place, value: Any, socket: Any, chain: Chain) -> list[Problem]:
    wanted: ValueType = socket.type
    try:
        source = links.socket_argument(graph, path, value)
        if not isinstance(source, tuple):
            return _check_types(graph, path, links.reference_type(graph, path, source, chain), wanted)
        if not wanted.many:
            return [graph.problem(path, f"expected one {wanted}, got a list of {len(source)}")]
    except GraphError as error:
        return list(error.problems)
    problems, single = [], ValueType(wanted.base)
    for index, item in enumerate(source):
        try:
            problems += _check_types(
                graph, (*path, index), links.reference_type(graph, (*path, index), item, chain), single
            )
        except GraphError as error:
            problems += error.problems
    return problems


def _check_types(graph: Graph, path: Place, got: ValueType, wanted: ValueType) -> list[Problem]:
    if got.base != wanted.base or got.many != wanted.many:
        hint = "; write a list: [...]" if wanted.many and not got.many and got.base == wanted.base else ""
        return [graph.problem(path, f"expected {wanted}, got {got}{hint}")]
    return []


def _check_parameters(graph: Graph, path: Place, entry: Entry, signature: Signature, chain: Chain) -> list[Problem]:
    problems: list[Problem] = []
    values: dict[str, Any] = {}
    later = {key for key in entry.each if key in signature.parameters}
    for key in signature.parameters:
        if key not in entry.arguments:
            continue
        try:
            found = links.parameter_argument(graph, (*path, key), entry.arguments[key])
            if isinstance(found, Literal):
                values[key] = found.value
            elif isinstance(found, Measured):
                later.add(key)
                got = links.reference_type(graph, (*path, key), found.source, chain)
                if got.base.name != "Number" or got.many:
                    problems.append(graph.problem((*path, key), f"a parameter is fed by a Number, got {got}"))
            elif (default := _scalar_default(graph, (*path, key), found)) is not REQUIRED:
                values[key] = default
            else:
                later.add(key)
        except GraphError as error:
            later.add(key)
            problems += error.problems
    if signature.model is not None:
        faults = validate(signature.model, values, unknown=later)[1]
        problems += [
            graph.problem((*path, *where) if where[0] in entry.arguments else path, _explain(graph, entry, where, text))
            for where, text in faults
        ]
        for key, items in _literal_ranges(entry).items():
            if key in signature.parameters:
                problems += _check_range(graph, (*path, "each", key), signature, key, items, values, later)
    elif signature.graph is not None:
        problems += _check_graph_parameters(graph, path, signature.graph, values, later, entry)
    return problems


def _explain(graph: Graph, entry: Entry, where: tuple[str | int, ...], text: str) -> str:
    got = entry.arguments.get(str(where[0]))
    if text == "a value is required":
        return f"{where[0]}: {text}"
    if isinstance(got, str) and got.startswith("$"):
        return f"the default of {got} does not fit: {text}"
    if isinstance(got, str) and got.split(".")[0] in graph.nodes:
        return f"{text}; a measured number is written {{from: {got}}}"
    return text


def _check_graph_parameters(
    graph: Graph, path: Place, inner: Graph, values: Mapping[str, Any], later: set[str], entry: Entry
) -> list[Problem]:
    problems = []
    for key, value in values.items():
        try:
            check_scalar(inner.inputs[key], value)
        except ValueError as error:
            problems.append(graph.problem((*path, key), str(error)))
    for key, kind in inner.inputs.items():
        if links.is_scalar(kind) and kind.default is REQUIRED and key not in values and key not in later:
            problems.append(graph.problem(path, f"{key}: a value is required"))
    return problems


def _scalar_default(graph: Graph, path: Place, source: FromInput) -> Any:
    kind = graph.inputs.get(source.name)
    if kind is None:
        hint = did_you_mean(source.name, graph.inputs, label="inputs")
        raise GraphError([graph.problem(path, f"unknown graph input ${source.name}{hint}")])
    if not links.is_scalar(kind):
        raise GraphError(
            [graph.problem(path, f"${source.name} is {kind.type}, which flows into sockets and no parameters")]
        )
    return kind.default


def _literal_ranges(entry: Entry) -> dict[str, list[Any]]:
    return {key: value for key, value in entry.each.items() if isinstance(value, list)}


def _check_range(
    graph: Graph,
    path: Place,
    signature: Signature,
    key: str,
    items: list[Any],
    values: Mapping[str, Any],
    later: set[str],
) -> list[Problem]:
    assert signature.model is not None
    problems = []
    for index, item in enumerate(items):
        faults = validate(signature.model, {**values, key: links.unescaped(item)}, unknown=later)[1]
        problems += [graph.problem((*path, index), text) for where, text in faults if where[0] == key]
    return problems


def _check_each(graph: Graph, path: Place, entry: Entry, signature: Signature) -> list[Problem]:
    problems = []
    known = (*signature.sockets, *signature.parameters, "seed")
    for key, value in entry.each.items():
        place = (*path, "each", key)
        if key not in known:
            hint = did_you_mean(key, known, label="arguments")
            problems.append(graph.problem(place, f"{signature.title} has no argument {key!r}{hint}", key=True))
        elif key in entry.arguments or (key == "seed" and entry.seed is not None):
            problems.append(graph.problem(place, f"{key} is given twice: here and beside each", key=True))
        elif isinstance(value, str) and value.startswith("$") and not value.startswith("$$"):
            kind = graph.inputs.get(value[1:])
            if kind is None:
                hint = did_you_mean(value[1:], graph.inputs, label="inputs")
                problems.append(graph.problem(place, f"unknown graph input {value}{hint}"))
            elif not kind.type.startswith("list["):
                problems.append(graph.problem(place, f"each ranges over lists; {value} is {kind.type}"))
            elif (key in signature.sockets) == links.is_scalar(kind):
                problems.append(graph.problem(place, f"{value} is {kind.type}, which does not fit {key}"))
            elif key in signature.sockets and kind.type != f"list[{signature.sockets[key].type}]":
                problems.append(graph.problem(place, f"expected list[{signature.sockets[key].type}], got {kind.type}"))
        elif not isinstance(value, list) or not value:
            wanted = "a list with at least one item, or $input; computed values cannot be ranged over"
            problems.append(graph.problem(place, f"expected {wanted}, got {shorten(value)}"))
        elif key in signature.sockets:
            problems += _check_openables(graph, place, value, signature.sockets[key].type)
        elif key == "seed":
            problems += [_seed_problem(graph, (*place, i), s) for i, s in enumerate(value) if not _is_seed(s)]
    if entry.on_error == "keep" and not entry.each:
        problems.append(
            graph.problem((*path, "on_error"), "on_error: keep belongs to each:, a single node has no cells")
        )
    if entry.seed is not None and not _is_seed(entry.seed) and not str(entry.seed).startswith("$"):
        problems.append(_seed_problem(graph, (*path, "seed"), entry.seed))
    elif isinstance(entry.seed, str):
        try:
            default = _scalar_default(graph, (*path, "seed"), FromInput(entry.seed[1:]))
            if default is not REQUIRED and not _is_seed(default):
                problems.append(_seed_problem(graph, (*path, "seed"), default))
        except GraphError as error:
            problems += error.problems
    return problems


def _check_openables(graph: Graph, place: Place, items: list[Any], kind: ValueType) -> list[Problem]:
    problems = []
    for index, item in enumerate(items):
        try:
            check_openable(kind, item)
        except ValueError as error:
            hint = "; computed values cannot be ranged over" if str(item).split(".")[0] in graph.nodes else ""
            problems.append(graph.problem((*place, index), f"{error}{hint}"))
    return problems


def _is_seed(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _seed_problem(graph: Graph, path: Place, value: Any) -> Problem:
    return graph.problem(path, f"a seed is a whole number from 0, got {shorten(value)}")


def _check_cycles(graph: Graph) -> list[Problem]:
    flow = nx.DiGraph((source, name) for name in graph.nodes for source in links.sources_of(graph, name))
    problems = []
    for group in nx.strongly_connected_components(flow):
        first = min(group, key=list(graph.nodes).index)
        if len(group) > 1 or flow.has_edge(first, first):
            circle = nx.find_cycle(flow.subgraph(group), first)
            names = " -> ".join([edge[0] for edge in circle] + [circle[-1][1]])
            problems.append(graph.problem(("nodes", first), f"nodes feed each other in a circle: {names}", key=True))
    return problems


def _check_output(graph: Graph, path: Place, output: Output, chain: Chain) -> list[Problem]:
    try:
        kind = links.reference_type(graph, path, links.reference(graph, path, output.source), chain)
    except GraphError as error:
        return list(error.problems)
    suffix = Path(output.file).suffix if output.file else DEFAULT_SUFFIX.get(kind.base.name)
    if suffix is None:
        return []  # a type that is handed back but never written
    try:
        entry = find_writer(kind.base, suffix)
    except ValueError as error:
        return [graph.problem((*path, "file") if output.file else path, str(error))]
    faults = validate(entry.options, output.options)[1]
    return [
        graph.problem((*path, *where), text.replace("unknown parameter", "unknown option")) for where, text in faults
    ]
