import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.image.exemplars.bricks import bricks
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.image.exemplars.woven_cloth import woven_cloth
from graphtex_nodes.perspective._hole_scale import measured_scale, slope_of

Y, X = np.mgrid[:192, :192]
HOLE = np.hypot(Y - 100, X - 80) < 40


def blanked(picture):
    return np.where(HOLE[..., None], picture[~HOLE].mean(axis=0), picture).astype(np.float32)


@pytest.mark.parametrize("kind", [pebbles, woven_cloth, bricks])
def test_slope_is_told_by_what_is_around(kind):
    """Within a tenth, whatever the elements are."""
    made = kind(width=192, height=192, size=14.0, slant=55.0, rng=0)
    truth = slope_of(made.scale, HOLE)
    found = slope_of(measured_scale(blanked(made.image), HOLE, False, Context(threads=1)), HOLE)
    assert found.down == pytest.approx(truth.down, rel=0.1)
    assert abs(found.right) < 0.1 * truth.down


def test_noise_and_plain_colour_are_flat():
    noise = np.random.default_rng(5).random((192, 192, 1)).astype(np.float32)
    for picture in (noise, np.full((192, 192, 3), 0.5, np.float32)):
        assert slope_of(measured_scale(blanked(picture), HOLE, False, Context(threads=1)), HOLE).flat
