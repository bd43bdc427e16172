import numpy as np

from graphtex_nodes.numerics.principal import principal_channel


def test_principal_channel_of_one_channel_is_that_channel_less_its_mean():
    image = np.random.default_rng(2).random((5, 4, 1), np.float32)
    np.testing.assert_allclose(principal_channel(image), image[..., 0] - image.mean(), atol=1e-6)


def test_brighter_is_larger():
    image = np.random.default_rng(3).random((20, 20, 1), np.float32) * np.array([0.2, 0.9, 0.4], np.float32)
    assert np.corrcoef(principal_channel(image).ravel(), image.mean(axis=2).ravel())[0, 1] > 0.999
