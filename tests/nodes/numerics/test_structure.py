import numpy as np
import pytest

from graphtex_nodes.image.exemplars.sample import sample
from graphtex_nodes.numerics.levels import FEW, Stage, automatic_levels, eased, fitting, most_levels, rim, stages
from graphtex_nodes.numerics.structure import grain, outlined, outlines, structure

NOISE = np.random.default_rng(0).random((128, 128, 1)).astype(np.float32)


def chequers(period, size=128):
    row, column = np.mgrid[:size, :size]
    return ((row // (period // 2) + column // (period // 2)) % 2).astype(np.float32)[..., None]


@pytest.mark.parametrize("period", [8, 12, 20])
def test_period_of_chequers(period):
    """The nearest repeat of chequers lies along the diagonal."""
    assert structure(chequers(period)).period == pytest.approx(period / 2**0.5, abs=0.5)


def test_period_survives_noise_and_shading():
    shading = np.linspace(0, 4, 128, dtype=np.float32)[:, None, None]
    assert structure(chequers(20) + shading + NOISE).period == pytest.approx(20 / 2**0.5, abs=1)


@pytest.mark.parametrize("image", [NOISE, NOISE[:5], np.ones((64, 64, 3), np.float32)])
def test_no_period(image):
    assert structure(image).period == 0


@pytest.mark.parametrize(
    ("image", "levels"), [(NOISE, 3), (chequers(16), 3), (chequers(40), 3), (chequers(48), 5), (NOISE[:9], 1)]
)
def test_automatic_levels(image, levels):
    assert automatic_levels(image) == levels


def test_reach_of_a_blur():
    """Means of 9 x 9 pixels of noise are related by (1 - y / 9) (1 - x / 9), which falls to 0.1 about 7 pixels away."""
    noise = np.random.default_rng(1).random((200, 200)).astype(np.float32)
    view = np.lib.stride_tricks.sliding_window_view(noise, (9, 9)).mean(axis=(2, 3))[..., None]
    assert structure(view).reach == pytest.approx(7.5, abs=1.5)
    assert structure(NOISE).reach == 0


def test_most_levels():
    assert [most_levels((side, 900)) for side in (1, 6, 7, 256)] == [1, 1, 2, 7]


def test_stages_by_hand():
    plan = stages((64, 200), 5, (16, 8), 4)
    coarse = [(4, 4, 18), (3, 4, 18), (2, 8, 12)]
    assert [(s.level, s.window, s.iterations) for s in plan] == [*coarse, (1, 16, 3), (1, 8, 3), (0, 8, 2)]


def test_eased_stages():
    plan = [Stage(2, 16, 5), Stage(2, 8, 5), Stage(1, 8, 5), Stage(0, 8, 3)]
    assert [stage.iterations for stage in eased(plan, 2, 1)] == [5, 5, 3, 2]
    assert [stage.iterations for stage in eased(plan, 0, 4)] == [2, 2, 0, 0]
    assert [stage.iterations for stage in eased(plan[2:], 0, 4)] == [2, 0]  # the coarsest level must search
    assert [stage.iterations for stage in eased(plan[3:], 0, 4)] == [1]


def test_automatic_windows():
    """Twice as large ones on the coarsest level alone."""
    plan = stages((64, 200), 2, (), 4)
    assert [(s.level, s.window, s.iterations) for s in plan] == [(1, 16, 3), (1, 8, 3), (0, 8, 2)]


@pytest.mark.parametrize("shape", [(1, 1), (3, 50), (17, 9)])
def test_windows_fit_the_exemplar(shape):
    for levels in range(1, most_levels(shape) + 1):
        for stage in stages(shape, levels, (64, 8), 1):
            assert 1 <= stage.window <= -(-min(shape) // 2**stage.level)


@pytest.mark.parametrize(("period", "window"), [(1, 8), (5, 4), (2, 1)])
def test_windows_fit_between_what_is_not_usable(period, window):
    """Lines each ``period`` pixels are not usable: the largest windows between them, not one that fits somewhere."""
    lines = np.arange(80) % period == (period - 1 if period > 1 else -1)
    usable = ~(lines[:, None] | lines)
    usable[:8, :8] = True
    assert fitting([Stage(0, 8, 3)], [usable]) == [Stage(0, window, 3)]


def test_few_usable_pixels_make_smaller_windows():
    """Of a square of 8 x 8 pixels a quarter are places of a window of 5 x 5."""
    usable = np.zeros((30, 30), bool)
    usable[10:18, 10:18] = True
    assert usable.sum() <= FEW
    assert fitting([Stage(0, 8, 3)], [usable]) == [Stage(0, 5, 3)]


@pytest.mark.parametrize(("name", "share"), [("sand", 0), ("pebbles", 1), ("bricks", 1), ("flowers", 1)])
def test_elements_have_outlines_and_grain_has_none(name, share):
    picture = sample(name=name)
    assert outlined(picture) == share
    assert outlined(3 * picture[::-1]) == share


def test_the_border_of_a_mask_is_no_outline():
    picture, usable = sample(name="sand"), np.zeros((256, 256), bool)
    usable[40:200, 60:220] = True
    masked = picture * usable[..., None]
    assert outlined(masked) == 1
    assert outlined(masked, usable) == 0


def test_nothing_has_no_outlines():
    assert outlined(np.zeros((1, 1, 3), np.float32)) == outlined(np.ones((9, 9, 1), np.float32)) == 0


@pytest.mark.parametrize(("side", "share"), [(4, 1), (10, 0.6), (40, 0)])
def test_small_elements_are_grain_whatever_their_outlines(side, share):
    """Pixels of discs are related over most of their diameter: a 64th, a 25th, or a sixth of the picture."""
    rows, columns = np.mgrid[:256, :256]
    places = np.random.default_rng(1).integers(0, 256, (2, 12000 // side**2))
    picture = np.zeros((256, 256, 1), np.float32)
    for row, column in places.T:
        picture[np.hypot(rows - row, columns - column) <= side / 2] = 1
    assert outlined(picture) == 1
    assert grain(picture) == pytest.approx(share, abs=0.1)


def test_rims_are_wider_in_grain():
    """A quarter of a window's side, three eighths in grain; none where parts may not be used, nor at one pixel."""
    assert [rim(window, None, 0.0) for window in (16, 8, 6, 1)] == [4, 2, 1, 0]
    assert [rim(window, None, 1.0) for window in (16, 8, 6, 1)] == [6, 3, 2, 0]
    assert rim(8, np.ones((20, 20), bool), 1.0) == 0


def test_noise_does_not_hide_outlines_from_squares():
    """Paving with noise of single pixels: neighbours differ by noise, squares of them by what they belong to."""
    noisy = chequers(64) + 0.8 * NOISE
    assert outlined(noisy) < 0.1
    assert outlines([noisy]) == 1
    assert outlines([NOISE]) == 0


def test_outlines_of_pictures_together():
    """The same for mirror images, for larger pictures, and for parts below each other with nothing between them."""
    blurred = np.kron(np.random.default_rng(4).random((31, 33)), np.ones((3, 3)))[..., None].astype(np.float32) ** 5
    share = outlines([blurred])
    assert 0 < share < 1
    assert outlines([blurred[:, ::-1]]) == pytest.approx(share, abs=1e-12)
    assert outlines([blurred, blurred]) == pytest.approx(share, abs=1e-12)
    assert outlines([blurred.repeat(4, 0).repeat(4, 1)], size=4) == pytest.approx(share, abs=1e-5)
    sheet = np.concatenate([blurred, np.full((9, 99, 1), 7, np.float32), blurred])
    assert outlines([sheet], sheet[..., 0] != 7) == pytest.approx(share, abs=1e-12)
    assert outlines([sheet]) != pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 9, 1), (2, 3, 1), (3, 2, 1)])
def test_pictures_too_small_for_outlines(shape):
    assert outlines([np.ones(shape, np.float32)]) == 0
    assert outlines([np.ones(shape, np.float32)], np.ones(shape[:2], bool)) == 0
    assert outlines([np.ones(shape, np.float32)], size=4) == 0
