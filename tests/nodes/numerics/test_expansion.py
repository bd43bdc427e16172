from itertools import product

import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics.expansion import expand

FIRST, SECOND = np.array([0, 1, 2, 0, 1]), np.array([1, 2, 3, 2, 3])


def potts(weights):
    return lambda one, other: weights * (one != other)


def cost(unary, pairwise, labels):
    return unary[labels, np.arange(len(labels))].sum() + pairwise(labels[FIRST], labels[SECOND]).sum()


@pytest.mark.parametrize("seed", range(8))
def test_two_labels_are_the_optimum(seed):
    """Against all labellings of four nodes."""
    rng = np.random.default_rng(seed)
    unary, pairwise = rng.random((2, 4)), potts(rng.random(5))
    found = expand(unary, FIRST, SECOND, pairwise, np.zeros(4, int), 3, Context())
    best = min(cost(unary, pairwise, np.array(labels)) for labels in product(range(2), repeat=4))
    assert cost(unary, pairwise, found) == pytest.approx(best)


@pytest.mark.parametrize("seed", range(4))
def test_no_expansion_lowers_the_cost(seed):
    rng = np.random.default_rng(seed)
    places, scale = rng.random(5), rng.random(5)
    unary = rng.random((5, 4))

    def pairwise(one, other):
        return scale * abs(places[one] - places[other])

    found = expand(unary, FIRST, SECOND, pairwise, np.argmin(unary, axis=0), 3, Context())
    reached = cost(unary, pairwise, found)
    for label, taken in product(range(5), product([False, True], repeat=4)):
        assert cost(unary, pairwise, np.where(taken, label, found)) >= reached - 1e-6


def test_strong_edges_make_one_label():
    unary = np.array([[0.0, 1, 1, 0], [1, 0, 0, 0.5]])
    assert expand(unary, FIRST, SECOND, potts(np.full(5, 9.0)), np.zeros(4, int), 3, Context()).tolist() == [1, 1, 1, 1]
