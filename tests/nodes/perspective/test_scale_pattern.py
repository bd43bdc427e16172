import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex import Context
from graphtex_nodes.perspective.scale_from_angles import scale_from_angles
from graphtex_nodes.perspective.scale_pattern import scale_from_image, scale_pattern


def test_ramp_worked_by_hand():
    np.testing.assert_allclose(scale_pattern(width=3, height=1, angle=90, low=0.25, high=4)[0], [4, 1, 0.25])
    np.testing.assert_allclose(
        scale_pattern(width=3, height=1, angle=90, low=1, high=4, spacing="linear")[0], [4, 2.5, 1]
    )


def test_linear_ramp_is_a_plane():
    """Slant 60 in the paper's convention: a plane's scales from 1/2 to 2."""
    plane = scale_from_angles(width=20, height=13, slant=60, tilt=25)
    ramp = scale_pattern(width=20, height=13, low=0.5, high=2, angle=25, spacing="linear")
    np.testing.assert_allclose(ramp, plane, atol=1e-6)


def test_radial_worked_by_hand():
    scale = scale_pattern(pattern="radial", width=5, height=1, low=0.25, high=4)
    np.testing.assert_allclose(scale[0], [0.25, 1, 4, 1, 0.25])


def test_waves_worked_by_hand():
    scale = scale_pattern(pattern="waves", waves=1, width=5, height=1, angle=90, low=0.25, high=4)
    np.testing.assert_allclose(scale[0], [0.25, 1, 4, 1, 0.25])


def test_s_curve_is_an_s():
    """From the top: through the middle, left of it, through the middle, right of it, through the middle."""
    scale = scale_pattern(pattern="s_curve", width=81, height=81)
    rows = [0, 20, 40, 60, 80]
    np.testing.assert_array_equal(scale[rows].argmax(axis=1), [40, 20, 40, 60, 40])
    np.testing.assert_allclose(scale[rows].max(axis=1), 2)
    assert scale.min() == pytest.approx(0.5)
    turned = scale_pattern(pattern="s_curve", width=81, height=81, angle=180)
    np.testing.assert_allclose(turned, scale, atol=1e-5)  # an S upside down is an S


@given(
    pattern=st.sampled_from(["ramp", "radial", "s_curve", "waves"]),
    width=st.integers(1, 40),
    height=st.integers(1, 40),
    ends=st.tuples(st.floats(0.125, 8), st.floats(0.125, 8)),
    angle=st.floats(-360, 360),
    spacing=st.sampled_from(["log", "linear"]),
)
def test_stays_in_range(pattern, width, height, ends, angle, spacing):
    scale = scale_pattern(
        pattern=pattern, width=width, height=height, low=ends[0], high=ends[1], angle=angle, spacing=spacing
    )
    assert scale.shape == (height, width)
    assert scale.min() >= min(ends) * (1 - 1e-6)
    assert scale.max() <= max(ends) * (1 + 1e-6)


def test_picture_worked_by_hand():
    grey = np.array([[[0.0], [0.25], [1.0]]], np.float32)
    np.testing.assert_allclose(scale_from_image(grey, low=0.25, high=4)[0], [0.25, 0.5, 4])
    np.testing.assert_allclose(scale_from_image(grey, low=1, high=5, spacing="linear")[0], [1, 2, 5])
    np.testing.assert_allclose(scale_from_image(grey, low=4, high=0.25)[0], [4, 2, 0.25])


def test_picture_of_several_channels_stretched():
    picture = np.zeros((1, 3, 3), np.float32)
    picture[0, :, 0] = [0.3, 0.6, 0.9]
    np.testing.assert_allclose(scale_from_image(picture, stretch=True, low=0.25, high=4)[0], [0.25, 1, 4], rtol=1e-6)
    flat = np.full((2, 2, 1), 0.9, np.float32)
    np.testing.assert_allclose(scale_from_image(flat, stretch=True, low=0.5, high=2), 1)


def test_picture_beyond_the_range_is_told():
    told = []
    scale = scale_from_image(np.array([[[-1.0], [0.5], [0.5], [3.0]]], np.float32), ctx=Context(on_warning=told.append))
    np.testing.assert_allclose(scale[0], [0.5, 1, 1, 2])
    assert told == ["50.0% of the picture lies outside [0, 1] and was clamped: stretch fits it in"]


@pytest.mark.parametrize("wrong", [{"low": 0.1}, {"high": 9.0}, {"pattern": "spiral"}, {"width": 0}])
def test_refuses(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        scale_pattern(**{"width": 4, "height": 4, **wrong})
