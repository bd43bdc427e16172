import numpy as np
from scipy.ndimage import gaussian_filter

from graphtex import Context
from graphtex_nodes.numerics.request import Scales, pose


def test_noise_of_a_map_leaves_no_part_unwanted():
    """A flat target: of a plane only one line is wanted, of noise of 5 %, which counts a tenth, nearly all alike."""
    rng = np.random.default_rng(2)
    exemplar = rng.random((60, 200, 3)).astype(np.float32)
    smooth = gaussian_filter(rng.standard_normal((60, 200)), 8)
    plane = np.linspace(-0.1, 0.1, 200) * np.ones((60, 1))
    told = []
    least = []
    for log in (plane, 0.05 * smooth / smooth.std()):
        maps = Scales(np.exp(log).astype(np.float32), np.ones((80, 80), np.float32), 1.0, True)
        problem = pose(exemplar, (80, 80), maps, Context(on_warning=told.append))
        np.testing.assert_allclose(problem.importance.mean(), 1, rtol=1e-5)
        least.append(problem.importance.min())
    assert least[0] < 0.1
    assert least[1] > 0.8
    assert len(told) == 1
