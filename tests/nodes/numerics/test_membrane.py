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
    return membrane.join_known(image, source, exemplar, np.ones(exemplar.shape[:2], bool), wrap, Context())


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
