import re
from itertools import pairwise

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from graphtex import Cancelled, Context
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.numerics import membrane
from graphtex_nodes.numerics.guidance import resampled
from graphtex_nodes.perspective.feature_mask import feature_mask
from graphtex_nodes.perspective.feature_scale import feature_scale
from graphtex_nodes.perspective.optimize import optimize
from graphtex_nodes.perspective.resize_scale import resize_scale
from tests.truth import patch_distance, scale_slope, source_scale_correlation

QUIET = Context(threads=1)
RNG = np.random.default_rng(1)
NOISE = RNG.random((32, 40, 3)).astype(np.float32)
SCALE = np.repeat(np.linspace(0.5, 2, 32, dtype=np.float32)[:, None], 40, axis=1)


@pytest.fixture(scope="module")
def plane():
    """Pebbles on a plane in perspective, 128 pixels a side: picture and true scale."""
    made = pebbles(width=128, height=128, size=10.0, slant=55.0, rng=3)
    return np.array(made.image), np.array(made.scale)


def test_elements_follow_the_target_scale(plane):
    """The product's main job: the trend of element sizes is the exemplar's, plain optimisation has far less of it."""
    exemplar, scale = plane
    target = resampled(scale, (256, 256))
    own = scale_slope(exemplar, scale)
    guided = [optimize(exemplar, scale, target, rng=seed, ctx=QUIET) for seed in range(3)]
    assert np.mean([scale_slope(result.image, target) for result in guided]) > 0.8 * own
    for result in guided:
        assert source_scale_correlation(result.source, [scale], target) > 0.95
        # where the scale ends pieces can only be off to one side: this is what rows copied from the border are off by
        rows, columns = np.rint(result.source[..., 1:3]).astype(int).transpose(2, 0, 1)
        off = np.log(scale[rows, columns] / target)
        assert off[:16].mean() < 0.09
        assert off[-16:].mean() > -0.04
    plain = [optimize(exemplar, width=256, height=256, rng=seed, ctx=QUIET) for seed in range(3)]
    assert np.mean([scale_slope(result.image, target) for result in plain]) < 0.5 * own
    for result in (*guided, *plain):
        assert result.coverage > 0.7
        assert result.coherence > 0.8
        assert patch_distance(result.image, exemplar) < 0.02


def test_free_scale_follows_too(plane):
    exemplar, scale = plane
    target = resampled(scale, (200, 180))
    result = optimize(exemplar, scale, target, scale_mode="free", scale_weight=1.0, ctx=QUIET)
    assert source_scale_correlation(result.source, [scale], target) > 0.9


def test_flipped_target_turns_the_trend_around(plane):
    exemplar, scale = plane
    target = resampled(scale, (192, 192))[::-1]
    result = optimize(exemplar, scale, target, scale_weight=1.0, vote="discrete", ctx=QUIET)
    assert source_scale_correlation(result.source, [scale], target) > 0.93


@pytest.mark.parametrize("maps", [{}, {"exemplar_scale": SCALE, "target_scale": SCALE.T.copy()}])
def test_discrete_vote_replays(maps):
    result = optimize(NOISE, vote="discrete", rng=2, ctx=QUIET, **maps)
    rows, columns = (result.source[..., k].astype(int) for k in (1, 2))
    np.testing.assert_array_equal(result.image, NOISE[rows, columns])
    assert (result.source[..., [0, 3, 4, 5]] == 0).all()


def test_uneven_light_does_not_show_at_seams(monkeypatch):
    """The steepest places of the smoothed result, where pieces are bent to meet and where they only fade."""
    light = 0.3 * np.sin(np.linspace(0, 6, 96))[:, None] * np.cos(np.linspace(0, 5, 96))
    exemplar = np.clip(0.5 + light[..., None] + 0.15 * (RNG.random((96, 96, 1)) - 0.5), 0, 1).astype(np.float32)

    def steepest(image):
        return np.quantile(np.hypot(*np.gradient(gaussian_filter(image[..., 0], 3))), 0.995)

    own, bent = steepest(exemplar), steepest(optimize(exemplar, rng=3, ctx=QUIET).image)
    monkeypatch.setattr(membrane, "level", lambda *_: None)
    assert bent - own < 0.6 * (steepest(optimize(exemplar, rng=3, ctx=QUIET).image) - own)


def test_blend_and_discrete_share_their_sources():
    blend = optimize(NOISE, ctx=QUIET)
    discrete = optimize(NOISE, vote="discrete", ctx=QUIET)
    np.testing.assert_array_equal(blend.source, discrete.source)
    assert (blend.image != discrete.image).any()


def test_periodic_exemplar_stays_periodic():
    """Diagonal stripes of period 8: outputs repeat after 8 pixels nearly everywhere. One has faults by chance."""
    row, column = np.mgrid[:64, :64]
    exemplar = (0.5 + 0.5 * np.sin((row + column) * 2 * np.pi / 8)).astype(np.float32)[..., None]
    images = [optimize(exemplar, width=100, height=90, rng=seed, ctx=QUIET).image for seed in range(4)]
    assert max(np.median(np.abs(image[:, 8:] - image[:, :-8])) for image in images) < 0.01
    assert np.mean([np.mean(np.abs(image[8:] - image[:-8]) < 0.1) for image in images]) > 0.8


def test_threads_change_no_byte():
    one = optimize(NOISE, SCALE, SCALE, rng=5, ctx=Context(threads=1))
    three = optimize(NOISE, SCALE, SCALE, rng=5, ctx=Context(threads=3))
    for first, second in zip(one, three, strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("shape", [(1, 1, 1), (1, 30, 3), (5, 7, 2), (17, 9, 16)])
@pytest.mark.parametrize("size", [{}, {"width": 1, "height": 1}, {"width": 31, "height": 3}])
def test_any_size(shape, size):
    exemplar, told = RNG.random(shape).astype(np.float32), []
    image = optimize(exemplar, iterations=1, ctx=Context(threads=1, on_warning=told.append), **size).image
    room = min(4, min(shape[:2]))
    text = f"exemplar: shape {shape} has room for windows of {room} x {room} pixels only: too little to see elements in"
    assert told == [text]
    assert image.shape == (size.get("height", 2 * shape[0]), size.get("width", 2 * shape[1]), shape[2])
    assert image.min() >= exemplar.min() - 1e-5
    assert image.max() <= exemplar.max() + 1e-5


def test_output_follows_the_target_scale_unless_told():
    target = SCALE[:20, :10]
    assert optimize(NOISE, SCALE, target, iterations=1, ctx=QUIET).image.shape == (20, 10, 3)
    assert optimize(NOISE, SCALE, target, width=30, iterations=1, ctx=QUIET).image.shape == (20, 30, 3)


def test_constant_exemplar():
    result = optimize(np.full((24, 24, 2), 0.25, np.float32), ctx=QUIET)
    np.testing.assert_allclose(result.image, 0.25, atol=1e-6)
    assert result.energy == pytest.approx(0, abs=1e-4)


def test_weight_zero_ignores_the_maps():
    plain = optimize(NOISE, width=40, height=32, ctx=QUIET)
    guided = optimize(NOISE, SCALE, SCALE, scale_weight=0.0, ctx=QUIET)
    np.testing.assert_array_equal(plain.image, guided.image)


@pytest.mark.parametrize(
    ("target", "text"),
    [(np.full((20, 20), 6, np.float32), r"100% .* lacks"), (SCALE, None)],
    ids=["lacking", "fitting"],
)
def test_tells_of_scales_that_the_exemplar_lacks(target, text):
    told = []
    optimize(NOISE, SCALE, target, iterations=1, ctx=Context(threads=1, on_warning=told.append))
    assert [bool(re.search(text or "", line)) for line in told] == [True] * (text is not None)


@pytest.mark.parametrize(("windows", "warned"), [((), True), ((2,), False)])
def test_tells_that_hardly_any_window_is_usable(windows, warned):
    told = []
    usable = np.random.default_rng(0).random(NOISE.shape[:2]) < 0.6
    optimize(NOISE, usable=usable, windows=windows, iterations=1, ctx=Context(threads=1, on_warning=told.append))
    text = "exemplar: its usable part has room for windows of 2 x 2 pixels only: too little to see elements in"
    assert told == [text] * warned


def test_exemplar_smaller_than_the_window():
    told = []
    image = optimize(NOISE, windows=(64,), iterations=1, ctx=Context(threads=1, on_warning=told.append)).image
    assert image.shape == (64, 80, 3)
    assert told == ["windows: 64 is more than half of an exemplar of shape (32, 40, 3): it is made smaller"]


def test_scales_that_are_lacking_are_made_by_resampling():
    """Half of the output asks for 1.5 times the largest scale; with copies up to twice as large all is there."""
    told = []
    target = np.concatenate([SCALE[-8:], 1.5 * SCALE[-8:]])
    for resample in (1.0, 2.0):
        ctx = Context(threads=1, on_warning=told.append)
        result = optimize(NOISE, SCALE, target, resample=resample, ctx=ctx)
    assert len(told) == 1
    assert re.search(r"50% of the output asks for scales that the exemplar lacks \(it has 0.5 to 2\)", told[0])
    assert (result.source[-8:, :, 3] > 0).mean() > 0.8


def test_noise_of_a_flat_texture_hardly_guides():
    """What FeatureScale measures on elements of one size: followed in full it would break the picture to bits."""
    exemplar = pebbles(width=128, height=128, size=24.0, rng=3).image
    scale = feature_scale(feature_mask(exemplar))
    target = resize_scale(scale, width=160, height=160)
    with pytest.warns(UserWarning, match="varies by .* only, and not like a plane"):
        damped = optimize(exemplar, scale, target, rng=1)
    with pytest.warns(UserWarning, match="taken for noise"):
        full = optimize(exemplar, scale, target, scale_weight=7.5, rng=1)
    assert damped.coherence > full.coherence + 0.1


def test_constant_scale_warns_and_is_plain():
    told = []
    ones = np.ones((32, 40), np.float32)
    guided = optimize(NOISE, ones, ones, ctx=Context(threads=1, on_warning=told.append))
    assert "cannot guide" in told[0]
    np.testing.assert_array_equal(guided.image, optimize(NOISE, width=40, height=32, ctx=QUIET).image)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"exemplar_scale": SCALE}, "target_scale"),
        ({"target_scale": SCALE}, "exemplar_scale"),
        ({"exemplar_scale": SCALE[:9], "target_scale": SCALE}, "exemplar_scale"),
        ({"levels": 9}, "levels: expected at most 4"),
        ({"windows": (1,)}, "windows"),
        ({"exponent": 0.0}, "exponent"),
        ({"width": -1}, "width"),
        ({"vote": "median"}, "vote"),
    ],
)
def test_refuses(wrong, message):
    with pytest.raises(ValueError, match=message):
        optimize(NOISE, ctx=QUIET, **wrong)


def test_progress_rises_and_cancelling_stops():
    seen = []

    def stop():
        return bool(seen) and seen[-1] > 0.5

    with pytest.raises(Cancelled):
        optimize(NOISE, ctx=Context(threads=2, on_progress=lambda share, text: seen.append(share), cancelled=stop))
    assert all(a <= b for a, b in pairwise(seen))
    assert 0.5 < seen[-1] < 1
