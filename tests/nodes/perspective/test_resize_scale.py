import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex_nodes.perspective.resize_scale import resize_scale


def test_borders_are_aligned():
    """Corners stay, halves lie half-way."""
    scale = np.array([[0.5, 1.5], [1.0, 4.0]], np.float32)
    np.testing.assert_allclose(resize_scale(scale, width=3, height=3), [[0.5, 1, 1.5], [0.75, 1.75, 2.75], [1, 2.5, 4]])


def test_own_size_changes_nothing():
    scale = np.random.default_rng(0).uniform(0.2, 4, (7, 11)).astype(np.float32)
    np.testing.assert_array_equal(resize_scale(scale, width=11, height=7), scale)


def test_one_pixel_takes_the_middle():
    assert resize_scale(np.array([[1.0, 2.0, 4.0]], np.float32), width=1, height=1) == [[2.0]]


def test_there_and_back():
    """Twice as many intervals and back again lose nothing."""
    scale = np.random.default_rng(1).uniform(0.2, 4, (5, 6)).astype(np.float32)
    np.testing.assert_allclose(
        resize_scale(resize_scale(scale, width=11, height=9), width=6, height=5), scale, rtol=1e-6
    )


@given(w=st.integers(1, 30), h=st.integers(1, 30), rows=st.integers(1, 6), columns=st.integers(1, 6))
def test_keeps_the_range(w, h, rows, columns):
    scale = np.random.default_rng(rows * 7 + columns).uniform(0.125, 8, (rows, columns)).astype(np.float32)
    found = resize_scale(scale, width=w, height=h)
    assert found.shape == (h, w)
    assert found.min() >= scale.min()
    assert found.max() <= scale.max()


def test_refuses_no_pixels():
    with pytest.raises(ValueError, match="width"):
        resize_scale(np.ones((2, 2), np.float32), width=0, height=2)
