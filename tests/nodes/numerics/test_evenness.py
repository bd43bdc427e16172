import numpy as np
import pytest

from graphtex_nodes import bricks, optimize, pebbles, sample, scale_pattern
from graphtex_nodes.numerics.evenness import charge, homes, local_relief, usage
from graphtex_nodes.numerics.sources import near_copies


def test_usage_counts():
    """Four uses on four windows: three of one, one of another."""
    field = np.array([[[0, 0], [0, 0]], [[0, 0], [1, 1]]], np.int32)
    np.testing.assert_allclose(usage(field, (2, 2), 0), [[3, 0], [0, 1]])
    assert usage(field, (2, 2), 1) == pytest.approx(np.ones((2, 2)))


def test_charge_of_a_hole_rises_with_use():
    """Two of three wanted windows chose the first of four places: 5/3 over the mean; the last one pays half of 1/3."""
    field = np.zeros((1, 4, 2), np.int32)
    field[0, :, 1] = [0, 0, 3, 1]
    wanted = np.array([[True, True, True, False]])
    found = charge(
        np.ones((1, 4), np.float32), np.float32([[1, 1, 1, 0.5]]), field, 0.5,
        evenness=2.0, radius=0, step=1, allowed=None, wanted=wanted,
    )  # fmt: skip
    assert found == pytest.approx(np.array([[5 / 3, 0, 0, 1 / 6]]))


@pytest.mark.parametrize(("times", "most"), [(1, 0.0), (3, 4.0)])
def test_a_piece_that_is_copied_once_costs_nothing(times, most):
    """Of 40 x 40 places 8 x 8 are shown, by every other window, so that a place is used 25 times as often as the mean.

    Shown three times, it pays twice the mean distance for each time beyond the first.
    """
    piece = np.stack(np.meshgrid(np.arange(0, 8, 2), np.arange(0, 8, 2), indexing="ij"), axis=-1) + 16
    field = np.tile(piece.astype(np.int32), (1, times, 1))
    share = np.ones((40, 40), np.float32)
    share[:, 20:] = 0.1
    found = charge(
        share, np.ones_like(share), field, 1.0, evenness=2.0, radius=2, step=2, allowed=None, wanted=None
    )  # fmt: skip
    assert found.max() == pytest.approx(most, abs=1e-5)


def test_copies_of_one_place_are_charged_together():
    """Two copies of 40 x 40 pixels below each other: a piece of 2 x 2 is shown from the one and from the other."""
    rows, columns = np.mgrid[:80, :40]
    origin = np.stack([0 * rows, rows % 40, columns], axis=-1).astype(np.float32)
    piece = np.stack(np.mgrid[10:12, 10:12], axis=-1).astype(np.int32)
    field = np.concatenate([piece, piece + np.int32([40, 0])])
    share = np.ones((79, 39), np.float32)
    rest = {"evenness": 2.0, "radius": 1, "step": 1, "allowed": None, "wanted": None}
    assert (charge(share, share, field, 0.5, **rest) == 0).all()
    found = charge(share, share, field, 0.5, homes=homes(origin, (79, 39), 2, 0), **rest)
    expected = np.zeros((79, 39))
    expected[10:12, 10:12] = expected[50:52, 10:12] = 1.0  # twice instead of once, for twice the mean distance
    np.testing.assert_allclose(found, expected)


def test_places_are_as_large_as_half_a_window():
    """On a level of pixels twice as wide, windows of 4 pixels: their middles lie 4 pixels in, places are 4 wide."""
    rows, columns = np.mgrid[:16, :12]
    origin = np.stack([0 * rows, rows, columns], axis=-1).astype(np.float32)
    expected = np.array([[0, 0, 1], [0, 0, 1], [2, 2, 3], [2, 2, 3], [4, 4, 5]])
    np.testing.assert_array_equal(homes(origin, (5, 3), 4, 1), expected)


@pytest.mark.parametrize("exemplar", ["pebbles", "gravel"])
def test_a_large_stock_is_not_fled_from(exemplar):
    """Of resampled copies the output needs a small part: what it copies it must not be charged for.

    With a charge the output, of which nothing but smooth places is left, has 0.65 of the exemplar's deviation.
    """
    picture = pebbles(width=192, height=192, size=12.0, rng=3).image if exemplar == "pebbles" else sample(name="gravel")
    picture = np.ascontiguousarray(picture[:192, :192])
    target = scale_pattern(pattern="ramp", width=128, height=128, low=0.5, high=2.0)
    result = optimize(picture, np.ones((192, 192), np.float32), target, resample=2.0)
    assert result.image.std() > 0.85 * picture.std()
    assert result.coherence > 0.9


def test_smooth_windows_pay_less():
    """Steps of 1 between columns on the right half, of 0.1 on the left one: mean squares of 1, 0.01 and about 0.5."""
    line = np.cumsum(np.repeat(np.float32([0.1, 1]), 20))
    found = local_relief(np.tile(line, (40, 1))[..., None], 5)
    assert found.shape == (36, 36)
    np.testing.assert_allclose(found[:, :14], 0.01 / (0.5 / 3), rtol=0.1)
    assert (found[:, 18:33] == 1).all()
    assert (local_relief(np.ones((9, 9, 2), np.float32), 4) == 1).all()


def test_parts_of_an_exemplar_keep_their_share():
    """A picture of four plain areas: the largest change of an area's share is small, without evenness it is not."""
    exemplar = np.full((128, 128, 1), 0.5, np.float32)
    exemplar[:48, :48] = 0
    exemplar[64:, 80:] = 1
    exemplar[96:, :80] = 0.25
    exemplar += np.random.default_rng(0).normal(0, 0.02, exemplar.shape).astype(np.float32)

    def areas(image):
        return np.histogram(image, [-1, 0.12, 0.37, 0.75, 2])[0] / image.size

    def lost(evenness):
        image = optimize(exemplar, width=256, height=256, evenness=evenness, rng=1).image
        return float(np.abs(areas(image) - areas(exemplar)).max())

    assert lost(2.0) < 0.15
    assert lost(0.0) > 0.2


def test_the_border_of_an_exemplar_is_shown():
    """An eighth on each side is 0.44 of an exemplar: by windows inside it alone 0.15 to 0.17 of outputs show that."""
    exemplar = pebbles(width=128, height=128, rng=2).image
    places = [optimize(exemplar, width=256, height=256, rng=seed).source[..., 1:3] for seed in (1, 2, 3)]
    outer = [np.minimum(place, 127 - place).min(axis=-1) < 16 for place in places]
    assert np.mean(outer) > 0.22


def test_pieces_of_grain_end():
    """Of all pairs of pixels half the exemplar apart 0.2 show one piece without a charge for going on."""
    exemplar = sample(name="gravel")[:128, :128]
    places = [optimize(exemplar, width=256, height=256, rng=seed).source[..., 1:3] for seed in (1, 2, 3)]
    down = [(each[64:] - each[:-64] == (64, 0)).all(axis=-1).mean() for each in places]
    right = [(each[:, 64:] - each[:, :-64] == (0, 64)).all(axis=-1).mean() for each in places]
    assert np.mean([down, right]) < 0.12


def test_copies_keep_apart():
    """An output of four times the area: without a charge for crowding 0.49 of it is shown again near by."""
    exemplar = bricks(width=128, height=128, rng=3).image
    sources = [optimize(exemplar, width=256, height=256, rng=seed).source for seed in (1, 2, 3)]
    assert np.mean([near_copies(source, 48) for source in sources]) < 0.4
