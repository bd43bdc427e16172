"""Checks how an entry is run: `each`, `seed` and `on_error`."""

from typing import Any

from graphtex.check.values import dollars, item_problem, scalar_input
from graphtex.errors import GraphError, Problem, did_you_mean
from graphtex.graph import REQUIRED, Entry, Graph, Place
from graphtex.inputs import check_openable
from graphtex.links import FromInput, Signature
from graphtex.parameters import shorten
from graphtex.sockets import ValueType


def range_problems(graph: Graph, path: Place, entry: Entry, signature: Signature) -> list[Problem]:
    """Return what is wrong with an entry's `each`, `seed` and `on_error`."""
    problems = []
    for key, value in entry.each.items():
        problems += _range_problems(graph, (*path, "each", key), key, value, entry, signature)
    if entry.on_error == "keep" and not entry.each:
        told = "on_error: keep belongs to each:, a single node has no cells"
        problems.append(graph.problem((*path, "on_error"), told))
    return problems + _seed_problems(graph, (*path, "seed"), entry.seed)


def _range_problems(
    graph: Graph, place: Place, key: str, value: Any, entry: Entry, signature: Signature
) -> list[Problem]:
    known = (*signature.sockets, *signature.parameters, "seed")
    if key not in known:
        hint = did_you_mean(key, known, label="arguments")
        return [graph.problem(place, f"{signature.title} has no argument {key!r}{hint}", key=True)]
    if key in entry.arguments or (key == "seed" and entry.seed is not None):
        return [graph.problem(place, f"{key} is given twice: here and beside each", key=True)]
    if isinstance(value, str) and value.startswith("$") and not value.startswith("$$"):
        return item_problem(graph, place, FromInput(value[1:]), signature, key)
    if not isinstance(value, list) or not value:
        wanted = "a list with at least one item, or $input; computed values cannot be ranged over"
        return [graph.problem(place, f"expected {wanted}, got {shorten(value)}")]
    if key in signature.sockets:
        return _openable_problems(graph, place, value, signature.sockets[key].type)
    if key == "seed":
        return [_seed_problem(graph, (*place, i), seed) for i, seed in enumerate(value) if not _is_seed(seed)]
    return []  # items of parameters are checked with the other parameters


def _openable_problems(graph: Graph, place: Place, items: list[Any], kind: ValueType) -> list[Problem]:
    problems = []
    for index, item in enumerate(items):
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


def _seed_problems(graph: Graph, place: Place, seed: Any) -> list[Problem]:
    if isinstance(seed, str) and seed.startswith("$"):
        try:
            kind = scalar_input(graph, place, FromInput(seed[1:]))
        except GraphError as error:
            return list(error.problems)
        if kind.default is REQUIRED:
            return (
                [] if kind.type in ("int", "data") else [graph.problem(place, f"{seed} is {kind.type}, a seed is int")]
            )
        seed = kind.default
    return [] if seed is None or _is_seed(seed) else [_seed_problem(graph, place, seed)]


def _is_seed(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _seed_problem(graph: Graph, path: Place, value: Any) -> Problem:
    return graph.problem(path, f"a seed is a whole number from 0, got {shorten(value)}")
