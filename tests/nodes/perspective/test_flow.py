"""Fields of directions: from patterns, from strokes, from pictures, and what Optimize makes of them."""

import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.image.exemplars.sand import sand
from graphtex_nodes.numerics.orientation import orientation_error
from graphtex_nodes.numerics.strokes import Stroke, Strokes
from graphtex_nodes.perspective.flow_from_image import flow_from_image
from graphtex_nodes.perspective.flow_from_strokes import flow_from_strokes
from graphtex_nodes.perspective.flow_pattern import flow_pattern
from graphtex_nodes.perspective.optimize import optimize

ROW, COLUMN = np.mgrid[:60, :80]


def stripes(angle, period=8.0):
    """Lines in a direction, degrees clockwise from right."""
    across = -COLUMN * np.sin(np.radians(angle)) + ROW * np.cos(np.radians(angle))
    return (0.5 + 0.5 * np.sin(2 * np.pi * across / period)).astype(np.float32)[..., None]


def apart(angles, other):
    """Difference of directions without heads, degrees."""
    return np.abs((np.asarray(angles, np.float64) - other + 90) % 180 - 90)


def drawn(*lines, **options):
    return Strokes(lines=tuple(Stroke(points=points, radius=2) for points in lines), **options)


def test_patterns_by_hand():
    """A picture of 3 x 3, y down: right of the middle, below, left of it, above."""
    around = [(1, 2), (2, 1), (1, 0), (0, 1)]
    radial, circular = (flow_pattern(pattern=kind, width=3, height=3) for kind in ("radial", "circular"))
    assert [radial[place] for place in around] == [0, 90, 180, -90]
    assert [circular[place] for place in around] == [90, 180, -90, 0]
    assert (flow_pattern(pattern="constant", width=2, height=1, angle=-30) == -30).all()


def test_wave_swings_once_and_stays_within():
    wave = flow_pattern(pattern="wave", width=200, height=3, swing=30)
    assert np.ptp(wave[:, 0]) == 0
    np.testing.assert_allclose([wave.min(), wave.max()], [-30, 30], atol=0.1)
    assert (np.diff(np.sign(wave[1])) != 0).sum() == 2


@pytest.mark.parametrize("kind", ["constant", "radial", "circular", "wave"])
@pytest.mark.parametrize("angle", [-180.0, 170.0])
def test_any_pattern_stays_in_range(kind, angle):
    field = flow_pattern(pattern=kind, width=1, height=7, angle=angle)
    assert field.shape == (7, 1)
    assert np.abs(field).max() <= 180


@pytest.mark.parametrize("units", ["pixels", "relative"])
def test_flow_runs_along_strokes(units):
    """On each stroke its tangent, half way between two the direction in between."""
    level, steep = ((0, 5), (79, 5)), ((0, 54), (79, 54 - 79 * np.tan(np.radians(30))))
    if units == "relative":
        level, steep = ([((x + 0.5) / 80, (y + 0.5) / 60) for x, y in line] for line in (level, steep))
    lines = tuple(Stroke(points=line, radius=2 if units == "pixels" else 2 / 80) for line in (level, steep))
    field = flow_from_strokes(strokes=Strokes(lines=lines, units=units), width=80, height=60)
    assert apart(field[5, 10:70], 0).max() < 3
    assert apart(field[51, 6], -30) < 3
    assert 5 < apart(field[23, 20], 0) < 25


def test_drawn_to_and_fro():
    """Without heads opposite strokes agree; arrows keep their own sense."""
    strokes = drawn([(10, 10), (70, 10)], [(70, 50), (10, 50)])
    assert apart(flow_from_strokes(strokes=strokes, width=80, height=60), 0).max() < 1
    arrows = flow_from_strokes(strokes=strokes, width=80, height=60, arrows=True)
    assert abs(arrows[10, 40]) < 5
    assert abs(arrows[50, 40]) > 175


def test_points_within_a_line_change_nothing():
    few, many = drawn([(5, 5), (75, 45)]), drawn([(5 + 7 * i, 5 + 4 * i) for i in range(11)])
    fields = [flow_from_strokes(strokes=strokes, width=80, height=60) for strokes in (few, many)]
    np.testing.assert_allclose(fields[0], fields[1], atol=1e-3)


@pytest.mark.parametrize("lines", [[], [[(3, 3)]], [[(3, 3), (3, 3)]]])
def test_strokes_without_direction(lines):
    with pytest.raises(ValueError, match="strokes: expected at least one line of two different points, got none"):
        flow_from_strokes(strokes=drawn(*lines), width=8, height=8)


@pytest.mark.parametrize("angle", [0, 25, 90, 140])
@pytest.mark.parametrize("window", [0.0, 6.0])
def test_grain_of_stripes(angle, window):
    flow = flow_from_image(stripes(angle), window=window)
    assert apart(flow.angle[12:-12, 12:-12], angle).max() < 1.5
    assert flow.anisotropy > 0.9


def test_no_grain():
    noise = np.random.default_rng(2).random((80, 80, 3)).astype(np.float32)
    told = []
    ctx = Context(threads=1, on_warning=told.append)
    assert flow_from_image(noise, ctx=ctx).anisotropy < 0.1
    assert flow_from_image(np.full((9, 9, 1), 0.5, np.float32), window=3.0, ctx=ctx).anisotropy == 0
    assert [("a window" in line, "no direction stands out" in line) for line in told] == [(True, True), (False, True)]


@pytest.fixture(scope="module")
def ripples():
    return np.array(sand(width=128, height=128, rng=11).image)


def test_grain_follows_the_field(ripples):
    """Ripples in circles: within 12 degrees in the mean; without the field they run level, 40 to 50 degrees off."""
    field = flow_pattern(pattern="circular", width=160, height=160)
    own = flow_from_image(ripples).angle
    guided = optimize(ripples, exemplar_angle=own, target_angle=field, ctx=Context(threads=1))
    plain = optimize(ripples, width=160, height=160, ctx=Context(threads=1))
    assert guided.image.shape == (160, 160, 3)
    assert orientation_error(guided.image, field) < 12
    assert orientation_error(plain.image, field) > 35
    assert guided.coverage > 0.5
    turned = np.unique(guided.source[..., 4])
    assert len(turned) >= 8
    assert (turned % 15 == 0).all()


def test_field_and_scale_together(ripples):
    scale = np.repeat(np.linspace(0.7, 1.4, 128, dtype=np.float32)[:, None], 128, axis=1)
    field = np.full((100, 90), 60, np.float32)
    results = [
        optimize(ripples, scale, scale, target_angle=field, width=90, height=100, ctx=Context(threads=threads))
        for threads in (1, 2)
    ]
    np.testing.assert_array_equal(results[0].image, results[1].image)
    assert orientation_error(results[0].image, field) < 20


def test_exemplar_without_turned_copies(ripples):
    told = []
    field = np.full((64, 64), 90, np.float32)
    optimize(ripples, target_angle=field, turn_step=0.0, ctx=Context(threads=1, on_warning=told.append))
    assert any("100% of the output asks for directions" in line for line in told)


def test_arrows_tell_up_from_down(ripples):
    """Lit ripples: a copy that stands on its head has the same grain, but is another picture."""
    field = np.full((64, 64), 180, np.float32)
    for arrows, angles in ((False, {0}), (True, {180})):
        made = optimize(ripples, target_angle=field, turn_step=30.0, arrows=arrows, ctx=Context(threads=1))
        angle = made.source[..., 4]
        assert np.mean(np.isin(angle, list(angles))) > 0.6


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 9, 1), (3, 3, 2), (5, 40, 16)])
def test_small_exemplars_turn(shape):
    exemplar = np.random.default_rng(1).random(shape).astype(np.float32)
    field = flow_pattern(pattern="radial", width=20, height=17)
    told = []
    ctx = Context(threads=1, on_warning=told.append)
    result = optimize(exemplar, target_angle=field, tileable="both", iterations=1, ctx=ctx)
    assert len(told) == 1
    assert "has room for windows of" in told[0]
    assert result.image.shape == (17, 20, shape[2])
    assert exemplar.min() - 1e-5 <= result.image.min() <= result.image.max() <= exemplar.max() + 1e-5


def test_partly_usable_and_known(ripples):
    """Turned copies show usable pixels alone, and known ones stay."""
    usable = np.zeros((128, 128), bool)
    usable[20:120, 10:110] = True
    known = np.zeros((48, 64), bool)
    known[:, :9] = True
    field = np.full((48, 64), 60, np.float32)
    start = ripples[:48, :64].copy()
    ctx = Context(threads=1)
    result = optimize(ripples, None, None, usable, start, known, target_angle=field, vote="discrete", ctx=ctx)
    np.testing.assert_array_equal(result.image[known], start[known])
    row, column = (np.rint(result.source[~known][:, axis]).astype(int) for axis in (1, 2))
    assert usable[row, column].all()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"exemplar_angle": np.zeros((9, 9))}, "exemplar_angle"),
        ({"target_angle": np.zeros((9, 9)), "turn_step": 1e-3}, r"turn_step: 179999 turned copies .* more than"),
        ({"exemplar_angle": np.zeros((128, 128))}, "target_angle: expected a map beside exemplar_angle"),
        ({"target_angle": np.full((9, 9), 400.0)}, r"target_angle: AngleMap lies in \[-360, 360\]"),
        (
            {"target_angle": np.zeros((9, 9)), "more_angle": [np.zeros((9, 9))]},
            "more_angle: expected one for each of 0",
        ),
    ],
)
def test_refuses(ripples, wrong, message):
    with pytest.raises(ValueError, match=message):
        optimize(ripples, **wrong)
