"""Labels with the least cost by alpha expansion: each step one minimum cut (Boykov, Veksler & Zabih 2001)."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphtex_nodes.numerics.parallel import Work

Array = NDArray[Any]
Pairwise = Callable[[Array, Array], Array]


def expand(
    unary: Array, first: Array, second: Array, pairwise: Pairwise, labels: Array, sweeps: int, work: Work
) -> Array:
    """Labels (n,) of which no expansion of a single label lowers the cost.

    Parameters
    ----------
    unary
        Cost (k, n) of each label at each node.
    first, second
        Ends (m,) of the edges.
    pairwise
        Cost (m,) of the edges for labels (m,) at their first and (m,) at their second ends: 0 for equal labels, and a
        metric, or else steps are cuts of the nearest costs that are.
    labels
        Where to begin.
    sweeps
        Times that each label is tried, at most.
    """
    import maxflow

    labels = labels.copy()
    nodes = np.arange(labels.size)

    def joins(labels: Array) -> Array:
        return pairwise(labels[first], labels[second]).astype(np.float64)

    def total(labels: Array, both: Array) -> float:
        return float(unary[labels, nodes].sum(dtype=np.float64) + both.sum())

    both = joins(labels)
    best = total(labels, both)
    settled = 0  # labels in a row of which no expansion helped: after all of them none will
    for _ in range(sweeps):
        for label in range(len(unary)):
            if settled == len(unary):
                return labels
            settled += 1
            work.check()
            alpha = np.full(first.size, label)
            one, other = pairwise(labels[first], alpha), pairwise(alpha, labels[second])
            graph = maxflow.GraphFloat(labels.size, first.size)
            graph.add_nodes(labels.size)
            stay, change = unary[labels, nodes].astype(np.float64), unary[label].astype(np.float64)
            # costs 00, 01, 10, 11 with 11 = 0 as terms of the nodes and one of the edge (Kolmogorov & Zabih 2004)
            stay += np.bincount(first, both - other, labels.size)
            stay += np.bincount(second, other, labels.size)
            graph.add_grid_tedges(nodes, change, stay)
            graph.add_edges(first, second, np.maximum(one + other - both, 0), np.zeros(first.size))
            graph.maxflow()
            changed = np.where(graph.get_grid_segments(nodes), label, labels)
            if (changed == labels).all():
                continue
            joined = joins(changed)
            cost = total(changed, joined)
            if cost < best - 1e-9 * abs(best):
                labels, both, best, settled = changed, joined, cost, 0
    return labels
