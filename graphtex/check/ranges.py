"""Checks how an entry is run: `each`, `seed` and `on_error`."""

from typing import Any

from graphtex.check.values import dollars, item_problem, reference_problems, scalar_input
from graphtex.document import REQUIRED, Document, Entry, Place
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.inputs import check_openable, check_seed
from graphtex.links import Links, Signature
from graphtex.parameters import shorten
from graphtex.references import FromInput, is_input
from graphtex.sockets import ValueType


def range_problems(links: Links, path: Place, entry: Entry, signature: Signature) -> list[Problem]:
    """Return what is wrong with an entry's `each`, `seed` and `on_error`."""
    graph = links.graph
    problems = []
    for key, value in entry.each.items():
        problems += _range_problems(links, (*path, "each", key), key, value, entry, signature)
    if entry.on_error not in ("stop", "keep"):
        problems.append(graph.problem((*path, "on_error"), f"stop or keep, got {shorten(entry.on_error)}"))
    elif entry.on_error == "keep" and not entry.each:
        told = "on_error: keep belongs to each:, a single node has no cells"
        problems.append(graph.problem((*path, "on_error"), told))
    return problems + ([] if entry.seed is None else _seed_problems(graph, (*path, "seed"), entry.seed))


def _range_problems(
    links: Links, place: Place, key: str, value: Any, entry: Entry, signature: Signature
) -> list[Problem]:
    graph = links.graph
    known = (*signature.sockets, *signature.parameters, "seed")
    if key not in known:
        hint = did_you_mean(key, known, label="arguments")
        return [graph.problem(place, f"{signature.title} has no argument {key!r}{hint}", key=True)]
    if key in entry.arguments or (key == "seed" and entry.seed is not None):
        return [graph.problem(place, f"{key} is given twice: here and beside each", key=True)]
    if key in signature.sockets and signature.sockets[key].type.many:
        return [graph.problem(place, f"each cannot range over {key}, which takes a list for each cell", key=True)]
    if is_input(value):
        return item_problem(graph, place, FromInput(value[1:]), signature, key)
    if not isinstance(value, list) or not value:
        wanted = "a list with at least one item, or $input; computed values cannot be ranged over"
        return [graph.problem(place, f"expected {wanted}, got {shorten(value)}")]
    if key in signature.sockets:
        return _openable_problems(links, place, value, signature.sockets[key].type)
    if key == "seed":
        return [problem for i, seed in enumerate(value) for problem in _seed_problems(graph, (*place, i), seed)]
    return []  # items of parameters are checked with the other parameters


def _openable_problems(links: Links, place: Place, items: list[Any], kind: ValueType) -> list[Problem]:
    graph, problems = links.graph, []
    for index, item in enumerate(items):
        if is_input(item):
            problems += reference_problems(links, (*place, index), item, kind)
            continue
        inside = list(dollars(item, (*place, index)))
        if inside:
            problems += [graph.problem(*fault) for fault in inside]
            continue
        try:
            check_openable(kind, item)
        except ValueError as error:
            computed = isinstance(item, str) and item.split(".")[0] in graph.nodes
            hint = "; computed values cannot be ranged over" if computed else ""
            problems.append(graph.problem((*place, index), f"{error}{hint}"))
    return problems


def _seed_problems(graph: Document, place: Place, seed: Any) -> list[Problem]:
    if is_input(seed):
        try:
            kind = scalar_input(graph, place, FromInput(seed[1:]))
        except GraphError as error:
            return list(error.problems)
        if kind.default is REQUIRED:
            return (
                [] if kind.type in ("int", "data") else [graph.problem(place, f"{seed} is {kind.type}, a seed is int")]
            )
        seed = kind.default
    try:
        check_seed(seed)
    except ValueError as error:
        return [graph.problem(place, str(error))]
    return []
