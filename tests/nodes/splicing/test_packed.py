import numpy as np

from graphtex import Elements
from graphtex_nodes import find_textons, separate_foreground, textons
from graphtex_nodes.splicing._agreement import agreement
from graphtex_nodes.splicing._nearness import common_offset
from graphtex_nodes.splicing._packed import outline_fit, touching


def test_finds_what_elements_were_moved_and_shrunk_by():
    """Discs lit from above left; colours in and out of their outlines tell less."""
    made = textons(width=160, height=128, size=24.0, arrangement="hexagonal", spacing=1.03, rng=6)
    off = Elements(made.centres - (1.5, 1.0), made.elements.angles, made.elements.scales)
    offset, width, height = outline_fit(made.image, off, 22.0, 22.0)
    wrong = np.abs(offset - (1.5, 1.0)).max()
    assert wrong < min(0.7, np.abs(common_offset(made.image, off, 22.0, 22.0) - (1.5, 1.0)).max())
    np.testing.assert_allclose((width, height), 24.0, rtol=0.06)


def test_rectangles_have_corners():
    """Tiles of 20 x 12 pixels that fade to the right and down, with nothing between them."""
    y, x = np.mgrid[:120, :160]
    image = (0.9 - 0.02 * (x % 20) - 0.03 * (y % 12))[..., None].astype(np.float32)
    points = np.stack(np.meshgrid(np.arange(8) * 20 + 9.5, np.arange(10) * 12 + 5.5), axis=2).reshape(-1, 2)
    off = Elements(points + np.array([1.0, -1.0]), np.zeros(80), np.ones(80))
    offset, width, height = outline_fit(image, off, 18.0, 12.0)
    np.testing.assert_allclose(offset, (-1.0, 1.0), atol=0.3)
    np.testing.assert_allclose((width, height), (20.0, 12.0), atol=1.0)


def test_foreground_of_touching_elements():
    """Found without help and cut out of a noisy picture."""
    made = textons(width=192, height=160, size=28.0, arrangement="hexagonal", spacing=0.97, jitter=0.03, rng=5)
    found = find_textons(made.image)
    assert agreement(found.points, made, 28.0)[0] == 1
    noise = np.random.default_rng(1).normal(0, 0.02, made.image.shape).astype(np.float32)
    cut = separate_foreground(np.clip(made.image + noise, 0, 1), found.elements, width=found.width, height=found.height)
    assert (cut.mask & made.mask).sum() / (cut.mask | made.mask).sum() > 0.94


def test_touching():
    """Discs of size 10 at 10 and at 12 pixels; a single one has nothing to touch."""
    points = np.array([[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]])
    assert touching(Elements(points, np.zeros(3), np.ones(3)), 10.0, 5.0)
    assert not touching(Elements(1.2 * points, np.zeros(3), np.ones(3)), 10.0, 10.0)
    assert not touching(Elements(points[:1], np.zeros(1), np.ones(1)), 10.0, 10.0)
