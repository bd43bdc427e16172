from typing import get_args

import numpy as np
import pytest

from graphtex_nodes import sample, sample_texture, textons
from graphtex_nodes.image.exemplars._forms import Form
from graphtex_nodes.image.exemplars.sample import ELEMENTS
from graphtex_nodes.numerics.arrangements import apart_points
from graphtex_nodes.splicing.tags import checked_tag

SMALL = {"width": 96, "height": 80, "size": 20.0}


def test_square_lattice_by_hand():
    """Neighbours in a row and rows stand size x spacing apart."""
    x, y = textons(**SMALL, spacing=1.5).centres.T
    rows = np.unique(y.round(6))
    np.testing.assert_allclose(np.diff(rows), 30)
    for row in rows:
        np.testing.assert_allclose(np.diff(x[np.abs(y - row) < 1e-5]), 30)


def test_bricks_by_hand():
    """Columns 22 apart leave joints of 2; so rows of bricks 8 high stand 10 apart, moved by half a brick."""
    x, y = textons(**SMALL, form="tile", arrangement="brick", spacing=1.1, proportion=0.4).centres.T
    rows = np.unique(y.round(6))
    np.testing.assert_allclose(np.diff(rows), 10)
    firsts = np.array([x[np.abs(y - row) < 1e-5].min() for row in rows]) % 22
    np.testing.assert_allclose(np.abs(np.diff(firsts)), 11)


def test_discs_cover_what_discs_cover():
    made = textons(width=120, height=120, size=30.0, spacing=4.0, rng=5)
    whole = (np.abs(made.centres - 59.5) < 44).all(axis=1)
    areas = [np.count_nonzero(made.labels == i + 1) for i in np.flatnonzero(whole)]
    np.testing.assert_allclose(areas, np.pi * 15**2, rtol=0.02)


def test_labels_lie_on_their_centres():
    made = textons(**SMALL, form="flower", arrangement="random", turn=36.0, growth=1.2)
    column, row = np.rint(made.centres).astype(int).T
    np.testing.assert_array_equal(made.labels[row, column], np.arange(1, len(row) + 1))
    np.testing.assert_array_equal(made.mask, made.labels > 0)


def test_angles_are_clockwise():
    """The second moments of each leaf, a second method: its long axis points where its angle says."""
    made = textons(width=160, height=160, size=40.0, form="leaf", spacing=1.2, turn=60.0, growth=1.1, rng=2)
    for i in np.flatnonzero((np.abs(made.centres - 79.5) < 55).all(axis=1)):
        y, x = np.nonzero(made.labels == i + 1)
        xx, xy, yy = np.cov(x, y)[[0, 0, 1], [0, 1, 1]]
        axis = np.degrees(np.arctan2(2 * xy, xx - yy)) / 2
        assert abs((axis - made.elements.angles[i] + 90) % 180 - 90) < 4
        tip = np.radians(made.elements.angles[i])
        along = (x - made.centres[i, 0]) * np.cos(tip) + (y - made.centres[i, 1]) * np.sin(tip)
        assert along.max() > -along.min()  # it is the tip that points there, not the broad end


def test_scales_are_lengths():
    made = textons(width=160, height=160, size=24.0, spacing=1.2, growth=1.5, rng=3)
    whole = np.flatnonzero((np.abs(made.centres - 79.5) < 58).all(axis=1))
    areas = np.array([np.count_nonzero(made.labels == i + 1) for i in whole])
    np.testing.assert_allclose(np.sqrt(areas * 4 / np.pi), 24 * made.elements.scales[whole], rtol=0.03)
    assert np.ptp(made.elements.scales[whole]) > 0.3


def test_picture_shows_the_mask():
    """Elements and ground differ by more than either varies, in red against blue."""
    made = textons(**SMALL)
    hue = made.image[..., 0] - made.image[..., 2]
    assert hue[made.mask].mean() - hue[~made.mask].mean() > 3 * max(hue[made.mask].std(), hue[~made.mask].std())


def test_random_elements_keep_their_distance():
    points = apart_points(np.zeros(2), np.full(2, 200.0), 20.0, np.random.default_rng(1))
    apart = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)) + 1e3 * np.eye(len(points))
    assert apart.min() >= 20
    assert 0.6 < len(points) * 20**2 / 200**2 < 0.85  # random sequential addition jams near 0.7


def test_two_kinds_are_both_there():
    made = textons(width=128, height=128, size=16.0, other="leaf")
    areas = [
        np.count_nonzero(made.labels == i + 1) for i in np.flatnonzero((np.abs(made.centres - 63.5) < 50).all(axis=1))
    ]
    assert min(areas) < 0.75 * max(areas)


@pytest.mark.parametrize("form", get_args(Form))
def test_seed_decides(form):
    first, again, other = (textons(width=48, height=48, size=14.0, form=form, rng=seed) for seed in (3, 3, 4))
    assert first.image.tobytes() == again.image.tobytes()
    assert np.abs(first.image - other.image).mean() > 0.02
    assert first.image.min() >= 0
    assert first.image.max() <= 1


@pytest.mark.parametrize("name", ELEMENTS)
def test_sample_textures_are_the_samples(name):
    texture = sample_texture(name=name)
    np.testing.assert_array_equal(texture.image, sample(name=name))
    assert texture.mask.shape == (192, 192)
    assert len(texture.points) > 10
    checked_tag(texture.tag, "tag")


def test_unknown_tag():
    with pytest.raises(ValueError, match=r"entry\.tag: expected one of F=c, F=d, B=c, got 'F=e'"):
        checked_tag("F=e", "entry.tag")


@pytest.mark.parametrize("wrong", [{"size": 2.0}, {"spacing": 0.1}, {"form": "cube"}, {"jitter": 1.0}])
def test_refuses(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        textons(**wrong)
