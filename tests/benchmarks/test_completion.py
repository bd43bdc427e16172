"""Measures of a filled hole, on planes whose truth is known."""

import numpy as np
import pytest

from benchmarks import completion
from graphtex_nodes.numerics.sources import source_map


@pytest.fixture(scope="module")
def cases():
    return completion.cases(count=3)


def shifted(case, down, right):
    """The hole filled with the true picture from elsewhere."""
    return np.where(case.hole[..., None], np.roll(case.picture, (-down, -right), axis=(0, 1)), case.picture)


def test_scale_falls_upwards_and_is_the_same_along_rows(cases):
    for case in cases:
        assert np.ptp(case.scale, axis=1).max() < 1e-4
        assert (np.diff(case.scale[:, 0]) > 0).all()
        assert not np.array_equal(case.others[0], case.picture)


def test_holes_are_large_and_of_five_shapes():
    holes = [completion.shape(number) for number in range(5)]
    assert all(0.1 < hole.mean() < 0.3 for hole in holes)
    assert [bool(hole[-1].any()) for hole in holes] == [False, False, True, False, True]


def test_a_source_map_tells_sizes_by_hand(cases):
    """What is taken from another row has that row's size, times its enlargement."""
    case = cases[0]
    places = np.stack(np.mgrid[: completion.SIDE, : completion.SIDE], axis=-1)
    places[case.hole] = 300, 10
    source = source_map(places)
    source[case.hole, 3] = 1
    wanted = np.log(2 * case.scale[300, 10] / case.scale[case.hole])
    np.testing.assert_allclose(completion.source_errors(source, case), wanted, rtol=1e-5, atol=1e-6)


def test_copies_are_traced_back(cases):
    """From the side they have the right size; from above they are too small by the ratio of scales."""
    case = cases[0]
    rows = np.flatnonzero(case.hole.any(axis=1))
    beside = completion.traced_errors(shifted(case, 0, 140), case)
    assert np.sqrt(np.mean(beside**2)) < 0.1
    above = completion.traced_errors(shifted(case, -45, 140), case)
    wanted = np.log(case.scale[rows - 45, 0] / case.scale[rows, 0]).mean()
    assert above.mean() == pytest.approx(wanted, abs=0.05)


def test_size_error_tells_large_elements_from_right_ones(cases):
    case = cases[0]
    plain = np.where(case.hole[..., None], 0.5, case.picture)
    right, large, smear = (
        completion.size_error(picture, case) for picture in (case.picture, shifted(case, -45, 140), plain)
    )
    assert 5 * right < large < smear


def test_size_of_a_chequered_pattern_by_hand():
    """Squares of 4 x 6 pixels: in 12 x 12 pixels 2 crossings for each of 12 columns, 1 for each of 12 rows."""
    rows, columns = np.mgrid[:12, :12]
    squares = ((rows // 4 + columns // 6) % 2).astype(np.float32)[..., None]
    inside, level = np.ones((12, 12), bool), np.full((1, 12, 1, 1), 0.5)
    wanted = np.sqrt((12 * 11 / (2 * 12)) * (12 * 11 / 12))
    assert completion.element_size(squares, inside, level) == pytest.approx(wanted)
    assert completion.element_size(np.zeros_like(squares), inside, level) == float("inf")


def test_size_error_does_not_see_sharpness(cases):
    """The truth moved by half a pixel has all sizes right. Without smoothing it would be worse than wrong sizes."""

    def error(picture_of, **smooth):
        return np.mean([completion.size_error(picture_of(case), case, **smooth) for case in cases])

    def moved(case):
        right = (case.picture + np.roll(case.picture, 1, axis=1)) / 2
        return (right + np.roll(right, 1, axis=0)) / 2

    def wrong(case):
        return shifted(case, -45, 140)

    assert 8 * error(moved) < error(wrong)
    assert error(moved, smooth=0.0) > error(wrong, smooth=0.0)


def test_distance_is_zero_for_the_truth_and_counts_blur(cases):
    from scipy.ndimage import gaussian_filter

    case = cases[1]
    assert completion.hole_distance(case.picture, case) == 0
    blurred = gaussian_filter(case.picture, (4, 4, 0))
    assert completion.hole_distance(blurred, case) > 2 * completion.hole_distance(shifted(case, 140, 0), case)
