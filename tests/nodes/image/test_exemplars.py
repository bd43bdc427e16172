import socket
from importlib.resources import files

import numpy as np
import pytest
from PIL import Image

from graphtex.handlers import find_opener
from graphtex.sockets import find_type
from graphtex_nodes.image.exemplars.bricks import bricks
from graphtex_nodes.image.exemplars.flowers import flowers
from graphtex_nodes.image.exemplars.pebbles import pebbles
from graphtex_nodes.image.exemplars.sample import DRAWINGS, ELEMENTS, MATERIALS, NAMES, PHOTOGRAPHS, sample
from graphtex_nodes.image.exemplars.sand import sand
from graphtex_nodes.image.exemplars.woven_cloth import woven_cloth
from graphtex_nodes.numerics.plane import photograph, seen_plane
from tests.truth import rendered_plane, scale_slope

KINDS = (pebbles, flowers, bricks, woven_cloth, sand)
kinds = pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)


@kinds
@pytest.mark.parametrize("pose", [{}, {"slant": 50.0, "tilt": 35.0, "field_of_view": 40.0}])
def test_colour_picture_of_the_size_asked_for(kind, pose):
    made = kind(width=80, height=56, **pose)
    assert made.image.shape == (56, 80, 3)
    assert made.image.dtype == np.float32
    assert made.image.min() >= 0
    assert made.image.max() <= 1
    assert made.image.std(axis=(0, 1)).min() > 0.03  # every channel has something to show
    assert np.ptp(made.image.mean(axis=(0, 1))) > 0.01  # and it is no grey picture


@kinds
def test_seed_decides(kind):
    first, again, other = (
        kind(width=48, height=48, rng=3),
        kind(width=48, height=48, rng=3),
        kind(width=48, height=48, rng=4),
    )
    np.testing.assert_array_equal(first.image, again.image)
    assert np.abs(first.image - other.image).mean() > 0.02


@kinds
@pytest.mark.parametrize("tilt", [0.0, -50.0, 120.0])
def test_scale_is_that_of_rays_on_a_plane(kind, tilt):
    """A second method: rays cast on the plane."""
    made = kind(width=40, height=32, slant=48.0, tilt=tilt, field_of_view=50.0, size=16.0)
    np.testing.assert_allclose(made.scale, rendered_plane((32, 40), 48.0, tilt, 50.0), rtol=1e-5)


@kinds
def test_face_on_has_scale_one(kind):
    made = kind(width=32, height=32, slant=0.0, tilt=40.0)
    assert np.all(made.scale == 1)


@pytest.mark.parametrize("kind", [pebbles, flowers, bricks], ids=lambda kind: kind.name)
def test_centres_lie_inside_from_top_to_bottom(kind):
    x, y = kind(width=96, height=64, slant=45.0, tilt=20.0).centres.T
    assert len(x) > 5
    assert x.min() >= 0
    assert x.max() <= 95
    assert y.min() >= 0
    assert y.max() <= 63
    assert np.all(np.diff(y) > -1e-5)


def test_as_many_pebbles_as_fit():
    """A pebble each size², give or take the border."""
    assert abs(len(pebbles(width=240, height=192, size=16.0).centres) / (240 * 192 / 16**2) - 1) < 0.1


def test_pebbles_lie_on_their_centres():
    """The pixel at a pebble's centre has the colour of its surroundings, the gaps between pebbles do not."""
    made = pebbles(width=256, height=256, size=32.0, rng=1)
    grey = made.image.mean(axis=2)
    x, y = np.rint(made.centres[(made.centres.min(axis=1) > 6) & (made.centres.max(axis=1) < 249)]).astype(int).T
    assert len(x) > 40
    around = np.array([grey[j - 5 : j + 6, i - 5 : i + 6].std() for i, j in zip(x, y, strict=True)])
    assert np.median(around) < 0.5 * grey.std()


def test_bricks_stand_a_length_apart():
    """On a floor, the bricks of a course lie side by side `size` times the course's true scale apart."""
    made = bricks(width=128, height=128, size=24.0, slant=50.0)
    x, y = made.centres.T
    truth = rendered_plane(128, 50.0)
    courses = np.unique(y.round(6))
    assert len(courses) > 5
    for course in courses:
        row = np.sort(x[np.abs(y - course) < 1e-5])
        scale = np.interp(course, np.arange(128), truth[:, 64])
        np.testing.assert_allclose(np.diff(row), 24 * scale, rtol=1e-4)


def test_level_courses_for_any_tilt():
    """Tilt turns the view, not the wall: face on it changes nothing."""
    upright, turned = bricks(width=64, height=64, rng=1), bricks(width=64, height=64, tilt=90.0, rng=1)
    np.testing.assert_allclose(turned.centres, upright.centres, atol=1e-6)


def test_elements_shrink_with_distance():
    """The measured slope of sizes: clear on the plane, none when the same pebbles are seen face on."""
    seen = [pebbles(width=192, height=192, size=14.0, slant=55.0, rng=seed) for seed in (0, 1)]
    flat = [pebbles(width=192, height=192, size=14.0, rng=seed) for seed in (0, 1)]
    assert np.mean([scale_slope(made.image, made.scale) for made in seen]) > 0.4
    assert abs(np.mean([scale_slope(made.image, seen[0].scale) for made in flat])) < 0.15


@kinds
def test_horizon_is_refused(kind):
    with pytest.raises(ValueError, match=r"field_of_view: the horizon is in the picture.*got 1\.0"):
        kind(width=32, height=32, slant=70.0, tilt=0.0, field_of_view=42.0)


def test_scales_beyond_a_scale_map_are_refused():
    """tan(70) tan(20) = 1 but for 1 %: scales of 1 to 200."""
    with pytest.raises(ValueError, match="a scale map holds"):
        pebbles(width=128, height=128, slant=70.0, field_of_view=40.0)


@pytest.mark.parametrize(
    "wrong", [{"slant": 85.0}, {"size": 0.0}, {"width": 2}, {"tilt": 200.0}, {"field_of_view": 0.0}]
)
def test_refuses(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        pebbles(**wrong)


def test_photograph_of_coordinates_gives_coordinates():
    """A plane painted with its own coordinates: each pixel shows the place that its ray meets."""
    plane = seen_plane(48, 40, 50.0, 30.0, 40.0)

    def paint(region):
        return np.stack(np.broadcast_arrays(region.u[None, :], region.v[:, None]), axis=-1)

    y, x = np.mgrid[:40, :48]
    u, v = plane.to_plane(*plane.rotate(x, y))
    picture = photograph(plane, paint)
    np.testing.assert_allclose(picture[..., 0], u, atol=0.08)  # a twelfth of a pixel
    np.testing.assert_allclose(picture[..., 1], v, atol=0.25)  # pixels reach further back than forth


def test_photograph_averages_what_is_too_small_to_see():
    """Checks far smaller than a pixel's footprint become an even grey."""
    plane = seen_plane(64, 64, 65.0, 0.0, 40.0)

    def paint(region):
        checks = (np.floor(region.u / 1.3)[None, :] + np.floor(region.v / 1.3)[:, None]) % 2
        return checks[..., None]

    far = photograph(plane, paint)[:8, :, 0]
    assert abs(far.mean() - 0.5) < 0.01
    assert far.std() < 0.06


def test_picture_and_plane_undo_each_other():
    plane = seen_plane(50, 30, 55.0, -70.0, 35.0)
    y, x = np.mgrid[:30, :50].astype(float)
    back = plane.to_picture(*plane.to_plane(*plane.rotate(x, y)))
    np.testing.assert_allclose(back, [x, y], atol=1e-9)


@pytest.mark.parametrize("weave", ["plain", "twill", "basket"])
def test_half_of_the_cloth_is_warp(weave):
    """Each yarn is up as often as down, so red warp and green weft share the picture."""
    image = woven_cloth(width=128, height=128, size=8.0, weave=weave, warp=(0.9, 0.1, 0.1), weft=(0.1, 0.9, 0.1)).image
    assert 0.42 < (image[..., 0] > image[..., 1]).mean() < 0.58


def test_samples_need_no_network(monkeypatch):
    def refuse(*args, **kwargs):
        raise AssertionError("a sample went to the network")

    monkeypatch.setattr(socket, "socket", refuse)
    for name in PHOTOGRAPHS:
        image = sample(name=name)
        assert image.shape == (512, 512, 1)
        with files("skimage.data").joinpath(f"{name}.png").open("rb") as file:
            np.testing.assert_array_equal(np.rint(image[..., 0] * 255), np.asarray(Image.open(file)))


def test_the_spiral_is_a_drawing():
    """Grey from black to white, and turned half a turn its own negative."""
    image = sample(name="spiral")
    assert image.shape == (256, 256, 1)
    assert image.min() == pytest.approx(0, abs=1e-3)
    np.testing.assert_allclose(image[::-1, ::-1], 1 - image, atol=1e-4)


@pytest.mark.parametrize("name", sorted(set(NAMES) - set(PHOTOGRAPHS) - set(MATERIALS) - set(DRAWINGS)))
def test_drawn_samples(name):
    image = sample(name=name)
    assert image.shape == ((192, 192, 3) if name in ELEMENTS else (256, 256, 3))
    assert image.std() > 0.05


def test_maps_of_a_sample_agree():
    """Mortar lies low and bricks high, within [0, 1]; normals are unit vectors, and level on a brick's face."""
    colour, height, normal = (sample(name=f"bricks{kind}") for kind in ("", "-height", "-normal"))
    assert height.shape == (256, 256, 1)
    assert 0 < height.min() < 0.25 < 0.75 < height.max() < 1
    mortar = colour.min(axis=2) > 0.45  # grey, red bricks have little blue
    assert height[~mortar].mean() > 2 * height[mortar].mean()
    vectors = normal * 2.0 - 1
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=2), 1, atol=1e-5)
    assert np.median(vectors[..., 2][height[..., 0] > 0.7]) > 0.97
    made = bricks(rng=6)
    np.testing.assert_array_equal(made.height, height)


def test_sample_is_always_the_same():
    np.testing.assert_array_equal(sample(name="pebbles"), pebbles(slant=55.0, rng=1).image)


def test_unknown_sample():
    with pytest.raises(ValueError, match=r"should be 'pebbles' or another of .*brick.*gravel.*twill, got 'peebles'"):
        sample(name="peebles")


def test_scheme_of_a_string():
    """`sample:pebbles` in a graph file means this node."""
    from graphtex import Image as ImageType

    entry, rest = find_opener(find_type(ImageType), "sample:pebbles")
    assert entry.node is sample
    assert rest == "pebbles"
