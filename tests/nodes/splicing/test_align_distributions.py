import numpy as np
import pytest
from scipy.spatial import cKDTree

from graphtex_nodes import align_distributions, extend_texture, sample_texture
from graphtex_nodes.numerics.arrangements import lattice_points
from graphtex_nodes.splicing._pattern import orientations, spacing
from graphtex_nodes.splicing._tiling import Tiling, far_places
from tests.nodes.splicing.scenes import discs, grid


def turned(points, degrees, about):
    """Clockwise with y down."""
    angle = np.radians(degrees)
    rotation = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return (points - about) @ rotation + about


def lattice(kind, step, degrees, size=200.0, jitter=0.0):
    middle = np.full(2, size / 2)
    points = turned(lattice_points(kind, middle - size, middle + size, (step, step)), degrees, middle)
    points += np.random.default_rng(1).uniform(-jitter, jitter, points.shape) * step
    return points[((points >= -0.4) & (points <= size - 0.6)).all(axis=1)]


def test_spacing_worked_by_hand():
    """In a square lattice four neighbours are 10 away, the fifth 10 sqrt 2; those at the border would have fewer."""
    points = grid(10, (100, 100), 5)
    assert spacing(points, (100, 100), 4) == pytest.approx(10)
    assert spacing(points, (100, 100), 5) == pytest.approx(10 * (4 + np.sqrt(2)) / 5)
    assert spacing(points[:2], None, 5) == pytest.approx(10)


@pytest.mark.parametrize("kind", ["square", "hexagonal"])
@pytest.mark.parametrize("degrees", [0, 7, 25.5])
def test_orientation_of_a_lattice(kind, degrees):
    """Up to its symmetry, with jitter, within 1.2 degrees."""
    found = orientations(lattice(kind, 20, degrees, jitter=0.06), 20)
    assert len(found) > 0
    step = {"square": 45, "hexagonal": 30}[kind]  # diagonals are rows, too
    assert np.abs((found - degrees + step / 2) % step - step / 2).max() <= 1.2


def test_no_orientation_where_there_is_none():
    assert len(orientations(np.random.default_rng(5).uniform(0, 200, (60, 2)), 20)) == 0
    assert len(orientations(np.array([[0.0, 0.0], [10.0, 3.0]]), 10)) == 0


@pytest.mark.parametrize(("step", "degrees"), [(16, 0), (24, 20), (9, -35)])
def test_scale_and_turn_are_undone(step, degrees):
    """A square lattice of another size and orientation falls on the elements' own."""
    elements = extend_texture(discs(grid(16, (96, 96)), (96, 96), 5))
    other = discs(lattice("square", step, degrees, 160.0), (160, 160), 2)
    found = align_distributions(elements, other)
    assert found.scale == pytest.approx(16 / step, rel=0.01)
    assert (found.angle + degrees + 45) % 90 - 45 == pytest.approx(0, abs=0.6)
    inner = found.target.points[(np.abs(found.target.points - 47.5) < 32).all(axis=1)]
    distance = cKDTree(elements.points - (elements.left, elements.top)).query(inner)[0]
    assert len(inner) >= 12
    assert distance.max() < 2


def test_a_texture_on_itself_stays():
    texture = sample_texture(name="leaves")
    found = align_distributions(extend_texture(texture), texture)
    assert found.angle == 0
    assert found.scale == pytest.approx(1, abs=0.03)


def test_places_fill_the_window_and_its_surroundings():
    """Also where the arrangement is far smaller, and of another shape: no place is far from all."""
    elements = extend_texture(discs(grid(16, (96, 96)), (96, 96), 5))
    few = discs([[20, 15], [45, 15], [70, 15], [20, 40], [45, 40], [70, 40]], (50, 90), 5)
    places = align_distributions(elements, few).target.points
    assert places.min() < 0
    assert places.max() > 95
    window = np.stack(np.meshgrid(np.arange(96), np.arange(96)), axis=-1).reshape(-1, 2)
    assert cKDTree(places).query(window)[0].max() < 1.2 * 16


def test_a_lattice_goes_on_as_a_lattice():
    """Its picture is no whole number of cells; the corner of a picture's period would show a gap."""
    points = lattice("hexagonal", 20, 0, 107.4)
    far = Tiling(points, (107, 107), 20).over(np.full(2, -100.0), np.full(2, 207.0))
    inner = far[(np.abs(far - 53) < 120).all(axis=1)]
    nearest = cKDTree(far).query(inner, k=[2, 7])[0]
    np.testing.assert_allclose(nearest, 20, atol=0.3)


def test_margins_wider_than_between_neighbours_do_not_part_the_copies():
    """Six points 10 apart in the middle of a picture of 48 x 38: the next row and column are 10 away, not 28."""
    points = np.array([(x, y) for y in (14.0, 24.0) for x in (14.0, 24.0, 34.0)])
    far = Tiling(points, (38, 48), 10).over(np.full(2, -20.0), np.array([68.0, 58.0]))
    assert cKDTree(far).query(far, k=[2])[0].max() <= 10
    np.testing.assert_array_equal(np.unique(far[:, 0]), [-16, -6, 4, 14, 24, 34, 44, 54, 64])
    assert len(Tiling(points, (38, 48), 10).over(np.zeros(2), np.array([47.0, 37.0]))) == 6  # the picture itself stays


def test_copies_of_a_low_picture_leave_no_gap():
    """What its border cuts is not known: copies above and below leave bands with more room than between its points."""
    rng, points = np.random.default_rng(1), np.empty((0, 2))
    for place in rng.uniform((9, 9), (310, 70), (2000, 2)):
        if len(points) == 0 or np.hypot(*(points - place).T).min() > 20:
            points = np.concatenate([points, [place]])
    unit = spacing(points, (80, 320), 5)
    far = Tiling(points, (80, 320), unit).over(np.array([0.0, -100.0]), np.array([319.0, 180.0]))
    away = {
        name: cKDTree(far).query(np.stack(np.meshgrid(np.arange(20, 300, 3), rows), axis=-1))[0]
        for name, rows in (("inside", np.arange(16, 64, 3)), ("beyond", np.arange(-60, 140, 3)))
    }
    assert away["beyond"].max() < 1.2 * away["inside"].max()
    np.testing.assert_array_equal(far[: len(points)], points)


@pytest.mark.parametrize("counts", [(1, 1), (2, 5), (30, 31), (33, 29)])
def test_no_place_that_is_far_from_all_points_is_passed_over(counts):
    rng = np.random.default_rng(counts)
    points, (x, y) = rng.uniform(0, 30, (12, 2)), (np.linspace(0, 30, count) for count in counts)
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    away = cKDTree(points).query(places)[0]
    found, distance = far_places(points, x, y, 4.0)
    np.testing.assert_array_equal(found[distance > 4.0], places[away > 4.0])
    assert counts[0] < 30 or 0 < np.count_nonzero(away > 4.0) <= len(found) < len(places)


def test_disjoint_elements_are_given_room():
    """Discs 16 px wide, 20 px apart, in rows whose members are half as far apart as the rows: 14 px and 28 px."""
    texture = discs(grid(20, (100, 100), 10), (100, 100), 8)
    rows = discs(
        np.stack(np.meshgrid(np.arange(5.0, 100, 10), np.arange(10.0, 100, 20)), 2).reshape(-1, 2), (100, 100), 3
    )
    extension = extend_texture(texture)
    free, kept, wide = (align_distributions(extension, rows, spread=spread) for spread in (None, 1.0, 2.0))
    nearest = [np.median(cKDTree(each.target.points).query(each.target.points, 2)[0][:, 1]) for each in (free, kept)]
    assert nearest[1] < 15
    assert nearest[0] == pytest.approx(0.95 * 16, abs=0.6)
    assert wide.scale == pytest.approx(2 * kept.scale)
    assert align_distributions(extension._replace(tag="F=c"), rows).scale == pytest.approx(kept.scale)


def test_kept_is_not_turned():
    elements = extend_texture(discs(grid(16, (96, 96)), (96, 96), 5))
    other = discs(lattice("square", 20, 20, 160.0), (160, 160), 2)
    assert align_distributions(elements, other, orientation="kept").angle == 0


def test_a_single_place_stays_where_it_is_in_its_picture():
    """A picture of 96 x 48 fits into a window of 64 x 64 at 2 / 3: its middle is (31.5, 31.5), 12 px left of it is 8."""
    elements = extend_texture(discs(grid(), (64, 64)))
    found = align_distributions(elements, discs([[47.5 - 12, 23.5 + 6]], (48, 96)))
    np.testing.assert_allclose(found.target.points, [[31.5 - 8, 31.5 + 4]])
    assert (found.scale, found.angle) == (pytest.approx(2 / 3), 0)


def test_a_single_element_counts_as_one_in_each_window():
    """A disc that fills its picture is not repeated within the extension: places are as far apart as windows."""
    elements = extend_texture(discs([[32, 32]], (64, 64), 28))
    assert len(elements.points) == 1
    found = align_distributions(elements, discs(grid(16, (64, 64)), (64, 64), 5), neighbours=4)
    assert found.scale == pytest.approx(64 / 16)


@pytest.mark.parametrize(
    ("elements", "arrangement", "told"),
    [
        ([], grid(), "elements: expected at least one texton, got none"),
        (grid(), [], "arrangement: expected at least one texton, got none"),
        (grid(), [[9, 9], [9, 9]], "arrangement: expected textons at different places"),
    ],
)
def test_refuses(elements, arrangement, told):
    extension = extend_texture(discs(elements, (64, 64)), factor=1.0)
    with pytest.raises(ValueError, match=told):
        align_distributions(extension, discs(arrangement, (64, 64)))


def test_refuses_points_outside():
    extension = extend_texture(discs(grid(), (64, 64)))
    outside = discs(grid(), (64, 64))._replace(points=np.array([[70.0, 3.0], [3.0, 3.0]]))
    with pytest.raises(ValueError, match="arrangement: expected points inside the image"):
        align_distributions(extension, outside)
