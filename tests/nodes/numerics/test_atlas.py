import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from graphtex import Context
from graphtex_nodes.numerics.atlas import Stock, enlarged, original, traced, view
from graphtex_nodes.numerics.frames import whole_windows
from graphtex_nodes.numerics.orientation import structure
from graphtex_nodes.numerics.sources import Look

RNG = np.random.default_rng(7)
ROW, COLUMN = np.mgrid[:40, :50]
PICTURE = np.stack([np.sin(ROW / 9), np.cos(COLUMN / 8), np.sin((ROW + COLUMN) / 11)], axis=-1).astype(np.float32)
SCALE = np.repeat(np.linspace(0.5, 2, 40, dtype=np.float32)[:, None], 50, axis=1)


def resampled_atlas(target=SCALE, mirror=False, largest=1.6):
    return enlarged([original(PICTURE, SCALE, None)], Stock(mirror, target, largest), unit=8)


@pytest.mark.parametrize("mirror", [False, True])
def test_origin_tells_where_all_comes_from(mirror):
    """Second method: the exemplar interpolated at the origins, for a smooth exemplar."""
    atlas = resampled_atlas(mirror=mirror)
    usable, origin = atlas.usable, atlas.origin
    assert (origin[usable, 3] != 0).any()
    assert set(np.unique(origin[usable, 5])) == ({0, 1} if mirror else {0})
    for channel in range(3):
        found = map_coordinates(PICTURE[..., channel], [origin[..., 1], origin[..., 2]], order=1, mode="nearest")
        np.testing.assert_allclose(atlas.picture[usable, channel], found[usable], atol=0.03)


def test_scale_is_that_of_the_origin_times_the_resampling():
    atlas = resampled_atlas()
    found = map_coordinates(SCALE, [atlas.origin[..., 1], atlas.origin[..., 2]], order=1) * 2 ** atlas.origin[..., 3]
    np.testing.assert_allclose(atlas.scale[atlas.usable], found[atlas.usable], rtol=0.02)


def test_copies_serve_where_scales_are_short():
    """Elements shrink with the scale, so the exemplar's larger half has the fewer: copies have that scale only."""
    atlas = resampled_atlas()
    copies = atlas.usable & (atlas.origin[..., 3] != 0)
    assert atlas.scale[copies].min() > 0.85
    assert (atlas.origin[copies, 3] > 0).mean() > 0.5


def test_scales_that_the_exemplar_lacks_are_made():
    atlas = resampled_atlas(target=SCALE * 1.4)
    assert atlas.scale[atlas.usable].max() > 2.5


@pytest.mark.parametrize("mirror", [False, True])
def test_the_exemplar_itself_comes_first_and_copies_keep_apart(mirror):
    atlas = resampled_atlas(mirror=mirror)
    np.testing.assert_array_equal(atlas.picture[:40, :50], PICTURE)
    assert atlas.usable[:40, :50].all()
    filled = np.flatnonzero(atlas.usable.any(axis=1))
    kinds = [tuple(atlas.origin[row, atlas.usable[row].argmax(), [3, 5]]) for row in filled]
    gaps = [
        below - above
        for above, below, one, other in zip(filled, filled[1:], kinds, kinds[1:], strict=False)
        if one != other
    ]
    assert len(gaps) >= 3
    assert min(gaps) > 16


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("angle", [0.0, 40.0, 90.0, 135.0])
def test_directions_turn_with_their_copy(angle, mirrored):
    """Second method: the structure tensor of the copy, of lines that run at 25 degrees."""
    lines = np.sin((ROW * np.cos(np.radians(25)) - COLUMN * np.sin(np.radians(25))) * 0.8)[..., None]
    exemplar = original(lines.astype(np.float32), None, None, np.full(ROW.shape, 25, np.float32))
    copy = view(exemplar, Look(exemplar.picture), angle=angle, mirrored=mirrored)
    found = structure(copy.picture, 1.0, 4.0)[0]
    inner = whole_windows(copy.usable, 21)
    apart = np.abs((found - copy.angle + 90) % 180 - 90)[10:-10, 10:-10]
    assert inner.any()
    assert apart[inner].max() < 3


def test_turned_copies_show_what_their_origin_tells():
    """Stacked copies for all directions: the exemplar interpolated at the origins, and only wanted directions."""
    flat = original(PICTURE, None, None, np.zeros(ROW.shape, np.float32))
    atlas = enlarged([flat], Stock(angles=np.array([[10.0, 100.0]], np.float32), turn_step=15.0), unit=4)
    origin = atlas.origin[atlas.usable]
    assert set(np.unique(origin[:, 4])) == {0, 15, 90, 105}
    for channel in range(3):
        found = map_coordinates(PICTURE[..., channel], [origin[:, 1], origin[:, 2]], order=1, mode="nearest")
        np.testing.assert_allclose(atlas.picture[atlas.usable][:, channel], found, atol=0.03)


def test_mirror_alone():
    usable = RNG.random((40, 50)) < 0.8
    atlas = enlarged([original(PICTURE, None, usable)], Stock(mirror=True), unit=4)
    assert atlas.scale is None
    assert atlas.usable.sum() == 2 * usable.sum()
    np.testing.assert_array_equal(atlas.picture[-40:], PICTURE[:, ::-1])
    np.testing.assert_array_equal(atlas.usable[-40:], usable[:, ::-1])


def test_places_are_traced_to_their_origins():
    sheet = resampled_atlas()
    places = np.array([[[3, 4], [45, 7]], [[-1, -1], [3, 4]]], np.int32)  # one pixel is known
    source, shown = traced(sheet, places, Context(threads=2))
    assert source.shape == (2, 2, 6)
    for row, column in ((0, 0), (0, 1), (1, 1)):
        assert (source[row, column] == sheet.origin[tuple(places[row, column])]).all()
    assert (shown == sheet.origin[[3, 45], [4, 7]]).all()
