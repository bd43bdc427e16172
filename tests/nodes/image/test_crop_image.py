import numpy as np
import pytest

from graphtex_nodes import crop_image

PICTURE = np.random.default_rng(2).random((7, 9, 4), np.float32)


@pytest.mark.parametrize(
    ("part", "rows", "columns"),
    [
        ({}, (0, 7), (0, 9)),
        ({"x": 2, "y": 3}, (3, 7), (2, 9)),
        ({"x": 8, "y": 6, "width": 1, "height": 1}, (6, 7), (8, 9)),
        ({"width": 9, "height": 7}, (0, 7), (0, 9)),
        ({"y": 1, "height": 2}, (1, 3), (0, 9)),
    ],
)
def test_pixels_of_the_rectangle(part, rows, columns):
    np.testing.assert_array_equal(crop_image(PICTURE, **part), PICTURE[slice(*rows), slice(*columns)])


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ({"x": 9}, "x: expected less than the picture's width of 9, got 9"),
        ({"y": 5, "height": 3}, "height: expected at most 2 from y 5 on, got 3"),
        ({"width": 10}, "width: expected at most 9 from x 0 on, got 10"),
    ],
)
def test_over_the_border(part, message):
    with pytest.raises(ValueError, match=message):
        crop_image(PICTURE, **part)
