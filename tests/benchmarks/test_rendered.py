"""Planes tiled with a picture, against the projection worked out by hand."""

import numpy as np
import pytest

from benchmarks.rendered import HEIGHT, VIEW, WIDTH, figures, rendered


def test_face_on_it_is_the_texture():
    """Slant 0 shows the texture pixel by pixel, its middle in the picture's."""
    texture = np.random.default_rng(0).random((HEIGHT, WIDTH, 1), dtype=np.float32)
    shown = rendered(np.repeat(np.repeat(texture[::8, ::8], 8, axis=0), 8, axis=1), 0.0, 0.0)
    inside = shown[4::8, 4::8]
    assert np.corrcoef(inside.ravel(), texture[::8, ::8].ravel())[0, 1] > 0.98


@pytest.mark.parametrize("slant", [30.0, 50.0])
def test_columns_converge_as_depth_says(slant):
    """On a floor (tilt 0) the distance of stripes is in proportion to 1 + y tan(slant) / focal, y down from the middle."""
    stripes = np.tile((np.arange(16) < 8).astype(np.float32)[None, :, None], (64, 20, 1))
    shown = rendered(stripes, slant, 0.0)[..., 0]
    rows = np.array([60, 180])
    counts = [np.count_nonzero(np.diff(shown[row] > 0.5)) for row in rows]
    focal = WIDTH / 2 / np.tan(np.radians(VIEW) / 2)
    near = 1 + (rows - (HEIGHT - 1) / 2) * np.tan(np.radians(slant)) / focal
    assert counts[0] / counts[1] == pytest.approx(near[1] / near[0], rel=0.08)


def test_a_folder_without_the_pictures(tmp_path, capsys):
    assert list(figures(tmp_path)) == []
    assert "stochastic-grass.png is not in" in capsys.readouterr().err
