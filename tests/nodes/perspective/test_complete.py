from functools import cache

import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.image.exemplars.bricks import bricks
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.image.maps import stack_maps
from graphtex_nodes.image.normals import normals_from_height
from graphtex_nodes.numerics.continuation import continued, fitted_plane
from graphtex_nodes.numerics.move_search import NARROW, Level, anchors, laid_flat
from graphtex_nodes.numerics.plane_moves import Slope
from graphtex_nodes.perspective.complete import complete
from tests.nodes.perspective.holes import KINDS, hole_of

QUIET = Context(threads=1)
BELOW, ACROSS = np.mgrid[:256, :256]
HOLE = np.hypot((ACROSS - 134) / 50, (BELOW - 140) / 40) < 1
RNG = np.random.default_rng(3)
NOISE = RNG.random((40, 50, 3)).astype(np.float32)
ROW, COLUMN = np.mgrid[:40, :50]
SLOPE = (0.5 + ROW * 0.02 + COLUMN * 0.01).astype(np.float32)


@cache
def plane(kind):
    made = pebbles(slant=55.0, rng=0) if kind == "pebbles" else bricks(kind="paving", size=40.0, slant=52.0, rng=0)
    return np.array(made.image), np.array(made.scale)


def size_error(scale, result, hole):
    """Mean of |log2| of the size of what was put in the hole over the size that belongs there."""
    rows, columns = (result.source[hole][:, k].astype(int) for k in (1, 2))
    shown = np.log2(scale[rows, columns]) + result.source[hole][:, 3]
    return np.abs(shown - np.log2(scale[hole])).mean()


@cache
def completed(kind, given, method, weight=1.25):
    photo, scale = plane(kind)
    return complete(photo, HOLE, scale if given else None, method=method, scale_weight=weight, ctx=QUIET)


@pytest.mark.parametrize(
    ("kind", "given", "method"),
    [
        ("pebbles", False, "pieces"),
        ("pebbles", True, "pieces"),
        ("paving", False, "pieces"),
        ("pebbles", False, "windows"),
        ("paving", True, "windows"),
    ],
)
def test_elements_in_the_hole_have_the_right_size(kind, given, method):
    """Within 10 %, with the scale map measured around the hole too; windows without a scale are off by over 25 %."""
    photo, scale = plane(kind)
    result = completed(kind, given, method)
    assert size_error(scale, result, HOLE) < np.log2(1.1)
    assert np.corrcoef(result.scale[HOLE], scale[HOLE])[0, 1] > 0.95
    np.testing.assert_array_equal(result.image[~HOLE], photo[~HOLE])
    if method == "windows":
        assert size_error(scale, completed(kind, given, method, 0.0), HOLE) > np.log2(1.25)


def test_windows_keep_to_a_measured_scale_in_a_large_hole():
    photo, scale = plane("pebbles")
    hole = np.hypot((ACROSS - 134) / 65, (BELOW - 140) / 52) < 1
    assert size_error(scale, complete(photo, hole, method="windows", ctx=QUIET), hole) < np.log2(1.1)


def test_seam_does_not_show():
    """Steps over the hole's border are like those elsewhere."""
    image = completed("pebbles", True, "pieces").image
    down = np.abs(np.diff(image, axis=0)).mean(axis=2)
    border = HOLE[1:] != HOLE[:-1]
    assert down[border].mean() < 1.2 * down[~HOLE[1:] & ~border].mean()


def test_outlines_go_on_over_the_border_of_a_hole():
    """Steps there are twice those of the original, where pebbles are cut; without narrow discs it was 2.6 times."""
    rows, columns = np.mgrid[:192, :192]
    hole = np.hypot((columns - 100) / 40, (rows - 95) / 34) < 1
    steps = []
    for seed in range(4):
        photo = np.array(pebbles(width=192, height=192, size=12.0, rng=seed).image)
        for picture in (complete(photo, hole, ctx=QUIET).image, photo):
            along = [np.abs(np.diff(picture, axis=axis)).mean(axis=2) for axis in (0, 1)]
            steps.append(sum(each[np.diff(hole, axis=axis)].mean() for axis, each in enumerate(along)))
    assert np.mean(np.divide(steps[::2], steps[1::2])) < 2.3


def test_anchors_are_wide_and_narrow_discs():
    """Around a hole of radius 20: the whole border, then discs as wide as it, then narrow ones; a small one has one."""
    rows, columns = np.mgrid[:90, :90]
    for size, radii in ((20.5, {20, NARROW}), (9.5, {9})):
        hole = np.hypot(rows - 45, columns - 45) < size
        level = Level(np.zeros((90, 90, 1), np.float32), ~hole, hole)
        (band, first), *discs = anchors(laid_flat(Slope(45.0, 45.0), level), 33)
        assert first == 0
        assert band[hole].all()
        assert [radius for _, radius in discs] == sorted((radius for _, radius in discs), reverse=True)
        assert {radius for _, radius in discs} == radii
        assert all(np.pi * radius**2 * 0.9 < disc.sum() < np.pi * (radius + 1) ** 2 for disc, radius in discs)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("scale", [None, SLOPE])
@pytest.mark.parametrize("continuation", ["plane", "harmonic"])
@pytest.mark.parametrize("method", ["pieces", "windows"])
def test_any_hole(kind, scale, continuation, method):
    hole = hole_of(kind)
    quiet = Context(threads=1, on_warning=lambda text: None)  # of two pixels no scale can be told
    result = complete(NOISE, hole, scale, continuation=continuation, method=method, iterations=1, ctx=quiet)
    np.testing.assert_array_equal(result.image[~hole], NOISE[~hole])
    np.testing.assert_array_equal(result.source[~hole, 1:3], np.argwhere(~hole))
    rows, columns = (result.source[..., k].astype(int) for k in (1, 2))
    assert not hole[rows, columns].any()
    if scale is not None:
        np.testing.assert_array_equal(result.scale[~hole], scale[~hole])
        if continuation == "plane" and kind != "nearly all":
            np.testing.assert_allclose(result.scale, SLOPE, atol=1e-4)


def test_what_is_in_the_hole_does_not_matter():
    hole = hole_of("corner")
    other = np.where(hole[..., None], np.float32(1), NOISE)
    for first, second in zip(complete(NOISE, hole, ctx=QUIET), complete(other, hole, ctx=QUIET), strict=True):
        np.testing.assert_array_equal(first, second)


def test_source_is_where_it_takes_from():
    hole, source = hole_of("corner"), np.zeros((40, 50), bool)
    source[25:, 30:] = True
    found = complete(NOISE, hole, source=source, scale_weight=0.0, ctx=QUIET).source[hole]
    assert (found[:, 1] >= 25).all()
    assert (found[:, 2] >= 30).all()


def test_only_the_surroundings_are_looked_at():
    """Far away from the hole the photo may be anything."""
    photo = RNG.random((300, 320, 1)).astype(np.float32)
    hole = np.zeros((300, 320), bool)
    hole[40:60, 50:70] = True
    other = photo.copy()
    other[190:] = 9
    first, second = (complete(picture, hole, iterations=1, ctx=QUIET) for picture in (photo, other))
    np.testing.assert_array_equal(first.image[hole], second.image[hole])
    assert first.source[hole, 1:3].max() < 70 + 128


def test_no_hole_changes_nothing():
    with pytest.warns(UserWarning, match="hole: nothing is marked, so the photo stays as it is"):
        result = complete(NOISE, np.zeros((40, 50), bool), SLOPE)
    np.testing.assert_array_equal(result.image, NOISE)
    np.testing.assert_array_equal(result.scale, SLOPE)
    np.testing.assert_array_equal(result.source[..., 1:3].astype(int), np.stack([ROW, COLUMN], axis=-1))


def test_pattern_on_a_plane_is_restored():
    """A chequered pattern whose scale is linear in the picture: pieces continue it, windows lose its order."""
    slope = Slope(80.0, 75.0, 0.006)
    rows, columns = np.mgrid[:160, :160]
    v, u = slope.to_plane(rows, columns)
    photo = (0.5 + 0.5 * np.sin(v * np.pi / 6) * np.sin(u * np.pi / 6)).astype(np.float32)[..., None]
    hole = np.zeros((160, 160), bool)
    hole[60:105, 50:100] = True
    scale = slope.scale(rows, columns).astype(np.float32)
    pieces, windows = (
        np.abs(complete(photo, hole, scale, method=method, ctx=QUIET).image - photo)[hole].mean()
        for method in ("pieces", "windows")
    )
    assert pieces < 0.01
    assert windows > 0.03


def test_periodic_picture_is_restored():
    tile = np.random.default_rng(2).random((10, 14, 3)).astype(np.float32)
    photo = np.tile(tile, (12, 9, 1))
    hole = np.zeros(photo.shape[:2], bool)
    hole[40:75, 50:90] = True
    hole[110:] = True
    np.testing.assert_allclose(complete(photo, hole, ctx=QUIET).image, photo, atol=1e-4)


@pytest.mark.parametrize("largest", [150_000, 8_000])
def test_pieces_are_cut_on_several_levels(largest, monkeypatch):
    """From a picture of a quarter of the sides up, moves stay right to the pixel."""
    monkeypatch.setattr("graphtex_nodes.numerics.hole_pieces.SEARCHED", largest)
    tile = np.random.default_rng(2).random((20, 28, 1)).astype(np.float32).repeat(4, axis=0).repeat(4, axis=1)
    photo = np.tile(tile, (4, 3, 1))
    hole = np.zeros(photo.shape[:2], bool)
    hole[101:160, 121:191] = True
    assert np.abs(complete(photo, hole, scale_weight=0.0, ctx=QUIET).image - photo)[hole].mean() < 1e-3


def test_far_parts_are_filled_each_from_its_own_surroundings():
    photo = RNG.random((100, 600, 1)).astype(np.float32)
    hole = np.zeros((100, 600), bool)
    hole[40:60, 50:70] = hole[40:60, 500:520] = True
    columns = complete(photo, hole, surroundings=60, ctx=QUIET).source[..., 2]
    assert columns[40:60, 50:70].max() < 130
    assert columns[40:60, 500:520].min() > 439


@pytest.mark.parametrize("method", ["pieces", "windows"])
def test_same_bytes_with_two_threads(method):
    photo = plane("pebbles")[0][80:180, 80:190]
    hole = np.zeros(photo.shape[:2], bool)
    hole[30:55, 35:70] = True
    first, second = (complete(photo, hole, method=method, ctx=Context(threads=threads)) for threads in (1, 2))
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("method", ["pieces", "windows"])
def test_material_maps_stay_aligned_and_normals_unit(method):
    """A map that says the same as another still does, and interpolated copies leave no short normals."""
    made = bricks(width=128, height=128, size=24.0, slant=40.0, rng=1)
    normals = normals_from_height(made.height, relief=4.0)
    kinds = ["colour", "normal", "colour", "scalar", "scalar"]
    stack = stack_maps([made.image, normals, made.image, *[made.height] * 2], kinds=kinds)
    hole = np.hypot(*(np.mgrid[:128, :128] - 64)) < 20
    image = complete(stack, hole, method=method, kinds=kinds, ctx=QUIET).image
    np.testing.assert_array_equal(image[~hole], stack[~hole])
    np.testing.assert_allclose(image[..., 6:9], image[..., :3], atol=2e-3)
    np.testing.assert_array_equal(image[..., 10], image[..., 9])
    length = np.linalg.norm(image[hole][:, 3:6] * 2 - 1, axis=1)
    np.testing.assert_allclose(length, 1, atol=0.0101)
    if method == "pieces":  # whose copies between pixels are so short that the test would see it
        plain = complete(stack, hole, ctx=QUIET).image
        assert abs(np.linalg.norm(plain[hole][:, 3:6] * 2 - 1, axis=1) - 1).max() > 0.02


@pytest.mark.parametrize(("method", "rows"), [("pieces", 96), ("windows", 10)])
def test_heights_meet_and_scalars_stay_as_copied(method, rows):
    """A pattern on a rising ramp: copies have its pattern but are 28 columns too high or low."""
    pattern = np.tile(np.random.default_rng(2).random((rows, 28, 3)).astype(np.float32), (10, 6, 1))[:96, :150]
    row, column = np.mgrid[:96, :150]
    ramp = (column / 60).astype(np.float32)[..., None]
    hole = np.hypot((row - 50) / 22, (column - 72) / 24) < 1
    kinds = ["colour", "height", "scalar"]
    stack = stack_maps([pattern, ramp, ramp], kinds=kinds)
    result = complete(stack, hole, method=method, scale_weight=0.0, kinds=kinds, ctx=QUIET)
    rows, columns = (result.source[hole][:, k].astype(int) for k in (1, 2))
    copied = ramp[rows, columns, 0]
    off = np.abs(copied - ramp[hole][:, 0]).mean()
    assert off > 0.005
    assert np.abs(result.image[hole][:, 4] - copied).mean() < (0 if method == "pieces" else 0.25 * off) + 1e-6
    assert np.abs(result.image[hole][:, 3] - ramp[hole][:, 0]).mean() < 0.15 * off


def test_doubts_normals_outside_the_hole_alone():
    """A hole that is blanked holds no normals, and is not read."""
    normals = np.full((40, 50, 3), (0.5, 0.5, 1), np.float32)
    hole = hole_of("nearly all")
    complete(np.where(hole[..., None], np.float32(0), normals), hole, kinds=["normal"], iterations=1, ctx=QUIET)
    with pytest.warns(UserWarning, match="photo: the third component of its normals is 0.00 in the mean"):
        complete(normals[..., ::-1].copy(), hole_of("corner"), kinds=["normal"], iterations=1)


def test_sprinkled_pixels_take_from_many_places():
    """With half of all pixels unknown hardly a window is whole; what is filled in still has the photo's colours."""
    photo, _ = plane("pebbles")
    hole = np.random.default_rng(0).random((256, 256)) < 0.5
    result = complete(photo, hole, ctx=QUIET)
    assert len(np.unique(result.source[hole][:, 1:3].astype(int), axis=0)) > 1000
    np.testing.assert_allclose(result.image[hole].mean(axis=0), photo[hole].mean(axis=0), atol=0.03)


@pytest.mark.parametrize("method", ["pieces", "windows"])
def test_a_plain_photo_recedes_nowhere(method):
    """Its mean in single precision differs from it, which must not be taken for texture; warnings would be errors."""
    photo, hole = np.full((96, 120, 3), 100 / 255, np.float32), np.zeros((96, 120), bool)
    hole[:30, :40] = True
    result = complete(photo, hole, method=method, ctx=Context(threads=1))
    assert (result.scale == 1).all()
    np.testing.assert_array_equal(result.image, photo)


def test_warnings_name_what_the_node_has():
    """Of a scale that hardly varies, and of one that the surroundings lack: there is no exemplar_scale, no resample."""
    told = []
    hole = hole_of("corner")
    ctx = Context(threads=1, on_warning=told.append)
    noisy = np.exp(RNG.normal(0, 0.05, SLOPE.shape)).astype(np.float32)
    scales = noisy, np.where(hole, np.float32(4), SLOPE)
    for scale in scales:
        complete(NOISE, hole, scale, continuation="given", method="windows", iterations=1, ctx=ctx)
    assert told[0].startswith("scale varies by 5% only, and not like a plane")
    assert told[-1].startswith("100% of the output asks for scales that the exemplar lacks")
    assert told[-1].endswith("the nearest are used there")


def test_given_scale_is_kept():
    scale = SLOPE[::-1].copy()
    result = complete(NOISE, hole_of("corner"), scale, continuation="given", iterations=1, ctx=QUIET)
    np.testing.assert_array_equal(result.scale, scale)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"hole": np.ones((40, 50), bool)}, "hole: expected some pixels outside"),
        ({"hole": np.ones((4, 5), bool)}, "hole"),
        ({"source": np.zeros((40, 50), bool)}, "source: expected some pixels"),
        ({"source": hole_of("corner")}, "source: expected some pixels"),
        ({"photo": np.full((40, 50, 3), 1e20, np.float32)}, "photo: expected the largest .* to 1e15"),
        ({"continuation": "given"}, "scale: expected a map"),
        ({"kinds": ["colour", "scalar"]}, "kinds: colour \\+ scalar are 4 channels, the picture has 3"),
    ],
)
def test_refuses(wrong, message):
    sockets = {"photo": NOISE, "hole": hole_of("corner"), **wrong}
    with pytest.raises(ValueError, match=message):
        complete(ctx=QUIET, **sockets)


def test_plane_ignores_what_does_not_lie_on_it():
    values = SLOPE + RNG.normal(0, 0.01, SLOPE.shape)
    values[:12, :20] = 4
    known = RNG.random(SLOPE.shape) < 0.8
    np.testing.assert_allclose(fitted_plane(values, known), SLOPE, atol=0.01)


@pytest.mark.parametrize("places", [[(3, 4)], [(3, 4), (3, 40)]])
def test_plane_through_too_few_pixels(places):
    known = np.zeros(SLOPE.shape, bool)
    for place in places:
        known[place] = True
    found = fitted_plane(SLOPE, known)
    np.testing.assert_allclose(found[known], SLOPE[known], atol=1e-5)
    np.testing.assert_allclose(found[0], found[-1], atol=1e-6)


def test_harmonic_values_are_means_of_their_neighbours():
    known = np.ones(SLOPE.shape, bool)
    known[10:25, 12:30] = False
    values = (SLOPE + RNG.random(SLOPE.shape) * 0.1).astype(np.float32)
    found = continued(values, known, True, Context()).astype(np.float64)
    mean = (found[:-2, 1:-1] + found[2:, 1:-1] + found[1:-1, :-2] + found[1:-1, 2:]) / 4
    inner = ~known[1:-1, 1:-1]
    np.testing.assert_allclose(found[1:-1, 1:-1][inner], mean[inner], atol=1e-4)
    np.testing.assert_array_equal(found[known], values[known])
