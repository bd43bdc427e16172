"""Use of an exemplar, estimated from pictures: known layouts have known shares."""

import numpy as np
import pytest

from benchmarks.likeness import likeness


@pytest.fixture(scope="module")
def exemplar():
    """Random grey blobs of a few pixels: no two windows are alike."""
    from scipy.ndimage import gaussian_filter

    noise = gaussian_filter(np.random.default_rng(5).standard_normal((64, 64)), 1.5)
    return ((noise - noise.min()) / np.ptp(noise)).astype(np.float32)[..., None]


def test_tiling_is_coherent_and_covers_all(exemplar):
    found = likeness(np.tile(exemplar, (2, 2, 1)), exemplar)
    # pairs that straddle the borders of tiles break: at most 13 of 122 rows and columns hold such windows
    assert found.coherence > 0.88
    assert found.coverage == 1


def test_the_exemplar_itself_is_perfect(exemplar):
    assert likeness(exemplar, exemplar).coherence == 1


def test_half_of_the_exemplar_covers_half(exemplar):
    found = likeness(np.tile(exemplar[:32], (4, 2, 1)), exemplar)
    assert 0.4 < found.coverage < 0.6


def test_random_pixels_are_not_coherent(exemplar):
    noise = np.random.default_rng(0).permutation(exemplar.ravel()).reshape(exemplar.shape)
    assert likeness(noise, exemplar).coherence < 0.2


def test_small_pieces_are_less_coherent_than_large_ones(exemplar):
    def pieces(side):
        rng = np.random.default_rng(1)
        rows = []
        for _ in range(128 // side):
            corners = rng.integers(0, 64 - side + 1, (128 // side, 2))
            rows.append(np.hstack([exemplar[y : y + side, x : x + side] for y, x in corners]))
        return np.vstack(rows)

    # of windows of 7 pixels, 8-pixel pieces hold (2/8)^2 whole, 32-pixel pieces (26/32)^2
    small, large = (likeness(pieces(side), exemplar).coherence for side in (8, 32))
    assert small < 0.5
    assert large > 0.66
    assert large > small + 0.3


def test_flat_ground_counts_neither_way():
    """One blob on white: a picture with the same blob elsewhere uses all that there is to use."""
    y, x = np.mgrid[:48, :48]
    blob = np.ones((48, 48, 1), np.float32)
    blob[..., 0] -= np.exp(-((x - 15) ** 2 + (y - 15) ** 2) / 40).astype(np.float32)
    moved = np.roll(blob, (9, 6), axis=(0, 1))
    found = likeness(moved, blob)
    assert found.coherence > 0.9
    assert found.coverage > 0.9
    assert likeness(np.ones_like(blob), blob).coverage < 0.2


def test_constant_pictures_have_nothing_to_tell():
    flat = np.full((16, 16, 1), 0.5, np.float32)
    found = likeness(flat, flat)
    assert (found.coherence, found.coverage) == (1, 1)


@pytest.mark.parametrize(
    ("image", "exemplar", "message"),
    [
        ((16, 16, 3), (16, 16, 1), "image: expected 1 channels as in the exemplar, got 3"),
        ((7, 16, 1), (16, 16, 1), r"image: expected more than 7 pixels a side, got \(7, 16\)"),
        ((16, 16, 1), (16, 5, 1), r"exemplar: expected more than 7 pixels a side, got \(16, 5\)"),
    ],
)
def test_what_cannot_be_compared_is_refused(image, exemplar, message):
    with pytest.raises(ValueError, match=message):
        likeness(np.zeros(image, np.float32), np.zeros(exemplar, np.float32))
