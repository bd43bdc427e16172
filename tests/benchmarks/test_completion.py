"""Measures of a filled hole, on planes whose truth is known."""

import numpy as np
import pytest

from benchmarks import completion


@pytest.fixture(scope="module")
def cases():
    return completion.cases()


def shifted(case, down, right):
    """The hole filled with the true picture from elsewhere."""
    return np.where(case.hole[..., None], np.roll(case.picture, (-down, -right), axis=(0, 1)), case.picture)


def test_scale_falls_upwards_and_is_the_same_along_rows(cases):
    assert len(cases) == 10
    for case in cases:
        assert np.ptp(case.scale, axis=1).max() < 1e-4
        assert (np.diff(case.scale[:, 0]) > 0).all()
        assert 0.02 < case.hole.mean() < 0.12
        assert not case.hole[[0, -1]].any()
        assert not case.hole[:, [0, -1]].any()


def test_copies_from_the_side_have_the_right_scale(cases):
    case = cases[0]
    assert completion.source_error(shifted(case, 0, 90), case) < 0.02


def test_copies_from_below_are_too_large_by_the_ratio_of_scales(cases):
    case = cases[0]
    rows = np.flatnonzero(case.hole.any(axis=1))[5:-5]
    wanted = np.log(case.scale[rows + 90, 0] / case.scale[rows, 0]).mean()
    assert completion.source_error(shifted(case, 90, 0), case) == pytest.approx(wanted, abs=0.03)


def test_size_error_tells_large_elements_from_right_ones(cases):
    right = np.mean([completion.size_error(case.picture, case) for case in cases[:3]])
    large = np.mean([completion.size_error(shifted(case, 90, 0), case) for case in cases[:3]])
    smear = np.mean(
        [completion.size_error(np.where(case.hole[..., None], 0.5, case.picture), case) for case in cases[:3]]
    )
    assert right < large < smear
    assert smear == pytest.approx(completion.WORST**2)


def test_distance_is_zero_for_the_truth_and_counts_blur(cases):
    from scipy.ndimage import gaussian_filter

    case = cases[1]
    assert completion.hole_distance(case.picture, case) == 0
    blurred = gaussian_filter(case.picture, (4, 4, 0))
    assert completion.hole_distance(blurred, case) > 2 * completion.hole_distance(shifted(case, 0, 90), case)
