import numpy as np
import pytest

from graphtex_nodes import appearance_vectors, sample
from graphtex_nodes.numerics.appearance import gaussian_weights


def neighbourhoods(image):
    """Weighted 5 x 5 neighbourhoods (h * w, 25 c), one pixel after the other."""
    padded = np.pad(image, ((2, 2), (2, 2), (0, 0)), mode="symmetric").astype(np.float64)
    weights = gaussian_weights()[..., None]
    height, width = image.shape[:2]
    rows = [(padded[i : i + 5, j : j + 5] * weights).ravel() for i in range(height) for j in range(width)]
    return np.array(rows)


def test_against_lapack():
    """A second method: eigenvectors of all neighbourhoods' covariance, up to each channel's sign."""
    image = sample(name="oranges")[:40, :50]
    found, kept = appearance_vectors(image, channels=4)
    rows = neighbourhoods(image)
    rows -= rows.mean(axis=0)
    values, vectors = np.linalg.eigh(rows.T @ rows / len(rows))
    expected = rows @ vectors[:, ::-1][:, :4]
    for channel in range(4):
        correlation = np.corrcoef(found[..., channel].ravel(), expected[:, channel])[0, 1]
        assert abs(correlation) > 0.999
    assert kept == pytest.approx(values[-4:].sum() / values.sum(), abs=1e-6)


def test_eight_channels_keep_most():
    assert 0.9 < appearance_vectors(sample(name="leaves")).kept <= 1


def test_distances_of_neighbourhoods_stay():
    image = sample(name="tiles")[:24, :24]
    vectors = appearance_vectors(image, channels=16).appearance.reshape(-1, 16)
    rows = neighbourhoods(image)
    pairs = np.random.default_rng(1).integers(0, len(rows), (200, 2))
    true, found = (np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1) for x in (rows, vectors))
    assert np.corrcoef(true, found)[0, 1] > 0.99


@pytest.mark.parametrize("shape", [(1, 1, 1), (3, 7, 2), (6, 5, 16)])
def test_small_pictures(shape):
    image = np.random.default_rng(2).random(shape).astype(np.float32)
    appearance = appearance_vectors(image).appearance
    assert appearance.shape[:2] == shape[:2]
    assert np.isfinite(appearance).all()


def test_constant_picture_has_one_channel_of_zeros():
    appearance, kept = appearance_vectors(np.full((9, 8, 3), 0.4, np.float32))
    assert appearance.shape == (9, 8, 1)
    assert np.abs(appearance).max() < 1e-6
    assert kept == 1
