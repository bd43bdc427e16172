"""Checks a whole graph before anything runs, and tells all that is wrong at once."""

from pathlib import Path

import networkx as nx

from graphtex import links
from graphtex.check.arguments import argument_problems
from graphtex.check.ends import input_problems, output_problems
from graphtex.check.ranges import range_problems
from graphtex.errors import GraphError, Problem
from graphtex.graph import Graph, Place
from graphtex.links import Chain
from graphtex.packs import registry


def check(graph: Graph, chain: Chain = ()) -> list[Problem]:
    """Return all problems of a graph and of the graphs that it includes, in order of place."""
    registry()  # packs register the openers and writers too
    return sorted(set(_problems(graph, chain, set())))


def _problems(graph: Graph, chain: Chain, done: set[Path]) -> list[Problem]:
    problems = input_problems(graph)
    for name, entry in graph.nodes.items():
        path: Place = ("nodes", name)
        if not entry.node and not entry.graph:
            place = next(((*path, key) for key in ("node", "graph") if (*path, key) in graph.places), path)
            problems.append(graph.problem(place, "an entry has a `node` or a `graph`"))
            continue
        try:
            signature = links.entry_signature(graph, path, entry, chain)
        except GraphError as error:
            problems += error.problems
            continue
        if (
            signature.graph is not None and signature.graph.file not in done
        ):  # a file that is used often is checked once
            if signature.graph.file is not None:
                done.add(signature.graph.file)
            problems += _problems(signature.graph, (*chain, graph.file.resolve() if graph.file else graph.base), done)
        problems += argument_problems(graph, path, entry, signature, chain)
        problems += range_problems(graph, path, entry, signature)
    problems += _cycles(graph)
    problems += output_problems(graph, chain)
    if not graph.nodes:
        problems.append(graph.problem(("nodes",), "a graph has at least one node"))
    return problems


def _cycles(graph: Graph) -> list[Problem]:
    flow = nx.DiGraph((source, name) for name in graph.nodes for source in links.sources_of(graph, name))
    problems = []
    for group in nx.strongly_connected_components(flow):
        first = min(group, key=list(graph.nodes).index)
        if len(group) > 1 or flow.has_edge(first, first):
            circle = nx.find_cycle(flow.subgraph(group), first)
            names = " -> ".join([edge[0] for edge in circle] + [circle[-1][1]])
            problems.append(graph.problem(("nodes", first), f"nodes feed each other in a circle: {names}", key=True))
    return problems
