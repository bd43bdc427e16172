import numpy as np
import pytest
from scipy import ndimage

from graphtex import Context
from graphtex_nodes.numerics.recut import Costs, _pieces, recut
from graphtex_nodes.numerics.sources import coherence

RNG = np.random.default_rng(5)
SIZE = 48
NOTHING = np.zeros((SIZE, SIZE, 2), np.float32)
EVEN = Costs(np.zeros(2, np.float32), 0.01, 1.0)


def places(left, right, cut=SIZE // 2, size=SIZE):
    """Source map of a piece from the exemplar's column ``left`` on, and right of the cut one from ``right`` on."""
    row, column = np.mgrid[:size, :size]
    return np.stack([row, column + np.where(column < cut, left, right)], axis=-1).astype(np.int32)


def two_pieces_that_agree_at(column):
    """A random exemplar in which the pieces from columns 0 and 60 on are alike around one column of the output.

    The left one can be continued up to column 35 of the output, the right one from column 13 on.
    """
    exemplar = RNG.random((SIZE, 120, 2)).astype(np.float32)
    exemplar[:, column + 59 : column + 61] = exemplar[:, column - 1 : column + 1]
    usable = np.ones((SIZE, 120), np.uint8)
    usable[:, 36:73] = 0
    return exemplar, usable


def total(exemplar, image, source, costs):
    """The whole cost, written down pixel by pixel."""
    height, width = source.shape[:2]
    cost = 0.0
    for y in range(height):
        for x in range(width):
            here = source[y, x]
            cost += (costs.pull * (exemplar[*here] - image[y, x]) ** 2).sum()
            for step in ((1, 0), (0, 1)):
                if y + step[0] == height or x + step[1] == width:
                    continue
                there = source[y + step[0], x + step[1]]
                if (there == here + step).all():
                    continue
                a, a_next, b, b_next = (exemplar[*at] for at in (here, here + step, there - step, there))
                apart = ((a - b) ** 2).sum() + ((a_next - b_next) ** 2).sum()
                change = ((a - a_next) ** 2).sum() + ((b - b_next) ** 2).sum()
                cost += costs.join + apart * costs.busy / (costs.busy + change)
    return cost


@pytest.mark.parametrize("column", [28, 32])
def test_seams_go_where_pieces_agree(column):
    exemplar, usable = two_pieces_that_agree_at(column)
    found = recut(exemplar, usable, NOTHING, places(0, 60), EVEN, Context())
    np.testing.assert_array_equal(found, places(0, 60, cut=column))


def test_scraps_are_taken_over():
    """A band of 8 columns of scraps between two pieces, as averages leave them."""
    exemplar, usable = two_pieces_that_agree_at(24)
    source = places(0, 60)
    source[:, 20:28] = RNG.integers(0, 30, (12, 2, 2)).repeat(4, axis=0).repeat(4, axis=1)
    found = recut(exemplar, usable, NOTHING, source, EVEN, Context())
    assert coherence(source) < 0.9
    np.testing.assert_array_equal(found, places(0, 60, cut=24))


def test_the_cost_falls():
    """From squares of 24 pixels at random, by a tenth and more; here a cost has all its parts."""
    exemplar = RNG.random((90, 90, 2)).astype(np.float32)
    image = RNG.random((96, 96, 2)).astype(np.float32)
    corners = RNG.integers(20, 46, (4, 4, 2)).repeat(24, axis=0).repeat(24, axis=1)
    source = (corners + np.stack(np.mgrid[:96, :96], axis=-1) % 24).astype(np.int32)
    costs = Costs(np.float32([0.01, 0.02]), 0.05, 0.3)
    found = recut(exemplar, np.ones((90, 90), np.uint8), image, source, costs, Context())
    assert total(exemplar, image, found, costs) < 0.9 * total(exemplar, image, source, costs)


def test_known_pixels_are_met():
    """What is known goes on in the right piece, which therefore takes over all that it can there."""
    exemplar, usable = two_pieces_that_agree_at(24)
    source, image = places(0, 60), NOTHING.copy()
    image[10:30, 3:20] = exemplar[10:30, 63:80]
    source[10:30, 3:20] = -1
    found = recut(exemplar, usable, image, source, EVEN, Context())
    np.testing.assert_array_equal(found[source < 0], -1)
    np.testing.assert_array_equal(found[10:30, 20:], places(60, 60)[10:30, 20:])


def test_unusable_pixels_are_not_taken():
    exemplar, usable = two_pieces_that_agree_at(18)
    usable[:, 78:84] = 0
    usable[:, 25:36] = 0
    found = recut(exemplar, usable, NOTHING, places(0, 60), EVEN, Context())
    np.testing.assert_array_equal(found, places(0, 60))


def test_pieces_grow_over_borders_that_join():
    """Of one piece, with a scrap along the border: only where the output wraps around is there more to gain."""
    exemplar = np.tile(RNG.random((SIZE, SIZE, 2)).astype(np.float32), (1, 3, 1))
    source = places(0, 0)
    source[:, :4] = places(30, 30)[:, :4]
    whole = recut(exemplar, np.ones(exemplar.shape[:2], np.uint8), NOTHING, source, EVEN, Context(), wrap=(False, True))
    np.testing.assert_array_equal(whole[..., 1] % SIZE, places(0, 0)[..., 1])


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (7, 50), (33, 2)])
@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
def test_any_size(size, wrap):
    exemplar = RNG.random((60, 60, 1)).astype(np.float32)
    source = np.stack(np.mgrid[: size[0], : size[1]], axis=-1).astype(np.int32)
    found = recut(
        exemplar, np.ones((60, 60), np.uint8), np.zeros((*size, 1), np.float32), source,
        Costs(np.ones(1, np.float32), 0.1, 1.0), Context(), wrap,
    )  # fmt: skip
    np.testing.assert_array_equal(found, source)


def test_scraps_that_nothing_takes_over_stay():
    """Where there is no large piece, seams stay as they are to the pixel."""
    exemplar = RNG.random((40, 40, 2)).astype(np.float32)
    corners = RNG.integers(0, 34, (10, 10, 2)).repeat(5, axis=0).repeat(5, axis=1)
    source = (corners + np.stack(np.mgrid[:50, :50], axis=-1) % 5).astype(np.int32)
    image = np.zeros((50, 50, 2), np.float32)
    found = recut(exemplar, np.ones((40, 40), np.uint8), image, source, EVEN, Context())
    np.testing.assert_array_equal(found, source)


def test_pieces_against_another_way_to_number_them():
    """Few shifts at random, so that parts meet in all ways; each shift's parts are numbered by SciPy on its own."""
    rng = np.random.default_rng(1)
    shifts = rng.integers(0, 2, (40, 31, 2)).astype(np.int32)
    labels, found = _pieces(shifts)
    covered = np.zeros(labels.shape, bool)
    for y, x in np.ndindex(2, 2):
        parts, count = ndimage.label((shifts == [y, x]).all(axis=-1))
        for part, (rows, columns) in enumerate(ndimage.find_objects(parts), 1):
            first = int(np.flatnonzero(parts == part)[0])
            number = labels.flat[first]
            np.testing.assert_array_equal(labels == number, parts == part)
            area, box = np.count_nonzero(parts == part), (rows.start, rows.stop, columns.start, columns.stop)
            assert found[number].tolist() == [first, area, *box]
        covered |= parts > 0
        assert count > 20
    assert covered.all()
    assert (np.diff(found[:, 0]) > 0).all()
