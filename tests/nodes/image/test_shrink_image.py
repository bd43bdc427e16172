"""Pictures made smaller."""

from pathlib import Path

import numpy as np
import pytest

from graphtex_nodes import load_image, shrink_image
from graphtex_nodes.image.save import save_image


def noise(height: int, width: int, channels: int = 3) -> np.ndarray:
    return np.random.default_rng(height * width).random((height, width, channels), np.float32)


def test_whole_factors_are_means_of_blocks():
    image = noise(12, 18)
    blocks = image.reshape(4, 3, 6, 3, 3).mean(axis=(1, 3))
    np.testing.assert_allclose(shrink_image(image, longest=6), blocks, atol=1.01 / 65535)


def test_pixels_covered_in_part_count_by_that_part():
    """Three pixels to two: each takes one and a half."""
    image = np.array([0.0, 0.6, 0.9], np.float32).reshape(1, 3, 1)
    np.testing.assert_allclose(shrink_image(image, longest=2).ravel(), [0.2, 0.8], atol=1 / 65535)


@pytest.mark.parametrize("size", [(7, 5), (1, 301), (301, 1), (64, 63), (2, 2)])
@pytest.mark.parametrize("channels", [1, 4, 16])
def test_any_size(size: tuple[int, int], channels: int):
    image = noise(*size, channels)
    for longest in (1, 4, 13):
        small = shrink_image(image, longest=longest)
        assert max(small.shape[:2]) == min(longest, max(size))
        assert image.min() <= small.min() <= small.max() <= image.max()


def test_small_pictures_stay():
    image = noise(9, 12)
    for longest in (0, 12, 200):
        np.testing.assert_array_equal(shrink_image(image, longest=longest), image)


def test_constant_and_unbounded_pictures():
    assert np.unique(shrink_image(np.full((50, 37, 1), 0.4, np.float32), longest=11)).size == 1
    wide = noise(20, 30) * 40 - 10
    np.testing.assert_allclose(
        shrink_image(wide, longest=15), wide.reshape(10, 2, 15, 2, 3).mean(axis=(1, 3)), atol=1e-4
    )


def test_a_16_bit_file_holds_the_result(tmp_path: Path):
    small = shrink_image(noise(40, 60), longest=23)
    save_image(small, tmp_path / "small.png", depth=16)
    np.testing.assert_array_equal(load_image(path=tmp_path / "small.png"), small)
