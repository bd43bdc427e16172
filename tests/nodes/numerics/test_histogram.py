import numpy as np
import pytest

from graphtex_nodes.numerics.histogram import BINS, SEEN_PIXELS, Histograms


def test_weights_by_hand():
    """Half of the exemplar in the first bin, three quarters of the image: surplus 0.25 over 0.5 + 1 / (8 bins)."""
    exemplar = np.array([[0, 0, 1, 1]], np.float32)[..., None]
    image = np.array([[0, 0, 0, 1]], np.float32)[..., None]
    weights = Histograms(exemplar, np.ones((1, 4), np.float32)).pixel_weights(image, gain=4.0)
    low = 1 / (1 + 4 * 0.25 / (0.5 + 1 / (8 * BINS)))
    np.testing.assert_allclose(weights, [[low, low, 1, 1]], rtol=1e-6)


def test_importance_moves_the_wanted_histogram():
    """With three quarters of the wish on the low pixels, three quarters of low pixels are no surplus."""
    exemplar = np.array([[0, 0, 1, 1]], np.float32)[..., None]
    image = np.array([[0, 0, 0, 1]], np.float32)[..., None]
    importance = np.array([[1.5, 1.5, 0.5, 0.5]], np.float32)
    assert (Histograms(exemplar, importance).pixel_weights(image, gain=4.0) == 1).all()


def test_without_gain_or_without_variation():
    exemplar = np.full((3, 3, 1), 0.5, np.float32)
    ones = np.ones((3, 3), np.float32)
    assert (Histograms(exemplar, ones).pixel_weights(exemplar, 8.0) == 1).all()
    exemplar = np.random.default_rng(0).random((3, 3, 1)).astype(np.float32)
    assert (Histograms(exemplar, ones).pixel_weights(exemplar * 0, 0.0) == 1).all()


@pytest.mark.parametrize(("side", "period"), [(510, 3), (555, 5)])
def test_part_of_a_large_image_shows_all_columns(side, period):
    """Some columns are bright: a part that saw too many or too few of them would find a surplus."""
    image = np.zeros((side, side, 1), np.float32)
    image[:, ::period] = 1
    assert image.size > 3 * SEEN_PIXELS
    exemplar = np.eye(1, period, dtype=np.float32)[..., None]
    weights = Histograms(exemplar, np.ones((1, period), np.float32)).pixel_weights(image, gain=20.0)
    np.testing.assert_allclose(weights, 1, atol=0.01)
