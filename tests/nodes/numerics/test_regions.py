import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from skimage.measure import points_in_poly

from graphtex_nodes.numerics.regions import (
    Brushed,
    Ellipse,
    Masked,
    Polygon,
    Rectangle,
    Whole,
    polygon_mask,
    region_weights,
)


def test_rectangle_worked_by_hand():
    """From -0.5 + 1 to -0.5 + 3, columns 1 and 2 are full; a quarter further, the next one is 0.25 inside."""
    row = region_weights(Rectangle(corner=(0.5, -2), opposite=(2.5, 2)), 5, 1)[0]
    np.testing.assert_allclose(row, [0, 1, 1, 0, 0])
    row = region_weights(Rectangle(corner=(2.75, 2), opposite=(0.5, -2)), 5, 1)[0]
    np.testing.assert_allclose(row, [0, 1, 1, 0.25**2 * 2.5, 0])  # the smooth step 3t² - 2t³ at 1/4


def test_soft_edge_is_half_way_at_the_outline():
    row = region_weights(Rectangle(corner=(10, -50), opposite=(90, 50), softness=8), 40, 1)[0]
    assert row[10] == pytest.approx(0.5)
    assert row[6] == 0
    assert row[14] == 1
    assert (np.diff(row) >= 0).all()


def test_ellipse_covers_its_area_and_turns_clockwise():
    weights = region_weights(Ellipse(centre=(30, 30), radii=(20, 5), angle=45), 61, 61)
    assert weights.sum() == pytest.approx(np.pi * 100, rel=0.01)
    assert weights[40, 40] == 1  # y is down: clockwise from the right is to the lower right
    assert weights[20, 40] == 0


@given(st.lists(st.tuples(st.floats(-3, 13), st.floats(-3, 13)), min_size=3, max_size=7))
def test_polygon_is_that_of_another_library(points):
    """Scikit-image's test of points in polygons follows the even-odd rule too; pixels on an outline may differ."""
    corners = np.array(points) + 1e-4 * np.sqrt(np.arange(2 * len(points))).reshape(-1, 2)
    closed = np.concatenate([corners, corners[:1]])
    y, x = np.mgrid[:9, :12]
    expected = points_in_poly(np.stack([x.ravel(), y.ravel()], axis=1), corners).reshape(9, 12)
    weights = region_weights(Polygon(points=tuple(map(tuple, corners.tolist()))), 12, 9)
    clear = (weights < 0.49) | (weights > 0.51)
    np.testing.assert_array_equal(polygon_mask(closed, 12, 9)[clear], expected[clear])
    np.testing.assert_array_equal(weights[clear] > 0.5, expected[clear])


def test_mask_hard_and_soft():
    mask = np.zeros((1, 9), bool)
    mask[:, 4:] = True
    np.testing.assert_array_equal(region_weights(Masked(), 9, 1, [mask])[0], mask[0])
    soft = region_weights(Masked(index=1, softness=4), 9, 1, [~mask, mask])[0]
    assert soft[3] + soft[4] == pytest.approx(1)  # the outline runs between them
    assert soft[1] == 0
    assert soft[6] == 1
    for same in (np.ones((1, 9), bool), np.zeros((1, 9), bool)):
        np.testing.assert_array_equal(region_weights(Masked(softness=4), 9, 1, [same]), same)


def test_whole_and_strokes():
    assert (region_weights(Whole(), 3, 2) == 1).all()
    brushed = Brushed(strokes={"lines": ({"points": ((1, 1),), "radius": 1, "label": "a"},)}, label="b")
    assert not region_weights(brushed, 3, 2).any()


def test_refuses_masks():
    with pytest.raises(ValueError, match="mask 2, counted from 0, got 1"):
        region_weights(Masked(index=2), 3, 2, [np.ones((2, 3), bool)])
    with pytest.raises(ValueError, match=r"masks\[0\]: expected the map's size \(2, 3\), got \(3, 2\)"):
        region_weights(Masked(), 3, 2, [np.ones((3, 2), bool)])
