"""The search for a plane ends early where none will be found, and changes nothing where there is one."""

import numpy as np

from graphtex import Context
from graphtex_nodes import woven_cloth
from graphtex_nodes.numerics.homogeneity import Recession, picture_recession


def test_a_plane_is_the_same_whatever_confidence_is_asked_for() -> None:
    picture = woven_cloth(width=128, height=128, size=8.0, slant=50.0, rng=1).image
    found = picture_recession(picture, None, Context(threads=1))
    assert found is not None
    assert found.confidence > 0.5
    assert picture_recession(picture, None, Context(threads=1), 0.3) == found


def test_where_no_plane_is_better_than_a_flat_one_the_search_ends() -> None:
    row, column = np.indices((128, 128))
    picture = (np.sin(row * (2 * np.pi / 8)) * np.sin(column * (2 * np.pi / 8)))[..., None].astype(np.float32)
    assert picture_recession(picture, None, Context(threads=1), 0.3) == Recession(0.0, 0.0, 0.0)
