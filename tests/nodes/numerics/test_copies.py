import numpy as np
import pytest
from scipy.ndimage import uniform_filter

from graphtex_nodes.numerics.copies import crowding, shown, stretch


def test_crowding_by_hand():
    """A line of 24 windows shows place (3, 3) at 4 and 8 and else (7, 7); half the exemplar of 8 x 8 places is 4.

    Around 6 the place is shown twice, around 4 and 5 once: what is there itself or beside it is no copy. Were all of
    the nine places around shown, that would be one copy.
    """
    field = np.full((1, 24, 2), 7, np.int32)
    field[0, [4, 8]] = 3
    seen = shown(field, (8, 8), 1)
    found = crowding(seen)
    assert seen.cell == 1
    assert found.shape == (1, 24, 8, 8)
    for place in ((3, 3), (2, 4)):
        assert found[0, :, *place] * 9 == pytest.approx([1] * 3 + [0] + [1, 1, 2, 1, 1] + [0] + [1] * 3 + [0] * 11)
    assert found[0, :, 1, 3].max() == 0


def test_crowding_against_sums_over_tiles():
    """Copies in the tiles up to so many away but for the nine nearest, averaged over cells by another library."""
    rng = np.random.default_rng(4)
    field = rng.integers(0, 20, (33, 21, 2)).astype(np.int32)
    seen = shown(field, (20, 23), 2)
    found, cell = crowding(seen), seen.cell
    reach = 2  # half the exemplar, 10 pixels, is 5 windows: tiles of a third of it, 2, and cells of half a tile
    assert (cell, found.shape) == (2, (17, 11, 10, 12))
    counts = np.zeros(found.shape)
    rows, columns = np.indices((33, 21))
    np.add.at(counts, (rows * 17 // 33, columns * 11 // 21, field[..., 0] // 2, field[..., 1] // 2), 1)
    for down, right in ((0, 0), (8, 5), (16, 10), (3, 9)):
        far, near = (
            counts[max(0, down - r) : down + r + 1, max(0, right - r) : right + r + 1].sum(axis=(0, 1))
            for r in (reach, 1)
        )
        expected = uniform_filter(far - near, 3, mode="nearest")
        np.testing.assert_allclose(found[down, right], expected, atol=1e-5)


def test_stretch_by_hand():
    """The exemplar of 12 x 12 places shown whole, in 6 x 6 tiles: around the first lie 21 of 72 that go on with it.

    This is true of its own four cells; beside them stand means over a cell and the eight around it.
    """
    whole = np.stack(np.mgrid[:12, :12], axis=-1).astype(np.int32)
    share, common = stretch(shown(whole, (12, 12), 1))
    assert share.shape == (6, 6, 12, 12)
    assert share[0, 0, 0, 0] == pytest.approx(21 / 72)
    assert share[0, 0, 1, 2] == pytest.approx(21 / 72 * 2 / 9)
    assert share[0, 0, 3:].max() == 0
    assert common > 0.1
    assert stretch(shown(whole % 4, (12, 12), 1))[1] == 0
