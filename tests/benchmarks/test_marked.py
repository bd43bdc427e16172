"""Marks by hand, and the scale maps that are made of them."""

import numpy as np
import pytest

from benchmarks.marked import MARKED, Marks, figures


def test_scale_goes_through_the_marks():
    """Sizes 10 and 30 at rows 0 and 20 are a line; over rows 5 to 15 it runs from 15 to 24, in proportion."""
    scale = Marks("none.png", 2, 5, 6, 15, {0: 10.0, 20: 30.0}).scale()
    assert scale.shape == (10, 4)
    np.testing.assert_allclose(scale[:, 0] / scale[0, 0], np.arange(15, 25) / 15, rtol=1e-6)
    assert scale[0, 0] * scale[-1, 0] == pytest.approx(1, rel=1e-6)


def test_thickness_goes_as_the_square_of_the_scale():
    scale = Marks("none.png", 0, 0, 2, 3, {0: 100.0, 2: 400.0}, receding=True).scale()
    np.testing.assert_allclose(scale[:, 0] / scale[0, 0], [1, 1.5, 2], rtol=1e-6)


@pytest.mark.parametrize("name", MARKED)
def test_marks_lie_on_a_line(name):
    """The scale of a plane is linear in its picture: no mark is off by more than a fifth."""
    rows, sizes = np.array(list(MARKED[name].sizes), float), MARKED[name].across()
    line = np.polyval(np.polyfit(rows, sizes, 1), rows)
    assert np.abs(sizes / line - 1).max() < 1 / 5


def test_a_folder_without_the_pictures(tmp_path, capsys):
    assert list(figures(None, tmp_path)) == []
    assert "perspective-pier.jpg is not in" in capsys.readouterr().err
