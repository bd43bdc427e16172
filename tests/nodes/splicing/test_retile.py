import numpy as np
import pytest

from graphtex import Context, Texture
from graphtex_nodes import extend_texture, hungarian, retile
from graphtex_nodes.splicing._blocks import blocks, shape
from graphtex_nodes.splicing._walls import cell_forms, cells, turned
from tests.nodes.splicing.scenes import discs, elements, grid

JOINT = 4


def wall(size=(128, 160), period=(16, 32), tag="B=c", joint=JOINT) -> Texture:
    """Running bond: bricks of `period` less a joint (height, width), each of its own grey, with a white middle."""
    y, x = np.mgrid[: size[0], : size[1]]
    row = y // period[0]
    along = x + period[1] // 2 * (row % 2)
    mask = (y % period[0] >= joint) & (along % period[1] >= joint)
    grey = 0.3 + 0.4 * ((row * 7 + along // period[1] * 3) % 5) / 5
    image = np.where(mask, grey, 0.05)
    points = []
    for top in range(0, size[0], period[0]):
        start = period[1] // 2 * (top // period[0] % 2)
        for left in range(-start, size[1], period[1]):
            points.append([left + (period[1] + joint - 1) / 2, top + (period[0] + joint - 1) / 2])
    points = np.array([p for p in points if 0 <= p[0] <= size[1] - 1 and 0 <= p[1] <= size[0] - 1])
    for px, py in points:
        image[np.hypot(x - px, y - py) < 2] = 1
    return Texture(np.repeat(image[..., None], 3, axis=2).astype(np.float32), mask, points, tag)


def laid(texture, places, **parameters):
    extension = extend_texture(texture)
    moves = hungarian(extension, elements(places)).moves
    size = texture.mask.shape
    picture = (
        np.zeros((*size, 3), np.float32),
        np.zeros(size, bool),
        np.zeros((*size, 6), np.float32),
        np.ones(size, bool),
    )
    return picture, retile(texture, extension, moves, *picture, **parameters)


PERIOD = 22.3
SQUARES = grid(PERIOD, (128, 160), 9)


def test_each_place_gets_an_element_and_joints_keep_their_width():
    """From running bond to squares: a warp would have to slide rows of bricks along each other, and turn none."""
    _, found = laid(wall(), SQUARES)
    assert not found.holes.any()
    inner = [place for place in SQUARES if 22 <= place[0] < 138 and 22 <= place[1] < 106]
    for px, py in inner:
        own = found.cells == found.cells[round(py), round(px)]
        for part, most in ((own & found.mask, 0.75), (own & (found.image[..., 0] > 0.9), 1.5)):
            y, x = np.nonzero(part)
            assert np.hypot(x.mean() - px, y.mean() - py) < most
    rows = [~found.mask[round(y), round(9 + PERIOD) : round(9 + 5 * PERIOD)] for y in 9 + PERIOD * np.arange(1, 5)]
    columns = [~found.mask[round(9 + PERIOD) : round(9 + 4 * PERIOD), round(x)] for x in 9 + PERIOD * np.arange(1, 6)]
    assert abs(np.mean(rows) * PERIOD - JOINT) <= 0.1
    assert abs(np.mean(columns) * PERIOD - JOINT) <= 0.1


def test_colours_and_sources_are_those_of_the_texture():
    texture = wall()
    _, found = laid(texture, SQUARES)
    row, column = np.rint(found.source[..., 1:3]).astype(int).reshape(-1, 2).T
    shown = texture.mask[row, column].reshape(found.mask.shape)
    assert (shown == found.mask).mean() > 0.97
    assert found.image[~found.mask].mean() < 0.15 < 0.3 < found.image[found.mask].mean()


def test_gaps_get_elements():
    """Places in the left half only; the cells to the right are not wider than twice those."""
    _, found = laid(wall(), SQUARES[SQUARES[:, 0] < 80])
    assert np.bincount(found.cells.ravel()).max() < 2 * PERIOD**2


def test_any_arrangement_fills_the_window_the_same_way_each_time():
    texture = wall()
    places = np.random.default_rng(3).uniform(0, (159, 127), (50, 2))
    (_, first), (_, second) = laid(texture, places), laid(texture, places)
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one, other)
    assert np.isfinite(first.image).all()
    assert (first.cells >= 0).all()
    assert first.source[..., 1].max() <= 127
    assert first.source[..., 2].max() <= 159


def test_fewer_places_than_elements_are_laid():
    """Every second brick of a row is asked to stay where it is: a warp would leave those between."""
    texture = wall()
    _, found = laid(texture, texture.points[::2])
    assert (found.cells >= 0).all()
    assert len(np.unique(found.cells)) < 0.75 * len(texture.points)


@pytest.mark.parametrize(
    ("texture", "places", "parameters"),
    [
        (wall(tag="F=d"), SQUARES, {}),
        (wall(), SQUARES, {"when": "never"}),
        (wall(), wall().points + np.array([1, 2]), {}),  # a shift: the warp can follow
        (discs(grid(20, (128, 160), 10), (128, 160), 4, "B=c"), SQUARES, {}),  # no joints
    ],
)
def test_what_is_left_as_it_is(texture, places, parameters):
    picture, found = laid(texture, places, **parameters)
    for one, other in zip(picture, found[:4], strict=True):
        np.testing.assert_array_equal(one, other)
    assert (found.cells == -1).all()


def test_a_wall_of_cut_elements_is_left_with_a_warning():
    texture = wall((32, 48))
    extension = extend_texture(texture)
    places = extension.points - (extension.left, extension.top)
    moves = hungarian(extension, elements(places * (1, 1.4))).moves
    told = []
    picture = texture.image, texture.mask, np.zeros((32, 48, 6), np.float32), np.zeros((32, 48), bool)
    found = retile(texture, extension, moves, *picture, ctx=Context(on_warning=told.append))
    assert (found.cells == -1).all()
    assert ["laid anew" in each for each in told] == [True]


def test_refuses_a_picture_of_another_size():
    texture = wall()
    extension = extend_texture(texture)
    moves = hungarian(extension, elements(SQUARES)).moves
    holes, source = np.zeros((128, 160), bool), np.zeros((128, 160, 6), np.float32)
    with pytest.raises(ValueError, match=r"mask: expected shape \(128, 160\)"):
        retile(texture, extension, moves, texture.image[:9], holes[:9], source[:9], holes[:9])
    with pytest.raises(ValueError, match="image: expected 3 channels"):
        retile(texture, extension, moves, texture.image[..., :1], holes, source, holes)
    flat = moves._replace(scales=moves.scales * 0)
    with pytest.raises(ValueError, match="moves: expected positive scales, got 0"):
        retile(texture, extension, flat, texture.image, holes, source, holes)


def test_blocks_of_a_wall():
    """Whole bricks alone, of 12 x 28 pixels, with half a joint of 2 and right angles."""
    found = blocks(*wall()[1:3])
    assert found.joint == pytest.approx(JOINT / 2, abs=0.05)
    assert found.round < 1.5
    assert found.radius == pytest.approx(np.sqrt(12 * 28 / np.pi), rel=0.02)
    lengths = np.ptp(found.outlines, axis=1)
    np.testing.assert_allclose(lengths, np.broadcast_to([28, 12], lengths.shape), atol=0.7)


def test_ragged_elements_are_not_used():
    """A hole and a bite of two pixels are closed; a brick of which a corner is left, in the form of an L, is not used."""
    texture = wall()
    count = len(blocks(texture.mask, texture.points).outlines)
    for rows, columns, left in (((40, 42), (64, 66), 0), ((36, 38), (70, 72), 0), ((40, 48), (72, 96), 1)):
        mask = texture.mask.copy()
        mask[slice(*rows), slice(*columns)] = False
        assert len(blocks(mask, texture.points).outlines) == count - left


def test_round_stones_have_round_corners():
    points = grid(16, (96, 96), 8)
    y, x = np.mgrid[:96, :96]
    mask = np.hypot(x % 16 - 8, y % 16 - 8) < 7
    found = blocks(mask, points)
    assert found.round > 0.4 * found.radius


def test_shapes_differ_by_the_logarithm():
    """Turned by 90 degrees a brick is as different as one of the inverse proportion."""
    wide, tall = shape(np.diag([4.0, 1.0])), shape(np.diag([1.0, 4.0]))
    assert np.linalg.norm(wide - tall) == pytest.approx(np.linalg.norm(np.log([4, 1]) - np.log([1, 4])))
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    assert np.linalg.norm(shape(turn @ np.diag([4.0, 1.0]) @ turn.T)) == pytest.approx(np.linalg.norm(wide))


def test_cells_are_split_by_growth():
    """Two equal ellipses, then one that is three times as wide as the other: the border is at 3 to 1."""
    places = np.array([[20.0, 24.0], [40.5, 24]])
    owner, depth = cells(places, np.array([np.diag([9.0, 4])] * 2), (48, 60))
    np.testing.assert_array_equal(owner[24], np.arange(60) > 30.25)
    np.testing.assert_allclose(depth[24, 29:32], [1, 0.25, 0.75], atol=0.01)
    owner, depth = cells(places, np.array([np.diag([81.0, 4]), np.diag([9.0, 4])]), (48, 60))
    np.testing.assert_array_equal(owner[24, :46], np.arange(46) > 20 + 0.75 * 20.5)


def test_forms_of_cells_are_those_of_rectangles():
    owner = np.ones((40, 60), int)
    owner[:20] = 0
    owner[20:, 20:] = 2
    owner[39, 59] = 3
    forms = cell_forms(owner, 4)
    np.testing.assert_allclose(forms[0], np.diag([60**2, 20**2]) / 12, atol=1e-9)
    np.testing.assert_allclose(forms[1], np.diag([20**2, 20**2]) / 12, atol=1e-9)
    np.testing.assert_allclose(forms[3], np.median(forms[:3], axis=0))


def test_forms_are_turned_and_sized():
    forms = turned(np.array([np.diag([4.0, 1]), np.diag([4.0, 1])]), np.array([90.0, 45]), np.array([1.0, 2]))
    np.testing.assert_allclose(forms, [[[1, 0], [0, 4]], [[10, 6], [6, 10]]], atol=1e-12)


def test_elements_turn_where_their_places_do():
    """Bricks at places turned by 90 degrees stand upright: a mark at the left end of each is on top."""
    texture = wall()
    image = texture.image.copy()
    for x, y in texture.points:
        image[round(y) - 2 : round(y) + 3, max(round(x) - 12, 0) : max(round(x) - 8, 0)] = [0, 0, 1]
    texture = texture._replace(image=image)
    places = np.stack(np.meshgrid(np.arange(8.0, 160, 16), np.arange(16.0, 128, 32)), axis=-1).reshape(-1, 2)
    extension = extend_texture(texture)
    moves = hungarian(extension, elements(places, angles=90)).moves
    nothing = np.zeros((128, 160), bool)
    found = retile(texture, extension, moves, image, nothing, np.zeros((128, 160, 6), np.float32), nothing)
    for px, py in places[(places[:, 0] > 20) & (places[:, 0] < 140) & (places[:, 1] > 20) & (places[:, 1] < 100)]:
        own = found.cells == found.cells[round(py), round(px)]
        y, x = np.nonzero(own & found.mask)
        assert np.ptp(y) > 1.7 * np.ptp(x)
        y, x = np.nonzero(own & (found.image[..., 2] - found.image[..., 0] > 0.5))
        assert y.mean() < py - 6
        assert abs(x.mean() - px) < 2


def test_blocks_have_their_joint_in_the_picture():
    """Bricks whose joint the border cuts are not used, as of a row that the picture ends 1 pixel below."""
    texture = wall()
    cut = texture.mask[:65], texture.points[texture.points[:, 1] < 65]
    assert blocks(*cut).outlines[..., 1].max() < 48
    assert blocks(texture.mask[:67], cut[1]).outlines[..., 1].max() > 60
