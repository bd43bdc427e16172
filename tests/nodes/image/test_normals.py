import numpy as np
import pytest

from graphtex_nodes.image.normals import normals_from_height

ROW, COLUMN = np.mgrid[:9, :12].astype(np.float32)


def vectors(height, **options):
    return normals_from_height(height[..., None].astype(np.float32), **options) * 2.0 - 1


@pytest.mark.parametrize(
    ("height", "expected"),
    [
        (0 * ROW, (0, 0, 1)),
        (0.75 * COLUMN, (-0.6, 0, 0.8)),  # uphill to the right: it faces left
        (0.75 * ROW, (0, 0.6, 0.8)),  # uphill downwards: it faces up
    ],
)
def test_slopes_by_hand(height, expected):
    """On a plane every pixel has the plane's normal, border pixels too."""
    np.testing.assert_allclose(vectors(height, relief=1.0), np.broadcast_to(expected, (9, 12, 3)), atol=1e-5)


def test_second_component_down():
    up, down = (vectors(0.3 * ROW, relief=2.0, kind=kind) for kind in ("normal", "normal-down"))
    np.testing.assert_allclose(up * [1, -1, 1], down, atol=1e-6)


def test_sphere():
    """Second method: the normal of a sphere is its radius."""
    y, x = (np.mgrid[:41, :41] - 20.0) / 60
    height = np.sqrt(1 - x**2 - y**2)
    expected = np.stack([x, -y, height], axis=-1)
    np.testing.assert_allclose(vectors(height * 60, relief=1.0)[1:-1, 1:-1], expected[1:-1, 1:-1], atol=2e-3)


def test_tileable_sides_see_each_other():
    """A surface rolled round has its normals rolled round; without, those at its sides differ."""
    surface = np.sin(COLUMN * 2 * np.pi / 12) * np.cos(ROW * 2 * np.pi / 9)
    rolled = np.roll(surface, (4, 5), (0, 1))
    np.testing.assert_allclose(
        vectors(rolled, tileable="both"), np.roll(vectors(surface, tileable="both"), (4, 5), (0, 1)), atol=1e-5
    )
    both, one = (vectors(surface, tileable=sides) for sides in ("both", "x"))
    np.testing.assert_allclose(both[1:-1], one[1:-1], atol=1e-6)
    assert np.abs(both - one).max() > 0.01


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (7, 1)])
def test_small(shape):
    found = vectors(np.random.default_rng(0).random(shape))
    assert found.shape == (*shape, 3)
    np.testing.assert_allclose(np.linalg.norm(found, axis=2), 1, atol=1e-5)


def test_refuses_colours():
    with pytest.raises(ValueError, match=r"height: expected one channel, got shape \(4, 4, 3\); Grey makes one"):
        normals_from_height(np.zeros((4, 4, 3), np.float32))
