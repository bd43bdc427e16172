import numpy as np
import pytest

from benchmarks.regularity import order, regular
from graphtex_nodes import bricks, pebbles, woven_cloth


@pytest.mark.parametrize("make", [bricks, woven_cloth])
def test_order_tells_of_faults(make):
    """Halves that are moved by half a row agree with themselves only."""
    exemplar = make(width=256, height=256, rng=1).image
    found = regular(exemplar)
    assert found is not None
    tall = np.tile(make(width=256, height=512, rng=1).image, (1, 2, 1))
    shifted = np.roll(tall, round(float(found.shifts[0, 0]) / 2), axis=0)
    broken = np.concatenate([tall[:, :256], shifted[:, 256:]], axis=1)
    assert order(broken, found) < 0.8 * order(tall, found)


def test_pebbles_are_not_regular():
    assert regular(pebbles(width=128, height=128, rng=1).image) is None
