"""Checks a whole graph before anything runs, and tells all that is wrong at once."""

from collections.abc import Iterator

import networkx as nx

from graphtex.check.arguments import argument_problems
from graphtex.check.ends import input_problems, output_problems
from graphtex.check.ranges import range_problems
from graphtex.document import Document, Place
from graphtex.errors import GraphError, Problem
from graphtex.links import Links
from graphtex.packs import registry


def check(graph: Document) -> list[Problem]:
    """Return all problems of a graph and of the graphs that it includes, in order of place."""
    return check_links(Links(graph))


def check_links(links: Links) -> list[Problem]:
    """Return all problems of a graph, with links that may be used again afterwards."""
    registry()  # packs register the openers and writers too
    problems: set[Problem] = set()
    ahead, done = [links], set[int]()
    while ahead:
        one = ahead.pop()
        if id(one) not in done:  # a file that is used often is checked once
            done.add(id(one))
            problems.update(_problems(one, ahead))
    return sorted(problems)


def _problems(links: Links, ahead: list[Links]) -> Iterator[Problem]:
    """Yield the problems of one graph; add those that it includes to `ahead`."""
    graph = links.graph
    yield from input_problems(graph)
    for name, entry in graph.nodes.items():
        path: Place = ("nodes", name)
        if not entry.node and not entry.graph:
            place = next(((*path, key) for key in ("node", "graph") if (*path, key) in graph.places), path)
            yield graph.problem(place, "an entry has a `node` or a `graph`")
            continue
        try:
            signature = links.signature(name)
        except GraphError as error:
            yield from error.problems
            continue
        if signature.inner is not None:
            ahead.append(signature.inner)
        yield from argument_problems(links, path, entry, signature)
        yield from range_problems(links, path, entry, signature)
    yield from _cycles(links)
    yield from output_problems(links)
    if not graph.nodes:
        yield graph.problem(("nodes",), "a graph has at least one node")


def _cycles(links: Links) -> Iterator[Problem]:
    flow = nx.DiGraph((source, name) for name, sources in links.flow.items() for source in sources)
    order = {name: index for index, name in enumerate(links.graph.nodes)}
    for group in nx.strongly_connected_components(flow):
        first = min(group, key=order.__getitem__)
        if len(group) > 1 or flow.has_edge(first, first):
            circle = nx.find_cycle(flow.subgraph(group), first)
            names = " -> ".join([edge[0] for edge in circle] + [circle[-1][1]])
            text = f"nodes feed each other in a circle: {names}"
            yield links.graph.problem(("nodes", first), text, key=True)
