import numpy as np
import pytest

from graphtex_nodes.numerics.sources import Look, coherence, continued, coverage, self_match, source_map

RAMP = np.stack(np.mgrid[:9, :7], axis=-1).astype(np.float32)  # channels tell row and column


def point(row, column, log=0.0, angle=0.0, mirrored=0):
    return np.array([[0, row, column, log, angle, mirrored]], np.float32)


def test_coherence_by_hand():
    """Two rows of two: the left column continues downwards, nothing else does."""
    source = np.array([[[0, 0], [5, 5]], [[1, 0], [9, 9]]])
    assert coherence(source) == 1 / 4
    assert coherence(np.zeros((1, 1, 2), int)) == 1
    assert coherence(np.stack(np.mgrid[:4, :5], axis=-1)) == 1


def test_coverage_counts_pixels_once():
    every = np.ones((2, 3), bool)
    source = source_map(np.array([[[0, 0], [0, 0], [1, 2]]]))
    assert coverage(source, [every]) == 2 / 6
    source[0, 1, 0] = 1
    assert coverage(source, [every, np.array([[True, False]])]) == 3 / 7
    source[0, 1, 0] = 2  # a known pixel
    assert coverage(source, [every, np.array([[True, False]])]) == 2 / 7


@pytest.mark.parametrize(
    ("view", "expected"),
    [
        ({}, (5, 8)),
        ({"log": 1.0}, (4.5, 6)),  # shown twice as large: half as far
        ({"mirrored": 1}, (5, 0)),
        ({"angle": 90.0}, (0, 5)),  # what lies to the right of a picture turned clockwise lay above it
        ({"angle": 180.0}, (3, 0)),
        ({"angle": 90.0, "mirrored": 1}, (0, 3)),
    ],
)
def test_what_lies_beside_a_point_by_hand(view, expected):
    """From row 4, column 4, one down and four to the right."""
    np.testing.assert_allclose(continued(point(4, 4, **view), 1.0, 4.0)[0], expected, atol=1e-9)


def test_whole_places_show_pixels():
    points = np.concatenate([point(2, 3), point(8, 6, log=0.5), point(0, 0, angle=30, mirrored=1)])
    np.testing.assert_array_equal(Look(RAMP).at(points), [[2, 3], [8, 6], [0, 0]])


def test_between_pixels_a_ramp_is_a_ramp():
    points = np.concatenate([point(4.25, 3.5), point(4.5, 2.75, log=-1)])
    np.testing.assert_allclose(Look(RAMP).at(points), [[4.25, 3.5], [4.5, 2.75]], atol=0.02)


def test_points_outside_show_the_border():
    np.testing.assert_array_equal(Look(RAMP).at(point(-0.4, 7)), [[0, 6]])


@pytest.mark.parametrize(
    ("kind", "view", "expected"),
    [
        ("normal", {"mirrored": 1}, (-0.6, 0.0)),
        ("normal", {"angle": 90.0}, (0.0, -0.6)),  # right becomes down, where a second component points up
        ("normal-down", {"angle": 90.0}, (0.0, 0.6)),
        ("normal", {"mirrored": 1, "angle": 90.0}, (0.0, 0.6)),
        ("normal", {"angle": 45.0}, (0.6 * 0.5**0.5, -0.6 * 0.5**0.5)),
    ],
)
def test_normals_turn_with_their_picture(kind, view, expected):
    """A normal that leans to the right, (0.6, 0, 0.8); the scalar before it stays."""
    stack = np.full((3, 3, 4), np.float32([0.3, 0.8, 0.5, 0.9]))
    scalar, *normal = Look(stack, ["scalar", kind]).at(point(1, 1, **view))[0]
    assert scalar == np.float32(0.3)
    np.testing.assert_allclose(np.array(normal) * 2 - 1, [*expected, 0.8], atol=1e-6)


@pytest.mark.parametrize("shift", [(0, 20), (13, 0), (9, -17)])
def test_self_match_of_a_repeated_piece(shift):
    """A piece of 8 x 12 pixels occurs a second time: 96 pairs among all that overlap at this lag."""
    row, column = np.mgrid[:40, :60]
    sources = np.stack([row, column], axis=-1)
    top, left = 4, 22
    sources[top + shift[0] : top + shift[0] + 8, left + shift[1] : left + shift[1] + 12] = sources[4:12, 22:34]
    share = 96 / ((40 - abs(shift[0])) * (60 - abs(shift[1])))
    assert self_match(source_map(sources)) == pytest.approx(share, abs=0.06)


def test_self_match_without_repeats():
    assert self_match(source_map(np.stack(np.mgrid[:100, :120], axis=-1))) < 0.06
