import numpy as np
import pytest

from graphtex import Elements
from graphtex_nodes import draw_elements, sample_texture, texture_entry
from graphtex_nodes.splicing.texture_entry import suggested_tag


@pytest.mark.parametrize("name", ["berries", "blossoms", "leaves", "oranges", "tiles"])
def test_suggested_tag_of_the_samples(name):
    made = sample_texture(name=name)
    assert texture_entry(made.image, made.mask, made.points).tag == made.tag


def test_tag_by_hand():
    mask = np.zeros((20, 30), bool)
    mask[2:9, 2:13], mask[2:9, 16:27] = True, True
    points = np.array([[7.0, 5], [21, 5]])
    assert suggested_tag(mask, points) == "F=d"  # boxes, but on much ground
    mask[11:18, 2:13], mask[11:18, 16:27] = True, True
    assert suggested_tag(mask, np.concatenate([points, points + np.array([0, 9])])) == "B=c"
    mask[5, 13:16] = True
    assert suggested_tag(mask, points) == "B=c"  # two touch, but their joints still hang together


def _hexagons(side: float, joint: float) -> tuple[np.ndarray, np.ndarray]:
    """Hexagons with an inner radius of ``side`` / 2 - ``joint`` / 2, and their centres."""
    rows = np.arange(9) * side * np.sqrt(3) / 2
    points = np.array([(x * side + (i % 2) * side / 2, y) for i, y in enumerate(rows) for x in range(8)])
    points = points[(points > 0).all(axis=1) & (points < 119).all(axis=1)]
    offset = np.moveaxis(np.mgrid[:120, :120][::-1], 0, -1)[None] - points[:, None, None]
    directions = np.array([(1, 0), (0.5, np.sqrt(0.75)), (-0.5, np.sqrt(0.75))])
    return (np.abs(offset @ directions.T).max(axis=-1) < (side - joint) / 2).any(axis=0), points


def test_hexagons_have_joints_and_discs_have_not():
    """Both fill about three quarters of the picture, on the same lattice."""
    mask, points = _hexagons(20.0, 3.0)
    assert suggested_tag(mask, points) == "B=c"
    y, x = np.mgrid[:120, :120]
    discs = (np.hypot(x - points[:, 0, None, None], y - points[:, 1, None, None]) < 9).any(axis=0)
    assert abs(discs.mean() - mask.mean()) < 0.05
    assert suggested_tag(discs, points) == "F=d"
    apart, _ = _hexagons(20.0, 8.0)
    assert suggested_tag(apart, points) == "F=d"


def test_a_net_hangs_together():
    """Each crossing with its half strands fills 28 of the 46 pixels of its hull."""
    mask = np.zeros((48, 48), bool)
    mask[3::8], mask[4::8], mask[:, 3::8], mask[:, 4::8] = True, True, True, True
    x, y = np.meshgrid(np.arange(3.5, 48, 8), np.arange(3.5, 48, 8))
    assert suggested_tag(mask, np.stack([x.ravel(), y.ravel()], axis=1)) == "F=c"


def test_given_tag_stays():
    made = sample_texture(name="oranges")
    entry = texture_entry(made.image, made.mask, made.points, tag="B=c")
    assert entry.tag == "B=c"
    np.testing.assert_array_equal(entry.points, made.points)


def test_refuses():
    made = sample_texture(name="oranges")
    with pytest.raises(ValueError, match=r"points: expected all in the picture .*got 1 outside.*\(500, 3\)"):
        texture_entry(made.image, made.mask, np.array([[4.0, 4.0], [500.0, 3.0]]))
    with pytest.raises(ValueError, match="points: expected at least one texton"):
        texture_entry(made.image, made.mask, np.empty((0, 2)))
    with pytest.raises(ValueError, match="mask: expected some foreground and some background, got no foreground"):
        texture_entry(made.image, np.zeros_like(made.mask), made.points)
    with pytest.raises(ValueError, match=r"mask.*must agree"):
        texture_entry(made.image, made.mask[:5], made.points)


def test_a_turned_box_is_drawn():
    """A box of 10 x 4 turned by 90 degrees is 4 wide and 10 high; beyond the picture nothing is drawn."""
    picture = np.zeros((30, 30, 1), np.float32)
    elements = Elements(np.array([[15.0, 14.0], [0.0, 0.0]]), np.array([90.0, 0.0]), np.ones(2))
    drawn = draw_elements(picture, elements, width=10.0, height=4.0)[..., 0] > 0
    row, column = np.nonzero(drawn[5:, 8:])
    assert (row.min() + 5, row.max() + 5, column.min() + 8, column.max() + 8) == (9, 19, 13, 17)
    assert draw_elements(picture, elements, np.zeros((30, 30), bool))[25, 25].tolist() == [0.75] * 3
