import numpy as np
import pytest

import graphtex
from graphtex import Elements, Texture, ViewStack
from graphtex.handlers import VIEWS
from graphtex.sockets import find_type
from graphtex_nodes.image import convert, views
from tests.nodes.image.files import noise

SAMPLES = {
    "Image": noise(5, 6, 3, dtype="float32"),
    "Mask": noise(5, 6) > 99,
    "ScaleMap": np.ones((5, 6), np.float32),
    "AngleMap": np.full((5, 6), 90, np.float32),
    "LabelMap": noise(5, 6).astype(np.int32),
    "Points": noise(7, 2, dtype="float64"),
    "Displacement": noise(5, 6, 2, dtype="float32"),
    "SourceMap": noise(5, 6, 6, dtype="float32"),
    "Elements": Elements(noise(7, 2, dtype="float64"), np.zeros(7), np.ones(7)),
    "Texture": Texture(noise(5, 6, 3, dtype="float32"), noise(5, 6) > 99, noise(3, 2, dtype="float64"), "rigid"),
    "ViewStack": ViewStack(noise(5, 4, 3, 1, dtype="float32"), np.zeros((5, 4))),
}
EMPTY = {
    "Mask": np.zeros((0, 3), bool),
    "ScaleMap": np.zeros((3, 0), np.float32),
    "AngleMap": np.zeros((0, 3), np.float32),
    "LabelMap": np.zeros((0, 0), np.int32),
    "Points": np.zeros((0, 2)),
    "Displacement": np.zeros((0, 3, 2), np.float32),
    "SourceMap": np.zeros((0, 3, 6), np.float32),
    "Elements": Elements(np.zeros((0, 2)), np.zeros(0), np.zeros(0)),
    "ViewStack": ViewStack(np.zeros((0, 4, 4, 3), np.float32), np.zeros((0, 4))),
}


def test_every_socket_type_has_a_view():
    """Numbers are the framework's; Vector, Views and Directions are parts of Elements and ViewStack."""
    own = {kind.name for kind in map(find_type, vars(graphtex).values()) if kind}
    assert own - {"Number", "Vector", "Views", "Directions"} == set(SAMPLES) <= set(VIEWS)


@pytest.mark.parametrize(("name", "value"), [*SAMPLES.items(), *EMPTY.items()])
def test_what_a_view_is(name, value):
    picture = VIEWS[name](value)
    assert picture.dtype == np.uint8
    assert picture.ndim == 3
    assert picture.shape[2] in (3, 4)
    assert picture.size


def test_image_by_channels():
    """Grey is repeated, alpha kept, further channels stand beside the colour, 4 pixels apart."""
    assert views.view_image(np.array([[[0.2]]], np.float32)).tolist() == [[[51, 51, 51]]]
    assert views.view_image(np.array([[[0.2, 0.4]]], np.float32)).tolist() == [[[51, 51, 51, 102]]]
    assert views.view_image(np.array([[[2.0, -1.0, 0.4, 1.0]]], np.float32)).tolist() == [[[255, 0, 102, 255]]]
    beside = views.view_image(np.array([[[0.2, 0.4, 0.6, 0.8, 1.0]]], np.float32))
    assert beside[0, [0, 5, 10]].tolist() == [[51, 102, 153], [204, 204, 204], [255, 255, 255]]
    assert beside.shape == (1, 11, 3)


def test_scale_is_128_where_it_is_1():
    assert views.view_scale(np.array([[1.0, 0.125, 1.5, 8.0]], np.float32))[0, :, 0].tolist() == [128, 16, 192, 255]


def test_labels_keep_their_colour():
    """A label has one colour in all pictures, and the first ones differ clearly."""
    first = views.view_labels(np.arange(12, dtype=np.int32)[None])
    np.testing.assert_array_equal(views.view_labels(np.array([[7]], np.int32))[0, 0], first[0, 7])
    apart = np.abs(first[0, :, None].astype(int) - first[0, None]).sum(axis=2) + 999 * np.eye(12, dtype=int)
    assert apart.min() > 40


def test_displacement_by_hand():
    """No shift is white; right is red; half as far is half as full."""
    shift = np.array([[[0, 0], [4, 0], [2, 0], [-4, 0]]], np.float32)
    expected = [[255, 255, 255], [255, 0, 0], [255, 128, 128], [0, 255, 255]]
    assert views.view_displacement(shift)[0].tolist() == expected


def test_angles_by_hand():
    """Right is red, down 90 degrees further round the circle of hues, left cyan; opposite ways of turning meet."""
    angles = np.array([[0, 90, 180, -270, 360]], np.float32)
    expected = [[255, 0, 0], [128, 255, 0], [0, 255, 255], [128, 255, 0], [255, 0, 0]]
    assert views.view_angles(angles)[0].tolist() == expected


def test_source_by_hand():
    """Columns grow red, rows green; mirrored pixels are lighter."""
    source = np.zeros((1, 3, 6), np.float32)
    source[0, :, 2] = [0, 10, 10]
    source[0, :, 1] = [5, 0, 5]
    source[0, 2, 5] = 1
    assert views.view_source(source)[0].tolist() == [[0, 255, 0], [255, 0, 0], [255, 255, 89]]


def test_points_keep_their_arrangement():
    """Four corners of a rectangle twice as wide as high: dots in the corners of the drawing."""
    drawing = views.view_points(np.array([[100, 50], [300, 50], [100, 150], [300, 150.0]]))
    rows, columns = np.nonzero(np.all(drawing == views._DOT, axis=2))
    assert drawing.shape == (256, 480, 3)
    assert {rows.min(), rows.max()} == {14, 242}
    assert {columns.min(), columns.max()} == {14, 466}


def test_texture_shows_background_dimmed():
    mask = np.zeros((4, 5), bool)
    mask[:, 0] = True
    picture = views.view_texture(Texture(np.zeros((4, 5, 3), np.float32), mask, np.zeros((0, 2)), "rigid"))
    assert picture.shape == (4, 14, 3)
    assert picture[0, [0, 9, 10], 0].tolist() == [0, 0, 160]


def test_stack_is_about_square():
    assert VIEWS["ViewStack"](SAMPLES["ViewStack"]).shape == (4 + 4 + 4, 3 + 4 + 3 + 4 + 3, 3)


def test_pictures_of_maps_are_their_views():
    for make, name in (
        (convert.image_from_labels, "LabelMap"),
        (convert.image_from_angles, "AngleMap"),
        (convert.image_from_displacement, "Displacement"),
        (convert.image_from_source, "SourceMap"),
    ):
        np.testing.assert_array_equal(np.rint(make(SAMPLES[name]) * 255), VIEWS[name](SAMPLES[name]))


def test_directions_are_seen_from_above():
    """Straight up is the middle; slant 90, tilt 90 is the right end of the rim."""
    picture = views.view_directions(np.array([[0.0, 0.0, 90.0, 90.0]]))
    assert picture[96, 96].tolist() == [214, 39, 40]
    assert picture[96, 96 + 88].tolist() == [31, 119, 180]
    assert picture[96, 96 - 88].tolist() == [255, 255, 255]


def test_bars_stand_on_zero():
    picture = views.view_vector(np.array([1.0, -1.0]))
    blue = (picture == (31, 119, 180)).all(axis=2)
    assert blue[:40, 0].all()
    assert not blue[60:, 0].any()
    assert blue[60:, -1].all()
    assert not blue[:40, -1].any()


@pytest.mark.parametrize("count", [0, 1, 5000])
def test_bars_of_any_number(count: int):
    assert views.view_vector(np.ones(count)).shape[2] == 3
