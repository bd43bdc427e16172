"""Maps of a size that no machine holds are refused before any work."""

import numpy as np
import pytest

from graphtex_nodes import flow_pattern, resize_scale, scale_from_angles, scale_pattern

ONES = np.ones((2, 2), np.float32)


@pytest.mark.parametrize(
    "make",
    [
        lambda **size: resize_scale(ONES, **size),
        lambda **size: scale_pattern(**size),
        lambda **size: flow_pattern(**size),
        lambda **size: scale_from_angles(slant=30.0, **size),
    ],
)
@pytest.mark.parametrize("side", ["width", "height"])
def test_maps_have_sides_up_to_16384(make, side):
    with pytest.raises(ValueError, match=rf"^{side}: should be less than or equal to 16384, got 1000000000"):
        make(**{"width": 4, "height": 4, side: 10**9})
