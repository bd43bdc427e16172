import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex import Context
from graphtex_nodes.numerics.local_spectra import local_spectra, to_plane_frequencies
from graphtex_nodes.numerics.plane import Plane, seen_plane, slant_of

PLANE = Plane(200, 160, 35.0, 1.0, 1.0, 0.004)


def test_frequencies_against_finite_differences():
    """The phase of a wave on the plane, at two places of the picture that are near each other."""
    across, along, wave = 31.0, -22.0, (0.07, -0.05)
    scale = PLANE.scale_at(np.array(along))

    def phase(b, a):
        u, v = PLANE.to_plane(np.array(b), np.array(a))
        return u * wave[0] + v * wave[1]

    step = 1e-4
    k_across = (phase(across + step, along) - phase(across - step, along)) / (2 * step)
    k_along = (phase(across, along + step) - phase(across, along - step)) / (2 * step)
    np.testing.assert_allclose(to_plane_frequencies(PLANE, across, scale, k_across, k_along), wave, rtol=1e-6)


def test_a_wave_on_the_plane_has_one_frequency_there():
    """In the picture it has another everywhere; taken back, the strongest sample of each window is the wave."""
    x, y = np.meshgrid(np.arange(200.0), np.arange(160.0))
    u, v = PLANE.to_plane(*PLANE.rotate(x, y))
    wave = np.array([0.10, 0.07])
    picture = np.sqrt(2) * np.cos(2 * np.pi * (u * wave[0] + v * wave[1]))
    spectra = local_spectra(picture[None], PLANE, None, Context())
    across, along = PLANE.rotate(spectra.x, spectra.y)
    sin, cos = np.sin(np.radians(35.0)), np.cos(np.radians(35.0))
    for window in range(spectra.count):
        mine = spectra.window == window
        best = np.argmax(np.where(mine, spectra.power, -np.inf))
        k_across = spectra.right[best] * cos + spectra.down[best] * sin
        k_along = spectra.right[best] * sin - spectra.down[best] * cos
        found = to_plane_frequencies(
            PLANE, across[window], PLANE.scale_at(along[window]), k_across, k_along
        )  # fmt: skip
        assert np.hypot(*found) == pytest.approx(np.hypot(*wave), rel=0.15)
    assert spectra.count > 30


def test_windows_keep_to_what_is_usable():
    usable = np.zeros((160, 200), bool)
    usable[:, 100:] = True
    noise = np.random.default_rng(0).standard_normal((160, 200))
    spectra = local_spectra(noise[None], PLANE, usable, Context())
    assert 0 < spectra.count < local_spectra(noise[None], PLANE, None, Context()).count
    assert spectra.x.min() > 100


@given(slant=st.floats(1, 70), tilt=st.floats(-180, 180), view=st.sampled_from([None, 10.0, 25.0]))
def test_slant_of_a_seen_plane(slant, tilt, view):
    plane = seen_plane(50, 70, slant, tilt, view)
    assert slant_of(50, 70, tilt, plane.steepness, view) == pytest.approx(slant, abs=1e-6)
