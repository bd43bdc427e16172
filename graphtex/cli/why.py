"""``graphtex why``: what makes a node run."""

from pathlib import Path
from typing import TYPE_CHECKING

from graphtex.cli.run import Set
from graphtex.cli.terminal import DONE, out
from graphtex.errors import GraphError, Problem, did_you_mean, listing

if TYPE_CHECKING:
    from graphtex.cli.forecast import Prospect
    from graphtex.plan import Plan

MOST = 20  # cells of one node that are told of


def why(graph: str, node: str, /, *, set_: Set = None, seed: int | None = None, cache: Path | None = None) -> int:
    """Tell whether a node is cached, and if not, what has changed.

    What has changed is told against the graph's last run.

    Parameters
    ----------
    graph
        A graph file, or the name of a graph that ships with graphtex.
    node
        The node's id in the graph; a cell of an each is cell[2,3], a node of a sub-graph cell[2,3]/warp. The name of an
        input means what opens it.
    set_
        NAME=VALUE: the value of a graph input, as for run.
    seed
        Used in place of the graph's own seed.
    cache
        The folder of the cache, by default the user's own.
    """
    from graphtex.cli.arguments import given_inputs, read_graph
    from graphtex.cli.forecast import cache_of, plan_of, prospects
    from graphtex.shipped import graph_identity

    loaded = read_graph(graph)
    plan = plan_of(loaded, given_inputs(loaded, set_ or ()), seed)
    tasks = tasks_of(plan, node)
    found = prospects(plan, cache_of(cache or True), graph_identity(loaded.file))
    for task in tasks[:MOST]:
        for line in told(task, found[task]):
            out(line)
    if len(tasks) > MOST:
        out(f"and {len(tasks) - MOST} more; name one, such as {tasks[MOST]}")
    return DONE


def tasks_of(plan: "Plan", node: str) -> list[str]:
    """Return the tasks of a node: itself, its cells, or what a sub-graph is made of; GraphError if there are none."""
    for name in (node, f"${node}"):  # what opens an input is $input, which shells take for a variable
        if name in plan.tasks:
            return [name]
    starts = tuple(f"{sign}{node}{mark}" for sign in ("", "$") for mark in "[/")
    found = [task for task in plan.tasks if task.startswith(starts)]
    if not found:
        hint = did_you_mean(node, plan.tasks, label="nodes")
        raise GraphError([Problem("", 0, 0, "", f"the graph has no node {node!r}{hint}")])
    return found


def told(task: str, prospect: "Prospect") -> list[str]:
    """Return the lines that explain a task."""
    changes = [f"  {change}" for change in prospect.changes]
    if prospect.forecast == "cached":
        if not changes:
            return [f"{task}: cached: nothing changed"]
        return [f"{task}: cached, from before the last run; since the last run changed", *changes]
    if prospect.forecast == "runs":
        return (
            [f"{task}: runs; since the last run changed", *changes] if changes else [f"{task}: runs: {prospect.note}"]
        )
    deciders = listing(prospect.decided_by)
    verb = "run and decide" if len(prospect.decided_by) > 1 else "runs and decides"
    head = f"{task}: runs unless its input comes out equal: {deciders} {verb}"
    if changes:
        return [f"{head}; besides, since the last run changed", *changes]
    return [f"{head}{f' ({prospect.note})' if prospect.note else ''}"]
