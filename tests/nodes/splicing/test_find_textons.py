from functools import partial

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from graphtex import Context
from graphtex_nodes import find_textons, textons
from graphtex_nodes.splicing._agreement import agreement, central
from graphtex_nodes.splicing._detection import reduced
from graphtex_nodes.splicing._peaks import cover, local_maxima, score_floor, suppress
from graphtex_nodes.splicing._unlit import unlit

small = partial(textons, width=144, height=128, size=20.0)
SETS = {
    "square": partial(small, jitter=0.1),
    "hexagonal": partial(small, form="flower", arrangement="hexagonal", jitter=0.1),
    "random": partial(small, form="leaf", arrangement="random", spacing=0.95),
    "touching": partial(small, arrangement="hexagonal", spacing=0.97, jitter=0.03),
    "bricks": partial(small, form="tile", size=32.0, arrangement="brick", spacing=1.12, proportion=0.45),
}


@pytest.mark.parametrize("name", SETS)
def test_given_element(name):
    made = SETS[name](rng=1)
    size = SETS[name].keywords["size"]
    found = find_textons(made.image, examples=[central(made)[1]])
    assert agreement(found.points, made, size)[0] >= 0.98
    assert found.confidence > 0.9


@pytest.mark.parametrize("name", SETS)
def test_automatic(name):
    made = SETS[name](rng=2)
    found = find_textons(made.image)
    assert agreement(found.points, made, SETS[name].keywords["size"])[0] >= 0.9


def test_two_kinds():
    """One example finds its own kind, two find both."""
    made = small(form="flower", other="disc", arrangement="hexagonal", spacing=1.25, rng=3)
    index, first = central(made)
    second = central(made, index)[1]
    both = agreement(find_textons(made.image, examples=[first, second]).points, made, 20.0)[0]
    assert both >= 0.98
    assert agreement(find_textons(made.image, examples=[first]).points, made, 20.0)[0] < 0.8


def test_turned_and_sized():
    made = textons(
        width=200, height=176, form="leaf", size=30.0, arrangement="random", turn=180.0, growth=1.2, spacing=1.0, rng=5
    )
    index, example = central(made)
    found = find_textons(made.image, examples=[example], turn=180.0, growth=1.5)
    share, which, true = agreement(found.elements.points, made, 30.0)
    assert share >= 0.98
    inner = (np.abs(made.centres[true] - (99.5, 87.5)) < (82, 70)).all(axis=1)
    which, true = which[inner], true[inner]
    off = found.elements.angles[which] - (made.elements.angles[true] - made.elements.angles[index])
    assert np.abs((off + 180) % 360 - 180).max() < 8
    sizes = found.elements.scales[which] * made.elements.scales[index] / made.elements.scales[true]
    assert np.abs(sizes - 1).max() < 0.1


def holes(count: int = 36, side: int = 160) -> tuple[np.ndarray, np.ndarray]:
    """Shaded hollows of four sizes on a plain ground, and their centres."""
    rng = np.random.default_rng(0)
    y, x = np.mgrid[:side, :side]
    image, centres, radii = np.full((side, side, 3), (0.94, 0.82, 0.5)), [], []
    while len(centres) < count:
        centre, radius = rng.uniform(4, side - 5, 2), float(rng.choice([4.5, 5.5, 6.5, 8.5], p=[0.4, 0.3, 0.2, 0.1]))
        if all(np.hypot(*(centre - other)) > radius + more + 5 for other, more in zip(centres, radii, strict=True)):
            centres.append(centre)
            radii.append(radius)
    for (left, top), radius in zip(centres, radii, strict=True):
        depth = np.clip(1.5 - 1.5 * np.hypot(x - left, y - top) / radius, 0, 1)[..., None] * rng.uniform(0.5, 1)
        image = image * (1 - depth) + depth * np.array([0.85, 0.55, 0.12])
    return image.astype(np.float32), np.array(centres)


def test_nothing_is_found_on_a_plain_ground():
    """Half way between two hollows the ground looks a little like them: 30 more are found where parts do not count."""
    image, centres = holes()
    found = find_textons(image)
    apart = np.hypot(*(found.points[:, None] - centres[None]).transpose(2, 0, 1))
    assert apart.min(axis=0).max() < 3
    assert len(found.points) == len(centres)
    assert found.confidence > 0.5


def test_small_elements_of_a_large_picture():
    """At first each is two of the pixels at which the picture is divided."""
    made = textons(width=1400, height=120, size=16.0, rng=1)
    told: list[str] = []
    found = find_textons(made.image, ctx=Context(on_warning=told.append))
    assert agreement(found.points, made, 16.0)[0] >= 0.98
    assert found.confidence > 0.5
    assert told == []


def lone(noise: float) -> np.ndarray:
    """A disc, 24 pixels wide, at (60, 66)."""
    y, x = np.mgrid[:128, :128]
    image = np.where((np.hypot(x - 60, y - 66) < 12)[..., None], (0.9, 0.3, 0.1), (0.3, 0.5, 0.3))
    return (image + np.random.default_rng(0).normal(0, noise, image.shape)).clip(0, 1).astype(np.float32)


@pytest.mark.parametrize("places", [[(60, 66, 12)], [(64, 64, 40)], [(35, 40, 15), (90, 80, 15), (40, 95, 12)]])
def test_few_elements_are_all_there_is_to_see(places):
    """One to three discs on noisy ground are no texture, but what else should they be?"""
    y, x = np.mgrid[:128, :128]
    away = np.min([np.hypot(x - left, y - top) / radius for left, top, radius in places], axis=0)
    image = np.where((away < 1)[..., None], (0.9, 0.3, 0.1), (0.3, 0.5, 0.3))
    image = image + np.random.default_rng(0).normal(0, 0.02, image.shape)
    told: list[str] = []
    found = find_textons(image.clip(0, 1).astype(np.float32), ctx=Context(on_warning=told.append))
    assert told == []
    order = np.argsort(found.points[:, 0])
    np.testing.assert_allclose(found.points[order], sorted((left, top) for left, top, _ in places), atol=1)
    sizes = 2 * np.array([radius for _, _, radius in sorted(places)])
    np.testing.assert_allclose(found.width * found.elements.scales[order], sizes, atol=2)


def test_what_is_white_all_over_is_no_example():
    """Without the slow changes of light a blotch, cut off at white, has spots that the picture itself has not."""
    noise = gaussian_filter(np.random.default_rng(0).normal(size=(128, 128)), 30)
    image = (0.5 + 0.2 * (noise - noise.mean()) / noise.std()).clip(0, 1)
    told: list[str] = []
    find_textons(np.repeat(image[..., None], 3, axis=2).astype(np.float32), ctx=Context(on_warning=told.append))
    assert "give one in examples" in told[0]


def test_blotches_of_noise_are_not_few_elements():
    for seed in range(3):
        noise = gaussian_filter(np.random.default_rng(seed).normal(size=(96, 96)), 8)
        image = (0.5 + 0.15 * noise / noise.std()).clip(0, 1)[..., None].astype(np.float32)
        told: list[str] = []
        assert find_textons(image, ctx=Context(on_warning=told.append)).confidence < 0.5
        assert told


@pytest.mark.parametrize(
    ("image", "place", "size", "wrong"),
    [
        (lone(0.02), (60, 66), 24, False),
        (lone(0.02), (20, 20), 24, True),
        (lone(0.02), (60, 66), 6, True),
        (small(jitter=0.1, rng=1).image, None, 20, False),
        (small(jitter=0.1, rng=1).image, None, 5, True),
    ],
)
def test_a_box_beside_an_element_or_on_a_part_of_one_is_told(image, place, size, wrong):
    example = central(small(jitter=0.1, rng=1))[1]
    x, y = place or (example.x, example.y)
    told: list[str] = []
    find_textons(image, examples=[{"x": x, "y": y, "width": size, "height": size}], ctx=Context(on_warning=told.append))
    assert ["examples: " in text and "are they whole elements?" in text for text in told] == [True] * wrong


def test_a_centre_on_the_last_row_is_inside_at_all_resolutions():
    """Of 128 rows every 1.5th is looked at, the last of which is row 126."""
    image = small(rng=1).image
    found = find_textons(image, examples=[{"x": 70, "y": 127, "width": 24, "height": 24}])
    assert len(found.points) > 0


def test_sizes_stay_in_range():
    """Discs of half the example's size are too small, however well they fit."""
    made = textons(width=160, height=160, size=14.0, jitter=0.1, rng=1)
    x, y = made.centres[np.argmin(np.hypot(*(made.centres - 80).T))]
    found = find_textons(made.image, examples=[{"x": x, "y": y, "width": 28, "height": 28}], growth=1.3)
    assert 1 / 1.3 - 1e-9 <= found.elements.scales.min() <= found.elements.scales.max() <= 1.3 + 1e-9


def test_places_are_between_pixels():
    made = small(rng=6)
    found = find_textons(made.image, examples=[central(made)[1]])
    _, which, true = agreement(found.points, made, 20.0)
    assert np.median(np.hypot(*(found.points[which] - made.centres[true]).T)) < 0.15


def test_literal_search_finds_noise_too():
    """The paper's channel choice and stop are worse than the default on the same element."""
    made = SETS["random"](rng=1)
    example = central(made)[1]
    literal = find_textons(made.image, examples=[example], search="literal")
    assert agreement(literal.points, made, 20.0)[0] < 0.9
    assert literal.similarity.shape == (128, 144, 1)


def test_grey_four_channels_and_one_element():
    """Brightness alone will do; a fourth channel is one more; a single element is found once."""
    made = small(form="leaf", rng=7)
    example = central(made)[1]
    grey = made.image.mean(axis=2, keepdims=True)
    for image in (grey, np.concatenate([made.image, grey], axis=2)):
        assert agreement(find_textons(image, examples=[example]).points, made, 20.0)[0] >= 0.95
    y, x = np.mgrid[:40, :50]
    dot = (np.hypot(x - 25, y - 20) < 7).astype(np.float32)[..., None]
    one = find_textons(dot, examples=[{"x": 25, "y": 20, "width": 17, "height": 17}])
    np.testing.assert_allclose(one.points, [[25, 20]], atol=0.05)


def test_threads_change_nothing():
    made = SETS["bricks"](rng=2)
    one, two = (find_textons(made.image, ctx=Context(threads=threads)) for threads in (1, 2))
    assert one.points.tobytes() == two.points.tobytes()
    assert one.similarity.tobytes() == two.similarity.tobytes()


def test_large_element_searches_a_smaller_picture():
    made = textons(width=400, height=400, size=80.0, rng=1)
    found = find_textons(made.image, examples=[central(made)[1]])
    assert agreement(found.points, made, 80.0)[0] == 1
    assert found.similarity.shape == (400, 400, 1)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 40, 3), (64, 64, 1)])
def test_nothing_to_find(shape):
    with pytest.raises(ValueError, match="image: expected alike elements, or one alone, found none"):
        find_textons(np.full(shape, 0.5, np.float32))


def test_noise_is_doubtful_or_empty():
    told: list[str] = []
    noise = np.random.default_rng(1).random((96, 96, 3)).astype(np.float32)
    try:
        find_textons(noise, ctx=Context(on_warning=told.append))
    except ValueError as error:
        told.append(str(error))
    assert "examples" in told[0]


def test_elements_of_a_pixel_are_not_told():
    """A large picture that was shrunk too far: whatever is found, its confidence is a number."""
    made = textons(width=128, height=128, size=24.0, form="disc", arrangement="square", rng=1).image
    tiny = np.tile(made.reshape(8, 16, 8, 16, 3).mean(axis=(1, 3)), (24, 24, 1)).astype(np.float32)
    told: list[str] = []
    assert 0 <= find_textons(tiny, ctx=Context(on_warning=told.append)).confidence < 0.5
    assert "examples" in told[0]


def test_refuses():
    image = small(rng=1).image
    with pytest.raises(ValueError, match=r"examples\[0\]: expected an element with its centre in the picture"):
        find_textons(image, examples=[{"x": 200, "y": 10, "width": 9, "height": 9}])
    with pytest.raises(ValueError, match="literal expects one example, turn 0 and growth 1, got 0 examples"):
        find_textons(image, search="literal")
    with pytest.raises(ValueError, match="width"):
        find_textons(image, examples=[{"x": 20, "y": 10, "width": 1, "height": 9}])


def test_peaks_by_hand():
    scores = np.zeros((5, 7))
    scores[2, 2], scores[2, 3], scores[4, 6] = 1.0, 0.5, 0.7
    points, values = local_maxima(scores, 1)
    np.testing.assert_allclose(points, [[2 + 0.5 * 0.5 / 1.5, 2], [6, 4]])  # the parabola through 0, 1, 0.5
    np.testing.assert_allclose(values, [1, 0.7])


def test_suppression_turns_with_the_element():
    """An ellipse of 10 x 2, turned by 90 degrees, removes what is above and not what is beside."""
    points, sizes = np.array([[0.0, 0.0], [0.0, 8.0], [8.0, 0.0]]), np.tile([10.0, 2.0], (3, 1))
    assert suppress(points, sizes, np.array([90.0, 0, 0]), 1.0).tolist() == [0, 2]
    assert suppress(points, sizes, np.zeros(3), 1.0).tolist() == [0, 1]


def test_cover_by_hand():
    """Boxes of 3 x 3 in a picture of 3 x 9."""
    assert cover(np.array([[1.0, 1], [4, 1], [7, 1], [1, 1]]), (3, 9), np.array([1.0, 1.0]), 0.95) == 3


def test_floor_parts_two_groups():
    assert 0.5 < score_floor(np.array([0.9, 0.95, 0.85, 0.3, 0.35, 0.28, 0.31])) < 0.7
    assert score_floor(np.array([0.9])) == 0.4


def test_unlit_ignores_brightness():
    """Shading that halves the light changes the shares of the colours little."""
    image = small(rng=1).image
    shaded = image * np.linspace(0.5, 1, 144, dtype=np.float32)[None, :, None]
    a, b = (unlit(x)[..., :3].reshape(-1, 3) for x in (image, shaded))
    for channel in range(3):
        assert np.corrcoef(a[:, channel], b[:, channel])[0, 1] > 0.97


def test_halving_first_is_hardly_another_picture():
    """Every sixth pixel of a smooth picture, from all of it and from one of half its sides: smoothed as much."""
    image = gaussian_filter(np.random.default_rng(4).random((121, 150, 2)), (5, 5, 0))
    small = reduced(image, 6.0)
    assert small.shape == (21, 25, 2)
    direct = gaussian_filter(image, (2.7, 2.7, 0), mode="mirror")[::6, ::6]
    assert np.abs(small[:, :25] - direct).max() < 0.02 * np.ptp(image)


def test_places_are_told_as_they_were_given():
    """The search shrinks the picture, and its numbers mean nothing to the user."""
    made = textons(width=97, height=131, size=36.0, rng=1)
    with pytest.raises(ValueError, match=r"examples\[0\]: .*x <= 96, y <= 130.*got x = 300, y = 30"):
        find_textons(made.image, examples=[{"x": 300, "y": 30, "width": 36, "height": 36}])
