"""Optimize with several exemplars, material maps, weights of channels, and what it tells of its energies."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from graphtex import Context
from graphtex_nodes.image.exemplars.bricks import bricks
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.image.maps import split_maps, stack_maps
from graphtex_nodes.image.normals import normals_from_height
from graphtex_nodes.numerics.guidance import resampled
from graphtex_nodes.perspective.optimize import optimize
from graphtex_nodes.perspective.replay import replay
from tests.truth import source_scale_correlation

QUIET = Context(threads=1)
RNG = np.random.default_rng(3)
NOISE = RNG.random((40, 48, 3)).astype(np.float32)
OTHER = RNG.random((33, 20, 3)).astype(np.float32)
SCALE = np.repeat(np.linspace(0.5, 1, 40, dtype=np.float32)[:, None], 48, axis=1)
OTHER_SCALE = np.repeat(np.linspace(1, 2, 33, dtype=np.float32)[:, None], 20, axis=1)
KINDS = ["colour", "normal", "scalar"]


@pytest.fixture(scope="module")
def wall():
    """Colour, normals and height of bricks."""
    made = bricks(width=128, height=128, size=32.0, rng=6)
    return np.array(made.image), normals_from_height(made.height, relief=4.0), np.array(made.height)


def test_sources_tell_the_exemplar():
    result = optimize(NOISE, more=[OTHER], vote="discrete", ctx=QUIET)
    assert set(np.unique(result.source[..., 0])) == {0, 1}
    np.testing.assert_array_equal(replay(result.source, [NOISE, OTHER]), result.image)
    share = np.mean(result.source[..., 0] == 1)
    assert 0.25 < share / (OTHER.size / (OTHER.size + NOISE.size)) < 2  # of a narrow one fewer windows fit
    assert result.image.shape == (80, 96, 3)


def test_each_exemplar_serves_the_scales_that_it_has():
    """Near and far pictures of one texture: the output asks for both."""
    target = resampled(np.concatenate([SCALE[:, :40], OTHER_SCALE[:, :1].repeat(40, 1)]), (90, 70))
    result = optimize(NOISE, SCALE, target, more=[OTHER], more_scale=[OTHER_SCALE], scale_weight=1.0, ctx=QUIET)
    assert source_scale_correlation(result.source, [SCALE, OTHER_SCALE], target) > 0.9
    assert np.mean(result.source[:30, :, 0]) < 0.1 < 0.9 < np.mean(result.source[60:, :, 0])


def test_masks_of_further_exemplars():
    usable = np.zeros((33, 20), bool)
    usable[:, 10:] = True
    result = optimize(
        NOISE, width=160, height=120, more=[OTHER, OTHER], more_usable=[usable, ~usable], vote="discrete", ctx=QUIET
    )
    index, column = result.source[..., 0], result.source[..., 2]
    assert (column[index == 1] >= 10).all()
    assert (column[index == 2] < 10).all()
    assert set(np.unique(index)) == {0, 1, 2}


def test_known_pixels_have_the_index_behind_the_last():
    known = np.zeros((30, 30), bool)
    known[:, :8] = True
    start = RNG.random((30, 30, 3)).astype(np.float32)
    result = optimize(NOISE, more=[OTHER], start=start, known=known, vote="discrete", ctx=QUIET)
    assert (result.source[known, 0] == 2).all()
    assert (result.source[~known, 0] < 2).all()
    np.testing.assert_array_equal(replay(result.source, [NOISE, OTHER, start]), result.image)


def test_copies_of_an_exemplar_are_one_exemplar():
    """Cut in two, stones give a picture like that of the whole."""
    stones = np.array(pebbles(width=96, height=96, size=9.0, rng=3).image)
    result = optimize(stones[:, :48].copy(), width=96, height=96, more=[stones[:, 48:].copy()], ctx=QUIET)
    assert 0.25 < np.mean(result.source[..., 0]) < 0.75
    assert result.coverage > 0.45  # of as many pixels as the output has


def test_maps_stay_aligned(wall):
    """Normals made of the height of the result are its normals, but for the seams; unit vectors to 1 %."""
    stack = stack_maps(list(wall), kinds=KINDS)
    result = optimize(stack, kinds=KINDS, width=160, height=160, ctx=QUIET)
    _, normal, height = split_maps(result.image, kinds=KINDS, renormalise=False)
    length = np.linalg.norm(normal * 2.0 - 1, axis=2)
    assert np.abs(length - 1).max() < 0.01 + 1e-6
    again = normals_from_height(height, relief=4.0)
    assert np.quantile(np.abs(again - normal).max(axis=2), 0.85) < 0.02


@pytest.mark.parametrize("kind", ["height", "scalar"])
def test_heights_have_no_cliffs(wall, kind):
    """Where pieces meet, a smooth surface has no step that its exemplar has not; a measured map stays as copied."""
    height = gaussian_filter(wall[2], (4, 4, 0))
    kinds = ["colour", kind]
    stack = stack_maps([wall[0], height], kinds=kinds)
    result = optimize(stack, kinds=kinds, map_weights=[1, 0], width=160, height=160, ctx=QUIET)
    again = replay(result.source, [height], kinds=[kind], vote="blend", ctx=QUIET)
    steps = [max(np.abs(np.diff(each, axis=axis)).max() for axis in (0, 1)) for each in
             (height[..., 0], result.image[..., 3], again[..., 0])]  # fmt: skip
    if kind == "height":
        assert max(steps[1:]) < 1.1 * steps[0]
        assert result.image[..., 3].std() > 0.85 * height.std()
    else:
        assert min(steps[1:]) > 1.4 * steps[0]


def test_mirrored_normals_turn(wall):
    """Lit from the right, a mirrored brick must look lit from the right again."""
    stack = stack_maps(list(wall), kinds=KINDS)
    result = optimize(stack, kinds=KINDS, mirror=True, vote="discrete", ctx=QUIET)
    mirrored = result.source[..., 5] == 1
    assert 0.1 < mirrored.mean() < 0.9
    own = stack[tuple(result.source[mirrored][:, axis].astype(int) for axis in (1, 2))]
    found = result.image[mirrored]
    np.testing.assert_allclose(found[:, 3], 1 - own[:, 3], atol=1e-6)
    np.testing.assert_array_equal(found[:, [0, 1, 2, 4, 5, 6]], own[:, [0, 1, 2, 4, 5, 6]])


@pytest.mark.parametrize(("weights", "guide"), [((1, 0), slice(0, 3)), ((0, 1), slice(3, 4))])
def test_one_map_guides_the_rest(weights, guide):
    """What only is copied has no say: another picture in its place gives the same sources up to the seams."""
    stacks = [NOISE, RNG.random((40, 48, 1)).astype(np.float32)]
    options = {"kinds": ["colour", "scalar"], "map_weights": weights, "vote": "mean", "histogram": 0.0, "ctx": QUIET}
    first = optimize(stack_maps(stacks, kinds=["colour", "scalar"]), **options)
    copied = 1 - weights.index(0)
    stacks[1 - copied] = RNG.random(stacks[1 - copied].shape).astype(np.float32)
    second = optimize(stack_maps(stacks, kinds=["colour", "scalar"]), **options)
    np.testing.assert_allclose(first.image[..., guide], second.image[..., guide], atol=1e-6)


def test_weights_of_channels_scale_distances():
    """Twice the weight is twice the contrast: sources stay, as the energy is relative."""
    weighted = optimize(NOISE, map_weights=(2.0, 2.0, 2.0), ctx=QUIET)
    plain = optimize(NOISE, ctx=QUIET)
    assert np.mean(weighted.source == plain.source) > 0.99
    assert weighted.energy == pytest.approx(plain.energy * 2**0.8, rel=1e-3)


def test_energies_fall_within_a_level():
    """One for each search; the last is the energy."""
    told = []
    ctx = Context(threads=1, on_progress=lambda share, text: told.append(text))
    result = optimize(np.array(pebbles(width=64, height=64, size=9.0, rng=3).image), evenness=0.0, ctx=ctx)
    assert len(result.energies) == sum(text.startswith("level") for text in told)
    assert result.energies[-1] == result.energy
    assert result.energies.dtype == np.float64
    assert result.energies[0] > result.energies[2] > 0
    assert result.energies[-1] < result.energies[-4]


def test_joint_components_follow_the_scale_too():
    made = pebbles(width=96, height=96, size=9.0, slant=55.0, rng=3)
    target = resampled(made.scale, (128, 128))
    apart, joint = (optimize(made.image, made.scale, target, pca=pca, ctx=QUIET) for pca in ("apart", "joint"))
    assert source_scale_correlation(joint.source, [made.scale], target) > 0.9
    assert (apart.image != joint.image).any()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"more": [OTHER[..., :1]]}, r"more\[0\]: expected 3 channels as exemplar has, got shape \(33, 20, 1\)"),
        (
            {"more": [OTHER], "exemplar_scale": SCALE, "target_scale": SCALE},
            "more_scale: expected one for each of 1 further exemplars, got 0",
        ),
        (
            {"more": [OTHER], "more_scale": [OTHER_SCALE], "target_scale": SCALE},
            "exemplar_scale: expected a map beside",
        ),
        (
            {"more": [OTHER], "more_scale": [SCALE], "exemplar_scale": SCALE, "target_scale": SCALE},
            r"more_scale\[0\]: expected the size of its exemplar, \(33, 20\), got shape \(40, 48\)",
        ),
        ({"more": [OTHER * np.float32(1e20)]}, r"more\[0\]: expected the largest .* to 1e15, got 9.99e\+19"),
        ({"start": np.full((80, 96, 3), 1e-30, np.float32)}, "start: expected the largest .* got 1e-30"),
        ({"more": [OTHER], "more_usable": [np.ones((4, 4), bool)]}, r"more_usable\[0\]: expected the size"),
        ({"more": [OTHER], "more_usable": [np.zeros((33, 20), bool)]}, r"more_usable\[0\]: expected at least one"),
        ({"more_usable": [np.ones((4, 4), bool)]}, "more_usable: expected one for each of 0 further exemplars, got 1"),
        ({"kinds": ["normal", "scalar"]}, r"kinds: normal \+ scalar are 4 channels, the picture has 3"),
        ({"map_weights": (1.0, 0.0)}, r"map_weights: expected one for each of 3 channels"),
        ({"map_weights": (1.0, 0.0), "kinds": ["colour"]}, r"map_weights: expected one for each of 1 maps"),
        ({"map_weights": (0.0, 0.0, 0.0)}, "map_weights: .* not all 0"),
        ({"exemplar_scale": np.where(SCALE > 0.7, np.nan, SCALE), "target_scale": SCALE}, "exemplar_scale: .* NaN"),
        ({"start": np.full((9, 9, 3), np.inf, np.float32)}, "start: .* infinite"),
    ],
)
def test_refuses(wrong, message):
    with pytest.raises(ValueError, match=message):
        optimize(NOISE, ctx=QUIET, **wrong)


def test_exemplar_with_holes_of_nan():
    exemplar = NOISE.copy()
    exemplar[3, 4, 1] = np.nan
    with pytest.raises(ValueError, match=r"exemplar: .* 1 NaN or infinite"):
        optimize(exemplar, ctx=QUIET)
