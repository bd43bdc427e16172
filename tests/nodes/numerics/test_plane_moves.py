import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from graphtex import Context
from graphtex_nodes.numerics.move_search import Level, anchors, fits, laid_flat
from graphtex_nodes.numerics.plane_moves import ORDER, Move, Slope, Views
from graphtex_nodes.numerics.spline_kernels import look_up

PLACES = np.array([3.0, 8.0, 15.0]), np.array([2.0, 9.0, 4.0])
TILTED = Slope(10.0, 7.0, 0.05, -0.02)


def test_plane_coordinates_by_hand():
    """Five rows below the place, scale is 1 + 5 * 0.1 = 1.5."""
    slope = Slope(2.0, 1.0, down=0.1)
    v, u = slope.to_plane(np.array([7.0]), np.array([4.0]))
    np.testing.assert_allclose([v[0], u[0]], [5 / 1.5, 2.0])


def test_picture_and_plane_are_inverse():
    for place, back in zip(PLACES, TILTED.to_picture(*TILTED.to_plane(*PLACES)), strict=True):
        np.testing.assert_allclose(back, place)


def test_move_sideways_follows_the_scale():
    """Where scale is twice that at the place, a shift by 3 is one by 6 pixels, in the same row."""
    rows, columns, enlarged = Move(Slope(0.0, 0.0, down=0.25), 0, 3).sources(np.array([0.0, 4.0]), np.array([0.0, 1.0]))
    np.testing.assert_allclose(rows, [0, 4])
    np.testing.assert_allclose(columns, [3, 7])
    np.testing.assert_allclose(enlarged, [1, 1])


def test_move_changes_size_by_the_ratio_of_scales():
    rows, columns, enlarged = Move(TILTED, 2, -1).sources(*PLACES)
    np.testing.assert_allclose(enlarged, TILTED.scale(*PLACES) / TILTED.scale(rows, columns))


def test_nothing_comes_from_beyond_the_vanishing_line():
    rows, columns, enlarged = Move(Slope(0.0, 0.0, down=0.1), 10, 0).sources(np.array([0.0]), np.array([0.0]))
    assert (rows[0], columns[0], enlarged[0]) == (-1, -1, 1)


def test_finer_move_takes_from_the_same_place():
    """Pixel i of the smaller picture has its centre at 2 i + 1/2 of the larger one."""
    coarse = Move(TILTED, 2, -1)
    rows, columns, _ = coarse.sources(*PLACES)
    fine_rows, fine_columns, _ = coarse.halved(-1).sources(*(2 * place + 0.5 for place in PLACES))
    np.testing.assert_allclose(fine_rows, 2 * rows + 0.5)
    np.testing.assert_allclose(fine_columns, 2 * columns + 0.5)


def test_plain_shifts_copy_exactly():
    picture = np.random.default_rng(0).random((20, 30, 3)).astype(np.float32)
    usable = np.ones((20, 30), bool)
    usable[5, 9] = False
    rows, columns = np.array([3, 2, 19]), np.array([4, 6, 6])
    colours, sound, _ = Views.of(picture, usable).moved(Move(Slope(0.0, 0.0), 3, 3), rows, columns)
    assert sound.tolist() == [True, False, False]
    np.testing.assert_array_equal(colours[0], picture[6, 7])


def level_of(picture, radius):
    y, x = np.mgrid[: picture.shape[0], : picture.shape[1]]
    hole = np.hypot(y - 90, x - 80) < radius
    return Level(np.where(hole[..., None], picture[~hole].mean(axis=0), picture).astype(np.float32), ~hole, hole)


def test_shift_of_a_periodic_picture_is_found():
    """All moves that fit are multiples of its periods, and fit exactly."""
    tile = np.random.default_rng(1).random((12, 15, 2)).astype(np.float32)
    level = level_of(np.tile(tile, (16, 12, 1)), 20)
    sheet = laid_flat(Slope(90.0, 80.0), level)
    found = fits(Slope(90.0, 80.0), sheet, anchors(sheet, 5), None, 2, Context())
    assert len(found) == 18  # two each of the band, of four wide discs and of four narrow ones
    for fit in found:
        assert fit.move.down % 12 == fit.move.right % 15 == 0
        assert fit.cost < 1e-6


@pytest.mark.parametrize("shape", [(20, 30, 3), (1, 7, 2), (3, 2, 1)])
def test_splines_between_pixels_are_scipys(shape):
    """Second method, at the corners and over the borders of small pictures too."""
    rng = np.random.default_rng(5)
    splines = rng.normal(size=shape).astype(np.float32)
    rows, columns = (rng.integers(0, 4 * side - 3, 200) / 4 for side in shape[:2])
    colours = np.empty((200, shape[2]), np.float32)
    look_up(splines, rows, columns, colours)
    for channel, found in zip(np.moveaxis(splines, -1, 0), colours.T, strict=True):
        expected = map_coordinates(channel, [rows, columns], order=ORDER, mode="mirror", prefilter=False)
        np.testing.assert_allclose(found, expected, atol=1e-6)


def test_fine_contrast_survives_between_pixels():
    """Stripes three pixels apart, seen half a pixel beside: cubic splines keep 0.87 of their contrast."""
    stripes = np.cos(2 * np.pi * np.arange(60) / 3).astype(np.float32)
    views = Views.of(np.tile(stripes, (60, 1))[..., None], np.ones((60, 60), bool))
    rows, columns = (places.ravel() for places in np.mgrid[20:40, 20:41])
    colours, usable, _ = views.moved(Move(Slope(0, 0), 0, 0.5), rows, columns)
    assert usable.all()
    assert 0.95 < colours.std() / stripes.std() <= 1
