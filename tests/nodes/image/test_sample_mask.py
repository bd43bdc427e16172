import numpy as np
import pytest
from scipy.ndimage import minimum_filter

from graphtex_nodes.image.exemplars.sample import sample
from graphtex_nodes.image.exemplars.sample_mask import sample_mask
from graphtex_nodes.numerics.principal import principal_channels


def test_masks_by_hand():
    """An ellipse's area is pi a b; the third disc reaches the lower border; the scratches reach all sides."""
    assert sample_mask(name="hole").sum() == pytest.approx(np.pi * 84 * 52, rel=0.01)
    holes = sample_mask(name="holes")
    assert holes[-1].any()
    assert not holes[0].any()
    scratches = sample_mask(name="scratches")
    assert all(side.any() for side in (scratches[0], scratches[-1], scratches[:, 0], scratches[:, -1]))


def test_joints_lie_where_the_paving_is_dark():
    """Lines one pixel wide, all of them near the darkest fifth of the picture."""
    joints = sample_mask(name="paving-joints")
    dark = principal_channels(sample(name="paving"), 1.0)[0]
    dark = minimum_filter(dark, 3) < np.quantile(dark, 0.2)
    assert 0.05 < joints.mean() < 0.12
    assert dark[joints].mean() > 0.9
    assert dark.mean() < 0.5


def test_unknown_name():
    with pytest.raises(ValueError, match="name"):
        sample_mask(name="hlole")
