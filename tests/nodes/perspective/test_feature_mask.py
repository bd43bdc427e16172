import warnings

import numpy as np
import pytest
from scipy.ndimage import zoom

from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.perspective.feature_mask import feature_mask
from graphtex_nodes.perspective.feature_scale import feature_scale


def grating(channels=1, period=16, width=3, size=64):
    """Bright vertical lines on dark ground; the lines' middle columns."""
    columns = np.arange(size)
    middles = columns[period // 2 :: period]
    line = np.clip(width / 2 + 0.5 - np.abs(columns[:, None] - middles).min(axis=1), 0, 1)
    image = np.broadcast_to(line[None, :, None], (size, size, channels))
    return np.ascontiguousarray(image, np.float32), middles


@pytest.mark.parametrize("channels", [1, 2, 3, 7])
def test_ridges_find_the_middle_of_lines(channels):
    """One column of features for each bright line, at its middle, whatever the number of channels."""
    image, middles = grating(channels)
    mask = feature_mask(image, method="ridges", sigma=1.5, threshold=3.0, polarity="bright")
    np.testing.assert_array_equal(np.flatnonzero(mask[20]), middles)


def test_dark_ridges_are_the_bright_ones_of_the_negative():
    image, _ = grating()
    bright = feature_mask(image, method="ridges", sigma=1.5, polarity="bright")
    np.testing.assert_array_equal(feature_mask(1 - image, method="ridges", sigma=1.5, polarity="dark"), bright)


def test_canny_finds_both_sides():
    image, middles = grating(width=6)
    found = np.flatnonzero(feature_mask(image, method="canny")[32])
    assert len(found) == 2 * len(middles)
    assert np.abs(np.abs(found[:, None] - middles).min(axis=1) - 3).max() <= 1


def test_contrast_outlines_what_stands_out():
    """A disc's outline, one pixel wide: as many pixels as its circumference, about."""
    y, x = np.mgrid[:64, :64] - 32
    image = (np.hypot(x, y) < 8)[..., None].astype(np.float32)
    mask = feature_mask(image, method="contrast", polarity="bright")
    assert np.abs(np.hypot(x, y)[mask] - 7.5).max() < 1.5
    assert 0.8 * 2 * np.pi * 8 < mask.sum() < 1.2 * 2 * np.pi * 8
    dark = feature_mask(1 - image, method="contrast", polarity="dark")
    np.testing.assert_array_equal(dark, mask)


@pytest.mark.parametrize("method", ["canny", "ridges", "contrast"])
def test_features_are_thin(method):
    """No 3 x 3 block is all features, as a filled region would be."""
    image = np.random.default_rng(0).random((48, 48, 1), np.float32).cumsum(0).cumsum(1)
    image = (image % 5 / 5).astype(np.float32)
    mask = feature_mask(image, method=method)
    assert mask.any()
    blocks = np.lib.stride_tricks.sliding_window_view(mask, (3, 3)).all(axis=(2, 3))
    assert blocks.mean() < 0.01


@pytest.mark.parametrize("method", ["canny", "ridges", "contrast"])
def test_contrast_and_brightness_do_not_matter(method):
    image = np.random.default_rng(1).random((40, 40, 1), np.float32)
    np.testing.assert_array_equal(feature_mask(image, method=method), feature_mask(image * 0.25 + 0.5, method=method))


def test_equally_bright_colours_are_told_apart():
    """Red squares on green of the same mean: the grey picture is flat, the principal channel is not."""
    image = np.zeros((48, 48, 3), np.float32)
    image[..., 1] = 0.6
    image[16:32, 16:32] = (0.6, 0.0, 0.0)
    assert image.mean(axis=2).std() < 1e-6
    mask = feature_mask(image, method="canny")
    assert mask[14:18].any()
    assert not mask[20:28, 20:28].any()


def test_higher_threshold_finds_less():
    image = np.random.default_rng(4).random((48, 48, 1), np.float32)
    found = [feature_mask(image, threshold=threshold).sum() for threshold in (0.5, 2.0, 4.0)]
    assert found[0] > found[1] > found[2]


def test_flat_picture_has_none():
    with pytest.warns(UserWarning, match="flat"):
        assert not feature_mask(np.full((8, 8, 3), 0.5, np.float32)).any()


def test_nothing_strong_enough():
    with pytest.warns(UserWarning, match="lower threshold"):
        assert not feature_mask(grating()[0], threshold=1e6).any()


@pytest.mark.parametrize("polarity", ["bright", "dark"])
def test_canny_has_no_polarity(polarity):
    with pytest.raises(ValueError, match="polarity: method canny"):
        feature_mask(grating()[0], method="canny", polarity=polarity)


@pytest.mark.parametrize("wrong", [{"method": "sobel"}, {"sigma": 0.0}, {"threshold": 0.0}, {"polarity": "grey"}])
def test_refuses(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        feature_mask(grating()[0], **wrong)


def gaps():
    """Grey stones of many tones with brown gaps three pixels wide, as bright as the stones' mean."""
    tones = np.random.default_rng(7).uniform(0.3, 0.7, (4, 4))
    image = np.repeat(np.repeat(tones, 16, axis=0), 16, axis=1)[..., None] * np.ones(3)
    gap = np.arange(64) % 16 < 3
    image[gap[:, None] | gap] = (0.6, 0.5, 0.4)
    return image.astype(np.float32)


def dab(x, y, label=""):
    return {"points": [[x, y]], "radius": 1, "label": label}


def test_scribbles_find_all_of_a_colour():
    """One dab on a gap, one on a stone of each of two tones: all gaps, as lines, and nothing else."""
    lines = [dab(17, 25), dab(8, 8, "other"), dab(40, 40, "other"), dab(8, 40, "other")]
    mask = feature_mask(gaps(), method="scribbles", sigma=0.3, strokes={"lines": lines})
    gap = np.arange(64) % 16 < 3
    assert not (mask & ~(gap[:, None] | gap)).any()
    rows = mask[:, 24][4:60]
    assert np.flatnonzero(rows).tolist() == [13, 29, 45]  # row 17, 33, 49: the middle of each gap


def test_samples_do_what_strokes_do():
    lines = [dab(17, 25)]
    samples = np.hypot(*(np.mgrid[:64, :64] - np.array([25, 17])[:, None, None])) <= 1
    found = feature_mask(gaps(), samples, method="scribbles")
    np.testing.assert_array_equal(found, feature_mask(gaps(), method="scribbles", strokes={"lines": lines}))


@pytest.mark.parametrize(
    ("lines", "message"),
    [([], "got 0 of 4096 pixels"), ([dab(9, 9, "stone")], "got 'stone'"), ([dab(900, 9)], "got 0 of 4096 pixels")],
)
def test_scribbles_that_show_nothing(lines, message):
    with pytest.raises(ValueError, match=message):
        feature_mask(gaps(), method="scribbles", strokes={"lines": lines})


def test_scribbles_on_everything():
    with pytest.raises(ValueError, match="some pixels without, got 4096 of 4096"):
        feature_mask(gaps(), np.ones((64, 64), bool), method="scribbles")


@pytest.mark.parametrize("colours", [1, 3])
def test_alpha_is_no_colour(colours):
    """A transparent half, however it is laid out, adds no features."""
    image, _ = grating(colours)
    alpha = np.zeros((*image.shape[:2], 1), np.float32)
    alpha[20:] = 1
    np.testing.assert_array_equal(feature_mask(np.dstack([image, alpha])), feature_mask(image))


@pytest.mark.parametrize("method", ["canny", "ridges"])
def test_fainter_colours_have_features_too(method):
    """Bars of two colours at right angles to each other in brightness: each is found wherever the other is."""
    image = np.full((64, 64, 3), 0.4, np.float32)
    image[12:20, :, :] += (0.3, 0.3, 0.3)  # grey, most of the variance
    image[44:52, :, :] += (0.16, -0.16, 0.0)  # reddish of the same brightness
    mask = feature_mask(image, method=method)
    assert mask[11:21].any(axis=0).mean() > 0.9
    assert mask[43:53].any(axis=0).mean() > 0.9
    assert not mask[26:38].any()


def enlarged(image, times):
    """A soft picture: cubic splines between pixels that lie so far apart."""
    return np.stack([zoom(image[..., c], times, order=3, mode="nearest") for c in range(image.shape[2])], axis=-1)


def test_a_soft_picture_has_about_the_mask_of_the_sharp_one():
    """Without halvings nothing curves enough in it; by itself the node finds the scale at which things do."""
    sharp = pebbles(width=160, height=160, size=16.0, slant=50.0, rng=5).image
    soft = enlarged(sharp, 4)
    assert feature_mask(soft, halvings=0).mean() < 0.02  # 0.2 of the sharp one
    mask = feature_mask(soft)
    assert mask.shape == soft.shape[:2]
    found, small = feature_scale(mask), feature_scale(feature_mask(sharp))
    assert np.corrcoef(found[2::4, 2::4].ravel(), small.ravel())[0, 1] > 0.98


def test_a_sharp_picture_is_not_halved():
    image = pebbles(slant=50.0, rng=5).image
    np.testing.assert_array_equal(feature_mask(image), feature_mask(image, halvings=0))


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (33, 47), (300, 5)])
@pytest.mark.parametrize("method", ["canny", "ridges", "contrast"])
def test_halvings_of_any_size(size, method):
    image = np.random.default_rng(2).random((*size, 3), np.float32)
    for halvings in (0, 1, 3):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            assert feature_mask(image, method=method, halvings=halvings).shape == size


def test_large_pictures_are_halved_whatever_they_show():
    image = np.random.default_rng(2).random((4, 4100, 1), np.float32)
    mask = feature_mask(image)
    assert mask.shape == (4, 4100)
    np.testing.assert_array_equal(mask, feature_mask(image, halvings=2))


def test_scribbles_on_a_soft_picture():
    """A thin dab stays seen after the halvings, and what it shows is found."""
    soft = enlarged(gaps(), 8)
    lines = [{"points": [[136, 200]], "radius": 2}, {"points": [[64, 64], [320, 64]], "radius": 9, "label": "other"}]
    mask = feature_mask(soft, method="scribbles", sigma=0.3, halvings=3, strokes={"lines": lines})
    gap = np.arange(512) % 128 < 24
    assert mask.any()
    assert (gap[:, None] | gap)[mask].mean() > 0.8
