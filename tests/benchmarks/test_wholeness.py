import numpy as np

from benchmarks.wholeness import cores, cut_share
from graphtex_nodes import bricks, pebbles

ROWS, COLUMNS = np.mgrid[:40, :40]
WHOLE = np.stack([ROWS, COLUMNS], axis=-1)
ELEMENTS = np.where((ROWS % 10 < 8) & (COLUMNS % 10 < 8), ROWS // 10 * 4 + COLUMNS // 10, -1)


def test_nothing_is_cut_in_a_copy_or_between_elements():
    shifted = np.stack([ROWS, (COLUMNS + np.where(COLUMNS < 19, 0, 10)) % 40], axis=-1)
    assert cut_share(WHOLE, ELEMENTS) == 0
    assert cut_share(WHOLE[5:25, 3:], ELEMENTS) == 0
    assert cut_share(shifted, ELEMENTS) == 0


def test_a_cut_through_a_column_of_elements():
    """Of four columns of elements the second is cut in the middle, and goes on as half of the fourth."""
    source = np.stack([ROWS, COLUMNS + np.where((COLUMNS >= 14) & (COLUMNS < 20), 20, 0)], axis=-1)
    assert cut_share(source, ELEMENTS) == 0.25


def test_less_than_a_tenth_may_be_missing():
    source = WHOLE.copy()
    source[:5, 0] = 39, 39
    assert cut_share(source, ELEMENTS) == 0
    source[:8, 0] = 39, 39
    assert 0.05 < cut_share(source, ELEMENTS) < 0.07


def test_cores_lie_around_centres_and_shrink_with_distance():
    for kind, aspect in ((pebbles, 1.0), (bricks, 3.0)):
        made = kind(width=128, height=128, slant=50.0, tilt=20.0, rng=1)
        found = cores(made, 50.0, 20.0, 45.0, aspect)
        x, y = made.centres.round().astype(int).T
        np.testing.assert_array_equal(found[y, x], np.arange(len(made.centres)))
        assert 0.4 < (found >= 0).mean() < 0.9
        areas = np.bincount(found[found >= 0])
        near = made.scale[y, x] > np.median(made.scale)
        assert areas[near].mean() > 1.5 * areas[~near].mean()
