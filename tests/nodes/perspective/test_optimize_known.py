"""Optimize with masks, known pixels, a start, and outputs that wrap around."""

import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.numerics.guidance import resampled
from graphtex_nodes.numerics.measures import seam_energy
from graphtex_nodes.perspective.optimize import optimize
from tests.truth import source_scale_correlation

QUIET = Context(threads=1)
RNG = np.random.default_rng(1)
NOISE = RNG.random((40, 48, 3)).astype(np.float32)
SCALE = np.repeat(np.linspace(0.5, 2, 40, dtype=np.float32)[:, None], 48, axis=1)
ROW, COLUMN = np.mgrid[:64, :64]


@pytest.fixture(scope="module")
def stones():
    return np.array(pebbles(width=96, height=96, size=9.0, rng=3).image)


def places(source):
    return source[..., 1].astype(int), source[..., 2].astype(int)


@pytest.mark.parametrize("kind", ["half", "speckled", "lone"])
@pytest.mark.parametrize("maps", [{}, {"exemplar_scale": SCALE, "target_scale": SCALE}])
def test_only_usable_pixels_are_copied(kind, maps):
    usable = np.ones((40, 48), bool)
    if kind == "half":
        usable[:, 20:] = False
    elif kind == "speckled":
        usable = RNG.random((40, 48)) < 0.7
    else:
        usable[:] = False
        usable[17, 30] = True
    ctx = Context(threads=1, on_warning=lambda text: None)  # the scale of a lone pixel cannot guide
    result = optimize(NOISE, usable=usable, vote="discrete", ctx=ctx, **maps)
    assert usable[places(result.source)].all()
    np.testing.assert_array_equal(result.image, NOISE[places(result.source)])


def test_values_that_must_not_be_used_do_not_matter():
    usable = np.ones((40, 48), bool)
    usable[10:30, 8:24] = False
    other = np.where(usable[..., None], NOISE, np.float32(50))
    first, second = (optimize(picture, usable=usable, ctx=QUIET) for picture in (NOISE, other))
    np.testing.assert_array_equal(first.image, second.image)


def test_masked_stones_are_used_evenly(stones):
    usable = np.ones((96, 96), bool)
    usable[:, 48:] = usable[20:40, 10:30] = False
    assert optimize(stones, usable=usable, ctx=QUIET).coverage > 0.55


@pytest.mark.parametrize("vote", ["blend", "discrete", "mean"])
def test_known_pixels_stay(vote):
    known = RNG.random((40, 48)) < 0.5
    known[10:20, 10:30] = False
    result = optimize(NOISE, SCALE, SCALE, start=NOISE[::-1].copy(), known=known, vote=vote, ctx=QUIET)
    np.testing.assert_array_equal(result.image[known], NOISE[::-1][known])
    assert (result.source[known, 0] == 1).all()
    np.testing.assert_array_equal(result.source[known, 1:3], np.argwhere(known))
    assert (result.source[~known, 0] == 0).all()


def test_a_hole_in_the_exemplar_is_found_again(stones):
    """What surrounds the hole is the exemplar's own: the best completion is the exemplar."""
    known = (ROW - 30) ** 2 + (COLUMN - 28) ** 2 > 18**2
    start = np.where(known[..., None], stones[20:84, 10:74], 0).astype(np.float32)
    result = optimize(stones, start=start, known=known, ctx=QUIET)
    assert np.abs(result.image - stones[20:84, 10:74]).mean() < 0.01


def test_all_known_is_the_start():
    result = optimize(NOISE, start=NOISE, known=np.ones((40, 48), bool), ctx=QUIET)
    np.testing.assert_array_equal(result.image, NOISE)


def test_unknown_pixels_of_the_start_are_not_read():
    known = np.ones((40, 48), bool)
    known[5:25, 30:] = False
    other = np.where(known[..., None], NOISE, np.float32(9))
    first, second = (optimize(NOISE, start=start, known=known, ctx=QUIET) for start in (NOISE, other))
    np.testing.assert_array_equal(first.image, second.image)


def test_start_rules_the_arrangement(stones):
    """Started from itself, most of a picture comes out as itself; without, nearly nothing does."""
    found, other = (
        np.abs(result.image - stones).mean(axis=2) < 0.01
        for result in (optimize(stones, start=stones, ctx=QUIET), optimize(stones, width=96, height=96, ctx=QUIET))
    )
    assert found.mean() > 0.5
    assert other.mean() < 0.1


@pytest.mark.parametrize(("tileable", "sides"), [("both", {0, 1}), ("x", {1}), ("y", {0})])
@pytest.mark.parametrize("size", [(96, 90), (77, 63)])
def test_tiles_join_without_a_seam(stones, tileable, sides, size):
    """Ranks of borders that join are those of any row, evenly spread from 0 to 1; others stand out."""
    ranks = {0: [], 1: []}
    for seed in range(3):
        image = optimize(stones, height=size[0], width=size[1], tileable=tileable, rng=seed, ctx=QUIET).image
        assert image.shape[:2] == size
        for side, found in ranks.items():
            found.append(seam_energy(image, side))
    for side, found in ranks.items():
        rank, excess = np.mean(found, axis=0)
        assert (rank < 0.95) == (side in sides)
        assert (excess < 1) == (side in sides)


def test_periodic_stripes_tile_without_a_fault():
    stripes = (0.5 + 0.5 * np.sin((ROW + COLUMN) * 2 * np.pi / 8)).astype(np.float32)[..., None]
    image = optimize(stripes, width=64, height=48, tileable="both", ctx=QUIET).image
    assert np.median(np.abs(np.roll(image, -8, 1) - image)) < 0.02


@pytest.mark.parametrize("size", [(1, 1), (3, 20), (9, 5)])
def test_small_tiles(size):
    image = optimize(NOISE, height=size[0], width=size[1], tileable="both", iterations=1, ctx=QUIET).image
    assert image.shape == (*size, 3)


def test_threads_change_no_byte():
    known = np.zeros((40, 48), bool)
    known[:, :9] = True
    usable = np.ones((40, 48), bool)
    usable[3:9, 4:30] = False
    results = [
        optimize(NOISE, SCALE, SCALE, usable, NOISE, known, tileable="both", ctx=Context(threads=threads))
        for threads in (1, 3)
    ]
    for first, second in zip(*results, strict=True):
        np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"usable": np.zeros((40, 48), bool)}, "usable: expected at least one"),
        ({"usable": np.ones((4, 4), bool)}, "usable"),
        ({"known": np.ones((4, 4), bool)}, "start: expected a picture"),
        ({"start": NOISE, "known": np.ones((4, 4), bool)}, "known"),
        ({"start": NOISE[..., :1]}, "start"),
        ({"start": NOISE, "width": 7}, "start: expected the output's size"),
        ({"start": NOISE, "known": SCALE > 1, "exemplar_scale": SCALE, "scale_mode": "free"}, "target_scale"),
    ],
)
def test_refuses(wrong, message):
    with pytest.raises(ValueError, match=message):
        optimize(NOISE, ctx=QUIET, **wrong)


def test_a_larger_stock_repeats_less():
    """Rows near the eye: more different pixels, and sources whose scale is no worse."""
    made = pebbles(width=128, height=128, size=10.0, slant=55.0, rng=3)
    scale = np.array(made.scale)
    target = resampled(scale, (256, 256))
    few, many = (
        optimize(made.image, scale, target, resample=factor, ctx=QUIET) for factor in (1.0, 1.3)
    )  # fmt: skip
    assert (many.source[..., 3] != 0).mean() > 0.1
    different = [len(np.unique(result.source[-60:].reshape(-1, 6), axis=0)) for result in (few, many)]
    assert different[1] > 1.05 * different[0]
    assert source_scale_correlation(many.source, [scale], target) > 0.95


def test_mirrored_sources_replay():
    result = optimize(NOISE, mirror=True, vote="discrete", ctx=QUIET)
    assert set(np.unique(result.source[..., 5])) == {0, 1}
    np.testing.assert_array_equal(result.image, NOISE[places(result.source)])
