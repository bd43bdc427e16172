import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex_nodes.numerics.pyramid import halve, level_size, masked_pyramid, pyramid


def test_worked_by_hand():
    """(1 3 3 1) / 8 around pixels 0 and 1, around 2 and 3; borders repeated."""
    row = np.array([[8, 0, 0, 16]], np.float32)
    np.testing.assert_allclose(halve(row), [[(8 + 24 + 0 + 0) / 8, (0 + 0 + 48 + 16) / 8]])
    np.testing.assert_allclose(halve(row.T).T, halve(row))


def test_straight_ramp_stays_between_its_pixels():
    """Pixel i lies over 2i and 2i + 1: of a ramp it is their mean, off the border."""
    ramp = np.tile(np.arange(10, dtype=np.float32), (3, 1))
    np.testing.assert_allclose(halve(ramp)[0, 1:-1], [2.5, 4.5, 6.5])


@given(h=st.integers(1, 40), w=st.integers(1, 40), levels=st.integers(1, 5))
def test_sizes_and_constants(h, w, levels):
    images = pyramid(np.full((h, w, 2), 0.25, np.float32), levels)
    assert [image.shape for image in images] == [(level_size(h, n), level_size(w, n), 2) for n in range(levels)]
    assert all((image == 0.25).all() and image.flags.c_contiguous for image in images)


@pytest.mark.parametrize(("size", "level", "expected"), [(256, 4, 16), (5, 1, 3), (5, 2, 2), (1, 9, 1)])
def test_level_size(size, level, expected):
    assert level_size(size, level) == expected


def test_masked_pixels_leave_no_trace():
    """Where only True pixels differ from others, means are those of the True ones."""
    mask = np.zeros((16, 16), bool)
    mask[:, :8] = True
    image = np.where(mask, np.float32(0.25), np.float32(77))
    values, masks = masked_pyramid(image, mask, 3)
    for level in range(3):
        np.testing.assert_array_equal(masks[level][:, : 8 >> level], True)
        assert not masks[level][:, (8 >> level) + 1 :].any()
        np.testing.assert_allclose(values[level][masks[level]], 0.25, rtol=1e-6)
