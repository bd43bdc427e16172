from itertools import permutations

import numpy as np
import pytest

from graphtex_nodes import extend_texture, hungarian
from tests.nodes.splicing.scenes import discs, elements, grid, whole


def test_worked_by_hand():
    """The nearer of two for each would cost 2 + 12; crossing over costs 4 + 6."""
    found = hungarian(whole(discs([[10, 20], [16, 20]])), elements([[12, 20], [22, 20]]))
    np.testing.assert_array_equal(found.moves.targets, [[12, 20], [22, 20]])
    assert found.distance == 4
    assert found.empty == 0


def test_equals_the_best_of_all_permutations():
    rng = np.random.default_rng(3)
    points, places = rng.uniform(8, 52, (6, 2)), rng.uniform(8, 52, (6, 2))
    found = hungarian(whole(discs(points, (60, 60), 2)), elements(places))
    best = min(np.linalg.norm(points - places[list(order)], axis=1).sum() for order in permutations(range(6)))
    assert np.linalg.norm(found.moves.targets - points, axis=1).sum() == pytest.approx(best)


def test_surplus_follows_its_neighbours():
    """All assigned textons move by (2, 1): the one that is left over does, too."""
    points = grid(12, (48, 48), 6)
    found = hungarian(whole(discs(points, (48, 48), 2)), elements(np.delete(points, 5, axis=0) + np.array([2, 1])))
    assert found.moves.matched.sum() == 15
    np.testing.assert_allclose(found.moves.targets - points, np.tile([2.0, 1.0], (16, 1)))


def test_places_are_in_pixels_of_the_window():
    extension = extend_texture(discs(grid(), (64, 64)), factor=1.5)
    found = hungarian(extension, elements([[8, 8], [24, 40]]))
    np.testing.assert_allclose(
        np.sort(found.moves.targets[found.moves.matched > 0], axis=0),
        np.sort(np.array([[8, 8], [24, 40]]) + np.array([extension.left, extension.top]), axis=0),
    )


def test_angles_and_scales_go_with_their_places():
    target = elements([[10, 10], [30, 30]])._replace(angles=np.array([20.0, 70.0]), scales=np.array([0.5, 2.0]))
    moves = hungarian(whole(discs([[29, 31], [11, 10]])), target).moves
    assert moves.angles.tolist() == [70, 20]
    assert moves.scales.tolist() == [2, 0.5]


def test_a_texton_that_would_have_to_go_too_far_stays():
    with pytest.warns(UserWarning, match="1 of 2 places"):
        found = hungarian(whole(discs([[10, 10], [10, 30]])), elements([[12, 10], [39, 39]]), farthest=5)
    assert found.moves.matched.tolist() == [1, 0]
    assert found.distance == 2


def test_elements_cut_by_the_border_are_taken_last():
    extension = whole(discs([[1, 20], [20, 20]]))
    assert hungarian(extension, elements([[0, 20]])).moves.matched.tolist() == [0, 1]
    assert hungarian(extension, elements([[0, 20], [30, 20]])).moves.targets[:, 0].tolist() == [0, 30]


def test_three_places_for_hundreds_and_hundreds_for_three():
    many, few = grid(6, (96, 96), 3), grid(40, (96, 96), 20)[:3]
    found = hungarian(whole(discs(many, (96, 96), 1)), elements(few))
    assert found.moves.matched.sum() == 3
    with pytest.warns(UserWarning, match="253 of 256 places got no texton"):
        assert hungarian(whole(discs(few, (96, 96), 1)), elements(many)).empty == 253


@pytest.mark.parametrize(
    ("points", "places", "told"),
    [([], [[1, 1]], "elements: expected at least one texton"), ([[9, 9]], [], "target: expected at least one place")],
)
def test_refuses(points, places, told):
    with pytest.raises(ValueError, match=told):
        hungarian(whole(discs(points)), elements(places))


def test_refuses_more_pairs_than_fit_in_memory():
    extension = whole(discs([[9, 9]]))._replace(points=np.zeros((8000, 2)), labels=np.full((40, 40), -1, np.int32))
    with pytest.raises(ValueError, match="target: expected at most 5e\\+07 pairs"):
        hungarian(extension, elements(np.zeros((8000, 2))))


def test_elements_with_a_seam_are_taken_where_others_are_far():
    """Two textons are as near to a place; the one in which two pieces meet is left."""
    extension = whole(discs([[12, 20], [28, 20]]))
    source = extension.source.copy()
    source[:, 12:, 2] += 3
    joined = extension._replace(source=source)
    assert hungarian(joined, elements([[19, 20]])).moves.matched.tolist() == [0, 1]
    assert hungarian(joined, elements([[12, 20]])).moves.matched.tolist() == [1, 0]
    assert hungarian(joined._replace(tag="F=c"), elements([[19, 20]])).moves.matched.tolist() == [1, 0]
