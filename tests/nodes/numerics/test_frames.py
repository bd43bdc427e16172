import numpy as np
import pytest

from graphtex_nodes.numerics.frames import Frame, nearest_places, replayed, whole_windows

RNG = np.random.default_rng(6)


def test_wrapped_canvas_repeats_and_crop_undoes_spread():
    values = RNG.random((12, 10, 2))
    frame = Frame.of((12, 10), 0, 8, 3, (True, False))
    canvas = frame.spread(values)
    np.testing.assert_array_equal(frame.crop(canvas), values)
    top, left = frame.margins
    assert left == 3
    np.testing.assert_array_equal(canvas[top - 5, left : left + 10], values[-5])
    np.testing.assert_array_equal(canvas[top + 12 + 4, left : left + 10], values[4])
    np.testing.assert_array_equal(canvas[top : top + 12, 0], values[:, 0])
    changed = canvas.copy()
    changed[:top] = -1
    frame.wrap_canvas(changed)
    np.testing.assert_array_equal(changed, canvas)


@pytest.mark.parametrize(("size", "step"), [((64, 36), 4), ((64, 34), 2), ((63, 64), 1), ((63, 33), 3)])
def test_steps_divide_what_wraps(size, step):
    frame = Frame.of(size, 0, 16, 0, (True, True))
    assert frame.grid.step == step
    assert frame.periods == size
    assert Frame.of(size, 1, 16, 0, (True, True)).grid.step == 4


def test_windows_repeat_with_the_canvas():
    """The window one period further down is the same window."""
    frame = Frame.of((12, 10), 0, 8, 0, (True, True))
    field = RNG.integers(0, 99, (frame.grid.rows, frame.grid.columns, 2)).astype(np.int32)
    frame.wrap_windows(field)
    np.testing.assert_array_equal(field[6:], field[:-6])
    np.testing.assert_array_equal(field[:, 5:], field[:, :-5])


def test_inside_is_where_the_output_is():
    frame = Frame.of((5, 6), 1, 4, 2, (False, True))
    inside = frame.inside()
    assert inside[2:5].all()
    assert not inside[:2].any()
    assert not inside[5:].any()


@pytest.mark.parametrize("step", [1, 3])
def test_whole_windows_against_views(step):
    mask = RNG.random((9, 11)) < 0.8
    views = np.lib.stride_tricks.sliding_window_view(mask, (3, 3))
    np.testing.assert_array_equal(whole_windows(mask, 3, step), views.all(axis=(2, 3))[::step, ::step])


def test_no_windows_in_less_than_one():
    assert whole_windows(np.ones((2, 9), bool), 3).size == 0


def test_nearest_places():
    allowed = np.zeros((4, 5), bool)
    allowed[0, 0] = allowed[3, 4] = True
    nearest = nearest_places(allowed)
    assert nearest[0, 1].tolist() == [0, 0]
    assert nearest[3, 3].tolist() == [3, 4]


def test_replayed_pixels_are_what_coarse_ones_stand_for():
    """By hand, for an exemplar of 5 rows: its last coarse row stands for one row alone."""
    source = np.array([[[2, 0], [0, 1]]], np.int32)
    expected = [[[4, 0], [4, 1], [0, 2]], [[4, 0], [4, 1], [1, 2]]]
    np.testing.assert_array_equal(replayed(source, 2, (2, 3), (5, 4, 1)), expected)
    assert replayed(source, 1, (1, 2), (5, 4, 1)) is source


def test_replay_of_a_copy_is_a_copy():
    places = np.stack(np.mgrid[:7, :9], axis=-1).astype(np.int32)
    coarse = np.stack(np.mgrid[:2, :3], axis=-1).astype(np.int32)
    np.testing.assert_array_equal(replayed(coarse, 4, (7, 9), (7, 9, 3)), places)


@pytest.mark.parametrize("wrap", [False, True])
@pytest.mark.parametrize(("size", "window"), [((13, 10), 8), ((40, 41), 6), ((1, 1), 8)])
def test_windows_whose_centres_lie_on_the_output_are_shown(size, window, wrap):
    frame = Frame.of(size, 1, window, window, (wrap, False))
    for axis, (part, count) in enumerate(zip(frame.shown(), (frame.grid.rows, frame.grid.columns), strict=True)):
        centres = np.arange(count) * frame.grid.step + window / 2 - frame.margins[axis]
        expected = (centres >= 0) & (centres < frame.size[axis])
        np.testing.assert_array_equal(np.arange(count)[part], np.flatnonzero(expected))
