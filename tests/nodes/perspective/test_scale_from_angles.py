import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex import Context
from graphtex_nodes.perspective.resize_scale import resize_scale
from graphtex_nodes.perspective.scale_from_angles import scale_from_angles
from tests.truth import rendered_plane


def test_worked_by_hand():
    """Three pixels, slant 60: the ends are cos 60 and 1/cos 60, the middle their mean."""
    np.testing.assert_allclose(scale_from_angles(width=1, height=3, slant=60.0)[:, 0], [0.5, 1.25, 2.0])


def test_worked_by_hand_with_a_camera():
    """View 90 over three pixels: f = 1.5. tan(slant) = 1 and Y = 1, so k = 2/3, and the ends are as 1 to 5."""
    scale = scale_from_angles(width=1, height=3, slant=45.0, field_of_view=90.0)[:, 0]
    np.testing.assert_allclose(scale, [5**-0.5, 3 * 5**-0.5, 5**0.5], rtol=1e-6)


def test_ends_of_the_paper():
    """Slant 55 without a camera: 1/cos² = 3.04; with one of 45 degrees the rays see 3.9."""
    without = scale_from_angles(width=256, height=256, slant=55.0)
    seen = scale_from_angles(width=256, height=256, slant=55.0, field_of_view=45.0)
    assert without.max() / without.min() == pytest.approx(3.04, abs=0.005)
    assert seen.max() / seen.min() == pytest.approx(3.9, abs=0.05)


def test_line_across_the_tilt_is_flat():
    assert np.all(scale_from_angles(width=3, height=1, slant=60.0, tilt=180.0) == 1)


def test_face_on_is_flat():
    assert np.all(scale_from_angles(width=5, height=4, slant=0.0, field_of_view=60.0) == 1)


@pytest.mark.parametrize("tilt", [0.0, 30.0, -75.0, 135.0])
def test_linear_in_the_rendered_plane(tilt):
    """A second method: inverse depth by ray casting is an affine function of the map."""
    truth = rendered_plane(64, slant=50.0, tilt=tilt, field_of_view=40.0)
    scale = scale_from_angles(width=64, height=64, slant=50.0, tilt=tilt)
    assert np.corrcoef(scale.ravel(), truth.ravel())[0, 1] > 0.99999


@pytest.mark.parametrize(("tilt", "size"), [(0.0, (48, 48)), (60.0, (30, 50)), (-130.0, (50, 30))])
def test_with_a_camera_it_is_the_rendered_plane(tilt, size):
    """The same, to the number, once the field of view is known."""
    truth = rendered_plane(size, slant=45.0, tilt=tilt, field_of_view=40.0)
    scale = scale_from_angles(width=size[1], height=size[0], slant=45.0, tilt=tilt, field_of_view=40.0)
    np.testing.assert_allclose(scale, truth, rtol=1e-5)


def test_a_wrong_tilt_shows():
    """How much a tilt that is off by 10, 20 and 30 degrees costs in correlation with the truth."""
    truth = rendered_plane(96, slant=50.0, tilt=20.0, field_of_view=40.0).ravel()
    found = [
        np.corrcoef(scale_from_angles(width=96, height=96, slant=50.0, tilt=20.0 + off).ravel(), truth)[0, 1]
        for off in (10.0, 20.0, 30.0)
    ]
    np.testing.assert_allclose(found, np.cos(np.radians([10, 20, 30])), atol=1e-3)


def test_mirror_and_flip():
    plain = scale_from_angles(width=7, height=5, slant=50.0, tilt=35.0)
    np.testing.assert_allclose(scale_from_angles(width=7, height=5, slant=50.0, tilt=35.0, mirror=True), plain[:, ::-1])
    np.testing.assert_allclose(scale_from_angles(width=7, height=5, slant=50.0, tilt=35.0, flip=True), plain[::-1])
    np.testing.assert_allclose(
        scale_from_angles(width=7, height=5, slant=50.0, tilt=-35.0), plain[:, ::-1], rtol=1e-6
    )  # a mirrored map is the map of the mirrored tilt


@given(w=st.integers(1, 40), h=st.integers(1, 40), slant=st.floats(0, 89), tilt=st.floats(-180, 180))
def test_stays_in_range(w, h, slant, tilt):
    told = []
    scale = scale_from_angles(width=w, height=h, slant=slant, tilt=tilt, ctx=Context(on_warning=told.append))
    assert not told or slant > 82.8
    bound = min(1 / np.cos(np.radians(slant)), 8) * (1 + 1e-6)
    assert scale.shape == (h, w)
    assert scale.min() >= 1 / bound
    assert scale.max() <= bound


def test_tells_what_is_clamped():
    """At slant 84 a column falls evenly from 9.6 to 0.1: a sixth of it is above 8, and its last three pixels below 1/8."""
    told = []
    scale = scale_from_angles(width=3, height=1001, slant=84.0, ctx=Context(on_warning=told.append))
    assert (scale.min(), scale.max()) == (1 / 8, 8)
    assert told == ["slant: 16.9% of the scales lie outside [1/8, 8] and are clamped: a smaller slant has fewer"]


@pytest.mark.parametrize(
    "wrong", [{"slant": 90.0}, {"slant": -1.0}, {"width": 0}, {"tilt": 181.0}, {"field_of_view": 180.0}]
)
def test_refuses(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        scale_from_angles(**{"width": 4, "height": 4, **wrong})


@pytest.mark.parametrize(("slant", "tilt"), [(61.0, 0.0), (52.0, 45.0)])
def test_horizon(slant, tilt):
    """At view 60 the horizon enters at slant 60 for tilt 0, and earlier where the tilt points into a corner."""
    with pytest.raises(ValueError, match="horizon is in the picture"):
        scale_from_angles(width=200, height=200, slant=slant, tilt=tilt, field_of_view=60.0)
    assert scale_from_angles(width=200, height=200, slant=45.0, tilt=0.0, field_of_view=60.0).min() > 0.4


def test_resized_it_is_the_same_plane():
    small = scale_from_angles(width=9, height=7, slant=50.0, tilt=0.0)
    np.testing.assert_allclose(
        resize_scale(small, width=40, height=31), scale_from_angles(width=40, height=31, slant=50.0), rtol=1e-6
    )


def test_takes_the_size_of_a_picture():
    image = np.zeros((5, 9, 3), np.float32)
    np.testing.assert_array_equal(scale_from_angles(image, tilt=20.0), scale_from_angles(width=9, height=5, tilt=20.0))
    assert scale_from_angles(image, height=7).shape == (7, 9)


def test_needs_a_size():
    with pytest.raises(ValueError, match="height: expected at least 1 pixel, or an image"):
        scale_from_angles(width=4)
