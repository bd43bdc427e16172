import numpy as np
import pytest

from benchmarks.splicing_warp import _bed_joints, _missed, _strain
from graphtex import Texture
from graphtex_nodes import extend_texture
from graphtex_nodes.splicing.values import Moves


@pytest.fixture
def courses():
    """Two courses of one brick each, with a joint of 3 rows between them."""
    mask = np.ones((11, 20), bool)
    mask[4:7] = False
    return extend_texture(
        Texture(np.zeros((11, 20, 3), np.float32), mask, np.array([[10.0, 1], [10, 9]]), "B=c"), factor=1
    )


def test_a_turn_is_no_strain_and_a_stretch_is():
    turn, (y, x) = np.radians(20), np.mgrid[:8, :9].astype(float)
    turned = np.stack([x * np.cos(turn) - y * np.sin(turn) - x, x * np.sin(turn) + y * np.cos(turn) - y], axis=2)
    np.testing.assert_allclose(_strain(turned, np.ones((8, 9), bool)), 0, atol=1e-12)
    np.testing.assert_allclose(_strain(np.stack([0.1 * x, -0.02 * y], axis=2), np.ones((8, 9), bool)), 0.1)


def test_joints_by_hand(courses):
    """The lower course sinks by 0.5: the joint is so much wider; a tilt by 0.02 is its slope."""
    warp = np.zeros((11, 20, 2), np.float32)
    warp[6:, :, 1] = 0.5
    assert _bed_joints(courses, warp) == pytest.approx((0.5, 0))
    warp[..., 1] = 0.02 * np.arange(20)
    assert _bed_joints(courses, warp) == pytest.approx((0, 0.02))


def test_the_farthest_element_counts(courses):
    warp = np.zeros((11, 20, 2), np.float32)
    warp[7:] = (3, 4)
    moves = Moves(courses.points, courses.points + np.array([0, 1]), np.zeros(2), np.ones(2), np.ones(2))
    assert _missed(courses, moves, warp) == pytest.approx(np.hypot(3, 3))
