import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from graphtex_nodes.numerics import guidance

ROWS = np.repeat(np.linspace(0.5, 2, 40, dtype=np.float32)[:, None], 30, axis=1)


@pytest.mark.parametrize("weight", [0.5, 2.0])
def test_scale_factor_is_a_ratio_of_deviations(weight):
    colours = np.random.default_rng(0).random((40, 30, 3)).astype(np.float32)
    factor = guidance.scale_factor(colours, ROWS, weight)
    total = np.sqrt(colours.reshape(-1, 3).var(axis=0).sum())
    assert (ROWS * factor).std() == pytest.approx(weight * total, rel=1e-5)
    assert guidance.scale_factor(colours, np.ones((40, 30), np.float32), weight) == 0


def test_noise_of_a_map_is_not_trusted():
    """A tenth for smooth noise of 5 %; all for a step, for noise of 30 %, and for a plane of 5 % under noise of 1 %."""
    smooth = gaussian_filter(np.random.default_rng(1).standard_normal((90, 300)), 12)
    smooth = smooth / smooth.std()
    every = np.ones(smooth.shape, bool)
    plane = np.linspace(-1.7, 1.7, 300) * np.ones((90, 1))
    step = np.where(np.arange(300) < 150, 0.25, -0.25) * np.ones((90, 1))
    for log, expected in ((0.05 * smooth, 0.1), (0.3 * smooth, 1), (step, 1), (0.05 * plane + 0.01 * smooth, 1)):
        assert guidance.trust(np.exp(log).astype(np.float32), every) == pytest.approx(expected)


def test_trust_looks_at_what_is_chosen():
    scale = np.ones((40, 30), np.float32)
    scale[:10] = 4
    chosen = np.ones(scale.shape, bool)
    assert guidance.trust(scale, chosen) == 1
    chosen[:10] = False
    assert guidance.trust(scale, chosen) == 0.1


def test_copies_of_a_plane_do_not_make_it_noise():
    """A plane of 4 % and a copy of it, 12 % smaller: together no plane; each part tells that they are no noise."""
    plane = np.exp(np.linspace(-0.07, 0.07, 64))[:, None] * np.ones((1, 40))
    sheet = np.concatenate([plane, plane / 1.12]).astype(np.float32)
    every = np.ones(sheet.shape, bool)
    parts = [(half, np.ones(half.shape, bool)) for half in np.split(sheet, 2)]
    assert guidance.trust(sheet, every) < 0.5
    assert guidance.trust(sheet, every, parts) == 1


@pytest.mark.parametrize(("target", "share"), [([0.5, 2.0], 0), ([0.4, 1.0], 0.5), ([4, 0.2], 1), ([0.48, 2.09], 0)])
def test_missing_share(target, share):
    assert guidance.missing_share(ROWS, np.array([target], np.float32)) == share


def test_importance_follows_the_target():
    """A target that wants small scales only: the top of the exemplar matters, the bottom does not."""
    importance = guidance.importance(ROWS, np.full((9, 9), 0.6, np.float32))
    assert importance.mean() == pytest.approx(1, rel=1e-5)
    assert importance[2:4].min() > 20 * importance[20:].max()


def test_importance_of_the_own_scale():
    np.testing.assert_allclose(guidance.importance(ROWS, ROWS.repeat(3, axis=1)), 1, rtol=0.02)


def test_resampled():
    ramp = np.array([[0, 1, 2, 3]], np.float32)
    np.testing.assert_allclose(guidance.resampled(ramp, (2, 2)), [[0.5, 2.5]] * 2)
    np.testing.assert_allclose(guidance.resampled(ramp, (1, 8))[0, :3], [0, 0.25, 0.75])
    assert guidance.resampled(ramp, (1, 4)) is ramp
    assert guidance.resampled(np.ones((1, 1), np.float32), (3, 2)).tolist() == [[1, 1]] * 3


def test_blocks_are_copies_and_every_part_gets_its_chance():
    field = guidance.random_blocks((12, 12), (9, 9), 1, 2, np.random.default_rng(0))
    assert len(set(map(tuple, field.reshape(-1, 2).tolist()))) == 81
    field = guidance.random_blocks((8, 8), (50, 50), 4, 2, np.random.default_rng(0))
    inside = field[4:, 4:] - field[4, 4]
    if field[4, 4].max() <= 43:
        assert inside[3, 2].tolist() == [6, 4]
    assert field.min() >= 0
    assert field.max() <= 49


def test_blocks_of_matching_scale():
    """Every block starts within a tenth of the exemplar's ranks around the scale that it wants."""
    wanted = np.repeat(np.linspace(0.5, 2, 20, dtype=np.float32)[:, None], 20, axis=1)
    field = guidance.random_blocks((20, 20), (40, 30), 1, 1, np.random.default_rng(1), wanted, ROWS)
    assert np.abs(ROWS[field[..., 0], field[..., 1]] - wanted).max() < 0.13
    assert len(np.unique(field[..., 1])) == 30


def test_blocks_of_matching_direction(monkeypatch):
    """Among the nearest tenth, also where there are so many blocks that they are compared with a sample, part by part."""
    directions = guidance.direction_channels(np.tile(np.arange(0.0, 180.0, 4.5, dtype=np.float32), (30, 1)), False)
    wanted = np.repeat(directions[:1, ::2], 20, axis=0)
    sampled = []
    for most, at_once in ((1 << 24, 1 << 18), (1 << 16, 1 << 12)):
        monkeypatch.setattr(guidance, "MOST_COMPARED", most)
        monkeypatch.setattr(guidance, "COMPARED_AT_ONCE", at_once)
        field = guidance.random_blocks((20, 20), (30, 40), 1, 1, np.random.default_rng(1), wanted, directions)
        apart = (directions[field[..., 0], field[..., 1]] * wanted).sum(axis=2)
        assert apart.min() > np.cos(np.radians(2 * 9.5))  # 40 directions: the tenth are two on each side
        sampled.append(len(np.unique(field.reshape(-1, 2), axis=0)))
    assert sampled[0] > 300
    assert 100 < sampled[1] < 164  # of 65536 / 400


def test_scale_beyond_the_exemplar_takes_the_nearest():
    wanted = np.full((4, 4), 8, np.float32)
    field = guidance.random_blocks((4, 4), (40, 30), 1, 1, np.random.default_rng(1), wanted, ROWS)
    assert field[..., 0].min() >= 38 - 1
