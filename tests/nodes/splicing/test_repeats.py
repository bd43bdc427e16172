import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from graphtex import Context
from graphtex_nodes import find_textons, textons
from graphtex_nodes.splicing._agreement import agreement
from graphtex_nodes.splicing._repeats import Repeats, cell, repeated_share, repeats
from tests.nodes.splicing.scenes import grid


def tiled(shift, shape=(80, 96), tile=(15, 13), seed=0):
    """A random tile, in rows of which each is shifted against the last."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    made = np.random.default_rng(seed).random((*tile, 3)).astype(np.float32)
    return made[rows % tile[0], (columns - shift * (rows // tile[0])) % tile[1]]


def test_the_cell_of_a_lattice():
    found = repeats(tiled(0))
    assert {(13, 0), (0, 15), (13, 15)} <= {tuple(shift) for shift in found.shifts.tolist()}
    assert found.correlations.min() == pytest.approx(1, abs=1e-3)
    assert cell(found) == pytest.approx((13, 15, 1), abs=1e-3)


def test_the_cell_of_shifted_rows_is_as_large_as_their_tile():
    """And as wide, where they are shifted by half of it, and shifts that lead up are shorter."""
    assert cell(repeats(tiled(6))) == pytest.approx((13, 15, 1), abs=1e-3)
    assert cell(repeats(tiled(7, tile=(9, 14)))) == pytest.approx((14, 9, 1), abs=1e-3)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 60, 1), (64, 64, 1)])
def test_nothing_repeats_in_a_constant_picture(shape):
    found = repeats(np.full(shape, 0.5, np.float32))
    assert len(found.shifts) == 0
    assert cell(found) is None


def test_noise_and_stripes_have_no_cell():
    """Stripes repeat across themselves only, and along them they are alike all the way, for all their grain."""
    rng = np.random.default_rng(3)
    assert len(repeats(rng.random((80, 90, 3)).astype(np.float32)).shifts) == 0
    stripes = np.sin(np.arange(96) * 2 * np.pi / 12)[None, :] + rng.normal(0, 0.3, (96, 96))
    found = repeats((stripes[..., None] / 4 + 0.5).astype(np.float32))
    assert len(found.shifts) > 0
    assert cell(found) is None


def test_points_that_repeat_and_points_that_do_not():
    """Of 4 x 4 points all meet others at a shift of one column; without one of them, 22 of 23 do of what had 24."""
    points, sideways = grid(10, (40, 40), 5), Repeats(np.array([[10, 0]]), np.ones(1), np.empty((0, 0)))
    assert repeated_share(points, sideways, (40, 40)) == 1
    assert repeated_share(np.delete(points, 5, axis=0), sideways, (40, 40)) == pytest.approx(20 / 22)
    assert repeated_share(points, sideways._replace(shifts=np.empty((0, 2), int)), (40, 40)) == 1


def cloth(across, down, side=192):
    """Checked cloth of threads: the shade of a spot is that of its column and that of its row together."""
    warp, weft = np.arange(side) % across < across / 2, np.arange(side) % down < down / 2
    shade = 0.25 + 0.3 * warp[None, :] + 0.3 * weft[:, None]
    threads = 0.06 * ((np.arange(side)[None, :] + np.arange(side)[:, None]) % 4 < 2)
    noise = gaussian_filter(np.random.default_rng(1).normal(0, 0.08, (side, side)), 0.7)
    grey = gaussian_filter(shade, 1.0) + threads + noise
    return np.stack([grey, grey * 0.5, grey * 0.5], axis=2).clip(0, 1).astype(np.float32)


@pytest.mark.parametrize(("across", "down"), [(24, 36), (32, 22)])
def test_checks_of_cloth_have_no_outlines_but_repeat(across, down):
    told: list[str] = []
    found = find_textons(cloth(across, down), ctx=Context(on_warning=told.append))
    assert told == []
    assert (found.width, found.height) == pytest.approx((across, down), rel=0.06)
    phase = np.exp(2j * np.pi * found.points / (across, down))
    off = np.angle(phase / phase.mean(axis=0)) / (2 * np.pi)
    assert np.abs(off).max() < 0.15
    inner = (192 - across) * (192 - down) / (across * down)
    assert len(found.points) >= 0.95 * inner


@pytest.mark.parametrize("seed", [1, 3, 6])
def test_flowers_that_touch_are_found_whole(seed):
    """No colours of a ground part them, and only their middles are alike and apart: cells are about these."""
    made = textons(width=192, height=176, form="flower", arrangement="hexagonal", spacing=0.97, jitter=0.03, rng=seed)
    told: list[str] = []
    found = find_textons(made.image, ctx=Context(on_warning=told.append))
    assert told == []
    assert agreement(found.points, made, 24.0)[0] >= 0.98
    assert found.width > 20


@pytest.mark.parametrize("contrast", [1e-4, 3e-5])
def test_faint_cloth_is_an_answer_or_a_warning(contrast):
    told = []
    faint = 0.5 + contrast * (cloth(24, 36) - 0.5)
    found = find_textons(faint.astype(np.float32), ctx=Context(on_warning=told.append))
    assert told or found.confidence > 0.6


def test_a_cell_of_one_colour_is_no_error_about_examples():
    """The cell about the picture's middle would be tried, and nobody gave it as an example."""
    told = []
    picture = cloth(24, 36)
    picture[46:146, 46:146] = 0.5
    assert len(find_textons(picture, ctx=Context(on_warning=told.append)).points)
    assert told
