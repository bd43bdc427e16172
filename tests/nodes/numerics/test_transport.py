"""Prices against transport worked out by hand, and against how often places are chosen without them."""

import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics.transport import MOST_PAIRS, ROUNDS, SOFTNESS, STEEPEST, market, prices


def chosen(windows, places, price):
    """How often each place is the cheapest."""
    cost = ((windows[:, None] - places[None]) ** 2).sum(axis=2) + price
    return np.bincount(cost.argmin(axis=1), minlength=len(places))


@pytest.mark.parametrize(("share", "border"), [([1, 1], 0.5), ([1, 3], 0.25)])
def test_two_places_on_a_line_share_it_at_the_wanted_point(share, border):
    """(x + 1)^2 + p = (x - 2)^2 + q at the border x: q - p = 6 x - 3."""
    windows = ((np.arange(1000) + 0.5) / 1000).astype(np.float32)[:, None]
    places = np.float32([[-1], [2]])
    price = prices(windows, market(places, np.float32(share)), 1000.0, Context())
    assert price[1] - price[0] == pytest.approx(6 * border - 3, abs=0.3)  # the border to 0.05


def test_places_far_from_all_windows_are_chosen_as_often_as_others():
    """Without prices the crowd in the middle takes nearly everything."""
    rng = np.random.default_rng(0)
    windows = rng.normal(size=(2000, 6)).astype(np.float32)
    places = 2 * rng.normal(size=(50, 6)).astype(np.float32)
    assert chosen(windows, places, 0).std() > 40
    assert (
        chosen(windows, places, prices(windows, market(places, np.ones(50, np.float32)), 1000.0, Context())).std() < 12
    )


def test_less_firmness_leaves_more_of_the_difference():
    """The largest use falls from that without prices towards the mean."""
    rng = np.random.default_rng(1)
    windows, places = (rng.normal(size=(n, 4)).astype(np.float32) for n in (1500, 30))
    share = np.ones(30, np.float32)
    most = [
        chosen(windows, places, prices(windows, market(places, share), firm, Context())).max()
        for firm in (0.0, 0.02, 0.2, 1000.0)
    ]
    assert most == sorted(most, reverse=True)
    assert most[-1] < 0.6 * most[0]


def test_places_of_a_group_share_a_price():
    """Windows at 0 and 2 need one place of each pair: as pairs they are used evenly, and no price is needed."""
    windows, places = np.float32([[0], [2]] * 5), np.float32([[0], [1], [2], [3]])
    share = np.ones(4, np.float32)
    apart, together = (
        prices(windows, market(places, share, groups), 10.0, Context()) for groups in (None, np.array([0, 0, 1, 1]))
    )
    assert np.ptp(apart) > 0.5
    assert np.ptp(together) < 0.05


def test_part_of_many_windows_tells_the_prices():
    """Beyond a number of pairs a regular part of the windows is asked; prices stay about the same."""
    rng = np.random.default_rng(2)
    windows, places = (rng.normal(size=(n, 3)).astype(np.float32) for n in (40000, 20))
    share = np.ones(20, np.float32)
    assert len(windows) * len(places) > 2 * MOST_PAIRS
    found, of_part = (prices(part, market(places, share), 1.0, Context()) for part in (windows, windows[1::3]))
    assert np.allclose(found, of_part, atol=0.3)


@pytest.mark.parametrize("scale", [0, 1e-20, 1e15])
def test_equal_and_extreme_places_have_finite_prices(scale):
    """A constant exemplar costs nothing; sizes that differ by any factor give numbers."""
    windows = np.linspace(0, 1, 30, dtype=np.float32).reshape(10, 3)
    price = prices(windows, market(scale * windows[::2], np.ones(5, np.float32)), 2.0, Context())
    assert np.isfinite(price).all()
    assert price.min() == 0
    assert scale > 0 or price.max() == 0


def test_prices_against_the_iteration_written_out():
    """Distances, attraction and the fixed point in double precision, for groups of unlike sizes and wishes."""
    rng = np.random.default_rng(3)
    windows, places = (rng.normal(size=(n, 7)).astype(np.float32) for n in (41, 13))
    share, groups = rng.random(13).astype(np.float32) + 0.5, np.arange(13) % 5
    variance = places.var(axis=0, dtype=np.float64).sum()
    costs = ((windows[:, None].astype(np.float64) - places) ** 2).sum(axis=2) / (SOFTNESS * variance)
    one_of = (groups == np.arange(5)[:, None]).astype(np.float64)
    pull = np.exp(-np.minimum(costs - costs.min(axis=1, keepdims=True), STEEPEST)) @ one_of.T
    wanted, appeal = one_of @ share / share.sum(), np.ones(5)
    for _ in range(ROUNDS):
        appeal = (wanted / (pull / (pull @ appeal)[:, None]).mean(axis=0)) ** (2.0 / (2.0 + SOFTNESS))
    expected = -SOFTNESS * variance * np.log(appeal)[groups]
    found = [prices(windows, market(places, share, groups), 2.0, Context(threads=threads)) for threads in (1, 2)]
    np.testing.assert_allclose(found[0], expected - expected.min(), rtol=1e-4, atol=1e-5)
    np.testing.assert_array_equal(*found)
