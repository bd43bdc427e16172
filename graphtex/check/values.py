"""What parameters accept and what graph inputs give, as JSON types; inputs in places where none is read."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from graphtex.document import Document, Input, Place
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.handlers import find_opener
from graphtex.inputs import split_type
from graphtex.json_types import JSON_TYPES, json_types
from graphtex.links import Links, Signature
from graphtex.references import FromInput, is_input, is_scalar, reference
from graphtex.sockets import ValueType

_GIVES = {"int": {"integer"}, "float": {"number"}, "str": {"string"}, "file": {"string"}, "bool": {"boolean"}}


def accepted(signature: Signature, key: str) -> frozenset[str]:
    """Return the JSON types that a parameter of a node or a scalar input of a graph accepts."""
    if signature.model is not None:
        return json_types(signature.model, key)
    assert signature.graph is not None
    given = _given(signature.graph.inputs[key].type)
    return given | {"integer"} if "number" in given else given


def _given(kind: str) -> frozenset[str]:
    inner, many = split_type(kind)
    return frozenset({"array"}) if many else frozenset(_GIVES.get(inner, JSON_TYPES))


def reference_problems(links: Links, path: Place, value: Any, wanted: ValueType) -> list[Problem]:
    """Return what is wrong with a reference that is to give a value of some type."""
    try:
        got = links.type_of(path, reference(links.graph, path, value))
    except GraphError as error:
        hint = _of_a_file(links, value, wanted)
        return [replace(problem, message=f"{problem.message}{hint}") for problem in error.problems]
    if got.base == wanted.base and got.many == wanted.many:
        return []
    hint = "; write a list: [...]" if wanted.many and not got.many and got.base == wanted.base else ""
    if got.many and not wanted.many and isinstance(value, str) and not value.startswith("$"):
        hint = "; to go on with each item, put both nodes into a graph file and let `each` range over that"
    return [links.graph.problem(path, f"expected {wanted}, got {got}{hint}")]


def _of_a_file(links: Links, value: Any, wanted: ValueType) -> str:
    """Return a hint where a file or a sample stands in the place of a reference."""
    if not isinstance(value, str) or value.partition(".")[0] in links.graph.nodes or value.startswith("$"):
        return ""
    try:
        find_opener(wanted.base, value)
    except ValueError:
        return ""
    return "; a file or a sample is the default of a graph input, which is written $name here"


def scalar_input(graph: Document, path: Place, source: FromInput) -> Input:
    """Return the graph input that feeds a parameter; GraphError if there is none or it is no scalar."""
    kind = graph.inputs.get(source.name)
    if kind is None:
        hint = did_you_mean(source.name, graph.inputs, label="inputs")
        raise GraphError([graph.problem(path, f"unknown graph input ${source.name}{hint}")])
    _require_known(kind)
    if not is_scalar(kind):
        told = f"${source.name} is {kind.type}, which flows into sockets and no parameters"
        raise GraphError([graph.problem(path, told)])
    return kind


def scalar_default(graph: Document, path: Place, source: FromInput, signature: Signature, key: str) -> Any:
    """Return the default of the input that feeds a parameter; GraphError if their types do not fit."""
    kind = scalar_input(graph, path, source)
    wanted = accepted(signature, key)
    if not _given(kind.type) & wanted:
        told = f"${source.name} is {kind.type}, {key} takes {' or '.join(sorted(wanted - {'null'}))}"
        raise GraphError([graph.problem(path, told)])
    return kind.default


def item_problem(graph: Document, place: Place, source: FromInput, signature: Signature, key: str) -> list[Problem]:
    """Tell if a list input, ranged over by `each`, does not fit an argument."""
    kind = graph.inputs.get(source.name)
    if kind is None:
        hint = did_you_mean(source.name, graph.inputs, label="inputs")
        return [graph.problem(place, f"unknown graph input ${source.name}{hint}")]
    try:
        inner, many = split_type(kind.type)
    except ValueError:
        return []  # told at the input
    name = f"${source.name} is {kind.type}"
    if not many:
        return [graph.problem(place, f"each ranges over lists; {name}")]
    if key in signature.sockets:
        wanted = f"list[{signature.sockets[key].type}]"
        return [] if kind.type == wanted else [graph.problem(place, f"expected {wanted}; {name}")]
    wanted_types = frozenset({"integer"}) if key == "seed" else accepted(signature, key)
    if not is_scalar(kind) or not _given(inner) & wanted_types:
        shown = " or ".join(sorted(wanted_types - {"null"}))
        return [graph.problem(place, f"{name}, {key} takes {shown}")]
    return []


def _require_known(kind: Input) -> None:
    try:
        split_type(kind.type)
    except ValueError:
        raise GraphError([]) from None  # told at the input


def dollars(value: Any, path: Place) -> Iterator[tuple[Place, str]]:
    """Yield the texts inside of a value that look like graph inputs, which only a whole argument can be."""
    if is_input(value):
        told = f"{value} inside of a value: a graph input can only be a whole argument; a plain dollar is written $$"
        yield path, told
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from dollars(item, (*path, index))
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from dollars(item, (*path, key))
