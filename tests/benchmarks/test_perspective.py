"""Truths that the perspective benchmark rests on."""

import numpy as np
import pytest

from benchmarks import perspective
from graphtex_nodes.numerics.measures import scale_slope


@pytest.mark.parametrize("name", perspective.SYNTHESISED)
def test_slope_tells_these_exemplars_well(name):
    """From 0, elements of one size, each kind keeps a distance that three pictures resolve."""
    kind, tilt = perspective.SYNTHESISED[name]
    planes = [perspective.plane(kind, tilt, seed) for seed in perspective.SEEDS]
    assert min(scale_slope(each.image, each.scale) for each in planes) > 0.4


def test_plane_doubles_scales():
    kind, tilt = perspective.SYNTHESISED["bricks"]
    found = perspective.plane(kind, tilt, 1)
    assert found.truth.shape == found.wanted.shape == (512, 512)
    # tilted by 90 degrees the far side is on the right, and columns have (nearly) one scale
    assert (np.diff(found.truth.mean(axis=0)) < 0).all()
    assert np.corrcoef(found.truth[::2, ::2].ravel(), found.scale.ravel())[0, 1] > 0.999


def test_correlation_of_a_picture_that_is_its_own_source():
    kind, tilt = perspective.SYNTHESISED["pebbles"]
    exemplar = perspective.plane(kind, tilt, 1)
    rows, columns = np.mgrid[:512, :512] // 2
    source = np.dstack([np.zeros((512, 512)), rows, columns, *np.zeros((3, 512, 512))])
    upside_down = source.copy()
    upside_down[..., 1] = source[::-1, :, 1]

    class Result:
        pass

    Result.source = source
    assert perspective.correlation(Result, exemplar) > 0.999
    Result.source = upside_down
    assert perspective.correlation(Result, exemplar) < -0.8
