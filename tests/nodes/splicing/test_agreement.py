import numpy as np
import pytest

from graphtex_nodes import textons
from graphtex_nodes.splicing._agreement import agreement, central


def test_a_miss_and_a_false_point_count_once_each():
    """With n inner elements, one missed and one invented: F1 = 2 (n - 1) / (2 (n - 1) + 2)."""
    made = textons(width=96, height=96, size=20.0, rng=1)
    inner = ((made.centres >= 5) & (made.centres <= 90)).all(axis=1)
    first, count = int(np.flatnonzero(inner)[0]), int(inner.sum())
    found = np.concatenate([np.delete(made.centres, first, axis=0), made.centres[[first]] + (11, 9)])
    share, which, true = agreement(found, made, 20.0)
    assert share == pytest.approx((count - 1) / count)
    assert first not in true
    np.testing.assert_array_equal(found[which], made.centres[true])


def test_the_central_element_and_one_of_the_other_kind():
    made = textons(width=96, height=96, size=20.0, form="flower", other="disc", rng=1)
    index, example = central(made)
    other, _ = central(made, index)
    middle = np.hypot(*(made.centres - 47.5).T)
    assert middle[index] == middle.min()
    assert (example.x, example.y) == tuple(made.centres[index])
    areas = np.bincount(made.labels.ravel(), minlength=len(made.centres) + 1)[1:]
    assert abs(np.log(areas[other] / areas[index])) > 0.25
