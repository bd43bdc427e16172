import numpy as np
import pytest

from graphtex_nodes.image.exemplars.bricks import bricks
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.numerics.measures import (
    element_sizes,
    patch_distance,
    scale_slope,
    seam_energy,
    source_scale_correlation,
)
from tests.truth import rendered_plane


def stripes(scale, period):
    """Stripes at right angles to the rows whose period at each row is `period` times the row's scale."""
    x = np.arange(scale.shape[1]) - scale.shape[1] / 2
    wave = np.sin(2 * np.pi * x / (period * scale) + 1.0)
    return np.repeat(wave[..., None], 3, axis=2) * 0.5 + 0.5


def test_size_of_stripes_is_known():
    """A sine crosses its median twice a period."""
    scale = np.geomspace(0.5, 2, 192)[:, None] * np.ones(192)
    scales, sizes = element_sizes(stripes(scale, 8.0), scale)
    np.testing.assert_allclose(sizes, 4 * scales, rtol=0.12)
    assert scale_slope(stripes(scale, 8.0), scale) == pytest.approx(1, abs=0.08)


def test_even_stripes_have_no_slope():
    scale = np.geomspace(0.5, 2, 128)[:, None] * np.ones(128)
    assert abs(scale_slope(stripes(np.ones_like(scale), 8.0), scale)) < 0.02


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_direction_follows_the_scale(turns):
    """Turned by quarters, picture and scale give the same slope."""
    scale = np.geomspace(0.5, 2, 96)[:, None] * np.ones(96)
    image = stripes(scale, 8.0)
    expected = scale_slope(image, scale)
    assert scale_slope(np.rot90(image, turns), np.rot90(scale, turns)) == pytest.approx(expected, abs=0.06)


def test_seam_energy_by_hand():
    """Columns 0, 1, 3, 4: steps of 1, 2, 1 inside and of 4 over the border; rows are all alike."""
    image = np.tile(np.float32([0, 1, 3, 4]), (3, 1))[..., None]
    assert seam_energy(image, 1) == (1.0, 4.0)
    assert seam_energy(image, 0) == (0.0, 0.0)
    assert seam_energy(np.float32([0, 2, 1, 1]).reshape(1, 4, 1), 1) == (1 / 3, 1 / 4)
    assert seam_energy(image[:1, :1], 0) == (0.0, 0.0)


def test_slope_of_an_exemplar_and_of_its_blocks():
    """A plane in perspective scores about 0.55, its blocks tossed together, or noise, about 0."""
    rng = np.random.default_rng(0)
    true, tossed = [], []
    for seed in (0, 1):
        image, scale, _ = pebbles(slant=55.0, rng=seed, size=18.0)
        blocks = image.reshape(8, 32, 8, 32, 3).swapaxes(1, 2).reshape(64, 32, 32, 3)[rng.permutation(64)]
        true.append(scale_slope(image, scale))
        tossed.append(scale_slope(blocks.reshape(8, 8, 32, 32, 3).swapaxes(1, 2).reshape(256, 256, 3), scale))
    assert 0.45 < np.mean(true) < 0.75
    assert abs(np.mean(tossed)) < 0.15
    assert abs(scale_slope(rng.random((128, 128, 1)), rendered_plane(128, 50.0))) < 0.12


def test_constant_scale_has_no_direction():
    with pytest.raises(ValueError, match="scale: expected a map that changes"):
        scale_slope(np.random.default_rng(0).random((32, 32, 1)), np.ones((32, 32)))


def test_a_flat_picture_has_no_elements():
    with pytest.raises(ValueError, match="at least two bands"):
        scale_slope(np.full((48, 48, 3), 0.5), rendered_plane(48, 45.0))


def test_correlation_of_source_scales_by_hand():
    """Sources of scale 1, 2, 3, 4: in order 1, reversed -1, and doubled resampling makes up for half the scale."""
    scales = [np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[0.5, 1.0], [1.5, 2.0]])]
    target = np.array([[1.0, 2.0], [3.0, 4.0]])
    source = np.zeros((2, 2, 6), np.float32)
    source[..., 1:3] = np.stack(np.mgrid[:2, :2], axis=-1)
    assert source_scale_correlation(source, scales, target) == pytest.approx(1)
    assert source_scale_correlation(source, scales, 5 - target) == pytest.approx(-1)
    source[1, :, 0], source[1, :, 3] = 1, 1  # the lower row from the second exemplar, shown at twice its size
    assert source_scale_correlation(source, scales, target) == pytest.approx(1)


def test_correlation_refuses_what_it_cannot_tell():
    source = np.zeros((2, 2, 6), np.float32)
    with pytest.raises(ValueError, match="vary on both sides"):
        source_scale_correlation(source, [np.ones((2, 2))], np.array([[1.0, 2], [3, 4]]))
    with pytest.raises(ValueError, match="target: expected the size"):
        source_scale_correlation(source, [np.ones((2, 2))], np.ones((3, 2)))


def test_patch_distance():
    """0 to itself; larger to another material than to another piece of its own."""
    one, two = (pebbles(width=128, height=128, size=12.0, rng=seed).image for seed in (1, 2))
    assert patch_distance(one, one) == 0
    assert patch_distance(two, one) < 0.5 * patch_distance(bricks(width=128, height=128).image, one)


def test_patch_distance_of_brightness():
    """A flat picture 0.1 brighter: patches project on the sum of each axis, whose mean size is sqrt(2 / pi)."""
    flat = np.full((64, 64, 1), 0.4)
    assert patch_distance(flat + 0.1, flat, directions=500) == pytest.approx(0.1 * np.sqrt(2 / np.pi), rel=0.1)


def test_patch_distance_refuses_small_pictures():
    with pytest.raises(ValueError, match="levels"):
        patch_distance(np.zeros((16, 16, 1)), np.zeros((16, 16, 1)))
