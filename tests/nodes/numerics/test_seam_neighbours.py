import numpy as np
import pytest

from graphtex_nodes.numerics import seam_kernels, seam_neighbours
from graphtex_nodes.numerics.seam_neighbours import OFFSETS, Contrast, around, near_seams
from graphtex_nodes.numerics.sources import source_map

ALL = np.ones((9, 9), bool)


def two_pieces():
    """Columns 0 to 3 show one place, columns 4 to 8 another."""
    places = np.stack(np.mgrid[:9, :9], axis=-1)
    places[:, 4:] += (20, 30)
    return source_map(places)


def test_seams_are_seen_from_two_pixels():
    mixed = near_seams(two_pieces(), ALL)
    assert np.flatnonzero(mixed.any(axis=0)).tolist() == [2, 3, 4, 5]
    assert mixed[:, 2:6].all()


@pytest.mark.parametrize(("row", "column"), [(4, 3), (0, 5), (8, 8)])
def test_what_is_around_by_hand(row, column):
    """Own place first; a pixel of the other piece shows the other piece's place, continued up to here."""
    found = around(two_pieces(), ALL, np.array([row]), np.array([column]))
    for number, (down, right) in enumerate(OFFSETS):
        y, x = row + down, column + right
        if not (0 <= y < 9 and 0 <= x < 9):
            assert found.first[0, number] == -1
            continue
        other = x >= 4
        np.testing.assert_allclose(found.points[0, number, 1:3], (row + 20 * other, column + 30 * other))
        assert (found.first[0, number] == 0) == (other == (column >= 4))
    assert len(set(found.first[0]) - {-1}) == (1 if column == 8 else 2)


def test_pixels_that_are_not_free_show_nothing():
    free = ALL.copy()
    free[:, 4:] = False
    assert not near_seams(two_pieces(), free).any()
    found = around(two_pieces(), free, np.array([4]), np.array([3]))
    assert set(found.first[0]) == {-1, 0}


@pytest.mark.parametrize("channel", [0, 3, 4, 5])
def test_another_view_is_another_piece(channel):
    source = two_pieces()
    source[:, 4:, 1:3] -= (20, 30)
    assert not near_seams(source, ALL).any()
    source[:, 4:, channel] = 1
    assert near_seams(source, ALL)[:, 2:6].all()


def test_maps_that_wrap_around_go_on_over_their_borders():
    """Moved around, what is around the border pixels is that of inner ones."""
    source = two_pieces()
    moved = np.roll(source, 5, axis=1)
    assert not near_seams(source, ALL)[:, -2:].any()
    wrapped = near_seams(moved, ALL, (False, True))
    np.testing.assert_array_equal(wrapped[:, 4:7], True)
    np.testing.assert_array_equal(wrapped[:, [0, 7, 8]], near_seams(source, ALL)[:, [4, 2, 3]])
    inner = around(source, ALL, np.array([4]), np.array([3]))
    border = around(moved, ALL, np.array([4]), np.array([8]), (False, True))
    np.testing.assert_array_equal(inner.points, border.points)
    np.testing.assert_array_equal(inner.first, border.first)


def test_elements_meet_more_sharply_than_grain():
    limits = np.zeros(3), np.ones(3)
    grain, elements = (Contrast(0.5, share, limits) for share in (0.0, 1.0))
    assert (grain.sharpness, elements.sharpness) == (0, 1)
    assert (grain.reach, elements.reach) == (16, 8)
    assert np.isfinite(np.float32(Contrast(0.0, 1.0, limits).sharpness))


def test_small_maps():
    assert not near_seams(np.zeros((1, 1, 6), np.float32), np.ones((1, 1), bool)).any()
    assert near_seams(np.zeros((1, 2, 6), np.float32), np.ones((1, 2), bool)).all()


def test_kernels_fade_as_far():
    """They keep the radius themselves, for loops of known length; a replay blends as a synthesis does."""
    assert seam_kernels.RADIUS == seam_neighbours.RADIUS
