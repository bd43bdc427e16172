import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics.recut import Costs
from graphtex_nodes.numerics.seams import fade_seams, move_seams
from graphtex_nodes.numerics.sources import coherence

RNG = np.random.default_rng(2)
USABLE = np.ones((12, 60), np.uint8)


def two_pieces(cut):
    """Columns 0 .. 19 of the exemplar up to the cut, columns 30 .. 49 after it."""
    row, column = np.mgrid[:12, :20]
    return np.stack([row, np.where(column < cut, column, column + 30)], axis=-1).astype(np.int32)


def exemplar_that_agrees_at(column):
    """Random pixels, but both pieces have the same two columns there: the seam is free in between."""
    exemplar = RNG.random((12, 60, 3)).astype(np.float32)
    exemplar[:, column + 29 : column + 31] = exemplar[:, column - 1 : column + 1]
    return exemplar


def test_seam_moves_to_where_the_pieces_agree():
    exemplar = exemplar_that_agrees_at(9)
    source = two_pieces(8)
    image = np.zeros((12, 20, 3), np.float32)
    moved = move_seams(exemplar, USABLE, image, source, Costs(np.zeros(3, np.float32), 0.01, 1.0), 4, Context())
    np.testing.assert_array_equal(moved, two_pieces(9))
    np.testing.assert_array_equal(source, two_pieces(8))


def test_a_piece_that_fits_stays_whole():
    exemplar = RNG.random((12, 60, 3)).astype(np.float32)
    whole = two_pieces(20)
    image = np.zeros((12, 20, 3), np.float32)
    moved = move_seams(exemplar, USABLE, image, whole, Costs(np.ones(3, np.float32), 0.0, 1.0), 3, Context())
    np.testing.assert_array_equal(moved, whole)


def test_lone_pixel_is_absorbed():
    exemplar = RNG.random((12, 60, 3)).astype(np.float32)
    source = two_pieces(20)
    source[5, 6] = 3, 50
    moved = move_seams(
        exemplar, USABLE, exemplar[:, :20], source, Costs(np.full(3, 0.1, np.float32), 0.1, 1.0), 1, Context()
    )
    assert coherence(moved) == 1


def test_unusable_pixels_are_not_taken():
    exemplar = np.zeros((12, 60, 3), np.float32)
    usable = USABLE.copy()
    usable[:, 8:20] = 0
    image = np.zeros((12, 20, 3), np.float32)
    moved = move_seams(exemplar, usable, image, two_pieces(8), Costs(np.zeros(3, np.float32), 1, 1), 9, Context())
    assert usable[moved[..., 0], moved[..., 1]].all()


def test_fading_mixes_near_the_seam_only():
    exemplar = RNG.random((12, 60, 3)).astype(np.float32)
    source = two_pieces(10)
    image, _ = fade_seams(exemplar, USABLE, source, channels=3, work=Context())
    np.testing.assert_array_equal(image[:, :8], exemplar[:, :8])
    np.testing.assert_array_equal(image[:, 12:], exemplar[:, 42:50])
    left, right = exemplar[:, 9], exemplar[:, 39]
    share = ((image[:, 9] - left) * (right - left)).sum() / ((right - left) ** 2).sum()
    np.testing.assert_allclose(image[:, 9], left + share * (right - left), atol=1e-5)
    assert 0.2 < share < 0.5


def test_pieces_that_differ_meet_sharply():
    """A difference of 1 leaves nothing of the other piece's weight, one of 0.1 nearly all."""
    exemplar = np.zeros((12, 60, 1), np.float32)
    exemplar[:6, 30:], exemplar[6:, 30:] = 1, 0.1
    image, _ = fade_seams(exemplar, USABLE, two_pieces(10), channels=1, work=Context(), sharpness=4)
    smooth, _ = fade_seams(exemplar, USABLE, two_pieces(10), channels=1, work=Context())
    share = float(smooth[3, 9, 0])
    np.testing.assert_array_equal(image[:6, :, 0], exemplar[:6, two_pieces(10)[0, :, 1], 0])
    left = 0.96**2 * share / (1 - share + 0.96**2 * share)
    assert image[9, 9, 0] == pytest.approx(0.1 * left, rel=1e-4)


def test_fading_leaves_out_what_cannot_be_continued():
    """The right piece starts at the exemplar's first column: it cannot reach over the seam, the left one can."""
    exemplar = RNG.random((12, 60, 3)).astype(np.float32)
    row, column = np.mgrid[:12, :20]
    source = np.stack([row, np.where(column < 10, column + 20, column - 10)], axis=-1).astype(np.int32)
    image, _ = fade_seams(exemplar, USABLE, source, channels=3, work=Context())
    np.testing.assert_allclose(image[:, :10], exemplar[:, 20:30], atol=1e-6)
    assert np.abs(image[:, 10] - exemplar[:, 0]).max() > 0.01


def test_faded_differences_are_the_pieces_own():
    """A ramp and a brighter copy of it have the same differences everywhere, though their mean has a step."""
    exemplar = np.repeat(0.01 * np.mgrid[:12, :60][0][..., None] + 0.02 * np.mgrid[:12, :60][1][..., None], 2, axis=2)
    exemplar[:, 25:] += 0.3
    exemplar = exemplar.astype(np.float32)
    image, steps = fade_seams(exemplar, USABLE, two_pieces(10), channels=2, work=Context())
    assert np.diff(image, axis=1).max() > 0.1
    np.testing.assert_allclose(steps[0, :-1], 0.01, atol=1e-6)
    np.testing.assert_allclose(steps[1, :, :-1], 0.02, atol=1e-6)


def test_an_image_is_the_same_without_differences():
    exemplar = RNG.random((12, 60, 2)).astype(np.float32)
    image, _ = fade_seams(exemplar, USABLE, two_pieces(10), channels=2, work=Context())
    alone, steps = fade_seams(exemplar, USABLE, two_pieces(10), channels=2, work=Context(), differences=False)
    np.testing.assert_array_equal(alone, image)
    assert steps.size == 0


def test_differences_leave_out_what_cannot_be_continued():
    """Neither piece goes on beyond the exemplar's last row: no difference is wanted there."""
    exemplar = RNG.random((12, 60, 1)).astype(np.float32)
    _, steps = fade_seams(exemplar, USABLE, two_pieces(10), channels=1, work=Context())
    assert (steps[0, -1] == 0).all()
    np.testing.assert_array_equal(steps[0, :-1, 0], exemplar[1:, 0] - exemplar[:-1, 0])
