import numpy as np
import pytest

from graphtex import Context, Elements
from graphtex_nodes import find_textons, textons
from graphtex_nodes.splicing._doubts import trust
from graphtex_nodes.splicing._partitions import Even


def discs(points, side=96, radius=7):
    y, x = np.mgrid[:side, :side]
    disc = np.zeros((side, side), bool)
    for across, down in points:
        disc |= np.hypot(x - across, y - down) < radius
    return Even(np.where(disc, 0.8, 0.2)[..., None].astype(np.float32), 1.0, (side, side))


def of(points):
    return Elements(points, np.zeros(len(points)), np.ones(len(points)))


GRID = np.stack(np.meshgrid(np.arange(12.0, 96, 24), np.arange(12.0, 96, 24)), axis=2).reshape(-1, 2)


def test_half_of_the_elements_explain_half():
    """All of them explain all; with half of them (0.5 / 0.8)^2 of the confidence is left."""
    image = discs(GRID)
    assert trust(image, of(GRID), np.ones(16), 14.0, 14.0) == pytest.approx(1)
    assert trust(image, of(GRID[::2]), np.ones(8), 14.0, 14.0) == pytest.approx((0.5 / 0.8) ** 2, abs=0.02)


def test_elements_that_do_not_repeat_with_the_picture():
    """Without every fourth disc, 10 of 16 discs or fewer meet others at the lattice's shifts."""
    image = discs(GRID)
    some = np.delete(GRID, np.arange(0, 16, 4), axis=0)
    assert trust(image, of(some + [0.0, 6.0] * np.arange(12)[:, None] % 7), np.ones(12), 14.0, 14.0) == 0


def test_unlike_scores_and_stripes():
    image = discs(GRID)
    assert trust(image, of(GRID), np.tile([1.0, 0.68], 8), 14.0, 14.0) == pytest.approx(0.5)
    waves = np.broadcast_to(np.sin(np.arange(96) / 3)[:, None, None] / 2, (96, 96, 1)).astype(np.float32)
    stripes = Even(waves, 1.0, (96, 96))
    assert trust(stripes, of(GRID), np.ones(16), 14.0, 14.0) < 0.05


def test_wrong_elements_are_warned_of():
    """Stripes under noise have pieces; discs are sure."""

    def told(image):
        warnings: list[str] = []
        find_textons(image, ctx=Context(on_warning=warnings.append))
        return [text for text in warnings if "give one in examples" in text]

    rng = np.random.default_rng(0)
    stripes = 0.5 + 0.3 * np.sin(2 * np.pi * np.arange(96) / 12)[None, :, None] + rng.normal(0, 0.1, (96, 96, 3))
    assert told(stripes.clip(0, 1).astype(np.float32))
    assert not told(textons(width=128, height=128, size=20.0, rng=1).image)
