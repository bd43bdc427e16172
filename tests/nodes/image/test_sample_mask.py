import numpy as np
import pytest

from graphtex_nodes.image.exemplars.sample_mask import sample_mask


def test_masks_by_hand():
    """An ellipse's area is pi a b; the third disc reaches the lower border; the scratches reach all sides."""
    assert sample_mask(name="hole").sum() == pytest.approx(np.pi * 84 * 52, rel=0.01)
    holes = sample_mask(name="holes")
    assert holes[-1].any()
    assert not holes[0].any()
    scratches = sample_mask(name="scratches")
    assert all(side.any() for side in (scratches[0], scratches[-1], scratches[:, 0], scratches[:, -1]))


def test_unknown_name():
    with pytest.raises(ValueError, match="name"):
        sample_mask(name="hlole")
