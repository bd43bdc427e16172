"""Elements that are told by standing apart, not by being alike."""

import numpy as np
import pytest

from graphtex import QUIET, Context
from graphtex_nodes import find_textons
from graphtex_nodes.splicing._automatic import _alike
from graphtex_nodes.splicing._detection import Search
from graphtex_nodes.splicing._partitions import even_and_small, measured, partitions, split


def stones(seed, side=160, step=22.0):
    """A wall of stones, each of its own shape and grey, with dark joints; and which pixel is of which stone, 0 none."""
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(seed)
    lattice = np.arange(-step, side + step, step)
    sites = np.stack(np.meshgrid(lattice, lattice), axis=-1).reshape(-1, 2)
    sites = sites + rng.uniform(-step / 3, step / 3, sites.shape)
    y, x = np.mgrid[:side, :side]
    apart, nearest = cKDTree(sites).query(np.stack([x, y], axis=-1), 2)
    labels = np.where(apart[..., 1] - apart[..., 0] > 4, nearest[..., 0] + 1, 0)
    grey = np.concatenate([[0.25], rng.uniform(0.4, 0.8, len(sites))])[labels]
    return (grey + rng.normal(0, 0.02, grey.shape)).clip(0, 1).astype(np.float32)[..., None], labels


def agreement(points, labels):
    """F1 of points against the stones that the border does not cut; points on others do not count."""
    border = np.unique(np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]]))
    whole = np.setdiff1d(np.unique(labels), np.append(border, 0))
    centres = np.array([np.argwhere(labels == index).mean(axis=0)[::-1] for index in whole])
    apart = np.hypot(*(points[:, None] - centres[None]).transpose(2, 0, 1))
    right = np.count_nonzero(apart.min(axis=0) < 4)
    column, row = np.rint(points).astype(int).clip(0, np.array(labels.shape[::-1]) - 1).T
    counted = np.count_nonzero(np.isin(labels[row, column], [*whole, 0]))
    return 2 * right / (len(whole) + counted)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_stones_of_a_wall(seed):
    """No two are alike: what looks like one of them is too little."""
    image, labels = stones(seed)
    found = find_textons(image)
    assert found.confidence > 0.7
    assert agreement(found.points, labels) >= 0.95
    even = even_and_small(image)
    alike = _alike(even, partitions(even), Search(image, 0.0, 1.0, 0.66, QUIET))
    assert agreement(alike.points, labels) < 0.9


def test_sizes_of_discs():
    """Each disc's scale is its radius over the typical one."""
    rng = np.random.default_rng(3)
    places = np.stack(np.meshgrid(np.arange(20, 160, 30), np.arange(20, 160, 30)), axis=-1).reshape(-1, 2)
    radii = rng.uniform(5, 13, len(places))
    y, x = np.mgrid[:160, :160]
    image = np.full((160, 160), 0.2)
    for (across, down), radius in zip(places, radii, strict=True):
        image[np.hypot(x - across, y - down) <= radius] = 0.8
    found = find_textons((image + rng.normal(0, 0.02, image.shape)).astype(np.float32)[..., None])
    apart = np.hypot(*(found.elements.points[:, None] - places[None]).transpose(2, 0, 1))
    assert len(found.points) == len(places)
    assert apart.min(axis=1).max() < 0.5
    sizes = found.width * found.elements.scales / 2
    assert np.abs(sizes / radii[apart.argmin(axis=1)] - 1).max() < 0.15


def test_bricks_of_two_tones():
    """The few light ones are not another kind of thing than the dark ones."""
    rng = np.random.default_rng(1)
    image = np.full((120, 160), 0.3)
    centres = []
    for row, top in enumerate(range(1, 118, 12)):
        for left in range(-10 * (row % 2) - 1, 160, 20):
            image[top : top + 10, max(left, 0) : left + 18] = 0.75 if rng.random() < 0.15 else 0.45
            if left >= 0 and left + 18 <= 160:
                centres.append((left + 8.5, top + 4.5))
    image = image + rng.normal(0, 0.015, image.shape)
    found = find_textons(image.astype(np.float32)[..., None])
    apart = np.hypot(*(found.points[:, None] - np.array(centres)[None]).transpose(2, 0, 1))
    assert apart.min(axis=0).max() < 2
    assert found.confidence > 0.5


@pytest.mark.parametrize("smooth", [1, 3, 5])
def test_patches_of_noise_are_doubtful(smooth):
    from scipy.ndimage import gaussian_filter

    told: list[str] = []
    noise = gaussian_filter(np.random.default_rng(smooth).normal(0, 1, (128, 128, 3)), (smooth, smooth, 0), mode="wrap")
    image = (0.5 + 0.2 * noise / noise.std()).clip(0, 1).astype(np.float32)
    found = find_textons(image, ctx=Context(on_warning=told.append))
    assert found.confidence < 0.5
    assert "these may not be the elements" in told[0]


def test_score_lowers_what_counts():
    """An own least score replaces the automatic one."""
    image, _ = stones(0)
    every = find_textons(image)
    some = find_textons(image, least_score=float(np.median(every.scores)) + 1e-9)
    assert 0 < len(some.elements.points) < len(every.elements.points)


def test_split_at_necks():
    """Two discs that touch are two, a bar is one."""
    y, x = np.mgrid[:30, :60]
    discs = (np.hypot(x - 15, y - 15) < 10) | (np.hypot(x - 33, y - 15) < 10)
    labels = split(discs)
    assert labels.max() == 2
    assert labels[15, 15] != labels[15, 33]
    bar = np.zeros((30, 60), bool)
    bar[10:16, 5:55] = True
    assert split(bar).max() == 1


def test_measures_by_hand():
    """Five squares of 6 x 6, one cut by the border: roundness 3 / pi, all alike, none cut by another."""
    labels = np.zeros((40, 40), np.int64)
    for index, (top, left) in enumerate([(0, 4), (10, 4), (10, 20), (28, 4), (28, 20)]):
        labels[top : top + 6, left : left + 6] = index + 1
    parts = measured(labels, 1.0, 2.0, (80, 80))
    assert parts is not None
    np.testing.assert_allclose(parts.points[1], [6.5, 12.5])
    np.testing.assert_allclose(parts.roundness, 3 / np.pi)
    assert parts.fits.tolist() == [False, True, True, True, True]
    assert parts.spread == pytest.approx(0, abs=1e-9)
    assert parts.merit == pytest.approx(6 / np.pi - 1)
    assert measured(labels * (labels < 4), 1.0, 1.0, (40, 40)) is None


def test_touching_parts_count_less():
    """Two strips of four squares each that share half of their outline."""
    labels = np.zeros((40, 40), np.int64)
    for index, left in enumerate(range(4, 36, 8)):
        labels[8:16, left : left + 8] = index + 1
        labels[24:32, left : left + 8] = index + 5
    parts = measured(labels, 1.0, 1.0, (40, 40))
    assert parts is not None
    # three cuts of 8 in each strip, and 2 x 32 + 2 x 8 to the ground
    assert parts.merit == pytest.approx((6 / np.pi - 1) * (1 - 24 / 104))
