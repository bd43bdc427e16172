import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.image.maps import select_map, stack_maps
from graphtex_nodes.perspective.optimize import optimize
from graphtex_nodes.perspective.replay import replay

QUIET = Context(threads=1)
RNG = np.random.default_rng(5)
NOISE = RNG.random((40, 44, 3)).astype(np.float32)
KINDS = ["colour", "normal", "scalar"]
ROW, COLUMN = np.mgrid[:40, :44]
SLOPES = np.stack([np.sin(ROW / 3), np.cos(COLUMN / 4), np.full(ROW.shape, 1.5)], axis=-1)
NORMALS = ((SLOPES / np.linalg.norm(SLOPES, axis=2, keepdims=True) + 1) / 2).astype(np.float32)
STACK = stack_maps([NOISE, NORMALS, NOISE[..., :1]], kinds=KINDS)
SCALE = np.repeat(np.linspace(0.5, 2, 40, dtype=np.float32)[:, None], 44, axis=1)
STONES = np.kron((NOISE[::10, ::11, :1] > 0.7) * NOISE[::10, ::11], np.ones((10, 11, 1))).astype(np.float32)
"""Elements with outlines: where they differ, they meet sharply."""
LEVEL = np.zeros((70, 60), np.float32)


def synthesis(picture=NOISE, **options):
    return optimize(picture, width=60, height=70, iterations=2, ctx=QUIET, **options)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"mirror": True},
        {"exemplar_scale": SCALE, "target_scale": SCALE, "resample": 1.6, "mirror": True},
        {"target_angle": LEVEL + np.linspace(0, 90, 60, dtype=np.float32), "mirror": True},
        {"tileable": "both"},
        {"more": [STACK[::2].copy()]},
    ],
    ids=["plain", "mirrored", "resampled", "turned", "tileable", "two exemplars"],
)
def test_discrete_vote_replays_to_the_bit(options):
    """Colours, normals and heights, of copies of all kinds."""
    made = synthesis(STACK, vote="discrete", kinds=KINDS, **options)
    maps = [STACK, *options.get("more", [])]
    np.testing.assert_array_equal(replay(made.source, maps, kinds=KINDS, ctx=QUIET), made.image)
    assert ("more" in options) == (made.source[..., 0].max() == 1)


@pytest.mark.parametrize("options", [{}, {"mirror": True}, {"tileable": "both"}, {"tileable": "x", "mirror": True}])
@pytest.mark.parametrize(("picture", "kinds"), [(STACK, KINDS), (STONES, [])], ids=["grain", "elements"])
def test_blended_vote_replays_but_for_rounding(picture, kinds, options):
    made = synthesis(picture, kinds=kinds, **options)
    sides = options.get("tileable", "none")
    again = replay(made.source, [picture], vote="blend", kinds=kinds, tileable=sides, ctx=QUIET)
    error = np.abs(again - made.image).max(axis=2)
    assert np.quantile(error, 0.97) < 1e-5  # a copy's own border is known to the synthesis alone
    assert (made.image != replay(made.source, [picture], kinds=kinds, ctx=QUIET)).any()


@pytest.mark.parametrize(
    "options",
    [
        {"target_angle": LEVEL + 40},
        {"exemplar_scale": SCALE, "target_scale": SCALE, "resample": 1.6},
        {"more": [STACK[::2].copy()]},
    ],
    ids=["turned", "resampled", "two exemplars"],
)
def test_blended_vote_of_other_copies_replays_nearly(options):
    """The borders of copies are known to the synthesis alone."""
    made = synthesis(STACK, kinds=KINDS, **options)
    maps = [STACK, *options.get("more", [])]
    error, rest = (
        np.abs(replay(made.source, maps, vote=vote, kinds=KINDS, ctx=QUIET) - made.image)[..., :3].mean()
        for vote in ("blend", "discrete")
    )
    assert error < 0.1 * rest


def test_larger_blended_maps_are_levelled_as_the_synthesis():
    """A picture shown four times as large, and one that is but brighter on one side, give the same trend."""
    shaded = np.clip(0.4 + 0.1 * (NOISE - 0.5) + 0.4 * (COLUMN[..., None] > 21), 0, 1).astype(np.float32)
    made = synthesis(shaded)
    large = replay(made.source, [shaded.repeat(2, 0).repeat(2, 1)], vote="blend", factor=2, ctx=QUIET)
    means = large.reshape(70, 2, 60, 2, 3).mean(axis=(1, 3))
    discrete = replay(made.source, [shaded], ctx=QUIET)
    assert np.abs(means - made.image).mean() < 0.3 * np.abs(discrete - made.image).mean()


def test_borders_in_larger_maps_have_no_wide_steps():
    """A white piece and a black one part along a diagonal, in steps of four pixels where they are merely copied."""
    halves = np.zeros((96, 240, 1), np.float32)
    halves[:, 120:] = 1
    source = np.zeros((20, 20, 6), np.float32)
    row, column = np.mgrid[:20, :20]
    source[..., 1], source[..., 2] = row, column + 30 * (column > row)
    for vote, wide in (("discrete", 3), ("blend", 1)):
        image = replay(source, [halves], factor=4, vote=vote)[12:68, :, 0]
        assert np.minimum(np.abs(image), np.abs(image - 1)).max() < 1e-3
        assert np.ptp((image > 0.5).argmax(axis=1) - np.arange(len(image))) == wide


def test_two_maps_from_one_guide():
    """A synthesis of the colours alone serves the normals; together they are what a synthesis of the stack gives."""
    colours = synthesis(vote="discrete")
    both = synthesis(
        stack_maps([NOISE, NORMALS], kinds=KINDS[:2]), vote="discrete", kinds=KINDS[:2], map_weights=(1, 0)
    )
    normals = select_map(both.image, kinds=KINDS[:2], index=1)
    np.testing.assert_array_equal(replay(both.source, [NORMALS], kinds=["normal"]), normals)
    np.testing.assert_array_equal(replay(colours.source, [NOISE]), colours.image)


@pytest.mark.parametrize("factor", [2, 3, 4])
def test_larger_maps_give_larger_outputs(factor):
    """Means of factor x factor pixels of the larger output are the smaller one, where the vote is discrete."""
    large = RNG.random((40 * factor, 44 * factor, 1)).astype(np.float32)
    small = large.reshape(40, factor, 44, factor, 1).mean(axis=(1, 3))
    source = synthesis(vote="discrete").source
    output = replay(source, [large], factor=factor)
    assert output.shape == (70 * factor, 60 * factor, 1)
    assert np.isin(output, large).all()
    means = output.reshape(70, factor, 60, factor, 1).mean(axis=(1, 3))
    np.testing.assert_allclose(means, replay(source, [small]), atol=1e-6)


def test_larger_mirrored_and_turned_sources():
    """One piece, mirrored and turned by a quarter: the larger output is the larger map so shown."""
    large = RNG.random((12, 18, 2)).astype(np.float32)
    source = np.zeros((6, 4, 6), np.float32)
    source[..., 4:] = 90, 1
    row, column = np.mgrid[:6, :4]
    source[..., 1], source[..., 2] = 3 - column, 5 - row
    expected = np.rot90(large[:, ::-1], -1)
    np.testing.assert_array_equal(replay(source, [large], factor=3), expected)


@pytest.mark.parametrize("factor", [0.5, 1.5])
def test_any_factor(factor):
    """A smooth map replayed at another resolution looks like the replay of the map itself."""
    ramp = (np.mgrid[: round(40 * factor), : round(44 * factor)][0][..., None] / (40 * factor)).astype(np.float32)
    source = np.zeros((20, 20, 6), np.float32)
    source[..., 1], source[..., 2] = np.mgrid[10:30, 5:25]
    output = replay(source, [ramp], factor=factor, vote="blend")
    assert output.shape == (round(20 * factor), round(20 * factor), 1)
    place = (np.arange(len(output)) + 0.5) / factor - 0.5 + 10
    np.testing.assert_allclose(output[:, 0, 0] * 40, place + 0.5 - 0.5 / factor, atol=0.05)


def test_a_forgotten_factor_is_warned_of():
    """Of maps of twice the sides only the first quarter would be seen."""
    made = synthesis(vote="discrete")
    large = NOISE.repeat(2, 0).repeat(2, 1)
    with pytest.warns(UserWarning, match=r"names its first \d+ of \d+ rows and \d+ of \d+ columns; is factor 2\?"):
        replay(made.source, [large])
    replay(made.source, [large], factor=2)
    replay(made.source, [np.pad(NOISE, ((0, len(NOISE)), (0, 0), (0, 0)))])  # another shape: it may be an atlas
    with pytest.warns(UserWarning, match=r"rows and \d+ of 110 columns; is it a map of that exemplar\?"):
        replay(made.source, [np.zeros((80, 110, 3), np.float32)])
    replay(made.source[:4, :4], [large])


def test_known_pixels_come_from_the_last_map():
    known = np.zeros((70, 60), bool)
    known[:, :12] = True
    start = RNG.random((70, 60, 3)).astype(np.float32)
    made = optimize(NOISE, start=start, known=known, vote="discrete", ctx=QUIET)
    for vote in ("discrete", "blend"):
        again = replay(made.source, [NOISE, start], known, vote=vote)
        np.testing.assert_array_equal(again[known], start[known])
    np.testing.assert_array_equal(replay(made.source, [NOISE, start]), made.image)


def test_unit_normals_stay_unit():
    made = synthesis(STACK, kinds=KINDS)
    blended = replay(made.source, [STACK], vote="blend", factor=1, kinds=KINDS)
    for stack in (made.image, blended):
        length = np.linalg.norm(stack[..., 3:6] * 2.0 - 1, axis=2)
        assert np.abs(length - 1).max() <= 0.01 + 1e-6
    plain = synthesis(STACK).image
    assert np.abs(np.linalg.norm(plain[..., 3:6] * 2.0 - 1, axis=2) - 1).max() > 0.01


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"maps": []}, r"maps: .* at least 1 .* got 0"),
        ({"maps": [NOISE[:20]]}, r"maps\[0\]: the source map names rows from .* \(20, 44, 3\) with factor 1"),
        ({"maps": [NOISE], "factor": 4.0}, r"maps\[0\]: .* with factor 4"),
        ({"maps": [NOISE, NOISE[..., :1]]}, r"maps\[1\]: expected 3 channels as maps\[0\] has, got 1"),
        ({"maps": [NOISE], "kinds": ["scalar"]}, "kinds: scalar are 1 channels, the picture has 3"),
        ({"maps": [NOISE], "factor": 0.0}, "factor"),
    ],
)
def test_refuses(change, message):
    source = synthesis(vote="discrete").source
    with pytest.raises(ValueError, match=message):
        replay(source, **change)


@pytest.mark.parametrize(("channel", "value"), [(0, 0.5), (0, -1.0), (1, -3.0)])
def test_refuses_places_that_are_none(channel, value):
    source = np.zeros((2, 2, 6), np.float32)
    source[0, 0, channel] = value
    with pytest.raises(ValueError, match=r"source: expected|rows from -3"):
        replay(source, [NOISE])
