import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics import search
from graphtex_nodes.numerics.search import Charge, search_exact, search_warm

RNG = np.random.default_rng(5)
WINDOWS = RNG.random((9, 7, 4)).astype(np.float32)
EXEMPLAR = RNG.random((11, 13, 4)).astype(np.float32)


def random_charge(tiles, cell, most):
    cells = (-(-11 // cell), -(-13 // cell))
    own, shared = (most * RNG.random(shape) for shape in ((11, 13), (*tiles, *cells)))
    return Charge(own.astype(np.float32), shared.astype(np.float32), cell)


def charges(charge):
    """What each exemplar window costs each window besides (9, 7, 11, 13)."""
    shared = charge.shared.repeat(charge.cell, 2).repeat(charge.cell, 3)[..., :11, :13]
    rows, columns = np.arange(9) * shared.shape[0] // 9, np.arange(7) * shared.shape[1] // 7
    return charge.own + shared[rows[:, None], columns]


def all_costs(charge):
    return ((WINDOWS[:, :, None, None] - EXEMPLAR) ** 2).sum(-1) + charges(charge)


def cost(charge, field, distances):
    rows, columns = np.indices((9, 7))
    return distances + charges(charge)[rows, columns, field[..., 0], field[..., 1]]


@pytest.mark.parametrize(("tiles", "cell"), [((1, 1), 1), ((3, 7), 2), ((4, 2), 5)])
def test_exact_against_all_distances(tiles, cell):
    charge = random_charge(tiles, cell, 0.3)
    field, distances = search_exact(WINDOWS, EXEMPLAR, charge, Context())
    expected = all_costs(charge).reshape(9, 7, -1)
    np.testing.assert_array_equal(field[..., 0] * 13 + field[..., 1], expected.argmin(-1))
    np.testing.assert_allclose(cost(charge, field, distances), expected.min(-1), rtol=1e-5)


@pytest.mark.parametrize("warm", [False, True])
def test_infinite_charge_is_never_chosen(warm):
    charge = Charge(np.full((11, 13), np.inf, np.float32))
    charge.own[4:6, 3] = 0
    field, _ = search_exact(WINDOWS, EXEMPLAR, charge, Context())
    if warm:
        field, _ = search_warm(WINDOWS, EXEMPLAR, charge, field, step=1, seed=1, passes=3, work=Context())
    assert set(map(tuple, field.reshape(-1, 2).tolist())) <= {(4, 3), (5, 3)}


def test_a_part_of_many_windows_is_never_empty(monkeypatch):
    """However few may be used, and however few of all could be seen in time."""
    monkeypatch.setattr(search, "LIST_LIMIT", 10)
    charge = Charge(np.full((11, 13), np.inf, np.float32))
    charge.own[4, 3] = 0
    field, distances = search_exact(WINDOWS, EXEMPLAR, charge, Context())
    assert (field == [4, 3]).all()
    assert np.isfinite(distances).all()


def test_warm_passes_never_get_worse_and_near_the_best():
    charge = random_charge((2, 3), 3, 0.05)
    field = np.zeros((9, 7, 2), np.int32)
    before = all_costs(charge)[..., 0, 0]
    for seed in range(60):
        field, distances = search_warm(WINDOWS, EXEMPLAR, charge, field, step=2, seed=seed, passes=2, work=Context())
        costs = cost(charge, field, distances)
        assert (costs <= before + 1e-6).all()
        before = costs
    best = all_costs(charge).min(axis=(2, 3))
    assert np.mean(costs <= best + 1e-6) > 0.7


def test_good_source_spreads_to_neighbours():
    """A copy of a piece of the exemplar with one right source: passes without luck still find the rest."""
    exemplar = RNG.random((40, 40, 4)).astype(np.float32)
    windows = np.ascontiguousarray(exemplar[5:37:2, 3:35:2])
    field = np.zeros((16, 16, 2), np.int32)
    field[8, 8] = 5 + 16, 3 + 16
    for seed in range(4):
        field, distances = search_warm(
            windows,
            exemplar,
            Charge(np.zeros((40, 40), np.float32)),
            field,
            step=2,
            seed=seed,
            passes=3,
            work=Context(),
        )
    assert np.mean(distances == 0) == 1
    np.testing.assert_array_equal(field[0, 0], [5, 3])
