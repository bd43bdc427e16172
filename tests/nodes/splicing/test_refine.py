import numpy as np
import pytest

from graphtex import Context, Texture
from graphtex_nodes import neighbour_sets, refine, sample_texture
from tests.nodes.splicing.scenes import discs, grid


def drawn(texture, holes):
    """A texture as it would come out of a warp that moves nothing, with holes."""
    height, width = texture.mask.shape
    source = np.zeros((height, width, 6), np.float32)
    source[..., 1:3] = np.moveaxis(np.mgrid[:height, :width], 0, -1)
    image, mask = texture.image.copy(), texture.mask.copy()
    image[holes], mask[holes], source[holes] = 0, False, -1
    return image, mask, source, holes


def box(shape, *where):
    holes = np.zeros(shape, bool)
    holes[where] = True
    return holes


@pytest.fixture(scope="module")
def stripes():
    """Diagonal stripes with a period of 8 pixels, and a disc here and there."""
    y, x = np.mgrid[:64, :64]
    texture = discs(grid(32, (64, 64), 16), (64, 64))
    ground = 0.5 + 0.4 * np.sin((x + y) * np.pi / 4)
    image = np.where(texture.mask[..., None], texture.image, ground[..., None]).astype(np.float32)
    return Texture(image, texture.mask, texture.points, "F=d")


def test_each_pixel_is_the_first_of_its_set():
    texture = discs(grid(), (48, 40))._replace(points=np.zeros((0, 2)))
    sets = neighbour_sets(texture, count=4)
    for indices in (sets.fine_sets, sets.coarse_sets):
        np.testing.assert_array_equal(indices.reshape(-1, 4)[:, 0], np.arange(48 * 40))


def test_similar_pixels_of_a_period_are_equal_and_apart():
    tile = np.random.default_rng(0).random((12, 12, 3)).astype(np.float32)
    row, column = np.mgrid[:48, :48]
    texture = Texture(tile[row % 12, column % 12], np.zeros((48, 48), bool), np.zeros((0, 2)), "F=d")
    sets = neighbour_sets(texture)
    place = np.stack(np.divmod(sets.fine_sets.reshape(48, 48, 3), 48), axis=-1)[4:-4, 4:-4]
    # a window cut by the border has no equal; of the others nearly all are found
    assert np.mean((place[:, :, 1:] - place[:, :, :1]) % 12 == 0) > 0.97
    assert (np.abs(place[:, :, 1:] - place[:, :, :1]).max(axis=3) >= 2).all()


def test_a_hole_is_filled_with_what_belongs_there(stripes):
    """The stripes go on through a hole 12 pixels wide: the error is less than half that of random pixels."""
    holes = box((64, 64), slice(26, 38), slice(26, 38))
    found = refine(stripes, neighbour_sets(stripes), *drawn(stripes, holes))
    truth = stripes.image[holes]
    error = np.abs(found.image[holes] - truth).mean()
    ground = stripes.image[~stripes.mask]
    naive = np.abs(ground[np.random.default_rng(1).integers(0, len(ground), len(truth))] - truth).mean()
    assert error < 0.5 * naive
    assert not found.mask[holes].any()


@pytest.mark.parametrize("name", ["oranges", "tiles"])
def test_rigid_pixels_keep_their_colours(name):
    texture = sample_texture(name=name)
    holes = box((192, 192), slice(50, 60), slice(90, 120))
    image, mask, source, holes = drawn(texture, holes)
    found = refine(texture, neighbour_sets(texture), image, mask, source, holes)
    rigid = (mask if name == "oranges" else ~mask) & ~holes
    np.testing.assert_array_equal(found.image[rigid], image[rigid])
    np.testing.assert_array_equal(found.source[rigid], source[rigid])
    outside = ~holes & ~rigid
    assert np.mean(found.mask[outside] == mask[outside]) > 0.97


def test_every_pixel_is_that_of_its_source(stripes):
    holes = box((64, 64), slice(5, 20), slice(30, 60))
    found = refine(stripes, neighbour_sets(stripes), *drawn(stripes, holes), jitter=4)
    row, column = np.moveaxis(found.source[..., 1:3].astype(int), 2, 0)
    np.testing.assert_array_equal(found.image, stripes.image[row, column])
    np.testing.assert_array_equal(found.mask, stripes.mask[row, column])


def test_threads_change_nothing_and_seeds_do(stripes):
    sets = neighbour_sets(stripes)
    holes = box((64, 64), slice(5, 20), slice(30, 60))
    one, two, other = (
        refine(stripes, sets, *drawn(stripes, holes), rng=seed, ctx=Context(threads=count))
        for seed, count in ((0, 1), (0, 2), (1, 1))
    )
    assert all(a.tobytes() == b.tobytes() for a, b in zip(one, two, strict=True))
    assert one.image.tobytes() != other.image.tobytes()


@pytest.mark.parametrize("tag", ["F=d", "B=c"])
@pytest.mark.parametrize("value", [False, True])
def test_masks_of_one_kind(tag, value):
    """Nothing rigid, or all of it: holes are filled all the same."""
    image = np.random.default_rng(0).random((20, 30, 1)).astype(np.float32)
    texture = Texture(image, np.full((20, 30), value), np.zeros((0, 2)), tag)
    holes = box((20, 30), slice(3, 9), slice(4, 20))
    found = refine(texture, neighbour_sets(texture), *drawn(texture, holes))
    assert (found.source[..., 1:3] >= 0).all()
    assert (found.image[holes] > 0).all()


@pytest.mark.parametrize("size", [(1, 1), (1, 7), (3, 2)])
def test_small_sizes_and_nothing_but_holes(size):
    texture = discs([[0, 0]], size, 0.5)
    found = refine(texture, neighbour_sets(texture), *drawn(texture, np.ones(size, bool)))
    assert found.image.shape == (*size, 3)
    assert (found.image > 0).all()


def test_refuses():
    one, other = discs([[20, 20]]), discs(grid(), (64, 64))
    with pytest.raises(ValueError, match=r"sets: expected those of a texture of shape \(40, 40\), got \(64, 64\)"):
        refine(one, neighbour_sets(other), *drawn(one, np.zeros((40, 40), bool)))
    grey = one._replace(image=one.image[..., :1].copy())
    with pytest.raises(ValueError, match="image: expected 1 channels as the texture, got 3"):
        refine(grey, neighbour_sets(grey), *drawn(one, np.zeros((40, 40), bool)))
