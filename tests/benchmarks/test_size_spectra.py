"""Sizes by spectra: textures whose sizes are known to the pixel, in noise and in other light."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from benchmarks.size_spectra import relative_slope


def drawn(height, scales, seed, *, receding=False):
    """Smooth noise (height, 256, 1) whose grain goes as the scale along rows, or as its square down the columns."""
    scale = np.linspace(*scales, height)
    noise = gaussian_filter1d(np.random.default_rng(seed).standard_normal((256, 4096)), 4.0, axis=1)
    if receding:
        places = np.cumsum(1 / scale**2)
        image = np.stack([np.interp(places, np.arange(4096), column) for column in noise], axis=1)
    else:
        rows = noise[np.arange(height) % 256]
        image = np.stack(
            [np.interp(np.arange(256) / s, np.arange(4096), row) for s, row in zip(scale, rows, strict=True)]
        )
    return image[..., None].astype(np.float32), np.repeat(scale[:, None], 256, axis=1).astype(np.float32)


@pytest.mark.parametrize("receding", [False, True])
def test_a_larger_picture_of_the_same_plane_has_the_same_slope(receding):
    exemplar, own = drawn(256, (0.7, 1.4), 0, receding=receding)
    larger, target = drawn(512, (0.7, 1.4), 1, receding=receding)
    bent, _ = drawn(512, (0.7**0.5, 1.4**0.5), 2, receding=receding)
    even, _ = drawn(512, (1.0, 1.0), 3, receding=receding)
    found = [relative_slope(image, target, exemplar, own, receding=receding) for image in (larger, bent, even)]
    np.testing.assert_allclose(found, [1, 0.5, 0], atol=0.12)


def test_light_and_contrast_do_not_count():
    exemplar, own = drawn(256, (0.7, 1.4), 0)
    larger, target = drawn(512, (0.7, 1.4), 1)
    lit = larger * np.linspace(3, 0.5, 512)[:, None, None] + np.linspace(-5, 5, 256)[:, None]
    found = relative_slope(lit, target, exemplar, own)
    assert found == pytest.approx(relative_slope(larger, target, exemplar, own), abs=0.03)
