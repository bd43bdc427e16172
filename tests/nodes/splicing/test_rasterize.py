import numpy as np
import pytest

from graphtex import Context, Texture
from graphtex_nodes import extend_texture, hungarian, rasterize
from graphtex_nodes.splicing.values import Moves
from tests.nodes.splicing.scenes import discs, elements, grid, whole


def still(extension) -> Moves:
    return hungarian(extension, elements(extension.points - (extension.left, extension.top))).moves


def constant(extension, x, y):
    return np.broadcast_to(np.array([x, y], np.float32), (*extension.mask.shape, 2)).copy()


def test_no_displacement_is_the_window():
    extension = extend_texture(discs(grid(), (64, 64)))
    drawn = rasterize(extension, still(extension), constant(extension, 0, 0), surplus=True)
    window = np.s_[extension.top : extension.top + 64, extension.left : extension.left + 64]
    np.testing.assert_allclose(drawn.image, extension.image[window], atol=1e-6)
    np.testing.assert_array_equal(drawn.mask, extension.mask[window])
    np.testing.assert_allclose(drawn.source, extension.source[window], atol=1e-5)
    assert not drawn.holes.any()


def test_a_shift_by_hand():
    """By 2 to the right and 1.5 down: two columns and two rows are left empty, and colours lie between pixels."""
    extension = whole(discs([[20, 20]]))
    drawn = rasterize(extension, still(extension), constant(extension, 2, 1.5))
    assert drawn.holes[:, :2].all()
    assert drawn.holes[:2].all()
    assert not drawn.holes[2:, 2:].any()
    np.testing.assert_allclose(drawn.source[10, 10, 1:3], [8.5, 8])
    between = (extension.image[8, 8] + extension.image[9, 8]) / 2
    np.testing.assert_allclose(drawn.image[10, 10], between, atol=1e-6)
    assert (drawn.source[drawn.holes][:, :3] == -1).all()


def folded(tag):
    """A picture 9 wide of which columns 5 and more are moved 4 to the left, so that 4 columns lie double."""
    image = np.tile(np.arange(9, dtype=np.float32)[:, None], (9, 1, 1))
    mask = np.zeros((9, 9), bool)
    mask[:, 5:] = True
    extension = whole(Texture(image, mask, np.array([[7.0, 4.0]]), tag))
    warp = np.zeros((9, 9, 2), np.float32)
    warp[:, 5:, 0] = -4
    return rasterize(extension, hungarian(extension, elements([[3, 4]])).moves, warp)


def test_rigid_parts_lie_on_top():
    """Columns 1 to 4 show 5 to 8 if these are rigid, and stay if the others are."""
    np.testing.assert_allclose(folded("F=d").image[4, 1:5, 0], [5, 6, 7, 8])
    np.testing.assert_allclose(folded("B=c").image[4, :4, 0], [0, 1, 2, 3])


def test_long_triangles_are_left_out():
    extension = whole(discs([[20, 20]]))
    warp = constant(extension, 0, 0)
    warp[:, 20:, 0] = 6
    moves = still(extension)
    holes = rasterize(extension, moves, warp).holes
    np.testing.assert_array_equal(np.flatnonzero(holes.all(axis=0)), [20, 21, 22, 23, 24, 25])
    assert not rasterize(extension, moves, warp, longest=8).holes.any()


def test_surplus_elements_are_not_drawn():
    """Nor those in which no texton was found; of a connected foreground all is drawn."""
    texture = discs([[10, 10], [30, 30], [10, 30]])._replace(points=np.array([[10.0, 10.0], [30.0, 30.0]]))
    for tag, left in (("F=d", [True, False, False]), ("F=c", [True, True, True])):
        extension = whole(texture._replace(tag=tag))
        moves = hungarian(extension, elements([[10, 10]])).moves
        drawn = rasterize(extension, moves, constant(extension, 0, 0))
        assert [bool(drawn.mask[y, x]) for x, y in ((10, 10), (30, 30), (10, 30))] == left
        assert bool(drawn.holes[30, 30]) is not left[1]


def test_threads_change_nothing():
    extension = extend_texture(discs(grid(), (64, 64)))
    warp = np.random.default_rng(1).normal(0, 1.5, (*extension.mask.shape, 2)).astype(np.float32)
    one, two = (rasterize(extension, still(extension), warp, ctx=Context(threads=count)) for count in (1, 2))
    assert all(a.tobytes() == b.tobytes() for a, b in zip(one, two, strict=True))


@pytest.mark.parametrize("size", [(1, 1), (1, 9), (9, 1)])
def test_what_has_no_triangle_is_a_hole(size):
    extension = whole(discs([[0, 0]], size))
    assert rasterize(extension, still(extension), constant(extension, 0, 0)).holes.all()


def test_refuses():
    one, other = whole(discs(grid(), (64, 64))), whole(discs([[20, 20]]))
    with pytest.raises(ValueError, match=r"warp: expected shape \(64, 64, 2\) as elements, got \(40, 40, 2\)"):
        rasterize(one, still(one), constant(other, 0, 0))
    with pytest.raises(ValueError, match="moves: expected 16 textons as elements, got 1"):
        rasterize(one, still(other), constant(one, 0, 0))


def test_rims_of_surplus_elements_are_not_drawn_either():
    extension = whole(discs([[10, 10], [30, 30]]))
    moves = hungarian(extension, elements([[10, 10]])).moves
    holes = rasterize(extension, moves, constant(extension, 0, 0)).holes
    y, x = np.mgrid[:40, :40]
    distance = np.maximum(np.hypot(x - 30, y - 30) - 4, 0)
    assert holes[distance <= 1].all()
    assert not holes[distance > 4].any()
