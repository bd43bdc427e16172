import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics import membrane

RNG = np.random.default_rng(8)


def hole_in(shape, hole):
    source = np.stack(np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij"), axis=-1).astype(np.int32)
    source[~hole] = -1
    return source


def solved(image, source, exemplar, wrap=(False, False)):
    lack = np.zeros((image.shape[2], *image.shape[:2]), np.float32)
    usable, bends = np.ones(exemplar.shape[:2], bool), np.ones(image.shape[2], np.uint8)
    return membrane.join_known(image, lack, source, exemplar, usable, bends, wrap, Context())


def test_constant_step_vanishes(monkeypatch):
    """A piece that is 0.1 too dark all along its border is 0.1 too dark inside, if nothing pulls it back."""
    monkeypatch.setattr(membrane, "SCREEN", 1e-9)
    photo = (RNG.random((20, 22, 3)) * 0.5 + 0.25).astype(np.float32)
    hole = np.zeros((20, 22), bool)
    hole[5:12, 6:15] = True
    exemplar = photo - np.float32(0.1)
    exemplar[0, 0], exemplar[0, 1] = 0, 1  # room for the correction
    image = np.where(hole[..., None], exemplar, photo)
    result = solved(image, hole_in(hole.shape, hole), exemplar)
    np.testing.assert_allclose(result, photo, atol=2e-4)
    np.testing.assert_array_equal(result[~hole], photo[~hole])


def test_what_is_measured_is_not_bent_to_known_pixels():
    """Of three channels alike, the one that is not to be bent stays as it was copied."""
    photo = np.full((9, 10, 3), 0.5, np.float32)
    hole = np.zeros((9, 10), bool)
    hole[3:6, 3:7] = True
    image = np.where(hole[..., None], np.float32(0.25), photo)
    lack, every = np.zeros((3, 9, 10), np.float32), np.ones((9, 10), bool)
    exemplar, bends = np.where(np.arange(10) < 8, 0.25, 0.75)[:, None].repeat(3, 1)[None].repeat(9, 0), (0, 1, 2)
    made = membrane.join_known(
        image, lack, hole_in((9, 10), hole), exemplar.astype(np.float32), every, np.array(bends, np.uint8),
        (False, False), Context(),
    )  # fmt: skip
    np.testing.assert_array_equal(made[..., 0], image[..., 0])
    assert (made[hole][:, 1:] > 0.45).all()


@pytest.mark.parametrize("wrap", [(False, False), (True, True)])
def test_against_dense_solution(wrap):
    """Second method: the quadratic form is built pair by pair and minimised by a dense solver."""
    shape = (5, 6)
    known = RNG.random(shape) < 0.4
    image = RNG.random((*shape, 1)).astype(np.float32)
    exemplar = np.concatenate([RNG.random((*shape, 1)), [[[-9.0], [9.0]] * 3]]).astype(np.float32)
    source = hole_in(shape, ~known)
    number = {tuple(place): index for index, place in enumerate(np.argwhere(~known))}
    matrix = np.eye(len(number)) * membrane.SCREEN
    right_side = np.zeros(len(number))
    for (y, x), p in number.items():
        for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0)):
            ny, nx = y + dy, x + dx
            if wrap[0]:
                ny, nx = ny % 5, nx % 6
            if not (0 <= ny < 5 and 0 <= nx < 6):
                continue
            matrix[p, p] += 1
            if (ny, nx) in number:
                matrix[p, number[ny, nx]] -= 1
            else:
                inside = 0 <= y + dy < 6 and 0 <= x + dx < 6
                ahead = exemplar[y + dy, x + dx, 0] if inside else image[y, x, 0]
                right_side[p] += image[ny, nx, 0] - ahead
    expected = image[~known, 0] + np.linalg.solve(matrix, right_side)
    np.testing.assert_allclose(solved(image, source, exemplar, wrap)[~known, 0], expected, atol=1e-3)


@pytest.mark.parametrize("known", [np.zeros((4, 4), bool), np.ones((4, 4), bool)])
def test_nothing_to_join(known):
    image = RNG.random((4, 4, 2)).astype(np.float32)
    np.testing.assert_array_equal(solved(image, hole_in((4, 4), ~known), image), image)


def levelled(image, steps, wrap=(False, False), variance=1e9, threads=1, bends=None, reach=16):
    image = image.copy()
    bends = np.array([1] * image.shape[2] if bends is None else bends, np.uint8)
    limits = np.full(image.shape[2], -9, np.float32), np.full(image.shape[2], 9, np.float32)
    work = Context(threads=threads)
    membrane.level(image, membrane.missing(image, steps, variance, bends, wrap, work), limits, reach, wrap, work)
    return image


def differences(image):
    """Differences (2, h, w, c) to the pixels below and to the right, around the borders."""
    return np.stack([np.roll(image, -1, axis) - image for axis in (0, 1)])


@pytest.mark.parametrize("wrap", [(False, False), (True, False), (False, True), (True, True)])
@pytest.mark.parametrize("shape", [(5, 6), (4, 7), (1, 5), (6, 1)])
def test_levelling_against_dense_solution(wrap, shape):
    """Second method: the quadratic form is built pair by pair and minimised by a dense solver."""
    image = RNG.random((*shape, 2)).astype(np.float32)
    steps = RNG.normal(size=(2, *shape, 2)).astype(np.float32)
    number = np.arange(image[..., 0].size).reshape(shape)
    matrix = np.eye(number.size) / 16**2
    right_side = np.zeros((number.size, 2))
    for axis in (0, 1):
        for place in np.ndindex(shape):
            other = list(place)
            other[axis] += 1
            if other[axis] == shape[axis]:
                if not wrap[axis]:
                    continue
                other[axis] = 0
            here, there = number[place], number[tuple(other)]
            lack = steps[axis][place] - (image[tuple(other)] - image[place])
            for one, sign in ((here, -1), (there, 1)):
                right_side[one] += sign * lack
                matrix[one, there] += sign
                matrix[one, here] -= sign
    expected = image + np.linalg.solve(matrix, right_side).reshape(image.shape)
    np.testing.assert_allclose(levelled(image, steps, wrap), expected, atol=2e-4)


def test_a_step_between_pieces_becomes_a_slope():
    """Half a picture is brighter; its own differences know nothing of it."""
    texture = RNG.random((40, 80, 3)).astype(np.float32)
    brighter = texture.copy()
    brighter[:, 40:] += 0.2
    image = levelled(brighter, differences(texture))
    columns = (image - texture).mean(axis=(0, 2))
    assert np.abs(np.diff(columns)).max() < 0.01
    assert columns[-1] - columns[0] > 0.15
    np.testing.assert_allclose(columns[39:41].mean(), 0.1, atol=1e-3)


@pytest.mark.parametrize("reach", [4, 8, 16])
def test_a_correction_fades_as_far_as_it_reaches(reach):
    """Beside a step in one direction it is (1 + s) ** -distance with s = about 1 / reach."""
    image = np.zeros((3, 120, 1), np.float32)
    image[:, 60:] = 0.2
    row = levelled(image, np.zeros((2, *image.shape), np.float32), reach=reach)[1, :, 0]
    assert row[59 - reach] / row[59] == pytest.approx(np.exp(-1), rel=0.02)


def test_a_torn_outline_stays():
    image = np.zeros((20, 40, 1), np.float32)
    image[:, 20:] = 1
    flat = np.zeros((2, 20, 40, 1), np.float32)
    np.testing.assert_allclose(levelled(image, flat, variance=0.25), image, atol=1e-5)
    assert np.abs(levelled(image, flat, variance=16) - image).max() > 0.3


def test_heights_join_where_outlines_are_torn():
    """One cliff in three channels: of what is measured, of a colour, and of a height."""
    image = np.zeros((20, 40, 3), np.float32)
    image[:, 20:] = 1
    made = levelled(image, np.zeros((2, *image.shape), np.float32), variance=0.25, bends=(0, 1, 2))
    np.testing.assert_array_equal(made[..., 0], image[..., 0])
    np.testing.assert_allclose(made[..., 1], image[..., 1], atol=1e-4)
    alone = levelled(image[..., 2:], np.zeros((2, 20, 40, 1), np.float32))
    np.testing.assert_allclose(made[..., 2:], alone, atol=1e-5)
    assert np.abs(np.diff(made[..., 2], axis=1)).max() < 0.05


def test_what_lacks_nothing_is_not_touched():
    image = RNG.random((9, 7, 4)).astype(np.float32)
    np.testing.assert_array_equal(levelled(image, differences(image)), image)
    flat = np.ones((3, 3, 1), np.float32)
    np.testing.assert_array_equal(levelled(flat, differences(flat), variance=0), flat)


def test_levelled_values_stay_within_limits():
    image = np.zeros((6, 30, 1), np.float32)
    image[:, 15:] = 0.5
    limits = np.zeros(1, np.float32), np.full(1, 0.5, np.float32)
    steps = np.zeros((2, 6, 30, 1), np.float32)
    steps[1, :, 14] = 0.7
    lack = membrane.missing(image, steps, 1e9, np.ones(image.shape[2], np.uint8), (False, False), Context())
    membrane.level(image, lack, limits, 16, (False, False), Context())
    assert image.min() == 0
    assert image.max() == 0.5


def test_levelling_does_not_depend_on_threads():
    image = RNG.random((301, 207, 3)).astype(np.float32)
    steps = differences(RNG.random((301, 207, 3)).astype(np.float32))
    one = levelled(image, steps, (True, False), 1.0)
    assert all(np.array_equal(one, levelled(image, steps, (True, False), 1.0, count)) for count in (2, 3))
