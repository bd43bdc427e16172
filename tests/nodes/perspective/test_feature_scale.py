import functools

import numpy as np
import pytest
from scipy.ndimage import binary_erosion, generic_filter
from scipy.stats import spearmanr

from graphtex_nodes.image.exemplars.bricks import bricks
from graphtex_nodes.image.exemplars.flowers import flowers
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.image.exemplars.woven_cloth import woven_cloth
from graphtex_nodes.numerics.window_mean import window_mean
from graphtex_nodes.perspective.feature_mask import feature_mask
from graphtex_nodes.perspective.feature_scale import _thickness, feature_scale, window_median
from tests.truth import rendered_plane

RANDOM = np.random.default_rng(0).random((13, 17))


def window(array, i, j, side):
    """The part of the window around (i, j) that lies in the picture, the slow way."""
    rows = [r for r in range(i - side // 2, i - side // 2 + side) if 0 <= r < array.shape[0]]
    columns = [c for c in range(j - side // 2, j - side // 2 + side) if 0 <= c < array.shape[1]]
    return array[np.ix_(rows, columns)]


@pytest.mark.parametrize("side", [1, 2, 5, 6, 40])
def test_window_mean_against_the_definition(side):
    expected = [[window(RANDOM, i, j, side).mean() for j in range(17)] for i in range(13)]
    np.testing.assert_allclose(window_mean(RANDOM, side), expected, rtol=1e-12)


def test_window_mean_by_hand():
    values = np.array([[3.0, 0.0, 6.0]])
    np.testing.assert_allclose(window_mean(values, 3), [[1.5, 3.0, 3.0]])
    np.testing.assert_allclose(window_mean(values.T, 3), [[1.5], [3.0], [3.0]])


@pytest.mark.parametrize("side", [3, 4, 9])
def test_window_median_against_the_definition(side):
    """The median is one of the middle values (of an even number, either), to a step of the range."""
    found = window_median(RANDOM, side)
    for i, j in [(0, 0), (6, 8), (12, 3), (5, 16)]:
        values = np.sort(window(RANDOM, i, j, side).ravel())
        low, high = values[(len(values) - 1) // 2], values[len(values) // 2]
        assert low - 1e-3 <= found[i, j] <= high + 1e-3


def test_window_median_of_equal_values():
    np.testing.assert_array_equal(window_median(np.full((4, 5), 0.3), 3), np.full((4, 5), 0.3))


def test_equation_one_by_hand():
    """Densities 0, 1/3, 2/3, 1 with a_mid = 1/2, in the three forms."""
    mask = np.zeros((4, 8), bool)
    mask[:, 4:] = True
    with pytest.warns(UserWarning, match="filled"), pytest.warns(UserWarning, match="38% of the scales"):
        row = {form: feature_scale(mask, window=3, passes=0, form=form)[1] for form in FORMS}
    np.testing.assert_allclose(row["bounded"], [2, 2, 2, 4 / 3, 2 / 3, 0.125, 0.125, 0.125], rtol=1e-6)
    np.testing.assert_allclose(row["literal"], [0.125, 0.125, 0.125, 2 / 3, 4 / 3, 2, 2, 2], rtol=1e-6)
    np.testing.assert_allclose(row["inverse"], [8, 8, 8, 1.5, 0.75, 0.5, 0.5, 0.5], rtol=1e-6)


def test_equation_two_by_hand():
    """One spot: nine windows hold it, so the mean of their scale is known, and the median is that of the many."""
    mask = np.zeros((21, 21), bool)
    mask[10, 10] = True
    scale = feature_scale(mask, window=3, smoothing=5, passes=1, alpha=0.8)
    # before smoothing 2, but 2 - (1/9) / (1/18) = 0, clamped to 1/8, in the block of nine
    assert scale[10, 10] == pytest.approx(0.8 * (16 * 2 + 9 * 0.125) / 25 + 0.2 * 2, abs=1e-3)
    assert scale[0, 0] == pytest.approx(2, abs=1e-3)


def test_smoothing_against_scipy():
    """Inside, one pass is alpha times SciPy's mean plus the rest times its median."""
    mask = np.random.default_rng(1).random((40, 40)) < 0.3
    raw = feature_scale(mask, window=8, passes=0).astype(float)
    found = feature_scale(mask, window=8, smoothing=9, passes=1, alpha=0.7)
    expected = 0.7 * generic_filter(raw, np.mean, 9) + 0.3 * generic_filter(raw, np.median, 9)
    np.testing.assert_allclose(found[4:-4, 4:-4], expected[4:-4, 4:-4], atol=2e-3)


@pytest.mark.parametrize("side", [7, 8])
def test_borders_are_not_darker(side):
    """Stripes of one period fill every window alike, at the border too."""
    mask = np.zeros((48, 48), bool)
    mask[::2] = True
    scale = feature_scale(mask, window=side * 2, smoothing=9)
    assert np.abs(scale - 1).max() < 0.15
    assert abs(scale[:4].mean() - scale[20:28].mean()) < 0.06


def test_denser_is_smaller():
    mask = np.zeros((64, 64), bool)
    mask[:, 0:32:8] = True
    mask[:, 32::4] = True
    scale = feature_scale(mask, window=16, passes=0)
    assert scale[:, :24].mean() > 1.2
    assert scale[:, 40:].mean() < 0.8
    literal = feature_scale(mask, window=16, passes=0, form="literal")
    np.testing.assert_allclose(literal, 2 - scale, atol=1e-6)


FORMS = ("bounded", "inverse", "literal")
KINDS = {"pebbles": pebbles, "bricks": bricks, "cloth": woven_cloth, "flowers": flowers}


@functools.cache
def drawn(kind, **pose):
    return KINDS[kind](rng=1, **pose).image


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("slant", "tilt"), [(45.0, 180.0), (45.0, 60.0), (55.0, -30.0)])
def test_ranks_pixels_like_the_truth(kind, slant, tilt):
    """Both nodes as they come: rank correlation of the measured scale with rays cast on the plane."""
    scale = feature_scale(feature_mask(drawn(kind, slant=slant, tilt=tilt)))
    truth = rendered_plane(256, slant, tilt)
    assert spearmanr(scale.ravel(), truth.ravel()).statistic >= 0.93


@pytest.mark.parametrize("method", ["canny", "contrast"])
def test_other_methods_rank_too(method):
    scale = feature_scale(feature_mask(drawn("pebbles", slant=55.0), method=method))
    assert spearmanr(scale.ravel(), rendered_plane(256, 55.0).ravel()).statistic >= 0.9


def test_the_window_of_the_paper():
    """n = 32, one pass of 9 x 9: noisier, as in Fig. 3, but it follows the plane."""
    mask = feature_mask(drawn("pebbles", slant=55.0, size=12.0))
    scale = feature_scale(mask, window=32, smoothing=9, passes=1)
    assert np.corrcoef(scale.ravel(), rendered_plane(256, 55.0).ravel())[0, 1] >= 0.9


@pytest.mark.parametrize("shape", [(1600, 90), (61, 3001)])
def test_large_masks_in_blocks(shape):
    """As with every pixel, but for a fraction of what varies over a window; borders and odd sizes too."""
    rows, columns = np.indices(shape)
    rng = np.random.default_rng(6)
    mask = rng.random(shape) < 0.1 + 0.2 * (rows / shape[0] + columns / shape[1]) / 2
    density = window_mean(mask.astype(float), 60)
    expected = 2 - density / ((density.min() + density.max()) / 2)
    found = feature_scale(mask, window=60, smoothing=60, passes=0)
    assert found.shape == shape
    assert np.abs(found - expected).mean() < 0.03


def test_small_windows_keep_every_pixel():
    mask = np.zeros((1, 2100), bool)
    mask[0, 1050] = True
    assert feature_scale(mask, window=1, smoothing=1, passes=0).argmin() == 1050


def test_share_of_clamped_pixels_is_reported():
    mask = np.zeros((20, 20), bool)
    mask[:, 10:] = True
    with pytest.warns(UserWarning, match="filled"), pytest.warns(UserWarning, match=r"4[05]% of the scales"):
        feature_scale(mask, window=3)


def test_filled_features_are_told():
    """Discs tell no size however they recede; their outlines do, and so do gaps in the literal form."""
    y, x = np.mgrid[:128, :128] % 16 - 7.5
    discs = np.hypot(x, y) < 7
    with pytest.warns(UserWarning, match="features are filled, 8 pixels from side to side"):
        feature_scale(discs)
    feature_scale(discs & ~binary_erosion(discs))
    feature_scale(discs, form="literal")


@pytest.mark.parametrize("width", [1, 2, 3])
def test_thickness_of_lines(width):
    mask = np.zeros((40, 60), bool)
    mask[:, 20 : 20 + width] = True
    assert _thickness(mask) == pytest.approx(width, abs=1)


def test_empty_mask():
    with pytest.raises(ValueError, match=r"mask: expected some features .*empty mask of shape \(4, 6\)"):
        feature_scale(np.zeros((4, 6), bool))


def test_mask_of_another_size_than_its_picture():
    mask = np.eye(4, 6, dtype=bool)
    np.testing.assert_array_equal(feature_scale(mask, np.zeros((4, 6, 3), np.float32)), feature_scale(mask))
    with pytest.raises(ValueError, match=r"image: axis w has size 5 .*, but mask has 6"):
        feature_scale(mask, np.zeros((4, 5, 3), np.float32))


@pytest.mark.parametrize("wrong", [{"window": 0}, {"alpha": 1.5}, {"passes": -1}, {"form": "linear"}, {"smoothing": 0}])
def test_refuses(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        feature_scale(np.ones((4, 4), bool), **wrong)


def test_one_pixel():
    assert feature_scale(np.ones((1, 1), bool)) == [[1.0]]
