import json

import numpy as np
import pytest
from scipy.spatial import cKDTree

from graphtex_nodes import arrange_path, arrange_pattern, arrange_points, extend_texture, vary_elements
from graphtex_nodes.splicing.texton_labels import texton_labels, texton_reach
from tests.nodes.splicing.scenes import discs, elements, grid, whole

PATTERNS = ["own", "random", "square", "hexagonal", "brick", "ring", "spiral"]


@pytest.fixture(scope="module")
def extension():
    return extend_texture(discs(grid(16, (96, 96)), (96, 96), 5))


def inside(places, margin=0.0):
    return places[((places >= margin) & (places <= 95 - margin)).all(axis=1)]


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("density", [1.5, 2.2])
def test_density(extension, pattern, density):
    """As many places for each area as textons times the density, within what a border of 96 px lets one tell."""
    places = arrange_pattern(extension, pattern=pattern, density=density).points
    assert len(inside(places)) / 96**2 == pytest.approx(density / 16**2, rel=0.25)


@pytest.mark.parametrize("pattern", PATTERNS[1:])
def test_places_reach_as_far_as_elements(extension, pattern):
    places = arrange_pattern(extension, pattern=pattern, spacing=16).points
    assert -6 < places.min() < 0
    assert 95 < places.max() < 101


def test_own_stays_where_it_is(extension):
    places = arrange_pattern(extension, pattern="own").points
    distance = cKDTree(extension.points - (extension.left, extension.top)).query(places)[0]
    assert distance.max() < 1e-9
    spread = arrange_pattern(extension, pattern="own", density=0.25).points
    np.testing.assert_allclose(cKDTree(spread).query(spread, k=[2])[0], 32, atol=0.5)


@pytest.mark.parametrize(
    ("pattern", "neighbours"),
    [("square", [20, 20, 20, 20]), ("hexagonal", [20] * 6), ("brick", [20, 20, *[np.hypot(10, 20)] * 4])],
)
def test_lattices_worked_by_hand(extension, pattern, neighbours):
    """Neighbours of the place in the middle, also when all is turned."""
    for angle in (0.0, 33.0):
        places = arrange_pattern(extension, pattern=pattern, spacing=20, angle=angle).points
        distance = np.sort(np.hypot(*(places - 47.5).T))
        np.testing.assert_allclose(distance[: len(neighbours) + 1], [0, *neighbours], atol=1e-9)


def test_aspect_is_of_a_cell(extension):
    places = arrange_pattern(extension, pattern="brick", spacing=30, aspect=3.0).points
    assert np.unique(np.diff(np.unique(places[:, 1].round(6)))).tolist() == [10]


def test_angle_is_clockwise(extension):
    """A row through the middle, turned by 30 degrees, goes down to the right."""
    places = arrange_pattern(extension, pattern="square", spacing=20, angle=30).points - 47.5
    wanted = 20 * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    assert np.abs(places - wanted).max(axis=1).min() < 1e-9


def test_rings_and_spiral(extension):
    radius = np.hypot(*(arrange_pattern(extension, pattern="ring", spacing=12).points - 47.5).T)
    assert np.abs((radius + 6) % 12 - 6).max() < 1e-9
    offset = arrange_pattern(extension, pattern="spiral", spacing=12).points - 47.5
    turn = np.arctan2(offset[:, 1], offset[:, 0]) / (2 * np.pi)
    assert np.abs((np.hypot(*offset.T) / 12 - turn + 0.5) % 1 - 0.5).max() < 1e-9


def test_random_keeps_its_distance_and_follows_the_seed(extension):
    one, two, other = (arrange_pattern(extension, pattern="random", spacing=10, rng=seed).points for seed in (0, 0, 1))
    np.testing.assert_array_equal(one, two)
    assert len(one) != len(other) or not np.array_equal(one, other)
    assert cKDTree(one).query(one, k=[2])[0].min() >= 10


def test_jitter(extension):
    still = arrange_pattern(extension, pattern="square", spacing=20).points
    moved = arrange_pattern(extension, pattern="square", spacing=20, jitter=0.2).points
    distance = cKDTree(still).query(inside(moved, 10))[0]
    assert 1 < distance.max() <= 4 * np.sqrt(2)


def test_a_path_by_hand(extension):
    """An L of 20 and 15 px, a place every 10: two on the way right, then down, turned by 90 degrees."""
    path = {
        "lines": [
            {"points": [(10, 10), (30, 10), (30, 10), (30, 25)], "radius": 1},
            {"points": [(50, 50)], "radius": 1},
        ]
    }
    found = arrange_path(extension, path=path, spacing=10)
    np.testing.assert_allclose(found.points, [[10, 10], [20, 10], [30, 10], [30, 20], [50, 50]])
    np.testing.assert_allclose(found.angles, [0, 0, 90, 90, 0])
    assert not arrange_path(extension, path=path, spacing=10, follow=False).angles.any()
    assert len(arrange_path(extension, path=path).points) == 4  # 16 px, as the textons


def test_a_path_in_a_file_and_on_a_picture_of_another_size(extension, tmp_path):
    file = tmp_path / "path.json"
    file.write_text(json.dumps({"size": [48, 48], "lines": [{"points": [[4.5, 4.5], [24.5, 4.5]], "radius": 1}]}))
    found = arrange_path(extension, path={"file": file}, spacing=20)
    np.testing.assert_allclose(found.points, [[9.5, 9.5], [29.5, 9.5], [49.5, 9.5]])


def test_points_are_places():
    found = arrange_points(np.array([[1.0, 2.0], [3.0, 4.0]]))
    assert found.points.tolist() == [[1, 2], [3, 4]]
    assert found.angles.tolist() == [0, 0]


def test_variation():
    many = elements(np.arange(400.0).reshape(200, 2), angles=10, scales=2)
    found = vary_elements(many, angle=5, turn=20, scale=0.5, growth=1.5)
    assert found.angles.min() >= -5
    assert found.angles.max() <= 35
    assert np.ptp(found.angles) > 35
    assert 1 / 1.5 <= found.scales.min() < 0.75
    assert 1.35 < found.scales.max() <= 1.5
    fewer = vary_elements(many, keep=0.3)
    assert len(fewer.points) == 60
    assert (np.diff(fewer.points[:, 0]) > 0).all()
    assert len(vary_elements(elements([]), turn=10).points) == 0


def test_reach_by_hand():
    texture = discs([[10, 10], [30, 25]], radius=5)
    assert texton_reach(texton_labels(texture.mask, texture.points), texture.points) == 5
    assert texton_reach(np.full((4, 4), -1), np.zeros((0, 2))) == 0


def test_refuses(extension):
    empty = whole(discs([]))
    with pytest.raises(ValueError, match="elements: expected at least one texton"):
        arrange_pattern(empty)
    with pytest.raises(ValueError, match="elements: expected at least one texton"):
        arrange_path(empty, path={"lines": [{"points": [(1, 1)], "radius": 1}]})
    with pytest.raises(ValueError, match="path: expected at least one line"):
        arrange_path(extension, path={})
    with pytest.raises(ValueError, match="spacing: expected at most 100000 places"):
        arrange_pattern(extension, spacing=0.1)
