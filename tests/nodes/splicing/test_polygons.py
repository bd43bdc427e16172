import numpy as np
import pytest

from graphtex_nodes.splicing._polygons import around, evenly, mean_value_coordinates, moments, normals

L_SHAPE = np.array([[0.0, 0], [60, 0], [60, 20], [20, 20], [20, 50], [0, 50]])


def test_moments_of_an_l_are_those_of_its_pixels():
    y, x = np.mgrid[:200, :240] / 4 + 0.125
    inside = (x < 60) & (y < 20) | (x < 20) & (y < 50)
    found = moments(L_SHAPE)
    pixels = np.stack([x[inside], y[inside]])
    assert found.area == pytest.approx(inside.sum() / 16)
    np.testing.assert_allclose(found.centre, pixels.mean(axis=1))
    np.testing.assert_allclose(found.covariance, np.cov(pixels, bias=True), atol=0.02)
    assert moments(L_SHAPE[::-1]).area == -found.area


@pytest.mark.parametrize("outline", [L_SHAPE, evenly(L_SHAPE, 40)])
def test_coordinates_give_each_point_back(outline):
    """So an outline mapped by an affine map takes what is inside along; near a corner its weight is nearly 1."""
    points = np.array([[10.0, 10], [50, 5], [5, 45], [19, 21], [59.999, 0.002]])
    weights = mean_value_coordinates(points, outline)
    np.testing.assert_allclose(weights.sum(axis=1), 1)
    np.testing.assert_allclose(weights @ outline, points, atol=1e-4)
    sheared = outline @ np.array([[1.0, 0.5], [-0.3, 2]]) + (7, 9)
    np.testing.assert_allclose(weights @ sheared, points @ np.array([[1.0, 0.5], [-0.3, 2]]) + (7, 9), atol=1e-4)


def test_corners_at_equal_distances():
    corners = evenly(np.array([[0.0, 0], [4, 0], [4, 2], [0, 2]]), 6)
    np.testing.assert_allclose(corners, [[0, 0], [2, 0], [4, 0], [4, 2], [2, 2], [0, 2]])


def test_outline_of_a_disc_and_its_normals():
    y, x = np.mgrid[:31, :41]
    outline = around(9.5 - np.hypot(x - 20, y - 15), np.array([100, 200]))
    found = moments(outline)
    assert found.area == pytest.approx(np.pi * 9.5**2, rel=0.01)
    np.testing.assert_allclose(found.centre, [120, 215], atol=0.01)
    corners = evenly(outline, 24)
    outward = (corners - (120, 215)) / 9.5
    np.testing.assert_allclose(normals(corners), outward, atol=0.05)


def test_no_outline():
    assert around(np.full((5, 5), -1.0), np.zeros(2)) is None
    assert around(np.pad([[0.3]], 3, constant_values=-1.0), np.zeros(2)) is None, "less than a pixel"
    assert around(np.ones((1, 9)), np.zeros(2)) is not None, "the border closes it"
