"""Strangeness: what a hole would show that is nowhere near it costs; what is beside it does not."""

from typing import Any

import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics.move_search import Level
from graphtex_nodes.numerics.plane_moves import Move, Slope
from graphtex_nodes.numerics.strangeness import AWAY, MOST, STRANGE, Strangeness

FLAT = Slope(0, 0)


def costs(picture: Any, hole: Any, *shifts: tuple[int, int], threads: int = 1) -> Strangeness:
    """Strangeness of plain shifts; one standard deviation is 1."""
    level = Level(picture.astype(np.float32), ~hole, hole)
    moves = [Move(FLAT, down, right) for down, right in shifts]
    return Strangeness.of(level, moves, 1.0, Context(threads=threads))


def regions() -> tuple[Any, Any]:
    """Dark at the left, bright at the right, and a lone object between both far from the hole in the middle."""
    picture = np.zeros((60, 160, 1))
    picture[:, 80:] = 1
    picture[:, :20] = 0.5
    hole = np.zeros((60, 160), bool)
    hole[20:40, 60:100] = True
    return picture, hole


def test_what_lies_beside_the_hole_costs_nothing_there() -> None:
    picture, hole = regions()
    found = costs(picture, hole, (0, -30), (0, 40)).costs
    assert found[0, 30, 61] == pytest.approx(0, abs=0.01)
    assert found[1, 30, 98] == pytest.approx(0, abs=0.01)


def test_what_lies_between_two_regions_costs_its_distance_from_both() -> None:
    picture, hole = regions()
    found = costs(picture, hole, (0, -70)).costs[0, 25:35, 65:75]
    assert (found > 0.3 * STRANGE).all()


def test_what_is_far_counts_less_than_what_is_near() -> None:
    picture, hole = regions()
    bright = costs(picture, hole, (0, 50)).costs[0, 30]
    assert bright[62] > bright[78] > bright[98]
    # at worst what is across the hole is taken to be as far away as it is
    assert bright[62] <= STRANGE * AWAY * np.hypot(20, 60) / np.sqrt(hole.sum())


def test_contrast_tells_apart_what_has_one_mean_colour() -> None:
    picture = np.full((60, 160, 1), 0.5)
    picture[:, :40] += np.where(np.indices((60, 40)).sum(axis=0) % 2, 0.4, -0.4)[..., None]
    hole = np.zeros((60, 160), bool)
    hole[20:40, 80:100] = True
    rough, plain = costs(picture, hole, (0, -70), (0, 40)).costs[:, 30, 90]
    assert rough == pytest.approx(0.4 * STRANGE, rel=0.05)
    assert plain == pytest.approx(0, abs=0.01)


def test_nothing_costs_outside_the_hole_or_where_nothing_is_known() -> None:
    picture, hole = regions()
    assert not costs(picture, hole, (0, -30)).costs[:, ~hole].any()
    assert not costs(picture, np.ones_like(hole), (0, -30)).costs.any()


def test_finer_pictures_have_the_costs_of_the_halved_one() -> None:
    picture, hole = regions()
    found = costs(picture, hole, (0, -70), (0, 50))
    rows, columns = np.array([50, 51]), np.array([130, 141])
    finer = found.finer().of_moves(np.array([1]))
    assert (finer.at(0, rows, columns) == found.costs[1, rows // 2, columns // 2]).all()


def test_threads_and_many_places_change_nothing() -> None:
    rng = np.random.default_rng(0)
    picture, hole = rng.random((90, 120, 4)), np.zeros((90, 120), bool)
    hole[30:60, 30:90] = True
    assert hole.sum() > MOST
    shifts = [(int(down), int(right)) for down, right in rng.integers(-30, 30, (20, 2))]
    one, two = (costs(picture, hole, *shifts, threads=threads).costs for threads in (1, 2))
    assert one.tobytes() == two.tobytes()
    assert np.isfinite(one).all()
