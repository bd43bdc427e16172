"""Checks the arguments of one entry: what flows into its sockets, and its parameters."""

from collections.abc import Mapping
from typing import Any

from graphtex.check.values import accepted, dollars, reference_problems, scalar_default
from graphtex.document import REQUIRED, Document, Entry, Place
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.inputs import check_scalar
from graphtex.links import Links, Signature
from graphtex.parameters import validate
from graphtex.references import FromInput, Literal, Measured, is_input, is_scalar, parameter_argument
from graphtex.sockets import ValueType


def argument_problems(links: Links, path: Place, entry: Entry, signature: Signature) -> list[Problem]:
    """Return what is wrong with an entry's arguments."""
    graph = links.graph
    problems: list[Problem] = []
    known = (*signature.sockets, *signature.parameters)
    for key in entry.arguments:
        if key not in known:
            hint = did_you_mean(key, known, label="arguments")
            problems.append(graph.problem((*path, key), f"{signature.title} has no argument {key!r}{hint}", key=True))
    for key, socket in signature.sockets.items():
        if key in entry.arguments:
            problems += _socket_problems(links, (*path, key), entry.arguments[key], socket.type)
        elif not socket.optional and key not in entry.each:
            problems.append(graph.problem(path, f"{signature.title} needs {key}: a reference to {socket.type}"))
    return problems + _parameter_problems(links, path, entry, signature)


def _socket_problems(links: Links, path: Place, value: Any, wanted: ValueType) -> list[Problem]:
    if not isinstance(value, list):
        return reference_problems(links, path, value, wanted)
    if not wanted.many:
        return [links.graph.problem(path, f"expected one {wanted}, got a list of {len(value)}")]
    single = ValueType(wanted.base)
    return [p for i, item in enumerate(value) for p in reference_problems(links, (*path, i), item, single)]


def _parameter_problems(links: Links, path: Place, entry: Entry, signature: Signature) -> list[Problem]:
    graph = links.graph
    problems: list[Problem] = []
    values: dict[str, Any] = {}
    later = {key for key in entry.each if key in signature.parameters}
    for key in signature.parameters:
        if key not in entry.arguments or key in later:  # given twice is told with `each`
            continue
        place = (*path, key)
        try:
            found = parameter_argument(graph, place, entry.arguments[key])
            if isinstance(found, Literal):
                values[key] = found.value
                problems += [graph.problem(*fault) for fault in dollars(entry.arguments[key], place)]
            elif isinstance(found, Measured):
                later.add(key)
                problems += _measured_problems(links, place, found, signature)
            elif (default := scalar_default(graph, place, found, signature, key)) is not REQUIRED:
                values[key] = default
            else:
                later.add(key)
        except GraphError as error:
            later.add(key)
            problems += error.problems
    if signature.model is not None:
        for where, text in validate(signature.model, values, unknown=later)[1]:
            place = (*path, *where) if where[0] in entry.arguments else path
            unknown = text.startswith("unknown parameter")
            problems.append(graph.problem(place, _explained(graph, entry, where, text), key=unknown))
    elif signature.graph is not None:
        problems += _subgraph_problems(graph, path, signature.graph, values, later)
    return problems + _item_problems(graph, path, entry, signature, values, later)


def _measured_problems(links: Links, place: Place, found: Measured, signature: Signature) -> list[Problem]:
    graph, key = links.graph, place[-1]
    if "number" not in (wanted := accepted(signature, str(key))) and "integer" not in wanted:
        return [graph.problem(place, f"{key} takes no number, so none that is measured")]
    got = links.type_of(place, found.source)
    if got.base.name == "Number" and not got.many:
        return []
    return [graph.problem(place, f"a parameter is fed by a Number, got {got}")]


def _explained(graph: Document, entry: Entry, where: tuple[str | int, ...], text: str) -> str:
    got = entry.arguments.get(str(where[0]))
    if text == "a value is required":
        return f"{where[-1]}: {text}"
    if is_input(got):
        return f"the default of {got} does not fit: {text}"
    if isinstance(got, str) and got.split(".")[0] in graph.nodes:
        return f"{text}; a measured number is written {{from: {got}}}"
    return text


def _subgraph_problems(
    graph: Document, path: Place, inner: Document, values: Mapping[str, Any], later: set[str]
) -> list[Problem]:
    problems = []
    for key, value in values.items():
        try:
            check_scalar(inner.inputs[key], value)
        except ValueError as error:
            problems.append(graph.problem((*path, key), str(error)))
    for key, kind in inner.inputs.items():
        if is_scalar(kind) and kind.default is REQUIRED and key not in values and key not in later:
            problems.append(graph.problem(path, f"{key}: a value is required"))
    return problems


def _item_problems(
    graph: Document, path: Place, entry: Entry, signature: Signature, values: Mapping[str, Any], later: set[str]
) -> list[Problem]:
    """Check each item of a literal list that `each` ranges over as the argument that it becomes."""
    problems = []
    for key, items in entry.each.items():
        if key not in signature.parameters or not isinstance(items, list):
            continue
        for index, item in enumerate(items):
            place = (*path, "each", key, index)
            try:
                found = parameter_argument(graph, place, item)
                if isinstance(found, Measured):
                    problems.append(graph.problem(place, "computed values cannot be ranged over"))
                    continue
                value = (
                    scalar_default(graph, place, found, signature, key) if isinstance(found, FromInput) else found.value
                )
            except GraphError as error:
                problems += error.problems
                continue
            inside = [] if is_input(item) else list(dollars(item, place))
            problems += [graph.problem(*fault) for fault in inside]
            if inside or value is REQUIRED:
                continue
            if signature.model is not None:
                faults = validate(signature.model, {**values, key: value}, unknown=later - {key})[1]
                problems += [graph.problem((*place, *where[1:]), text) for where, text in faults if where[0] == key]
            elif signature.graph is not None:
                try:
                    check_scalar(signature.graph.inputs[key], value)
                except ValueError as error:
                    problems.append(graph.problem(place, str(error)))
    return problems
