"""What the qualities of Optimize leave out."""

import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes.perspective.optimize import optimize

QUIET = Context(threads=1)
RNG = np.random.default_rng(1)
NOISE = RNG.random((40, 48, 3)).astype(np.float32)
ROW, COLUMN = np.mgrid[:80, :68]
WAVES = (np.sin(ROW / 3 + np.sin(COLUMN / 7)) + 0.1 * RNG.random((80, 68))).astype(np.float32)[..., None]


def test_quality_leaves_iterations_out():
    """Progress is told after each iteration: 40 x 48 has stages of 3, 3 and 2, halved, or quartered without the last."""
    told = {}
    for quality in ("default", "fast", "preview"):
        seen = []
        ctx = Context(threads=1, on_progress=lambda share, text, seen=seen: seen.append(text))
        optimize(NOISE, quality=quality, ctx=ctx)
        told[quality] = sum(text.startswith("level") for text in seen)
    assert told == {"default": 8, "fast": 5, "preview": 2}


@pytest.mark.parametrize("sides", [{}, {"tileable": "both"}, {"vote": "mean"}])
def test_preview_is_of_full_size(sides):
    """Also where the coarse result cannot be replayed pixel by pixel."""
    for size in ({}, {"height": 37, "width": 55}):
        result = optimize(WAVES, quality="preview", rng=2, ctx=QUIET, **sides, **size)
        assert result.image.shape == (size.get("height", 160), size.get("width", 136), 1)
        rows, columns = result.source[..., 1], result.source[..., 2]
        assert rows.min() >= 0
        assert rows.max() <= 79
        assert columns.max() <= 67
        assert result.coherence > 0.5


def test_preview_replays_and_does_not_depend_on_threads():
    one, two = (
        optimize(WAVES, quality="preview", vote="discrete", ctx=Context(threads=threads)) for threads in (1, 2)
    )  # fmt: skip
    np.testing.assert_array_equal(one.source, two.source)
    np.testing.assert_array_equal(one.image, WAVES[one.source[..., 1].astype(int), one.source[..., 2].astype(int)])


def test_preview_keeps_known_pixels():
    start = np.full((60, 50, 1), 0.25, np.float32)
    known = np.zeros((60, 50), bool)
    known[10:21, 7:30] = True
    result = optimize(WAVES, start=start, known=known, quality="preview", ctx=QUIET)
    assert (result.image[known] == 0.25).all()
    assert (result.source[~known, 0] == 0).all()
