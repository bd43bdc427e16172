import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from graphtex_nodes.numerics.strokes import Strokes, polyline_distance, stroke_weights


def one(points, radius, **more):
    return Strokes(lines=({"points": points, "radius": radius, **more},))


def test_distance_worked_by_hand():
    """A segment from (1, 1) to (3, 1): above it the distance is across, beyond its ends to the ends."""
    distance = polyline_distance(np.array([[1.0, 1.0], [3.0, 1.0]]), 6, 3, reach=9)
    np.testing.assert_allclose(distance[1], [1, 0, 0, 0, 1, 2])
    np.testing.assert_allclose(distance[0], [2**0.5, 1, 1, 1, 2**0.5, 5**0.5])


def test_distance_of_a_point_and_its_reach():
    distance = polyline_distance(np.array([[2.0, 0.0]]), 6, 1, reach=2)
    np.testing.assert_array_equal(distance[0], [2, 1, 0, 1, 2, np.inf])


@given(
    points=st.lists(st.tuples(st.floats(-9, 20), st.floats(-9, 20)), min_size=1, max_size=4),
    reach=st.floats(0.5, 30),
)
def test_distance_is_that_to_many_points_of_the_line(points, reach):
    """A second method: the nearest of 400 points on each segment."""
    corners = np.array(points)
    share = np.linspace(0, 1, 400)[:, None]
    dense = np.concatenate(
        [a * (1 - share) + b * share for a, b in zip(corners, [*corners[1:], corners[-1]], strict=True)]
    )
    y, x = np.mgrid[:7, :11]
    expected = np.sqrt(((x[..., None] - dense[:, 0]) ** 2 + (y[..., None] - dense[:, 1]) ** 2).min(axis=-1))
    distance = polyline_distance(corners, 11, 7, reach=reach)
    near = np.isfinite(distance)
    np.testing.assert_allclose(distance[near], expected[near], atol=0.08)
    assert (expected[~near] >= reach - 0.08).all()
    assert near[expected < reach - 0.08].all()


def test_a_dab_covers_its_disc():
    """The sum of the weights is the disc's area, hard or soft, wherever its centre lies."""
    for softness in (0, 5):
        weights = stroke_weights(one([(20.3, 18.6)], 9, softness=softness), 40, 40)
        # a rim of width s that falls alike on both sides adds pi s²/20 (the smooth step's second moment)
        assert weights.sum() == pytest.approx(np.pi * (81 + max(softness, 1) ** 2 / 20), rel=2e-3)
        assert weights[19, 20] == 1
        assert weights[0, 0] == 0


def test_overlapping_strokes_do_not_add_up():
    both = Strokes(lines=({"points": ((2, 2),), "radius": 2}, {"points": ((2, 2), (3, 2)), "radius": 1.5}))
    assert stroke_weights(both, 6, 5).max() == 1


def test_labels_choose_strokes():
    both = Strokes(
        lines=({"points": ((1, 1),), "radius": 1, "label": "a"}, {"points": ((7, 1),), "radius": 1, "label": "b"})
    )
    a, b, none, every = (stroke_weights(both, 9, 3, label=label) for label in ("a", "b", "c", None))
    assert a[1, 1] == 1
    assert a[1, 7] == 0
    assert not none.any()
    np.testing.assert_array_equal(np.maximum(a, b), every)


def test_three_ways_to_say_the_same():
    """Pixels of the picture, pixels of one half as large, and relative units; (x + 1/2) scales, since -1/2 is the edge."""
    here = one([(9.5, 19.5), (29.5, 4.5)], 4, softness=2)
    small = Strokes(size=(20, 15), lines=({"points": ((4.5, 9.5), (14.5, 2)), "radius": 2, "softness": 1},))
    relative = Strokes(
        units="relative", lines=({"points": ((0.25, 2 / 3), (0.75, 1 / 6)), "radius": 0.1, "softness": 0.05},)
    )
    expected = stroke_weights(here, 40, 30)
    np.testing.assert_allclose(stroke_weights(small, 40, 30), expected, atol=1e-9)
    np.testing.assert_allclose(stroke_weights(relative, 40, 30), expected, atol=1e-9)


def test_dabs_stay_round_on_a_stretched_picture():
    """Drawn on 20 x 20, used on 80 x 20: places stretch, the radius takes the root of the ratio of areas."""
    weights = stroke_weights(Strokes(size=(20, 20), lines=({"points": ((9.5, 9.5),), "radius": 2},)), 80, 20)
    assert weights.sum() == pytest.approx(np.pi * 16, rel=0.02)
    assert np.abs(np.nonzero(weights.max(axis=0) == 1)[0].mean() - 39.5) < 1e-9


def test_read_from_a_file(tmp_path):
    file = tmp_path / "strokes.json"
    inline = one([(1, 1), (4, 2)], 1.5)
    file.write_text(inline.model_dump_json(exclude={"file"}))
    np.testing.assert_array_equal(stroke_weights(Strokes(file=file), 6, 5), stroke_weights(inline, 6, 5))


@pytest.mark.parametrize(
    ("text", "told"),
    [("{", "JSON"), ('{"lines": [{"points": [[1, 1]]}]}', r"lines\.0\.radius"), ('{"file": "b.json"}', "b.json")],
)
def test_files_that_hold_no_strokes(tmp_path, text, told):
    file = tmp_path / "strokes.json"
    file.write_text(text)
    with pytest.raises(ValueError, match=told):
        Strokes(file=file).read()


def test_a_missing_file(tmp_path):
    with pytest.raises(ValueError, match=r"nothing\.json cannot be read"):
        Strokes(file=tmp_path / "nothing.json").read()


@pytest.mark.parametrize(
    "wrong",
    [
        {"lines": [{"points": [], "radius": 1}]},
        {"lines": [{"points": [[1, 1]], "radius": 0}]},
        {"lines": [{"points": [[1, float("nan")]], "radius": 1}]},
        {"lines": [], "file": "a.json", "units": "relative"},
        {"size": [0, 5]},
    ],
)
def test_refuses(wrong):
    with pytest.raises(ValidationError):
        Strokes.model_validate(wrong)
