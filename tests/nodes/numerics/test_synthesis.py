import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.numerics import parallel
from graphtex_nodes.numerics.frames import Frame, transfer
from graphtex_nodes.numerics.levels import stages
from graphtex_nodes.numerics.problem import Problem, Settings
from graphtex_nodes.numerics.synthesis import synthesise
from graphtex_nodes.numerics.windows import Grid

RNG = np.random.default_rng(4)
EXEMPLAR = RNG.random((40, 36, 3)).astype(np.float32)
SCALE = np.repeat(np.linspace(0.5, 2, 40, dtype=np.float32)[:, None], 36, axis=1)
TARGET = np.repeat(np.linspace(0.5, 2, 50, dtype=np.float32)[:, None], 61, axis=1)


def run(problem, threads=1, seed=0, **settings):
    work = Context(threads)
    plan = stages(problem.exemplar.shape, 3, (16, 8), 2)
    return synthesise(problem, plan, Settings(**settings), np.random.default_rng(seed), work)


@pytest.mark.parametrize(
    "problem", [Problem(EXEMPLAR, (50, 61)), Problem(EXEMPLAR, (50, 61), SCALE[..., None], TARGET[..., None])]
)
def test_threads_and_bands_change_no_byte(problem, monkeypatch):
    first = run(problem)
    monkeypatch.setattr(parallel, "SLICE", 2e3)
    monkeypatch.setattr(parallel, "WORTH_THREADS", 0)
    second = run(problem, threads=3)
    np.testing.assert_array_equal(first.image, second.image)
    np.testing.assert_array_equal(first.source, second.source)
    assert first.energies == second.energies
    assert (run(problem, seed=1).source != first.source).any()


def test_held_and_free_guides():
    held = run(Problem(EXEMPLAR, (50, 61), SCALE[..., None], TARGET[..., None]))
    np.testing.assert_array_equal(held.image[..., 3], TARGET)
    free = run(Problem(EXEMPLAR, (50, 61), SCALE[..., None], TARGET[..., None], hold=False))
    assert free.image.shape == (50, 61, 4)
    assert (free.image[..., 3] != TARGET).any()
    assert run(Problem(EXEMPLAR, (50, 61), SCALE[..., None])).image[..., 3].std() > 0.1


def test_image_is_made_of_exemplar_values():
    """A weighted mean stays in each channel's range."""
    image = run(Problem(EXEMPLAR, (30, 20))).image
    assert image.min() >= EXEMPLAR.min() - 1e-5
    assert image.max() <= EXEMPLAR.max() + 1e-5


def on_canvas(grid):
    return Frame(grid.canvas, grid, (0, 0), (0, 0))


@pytest.mark.parametrize(("factor", "old", "new"), [(1, 16, 8), (2, 8, 8), (2, 16, 8), (1, 8, 8)])
def test_transfer_keeps_a_copy(factor, old, new):
    """A field that copies with one shift still does after the change of grid."""
    before, after = Grid(20, 20, old, old // 4), Grid(15, 14, new, new // 4)
    row, column = np.mgrid[:20, :20]
    field = np.stack([row * before.step + 7, column * before.step + 3], axis=-1).astype(np.int32)
    found = transfer(field, on_canvas(before), on_canvas(after), factor, (900, 900))
    row, column = np.mgrid[:15, :14]
    expected = np.stack([row * after.step + 7 * factor, column * after.step + 3 * factor], axis=-1)
    np.testing.assert_array_equal(found, expected)


def test_transfer_stays_inside():
    field = np.full((3, 3, 2), 5, np.int32)
    found = transfer(field, on_canvas(Grid(3, 3, 8, 2)), on_canvas(Grid(9, 9, 8, 2)), 2, (6, 4))
    assert found[..., 0].max() <= 5
    assert found[..., 1].max() <= 3
    assert found.min() >= 0


def test_transfer_between_rims():
    """Places without a rim double; counted from its corner they are as much more as it is wide."""
    row, column = np.mgrid[:20, :20]
    field = np.stack([row * 2 + 7, column * 2 + 3], axis=-1).astype(np.int32)
    frames = on_canvas(Grid(20, 20, 8, 2)), on_canvas(Grid(15, 14, 8, 2))
    inside = transfer(field, *frames, 2, (900, 900))
    np.testing.assert_array_equal(transfer(field + 4, *frames, 2, (900, 900), (4, 2)), inside + 2)


def test_transfer_stretches_what_wraps_around():
    """A period of 12 becomes one of 21: copies of one row of windows stay 0 to 2 pixels from their places."""
    before, after = (
        Frame.of((side, side), level, 8, 0, (True, True)) for side, level in ((24, 1), (21, 0))
    )  # fmt: skip
    field = np.zeros((before.grid.rows, before.grid.columns, 2), np.int32)
    field[..., 0] = (np.arange(before.grid.rows) * before.grid.step - before.margins[0])[:, None] + 50
    rows = transfer(field, before, after, 2, (900, 900))[:, 0, 0]
    place = np.arange(rows.size) * after.grid.step - after.margins[0]
    np.testing.assert_allclose(rows - 100, place * 24 / 21, atol=2)
