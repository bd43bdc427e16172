import numpy as np
import pytest

from graphtex_nodes import factor_warp, hungarian, judge_splice, neighbour_sets, rasterize, refine, rigid_warp
from tests.nodes.splicing.scenes import discs, elements, grid, whole


def spliced(texture, places):
    extension = whole(texture)
    moves = hungarian(extension, elements(places)).moves
    drawn = rasterize(extension, moves, rigid_warp(extension, moves, *factor_warp(extension)))
    result = refine(texture, neighbour_sets(texture), *drawn)
    return extension, moves, result.mask, result.source, drawn.holes


def test_a_good_splice():
    """Discs moved by less than what lies between them, onto another side of their cells."""
    texture = discs(grid(16, (64, 64)), (64, 64), 4)
    verdict = judge_splice(*spliced(texture, texture.points + np.random.default_rng(1).integers(-2, 3, (16, 2))))
    assert verdict.cut == 0
    assert verdict.fidelity > 0.97
    assert verdict.stretched < 0.02
    assert verdict.holes < 0.1


def test_elements_that_cover_each_other_are_cut():
    """Of two discs 4 px apart one lies below; the third is by itself."""
    texture = discs([[12, 12], [12, 44], [44, 28]], (56, 56), 6)
    verdict = judge_splice(*spliced(texture, [[20, 26], [20, 30], [44, 28]]))
    assert verdict.cut == pytest.approx(1 / 3)
    assert verdict.stretched > 0.1


def test_what_was_counted_by_hand():
    """One disc at its place, of which a quarter is made up and half is foreground."""
    texture = discs([[10, 10]], (21, 21), 4)
    extension, moves, mask, source, holes = spliced(texture, [[10, 10]])
    holes, mask, source = holes.copy(), mask.copy(), source.copy()
    assert not holes.any()
    holes[:, :7] = True
    row, column = np.nonzero(mask)
    mask[row[::2], column[::2]] = False
    source[row[::4], column[::4], 1] += 5
    verdict = judge_splice(extension, moves, mask, source, holes)
    count = len(row)
    assert verdict.holes == pytest.approx(1 / 3)
    assert verdict.fidelity == pytest.approx((count - len(row[::2])) / count)
    assert verdict.stretched == pytest.approx(len(row[::4]) / count)
    assert verdict.cut == 1


def test_nothing_to_judge_and_a_wrong_size():
    texture = discs([[10, 10]], (21, 21), 4)
    extension, moves, mask, source, holes = spliced(texture, [[10, 10]])
    away = moves._replace(targets=moves.targets + 100)
    verdict = judge_splice(extension, away, np.zeros_like(mask), source, holes)
    assert verdict == (0, 1, 0, 0, 0, 0)
    with pytest.raises(ValueError, match=r"mask: expected shape \(21, 21\)"):
        judge_splice(extension, moves, mask[:-1], source[:-1], holes[:-1])


def test_bent_elements_and_sloping_joints_by_hand():
    """Four discs; the warp makes the left two twice as wide and lets the ground fall by 1 in 4 to the right."""
    texture = discs([[10, 10], [10, 30], [30, 10], [30, 30]], (41, 41), 5)
    extension = whole(texture)
    moves = hungarian(extension, elements(texture.points)).moves
    x = np.indices((41, 41))[1]
    warp = np.zeros((41, 41, 2), np.float32)
    warp[..., 0] = np.where(extension.mask & (x < 20), x - 10, 0)
    warp[..., 1] = np.where(extension.mask, 0, (x - 20) / 4)
    source, holes = extension.source, np.zeros((41, 41), bool)
    verdict = judge_splice(extension, moves, texture.mask, source, holes, warp)
    assert verdict.bent == 0.5
    assert verdict.slope == pytest.approx(0.25, abs=0.01)
    assert judge_splice(extension, moves, texture.mask, source, holes, warp * 0).bent == 0


def test_cells_laid_anew_by_hand():
    """Four cells of which one shows its source twice as wide; that one at the border does not count; no slope."""
    texture = discs([[10, 10], [10, 30], [30, 10], [30, 30]], (41, 41), 5)
    extension = whole(texture)
    moves = hungarian(extension, elements(texture.points)).moves
    y, x = np.indices((41, 41))
    cells = np.where((x - 20) ** 2 + (y - 20) ** 2 < 400, x // 21 + 2 * (y // 21), -1).astype(np.int32)
    cells[:, 0] = 4
    laid = extension.source.copy()
    laid[..., 2] = np.where(cells == 1, x / 2, np.where(cells == 4, x / 9, x))
    parts = extension, moves, np.ones((41, 41), bool), extension.source, np.zeros((41, 41), bool)
    warp = np.zeros((41, 41, 2), np.float32)
    verdict = judge_splice(*parts, warp, laid, cells)
    assert verdict.bent == 0.25
    assert verdict.slope == 0
    assert judge_splice(*parts, warp, laid, np.full((41, 41), -1, np.int32)).bent == 0, "nothing was laid anew"
