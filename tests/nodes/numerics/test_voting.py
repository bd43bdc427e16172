import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics.voting import robust_weights, vote_mean, vote_source, weighted_pixels, window_falloff

RNG = np.random.default_rng(9)


def shifted_field(rows, columns, step, down, right):
    row, column = np.mgrid[:rows, :columns]
    return np.stack([row * step + down, column * step + right], axis=-1).astype(np.int32)


def test_agreeing_windows_copy():
    exemplar = RNG.random((20, 20, 2)).astype(np.float32)
    field = shifted_field(4, 5, 2, down=3, right=1)
    image = np.empty((10, 12, 2), np.float32)
    weights = RNG.random((4, 5)).astype(np.float32) + 0.1
    weighted = weighted_pixels(exemplar, np.ones((20, 20), np.float32))
    vote_mean(field, weights, weighted, window_falloff(4, 1.0), 2, image, Context())
    np.testing.assert_allclose(image, exemplar[3:13, 1:13], atol=1e-6)
    source = vote_source(field, weights, exemplar, window_falloff(4, 1.0), 2, image, Context())
    np.testing.assert_array_equal(source, shifted_field(10, 12, 1, 3, 1))


def test_the_rim_is_not_copied():
    """Two rows of two windows of 2 x 2 pixels show an exemplar of 4 x 4 pixels in a rim of one.

    The last windows agree on row 3, but those of the first column lie on the rim in part: what nothing else proposes is
    the nearest pixel within.
    """
    exemplar = RNG.random((6, 6, 1)).astype(np.float32)
    field = np.array([[[0, 0], [1, 1]], [[3, 0], [3, 1]]], np.int32)
    image = np.zeros((3, 3, 1), np.float32)
    source = vote_source(field, np.ones((2, 2), np.float32), exemplar, np.ones((2, 2), np.float32), 1, image, Context(),
                         rim=1)  # fmt: skip
    assert source.min() >= 0
    assert source.max() <= 3
    assert source[0, 0].tolist() == [0, 0]  # proposed: (-1, -1) alone
    assert source[2, 0].tolist() == [3, 0]  # proposed: (3, -1) alone
    assert source[2].tolist() == [[3, 0], [3, 0], [3, 1]]


def test_weighted_mean_by_hand():
    """One row of two windows of two pixels, step 1: the middle pixel has weights 1 and 3, times 1 and 0.5."""
    exemplar = np.array([[[0.0], [8.0], [20.0]]], np.float32).repeat(2, axis=0)
    field = np.array([[[0, 0], [0, 1]]], np.int32)  # the middle pixel: exemplar pixels 1 and 1
    field[0, 1, 1] = 0  # now 1 (of the first window) and 0 (of the second)
    pixel_weights = np.array([[0.5, 1, 1], [0.5, 1, 1]], np.float32)
    image = np.full((2, 3, 1), -1, np.float32)
    weights = np.array([[1, 3]], np.float32)
    vote_mean(
        field, weights, weighted_pixels(exemplar, pixel_weights), np.ones((2, 2), np.float32), 1, image, Context()
    )
    np.testing.assert_allclose(image[0, :, 0], [0, 8 * 1 / (1 + 1.5), 8])


def test_guide_channel_stays():
    image = np.full((4, 4, 2), 7, np.float32)
    field = np.zeros((1, 1, 2), np.int32)
    exemplar = np.ones((4, 4, 2), np.float32)
    ones = np.ones((4, 4), np.float32)
    vote_mean(field, np.ones((1, 1), np.float32), weighted_pixels(exemplar[..., :1], ones), ones, 1, image, Context())
    assert (image[..., 0] == 1).all()
    assert (image[..., 1] == 7).all()


@pytest.mark.parametrize(("exponent", "ratio"), [(2.0, 1.0), (1.0, 0.5), (0.8, 4 ** (-0.6))])
def test_robust_weights(exponent, ratio):
    """Four times the squared distance weighs 4 ** ((r - 2) / 2) times as much."""
    weights = robust_weights(np.array([[1.0, 4.0]], np.float32), exponent)
    assert weights[0, 1] / weights[0, 0] == pytest.approx(ratio, rel=2e-3)
    assert weights.mean() == pytest.approx(1)


def test_perfect_windows_do_not_silence_the_rest():
    weights = robust_weights(np.array([[0.0, 1.0]], np.float32), 0.8)
    assert weights[0, 1] > 0.01 * weights[0, 0]
    assert (robust_weights(np.zeros((2, 2), np.float32), 0.8) == 1).all()
