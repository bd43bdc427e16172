import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex import Context
from graphtex_nodes.perspective.scale_edit import scale_edit

LEFT = {"kind": "rectangle", "corner": [-9, -9], "opposite": [1.5, 9]}  # columns 0 and 1
STEPS = np.array([[0.5, 1, 2, 4]], np.float32)


def edited(scale, *edits, masks=None):
    """The edited map and the warnings."""
    told = []
    return scale_edit(scale, masks, edits=list(edits), ctx=Context(on_warning=told.append)), told


def quiet(scale, *edits, masks=None):
    result, told = edited(scale, *edits, masks=masks)
    assert told == []
    return result


@pytest.mark.parametrize(
    ("edit", "expected"),
    [
        ({"do": "magnify", "factor": 2}, [1, 2, 2, 4]),
        ({"do": "minify", "factor": 2}, [0.25, 0.5, 2, 4]),
        ({"do": "set", "value": 8}, [8, 8, 2, 4]),
        ({"do": "duplicate", "offset": [2, 0]}, [2, 4, 2, 4]),
        ({"do": "duplicate", "offset": [0.5, 0]}, [0.5**0.5, 2**0.5, 2, 4]),
        ({"do": "flatten"}, [0.5**0.5, 0.5**0.5, 2, 4]),
        ({"do": "flatten", "amount": 0.5}, [0.5**0.75, 0.5**0.25, 2, 4]),
        ({"do": "exaggerate", "factor": 3}, [0.25, 2, 2, 4]),
    ],
)
def test_worked_by_hand(edit, expected):
    """Scales 1/2, 1, 2, 4; the first two are edited. Their logarithms have the mean ln(1/2)/2."""
    np.testing.assert_allclose(quiet(STEPS, {**edit, "region": LEFT})[0], expected, rtol=1e-6)


@pytest.mark.parametrize("sigma", [23.0, 25.0, 60.0])
def test_smooths_as_a_gaussian_with_the_border_repeated(sigma):
    """A narrow Gaussian and a wide one, which is worked out in another way, against the sum itself."""
    scale = np.exp(np.random.default_rng(4).uniform(-1, 1, (40, 70))).astype(np.float32)
    expected = np.log(scale.astype(np.float64))
    for axis, count in enumerate(scale.shape):
        steps = np.arange(-round(4 * sigma), round(4 * sigma) + 1)
        weights = np.exp(-(steps**2) / (2 * sigma**2))
        matrix = np.zeros((count, count))
        for place in range(count):
            np.add.at(matrix[place], np.clip(place + steps, 0, count - 1), weights / weights.sum())
        expected = np.moveaxis(np.tensordot(matrix, expected, axes=(1, axis)), 0, axis)
    smooth = quiet(scale, {"do": "smooth", "sigma": sigma})
    np.testing.assert_allclose(smooth, np.exp(expected), rtol=1e-6)


def test_smoothing_is_that_of_logarithms():
    """In the middle of a wide symmetric step from 1/4 to 4 a Gaussian leaves 1; outside the region nothing changes."""
    scale = np.repeat(np.array([[0.25, 4.0]], np.float32), 20, axis=1)
    scale = np.insert(scale, 20, 1, axis=1)
    smooth = quiet(scale, {"do": "smooth", "sigma": 3, "region": LEFT | {"opposite": [25.5, 9]}})
    assert smooth[0, 20] == pytest.approx(1, abs=1e-6)
    assert (np.diff(smooth[0, :26]) >= 0).all()
    np.testing.assert_array_equal(smooth[0, 26:], scale[0, 26:])
    middle = quiet(scale, {"do": "smooth", "sigma": 1e9})
    assert np.ptp(middle) < 1.5


def test_no_edits_and_outside_of_all_regions_nothing_changes():
    scale = np.random.default_rng(0).uniform(0.125, 8, (9, 7)).astype(np.float32)
    np.testing.assert_array_equal(quiet(scale), scale)
    changed = quiet(scale, {"do": "set", "value": 1, "region": LEFT})
    np.testing.assert_array_equal(changed[:, 2:], scale[:, 2:])


def test_soft_edges_blend_in_log_scale():
    """Half way at the outline: the root of the factor."""
    soft = {"kind": "rectangle", "corner": [10, -99], "opposite": [99, 99], "softness": 6}
    assert quiet(np.ones((1, 30), np.float32), {"do": "magnify", "factor": 4, "region": soft})[0, 10] == pytest.approx(
        2
    )


def test_order_counts_and_the_last_entry_can_be_undone():
    first, second = {"do": "set", "value": 2}, {"do": "magnify", "factor": 2, "region": LEFT}
    both = quiet(STEPS, first, second)
    np.testing.assert_allclose(both[0], [4, 4, 2, 2], rtol=1e-6)
    np.testing.assert_array_equal(quiet(quiet(STEPS, first), second), both)
    np.testing.assert_allclose(quiet(STEPS, second, first)[0], 2, rtol=1e-6)


def test_clamps_at_the_end_only_and_tells_the_share():
    up, down = {"do": "magnify", "factor": 4, "region": LEFT}, {"do": "minify", "factor": 4, "region": LEFT}
    scale = np.array([[8, 4, 8, 0.125]], np.float32)
    result, told = edited(scale, up)
    np.testing.assert_allclose(result[0], [8, 8, 8, 0.125])
    assert told == ["50.0% of the scales left [1/8, 8] and were clamped"]
    np.testing.assert_allclose(quiet(scale, up, down), scale, rtol=1e-6)


def test_masks_by_index():
    some = np.array([[True, False, False, True]])
    edit = {"do": "set", "value": 1, "region": {"kind": "mask", "index": 1}}
    np.testing.assert_allclose(quiet(STEPS, edit, masks=[~some, some])[0], [1, 1, 2, 1])


@pytest.mark.parametrize(
    "edit",
    [
        {"do": "magnify", "factor": 1.7},
        {"do": "set", "value": 0.6},
        {"do": "duplicate", "units": "relative", "offset": [0.2, -0.125]},
        {"do": "flatten", "amount": 0.7},
        {"do": "exaggerate", "factor": 2},
        {"do": "smooth", "units": "relative", "sigma": 0.04},
    ],
)
@pytest.mark.parametrize(
    "region",
    [
        {"kind": "ellipse", "centre": [0.4, 0.5], "radii": [0.25, 0.15], "angle": 20, "softness": 0.1},
        {"kind": "polygon", "points": [[0.2, 0.2], [0.7, 0.3], [0.5, 0.8]], "softness": 0.1},
        {"kind": "strokes", "strokes": [[0.2, 0.3], [0.5, 0.6], [0.7, 0.4]]},
        {"kind": "whole"},
    ],
)
def test_twice_the_map_gives_twice_the_result(edit, region):
    """In relative units: the means of two by two pixels of the large result are the small one."""
    if region["kind"] == "strokes":
        line = {"points": region["strokes"], "radius": 0.08, "softness": 0.06}
        region = {"kind": "strokes", "strokes": {"units": "relative", "lines": [line]}}
    elif region["kind"] != "whole":
        region = {**region, "units": "relative"}

    def of_width(width):
        x = ((np.arange(width) + 0.5) / width)[None, :]
        y = ((np.arange(width * 3 // 4) + 0.5) / (width * 3 // 4))[:, None]
        scale = np.exp(0.5 * np.sin(4 * x) + 0.6 * y).astype(np.float32)
        return np.log(edited(scale, {**edit, "region": region})[0])

    small, large = of_width(80), of_width(160)
    apart = np.abs(large.reshape(60, 2, 80, 2).mean(axis=(1, 3)) - small)
    assert apart.max() < 0.03  # across the edges, which are 8 pixels wide
    assert apart.mean() < 0.002


@pytest.mark.parametrize(
    "region",
    [
        {"kind": "ellipse", "centre": [-50, 2], "radii": [3, 3]},
        {"kind": "strokes", "strokes": {"lines": [{"points": [[99, 99]], "radius": 5}]}},
        {"kind": "strokes", "strokes": {}},
    ],
)
def test_regions_outside_are_told(region):
    result, told = edited(STEPS, {"do": "set", "value": 1, "region": region})
    np.testing.assert_array_equal(result, STEPS)
    assert told == ["edits[0]: its region lies outside the map of 4 x 1 pixels: nothing changed"]


def test_duplicating_from_outside_is_told():
    result, told = edited(STEPS, {"do": "duplicate", "offset": [-2, 0]})
    np.testing.assert_allclose(result[0], [0.5, 0.5, 0.5, 1], rtol=1e-6)
    assert told == ["edits[0]: 50% of what is duplicated lies outside the map: the border is taken there"]


@given(
    size=st.tuples(st.integers(1, 9), st.integers(1, 9)),
    point=st.tuples(st.floats(-5, 12), st.floats(-5, 12)),
    radius=st.floats(0.01, 20),
    edit=st.sampled_from(
        [
            {"do": "magnify", "factor": 64},
            {"do": "duplicate", "offset": [3, -40]},
            {"do": "flatten"},
            {"do": "exaggerate", "factor": 64},
            {"do": "smooth", "sigma": 5},
        ]
    ),
)
def test_any_dab_on_a_tiny_map(size, point, radius, edit):
    region = {"kind": "strokes", "strokes": {"lines": [{"points": [point], "radius": radius}]}}
    scale = np.linspace(0.2, 5, size[0] * size[1], dtype=np.float32).reshape(size)
    result, _ = edited(scale, {**edit, "region": region})
    assert result.shape == size
    assert result.min() >= 0.125
    assert result.max() <= 8


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        ({"do": "enlarge", "factor": 2}, r"edits\.0: .*'magnify'.*got 'enlarge'"),
        ({"do": "magnify"}, r"edits\.0\.factor: a value is required"),
        ({"do": "magnify", "factor": 0.5}, r"edits\.0\.factor"),
        ({"do": "set", "value": 9}, r"edits\.0\.value"),
        ({"do": "flatten", "factor": 2}, r"edits\.0\.factor"),
        ({"do": "flatten", "region": {"kind": "mask"}}, r"edits\[0\]: index: .*mask 0"),
        ({"do": "flatten", "region": {"kind": "polygon", "points": [[0, 0], [1, 1]]}}, r"edits\.0\.region\.points"),
        (
            {"do": "flatten", "region": {"kind": "strokes", "strokes": {"file": "no.json"}}},
            r"edits\[0\]: file: no\.json",
        ),
    ],
)
def test_refuses(edit, told):
    with pytest.raises(ValueError, match=told):
        scale_edit(STEPS, edits=[edit])
