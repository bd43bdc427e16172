"""What plain synthesis is measured on, and that other tools are called alike."""

import numpy as np
import pytest
from PIL import Image as Pillow

from benchmarks import peers, plain


def test_crop_halves_large_pictures_first():
    # 1100 / 2 = 550 is still two crops wide, so halved again; 2200 / 4 = 550 columns
    picture = np.arange(1100 * 2200, dtype=np.float32).reshape(1100, 2200, 1)
    found = plain.crop(picture)
    assert found.shape == (256, 256, 1)
    blocks = picture.reshape(275, 4, 550, 4, 1).mean(axis=(1, 3))
    np.testing.assert_allclose(found, blocks[9:265, 147:403], rtol=1e-6)


def test_crop_leaves_small_pictures():
    picture = np.random.default_rng(0).random((100, 300, 3)).astype(np.float32)
    np.testing.assert_array_equal(plain.crop(picture), picture[:, 22:278])


def test_folder_of_pictures_by_name(tmp_path):
    for name, values in (("b", [255, 9, 40]), ("a", [0, 1, 2]), ("mask", [0, 255, 0])):
        Pillow.fromarray(np.resize(np.uint8(values), (20, 30, 3))).save(tmp_path / f"{name}.png")
    (tmp_path / "notes.txt").write_text("no picture")
    found = plain.exemplars(tmp_path)
    assert [(name, picture.shape, picture.max()) for name, picture in found.items()] == [
        ("a", (20, 30, 3), np.float32(2 / 255)),
        ("b", (20, 30, 3), 1),
    ]


def test_folder_without_pictures_is_refused(tmp_path):
    with pytest.raises(ValueError, match="expected pictures"):
        plain.exemplars(tmp_path)


def test_figures_of_a_texture_are_medians_and_its_worst_coverage():
    scores = [plain.Score(np.full(1, d), d, 1 - d, c, c) for d, c in ((0.3, 0.9), (0.1, 0.4), (0.2, 0.8))]
    found = plain.typical(scores)
    assert (found.distance, found.coherence, found.coverage, found.worst) == (0.2, 0.8, 0.8, 0.4)
    assert found.image == 0.2


def test_summary_counts_wins_bounds_and_collapses():
    good, bad = (plain.Score(np.zeros(1), *values) for values in ((0.1, 0.8, 0.9, 0.9), (0.3, 0.95, 0.6, 0.45)))
    other = plain.Score(np.zeros(1), 0.2, 0.85, 0.85, 0.85)
    found = {figure.name: figure.value for figure in plain.summary([good, bad], {"peer": [other, other]})}
    assert found["share of 2 textures closer to the exemplar than peer's"] == 0.5
    assert found["graphtex: highest coherence"] == 0.95
    assert found["graphtex: lowest coverage"] == 0.6
    assert found["graphtex: textures that collapsed with some seed"] == 1
    assert found["peer: share of textures with coverage >= 0.8"] == 1


def test_missing_tools_are_left_out(monkeypatch):
    monkeypatch.setattr(peers, "installed", lambda module: False)
    assert peers.synthesisers() == {}
    assert peers.fillers() == {}


@pytest.mark.parametrize("channels", [1, 3])
def test_installed_tools_keep_what_is_known(channels):
    picture = np.random.default_rng(2).random((48, 40, channels)).astype(np.float32)
    hole = np.zeros((48, 40), bool)
    hole[20:28, 16:24] = True
    for name, fill in peers.fillers().items():
        found = fill(picture, hole, 1)
        assert found.shape == picture.shape, name
        np.testing.assert_array_equal(found[~hole], picture[~hole], err_msg=name)
    for name, synthesise in peers.synthesisers().items():
        assert synthesise(picture, (60, 70), 1).shape == (60, 70, channels), name
