import numpy as np
import pytest

from graphtex import Texture
from graphtex_nodes import extend_texture, sample_texture
from graphtex_nodes.splicing._fit import Fit
from graphtex_nodes.splicing.texton_labels import texton_labels
from tests.nodes.splicing.scenes import discs, grid


def test_factor_one_is_the_texture_itself():
    texture = sample_texture(name="leaves")
    extension = extend_texture(texture, factor=1.0)
    np.testing.assert_array_equal(extension.image, texture.image)
    np.testing.assert_array_equal(extension.mask, texture.mask)
    np.testing.assert_array_equal(extension.points, texture.points)
    assert extension[6:] == (0, 0, 192, 192)


def test_a_periodic_texture_goes_on_with_its_period():
    """Every pixel, every texton; the picture is no whole number of periods."""
    tile = np.random.default_rng(0).random((15, 13, 3)).astype(np.float32)
    rows, columns = np.mgrid[:50, :44]
    points = np.array([[x, y] for x in range(2, 44, 13) for y in range(2, 50, 15)], float)
    texture = Texture(tile[rows % 15, columns % 13], (rows % 15 < 5) & (columns % 13 < 5), points, "F=d")
    extension = extend_texture(texture, factor=1.6)
    rows, columns = np.mgrid[:80, :71]
    top, left = (80 - 50) // 2, (71 - 44) // 2
    np.testing.assert_array_equal(extension.image, tile[(rows - top) % 15, (columns - left) % 13])
    np.testing.assert_array_equal((extension.points - (left, top)) % (13, 15), np.full_like(extension.points, 2))
    assert len(np.unique(extension.points, axis=0)) == len(extension.points) == 6 * 6


@pytest.mark.parametrize("size", [(17, 13), (11, 30), (40, 36)])
@pytest.mark.parametrize("wanted", [(0, 0), (10, 12), (5, 9)])
def test_the_best_fit_of_all(size, wanted):
    """Against all shifts one by one, on canvases that are smaller than the piece, and larger ones."""
    rng = np.random.default_rng(4)
    piece, canvas = (rng.random((*shape, 2)).astype(np.float32) for shape in ((12, 15), size))
    known = rng.random(size) < 0.7
    canvas[~known] = 0
    tried = {}
    for shift in np.ndindex(12, 15):
        top, left = wanted[0] - shift[0], wanted[1] - shift[1]
        rows, columns = (
            np.arange(max(0, move), min(whole, move + side))
            for move, whole, side in zip((top, left), size, (12, 15), strict=True)
        )
        at = np.ix_(rows, columns)
        apart = ((piece[np.ix_(rows - top, columns - left)] - canvas[at]) ** 2).sum(axis=2)[known[at]]
        tried[top, left] = apart.size, known[at].size - apart.size, apart.sum() / max(apart.size, 1)
    shared = min(0.3 * 12 * 15, max(each[0] for each in tried.values()))
    added = 0.6 * max(each[1] for each in tried.values() if each[0] >= shared)
    allowed = {shift: each[2] for shift, each in tried.items() if each[0] >= shared and each[1] >= added}
    assert Fit(piece, size).best(canvas, known, wanted, 0.3, 0.6) == min(allowed, key=allowed.get)


@pytest.mark.parametrize("name", ["oranges", "berries", "tiles", "blossoms", "leaves"])
def test_all_follows_the_coordinates(name):
    texture = sample_texture(name=name)
    extension = extend_texture(texture, width=150, height=210)
    assert extension.image.shape == (315, 225, 3)
    row, column = np.moveaxis(extension.source[..., 1:3].astype(int), 2, 0)
    np.testing.assert_array_equal(extension.image, texture.image[row, column])
    np.testing.assert_array_equal(extension.mask, texture.mask[row, column])
    x, y = np.rint(extension.points).astype(int).T
    own = texture.points[:, None] - np.stack([column[y, x], row[y, x]], axis=1)
    assert np.abs(own).max(axis=2).min(axis=0).max() <= 0.5


@pytest.mark.parametrize("name", ["oranges", "tiles", "blossoms", "leaves"])
def test_few_elements_are_cut(name):
    """Whole elements have the size that they have in the texture: at most 5 % of the extension's are much smaller."""
    texture = sample_texture(name=name)
    extension = extend_texture(texture)

    def sizes(labels, count):
        border = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
        return np.bincount(labels[labels >= 0], minlength=count)[np.setdiff1d(np.arange(count), border)]

    usual = np.median(sizes(texton_labels(texture.mask, texture.points), len(texture.points)))
    assert np.mean(sizes(extension.labels, len(extension.points)) < 0.6 * usual) <= 0.05


@pytest.mark.parametrize("tag", ["F=d", "F=c", "B=c"])
def test_a_lone_element_is_repeated_with_ground_around_it(tag):
    """A disc of 13 px, off the middle, every 13 + 4 px: the pieces reach 4 px around it and share half of that."""
    noise = np.random.default_rng(1).normal(0, 0.02, (96, 96, 3))
    y, x = np.mgrid[:96, :96]
    mask = np.hypot(x - 30, y - 41) < 6.5
    image = (np.where(mask[..., None], 0.8, 0.3) + noise).astype(np.float32)
    extension = extend_texture(Texture(image, mask, np.array([[30.0, 41.0]]), tag))
    columns, rows = (np.unique(extension.points[:, axis]) for axis in (0, 1))
    np.testing.assert_array_equal(np.diff(columns), 17)
    np.testing.assert_array_equal(np.diff(rows), 17)
    assert len(extension.points) == len(columns) * len(rows) >= 64
    inside = ((extension.points > 8) & (extension.points < 135)).all(axis=1)
    sizes = np.bincount(extension.labels[extension.labels >= 0], minlength=len(extension.points))[inside]
    np.testing.assert_array_equal(sizes, np.count_nonzero(mask))
    row, column = np.moveaxis(extension.source[..., 1:3].astype(int), 2, 0)
    np.testing.assert_array_equal(extension.image, image[row, column])


def test_a_lone_element_that_fills_its_picture_stays_whole():
    """It is no more than 14 px from the border: no copy is laid over it."""
    y, x = np.mgrid[:128, :128]
    mask = np.hypot(x - 64, y - 64) < 50
    texture = Texture(np.where(mask[..., None], 0.8, 0.3).astype(np.float32), mask, np.array([[64.0, 64.0]]), "F=d")
    extension = extend_texture(texture)
    assert len(extension.points) == 1
    assert np.count_nonzero(extension.labels == 0) == np.count_nonzero(mask)
    np.testing.assert_array_equal(extend_texture(texture, factor=1.0).image, texture.image)


def test_a_window_smaller_than_the_texture():
    texture = discs(grid(), (64, 64))
    extension = extend_texture(texture, width=20, height=30, factor=1.0)
    np.testing.assert_array_equal(extension.image, texture.image[17:47, 22:42])


@pytest.mark.parametrize(("size", "tag"), [((1, 1), "F=c"), ((3, 17), "B=c"), ((40, 1), "F=d")])
def test_small_and_odd_sizes(size, tag):
    extension = extend_texture(discs([[0, 0]], size, tag=tag))
    assert extension.mask.shape == tuple(int(np.ceil(1.5 * side)) for side in size)


def test_channels():
    for channels in (1, 2, 16):
        image = np.random.default_rng(0).random((24, 24, channels)).astype(np.float32)
        extension = extend_texture(Texture(image, image[..., 0] >= image[3, 3, 0], np.array([[3.0, 3.0]]), "F=d"))
        assert extension.image.shape == (36, 36, channels)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"mask": np.zeros((9, 9), bool)}, r"texture: expected a mask of shape \(40, 40\) as the image, got \(9, 9\)"),
        ({"points": np.array([[50.0, 3.0], [1.0, 1.0]])}, "texture: expected points inside .* got 1 outside"),
        ({"tag": "x"}, "texture.tag: expected one of F=c, F=d, B=c, got 'x'"),
    ],
)
def test_refuses_what_does_not_fit(change, told):
    with pytest.raises(ValueError, match=told):
        extend_texture(discs([[9, 9]])._replace(**change))


def test_refuses_what_would_take_gigabytes():
    with pytest.raises(ValueError, match="texture: expected a window of at most 266666 pixels with factor"):
        extend_texture(discs([[9, 9]]), width=1000, height=1000)


def test_a_mask_without_elements_is_told():
    texture = discs([[9, 9]])
    with pytest.warns(UserWarning, match="no texton lies on the foreground"):
        extend_texture(texture._replace(mask=np.zeros((40, 40), bool)))
