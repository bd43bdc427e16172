import numpy as np

from graphtex_nodes.perspective.view_scale import view_scale


def test_grey_128_is_one():
    grey = view_scale(np.array([[1.0, 0.5, 0.125], [1.5, 1.9921875, 8.0]], np.float32))
    assert grey.shape == (2, 3, 1)
    np.testing.assert_allclose(grey[..., 0] * 255, [[128, 64, 16], [192, 255, 255]], rtol=1e-6)
