import numpy as np

from graphtex_nodes.numerics.principal import principal_channels


def test_principal_channel_of_one_channel_is_that_channel_less_its_mean():
    image = np.random.default_rng(2).random((5, 4, 1), np.float32)
    np.testing.assert_allclose(principal_channels(image, 1.0)[0], image[..., 0] - image.mean(), atol=1e-6)


def test_brighter_is_larger():
    image = np.random.default_rng(3).random((20, 20, 1), np.float32) * np.array([0.2, 0.9, 0.4], np.float32)
    assert np.corrcoef(principal_channels(image, 1.0)[0].ravel(), image.mean(axis=2).ravel())[0, 1] > 0.999


def test_components_are_uncorrelated_and_sorted():
    noise = np.random.default_rng(5).standard_normal((30, 20, 3)) @ np.array([[3.0, 1, 0], [0, 1, 0], [0, 0.5, 0.2]])
    found = principal_channels(noise, 0.0).reshape(3, -1)
    covariance = found @ found.T / found.shape[1]
    np.testing.assert_allclose(covariance, np.diag(np.diag(covariance)), atol=1e-9)
    assert np.all(np.diff(np.diag(covariance)) < 0)
    np.testing.assert_allclose(np.trace(covariance), noise.var(axis=(0, 1)).sum())


def test_faint_components_are_left_out():
    grey = np.random.default_rng(6).random((9, 8, 1))
    assert principal_channels(grey * np.ones(3), 0.003).shape == (1, 9, 8)
