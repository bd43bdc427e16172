from functools import partial

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from graphtex import Context, Elements
from graphtex_nodes import find_textons, separate_foreground, textons
from graphtex_nodes.numerics.illumination import evenly_lit
from graphtex_nodes.splicing import _outlines
from graphtex_nodes.splicing._agreement import central
from graphtex_nodes.splicing._colours import least_cut, mixture_cost, smoothness_costs, told_by_hue
from graphtex_nodes.splicing._cutter import Cutter, lost_share
from graphtex_nodes.splicing._nearness import common_offset
from graphtex_nodes.splicing.texton_labels import texton_labels

small = partial(textons, width=144, height=128, size=24.0)
SETS = {
    "discs": partial(small, jitter=0.1),
    "leaves": partial(small, form="leaf", size=30.0, arrangement="random", spacing=0.95),
    "bricks": partial(small, form="tile", size=40.0, arrangement="brick", spacing=1.12, proportion=0.45),
}


def overlap(mask, truth):
    """Intersection over union."""
    return np.count_nonzero(mask & truth) / np.count_nonzero(mask | truth)


def cut(image, **options):
    found = find_textons(image)
    return separate_foreground(image, found.elements, width=found.width, height=found.height, **options)


@pytest.mark.parametrize("name", SETS)
@pytest.mark.parametrize("spoiled", ["clean", "noise", "ramp"])
def test_automatic(name, spoiled):
    made = SETS[name](rng=1)
    image = made.image
    if spoiled == "noise":
        image = image + np.random.default_rng(1).normal(0, 0.02, image.shape).astype(np.float32)
    if spoiled == "ramp":
        image = image * np.linspace(0.5, 1, 144, dtype=np.float32)[None, :, None]
    assert overlap(cut(np.clip(image, 0, 1)).mask, made.mask) >= 0.9


@pytest.mark.parametrize("ramp", [1.0, 0.5])
@pytest.mark.parametrize("side", [60, 76])
def test_a_lone_element_is_no_light_in_the_middle(side, ramp):
    """A grey disc, 48 px wide and mottled, on darker mottled ground; its margins are not the ground, either."""
    rng = np.random.default_rng(2)
    middle = (side - 1) / 2
    y, x = np.mgrid[:side, :side]
    truth = np.hypot(x - middle, y - middle) < 24
    mottle = gaussian_filter(rng.normal(0, 1, (side, side)), 1.0)
    image = np.where(truth, 0.55, 0.2) * np.exp(0.25 * mottle / mottle.std()) * np.linspace(1, ramp, side)
    image = np.repeat(image[..., None], 3, axis=2).clip(0, 1).astype(np.float32)
    one = Elements(np.array([[middle, middle]]), np.zeros(1), np.ones(1))
    assert overlap(separate_foreground(image, one, width=48.0, height=48.0).mask, truth) >= 0.9


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_gaps_between_touching_elements(seed, noise):
    """What is farthest from all elements is not ground here but parts of others, whose middles are out of sight."""
    made = small(arrangement="hexagonal", spacing=0.97, jitter=0.03, rng=seed)
    image = made.image + np.random.default_rng(1).normal(0, noise, made.image.shape).astype(np.float32)
    found = separate_foreground(np.clip(image, 0, 1), made.elements, width=24.0, height=24.0)
    assert overlap(found.mask, made.mask) >= 0.9


@pytest.mark.parametrize("seed", [1, 2])
def test_touching_elements_found_without_an_example(seed):
    """Light falls on one side of them: what is taken for an element is too small and off its centre at first."""
    made = small(arrangement="hexagonal", spacing=0.97, jitter=0.03, rng=seed)
    found = find_textons(made.image)
    assert found.width == pytest.approx(24, rel=0.15)
    assert overlap(cut(made.image).mask, made.mask) >= 0.9


def test_joints_of_the_colour_of_some_bricks():
    """A stained pavement with some light bricks: darker than what is on both sides are the joints alone."""
    rng = np.random.default_rng(1)
    image, truth, centres = np.full((120, 160), 0.36), np.zeros((120, 160), bool), []
    for row, top in enumerate(range(1, 118, 12)):
        for left in range(-10 * (row % 2) + 1, 160, 20):
            brick = np.s_[top : top + 10, max(left, 0) : left + 18]
            image[brick], truth[brick] = 0.9 if rng.random() < 0.2 else 0.44, True
            centres.append((left + 8.5, top + 4.5))
    stain = gaussian_filter(rng.normal(0, 1, image.shape), 12)
    image = image * np.exp(0.3 * stain / stain.std()) + rng.normal(0, 0.01, image.shape)
    image = image.clip(0, 1).astype(np.float32)[..., None]
    elements = Elements(np.array(centres), np.zeros(len(centres)), np.ones(len(centres)))
    found = separate_foreground(image, elements, width=18.0, height=10.0)
    # whether a line along the border is a joint nobody can tell
    assert overlap(found.mask[2:-2, 2:-2], truth[2:-2, 2:-2]) >= 0.9
    even = evenly_lit(image).astype(np.float64)
    by_colours = Cutter("mixture", 5, None, 2.0, None)._cut(
        even, np.zeros(truth.shape, np.int8), elements, 18.0, 10.0, Context()
    )
    assert overlap(by_colours, truth) < 0.6
    assert lost_share(by_colours, elements, 18.0, 10.0) > 0.25


def test_lost_elements_by_hand():
    """Two of four are not in the mask; a ring is in it."""
    y, x = np.mgrid[:40, :80]
    mask = np.hypot(x - 10, y - 20) < 8
    mask |= (np.hypot(x - 30, y - 20) < 8) & (np.hypot(x - 30, y - 20) > 5)
    elements = Elements(np.array([[10.0, 20], [30, 20], [50, 20], [70, 20]]), np.zeros(4), np.ones(4))
    assert lost_share(mask, elements, 16.0, 16.0) == 0.5
    assert lost_share(mask, None, 0.0, 0.0) == 0


def test_common_offset_by_hand():
    """Bright discs on a dark ground, and ellipses of their size two pixels to the right and one up."""
    x, y = (places.ravel() for places in np.meshgrid(np.arange(12.0, 90, 24), np.arange(12.0, 90, 24)))
    column, row = np.meshgrid(np.arange(96), np.arange(96))
    image = np.full((96, 96, 3), 0.2, np.float32)
    for across, down in zip(x, y, strict=True):
        image[np.hypot(column - across, row - down) < 8] = (0.8, 0.5, 0.3)
    elements = Elements(np.stack([x + 2, y - 1], axis=1), np.zeros(len(x)), np.ones(len(x)))
    np.testing.assert_allclose(common_offset(image, elements, 16.0, 16.0), [-2, 1], atol=0.1)
    assert not common_offset(image[:12], elements, 16.0, 16.0).any()


def test_large_pictures_are_cut_along_outlines(monkeypatch):
    """From a picture of a ninth of the pixels: as good as from all, and better than the small mask enlarged."""
    made = textons(width=288, height=256, size=60.0, form="leaf", rng=3)
    options = {"width": 60.0, "height": 60.0}
    whole = separate_foreground(made.image, made.elements, **options)
    monkeypatch.setattr(_outlines, "LARGE", made.mask.size // 9)
    monkeypatch.setattr(_outlines, "TILE", 100)
    told: list[float] = []
    ctx = Context(on_progress=lambda share, _: told.append(share))
    found = separate_foreground(made.image, made.elements, **options, ctx=ctx)
    assert overlap(found.mask, made.mask) > overlap(whole.mask, made.mask) - 0.01
    assert len(told) >= 9
    inside = found.mask & whole.mask
    assert (found.labels[inside] == whole.labels[inside]).mean() > 0.97
    enlarged = whole.mask[::3, ::3].repeat(3, axis=0).repeat(3, axis=1)[:256, :288]
    assert overlap(found.mask, made.mask) > overlap(enlarged, made.mask) + 0.03
    ground = ~made.mask & (np.random.default_rng(1).random(made.mask.shape) < 0.02)
    marked = separate_foreground(made.image, made.elements, background=ground, **options)
    assert not marked.mask[ground].any()


def test_one_element_and_scribbles():
    """The mask of one element and a stroke on the ground tell all the others."""
    made = small(form="leaf", rng=2)
    index, _ = central(made)
    ground = {"points": [[0, 0], [143, 127]], "radius": 60, "label": "background"}
    scribble = np.zeros(made.mask.shape, bool)
    row, column = np.nonzero(~made.mask)
    scribble[row[::40], column[::40]] = True
    found = separate_foreground(made.image, foreground=made.labels == index + 1, background=scribble)
    assert overlap(found.mask, made.mask) >= 0.9
    assert not found.mask[scribble].any()
    with pytest.raises(ValueError, match="background: expected no pixel that foreground has too"):
        separate_foreground(made.image, foreground=made.mask, strokes={"lines": [ground]})


def test_strokes_are_labels():
    image = np.zeros((20, 30, 1), np.float32)
    image[:, 15:] = 1
    lines = [
        {"points": [[3, 10]], "radius": 2, "label": "foreground"},
        {"points": [[25, 10]], "radius": 2, "label": "background"},
    ]
    found = separate_foreground(image, strokes={"lines": lines}, even_light=False)
    np.testing.assert_array_equal(found.mask, image[..., 0] < 0.5)
    np.testing.assert_array_equal(found.labels, found.mask.astype(np.int32))


def test_literal_fails_on_one_wrong_sample():
    """The nearest known colour breaks with one wrong scribble, the mixture does not."""
    made = small(rng=3)
    wrong = made.mask & (np.random.default_rng(1).random(made.mask.shape) < 0.01)
    ground = (~made.mask & (np.random.default_rng(2).random(made.mask.shape) < 0.05)) | wrong
    one = (made.labels == central(made)[0] + 1) & ~ground
    masks = [separate_foreground(made.image, foreground=one, background=ground, colours=kind, sigma=sigma).mask | wrong
             for kind, sigma in (("mixture", None), ("literal", 1.0))]  # fmt: skip
    assert overlap(masks[0], made.mask) > 0.85 > overlap(masks[1], made.mask)


def test_touching_elements_are_split():
    made = small(arrangement="hexagonal", spacing=0.97, jitter=0.03, rng=4)
    found = separate_foreground(
        made.image, made.elements, foreground=made.mask, background=~made.mask, width=24.0, height=24.0
    )
    both = found.mask & (made.labels > 0) & (made.labels <= len(made.centres))
    assert (found.labels[both] == made.labels[both]).mean() > 0.93


def test_bricks_without_joints_are_split_where_they_meet():
    """The nearest centre takes the ends of long bricks for their neighbours'."""
    made = textons(form="tile", size=44.0, arrangement="brick", spacing=1.0, proportion=0.45, rng=1)
    known = (made.labels > 0) & (made.labels <= len(made.centres))
    rows, columns = np.nonzero(known)
    nearest = np.hypot(*(np.stack([columns, rows]) - made.centres[:, :, None]).transpose(1, 0, 2)).argmin(axis=0)
    truth = made.labels[known] - 1
    assert (texton_labels(made.mask, made.centres)[known] == truth).mean() > 0.9
    assert (nearest == truth).mean() < 0.8


def test_a_picture_without_background_is_split_halfway():
    labels = texton_labels(np.ones((3, 6), bool), np.array([[1.0, 1.0], [4.0, 1.0]]))
    np.testing.assert_array_equal(labels, [[0, 0, 0, 1, 1, 1]] * 3)


def test_least_cut_against_all_labellings():
    rng = np.random.default_rng(5)
    costs = rng.normal(0, 1, (3, 4))
    right, down = rng.random((2, 3, 4))
    right[:, -1] = down[-1] = 0

    def energy(labels):
        pairs = (right[:, :-1] * (labels[:, 1:] != labels[:, :-1])).sum() + (
            down[:-1] * (labels[1:] != labels[:-1])
        ).sum()
        return (costs * labels).sum() + pairs

    every = (np.arange(4096)[:, None] >> np.arange(12)) & 1
    best = min(energy(labels.reshape(3, 4)) for labels in every)
    assert energy(least_cut(costs, right, down)) == pytest.approx(best)


def test_smoothness_by_hand():
    """Two neighbours differ by 0.2 once and not at all once: the mean square is 0.02."""
    right, down = smoothness_costs(np.array([[[0.0], [0.2], [0.2]]]), None)
    np.testing.assert_allclose(right[0], [np.exp(-0.04 / 0.04), 1, 0])
    assert not down.any()


def test_mixture_finds_its_own_colours_likely():
    rng = np.random.default_rng(6)
    samples = np.concatenate([rng.normal(mean, 0.02, (100, 3)) for mean in (0.2, 0.5, 0.8)])
    costs = mixture_cost(np.array([[0.2] * 3, [0.5] * 3, [0.35] * 3]), samples, 3)
    assert costs[2] > max(costs[:2]) + 5


def test_shading_moves_a_colour_along_brightness():
    colour = np.array([[0.8, 0.4, 0.2]])
    bright, shaded = told_by_hue(colour), told_by_hue(colour * 0.6)
    np.testing.assert_allclose(bright[:, 1:], shaded[:, 1:], atol=0.06)
    assert bright[0, 0] - shaded[0, 0] > 0.25


def test_light_is_evened():
    """A ramp and its inverse square cancel: what is left is the flat picture."""
    ramp = np.linspace(0.4, 1, 50, dtype=np.float32)[None, :, None].repeat(30, axis=0)
    assert np.ptp(evenly_lit(ramp * 0.5)) < 0.02
    assert evenly_lit(np.ones((1, 1, 3), np.float32)).shape == (1, 1, 3)


def test_refuses():
    made = small(rng=1)
    with pytest.raises(ValueError, match="foreground: expected some pixels of it, by elements, a mask or strokes"):
        separate_foreground(made.image)
    with pytest.raises(ValueError, match="background: expected some pixels of it"):
        separate_foreground(made.image, foreground=made.mask)
    with pytest.raises(ValueError, match="width: expected the elements' size above 0, got 0 x 0"):
        separate_foreground(made.image, made.elements)
    with pytest.raises(ValueError, match=r"background.*must agree"):
        separate_foreground(made.image, foreground=made.mask, background=made.mask[:9])
    with pytest.raises(ValueError, match="image: expected colours that tell elements"):
        separate_foreground(np.full((128, 144, 3), 0.5, np.float32), made.elements, width=24.0, height=24.0)


def test_specks_are_no_foreground():
    """Nine dots of nine pixels are less than a fiftieth of elements of 24 x 24: nothing is left when they are gone."""
    image = (0.5 + 0.01 * np.random.default_rng(0).standard_normal((96, 96, 3))).astype(np.float32)
    x, y = (places.ravel() for places in np.meshgrid([16, 48, 80], [16, 48, 80]))
    for row, column in zip(y, x, strict=True):
        image[row : row + 3, column : column + 3] = (0.9, 0.1, 0.1)
    elements = Elements(np.stack([x + 1.0, y + 1.0], axis=1), np.zeros(9), np.ones(9))
    assert np.count_nonzero(separate_foreground(image, elements, width=6.0, height=6.0).mask) == 81
    with pytest.raises(ValueError, match=r"image: expected colours that tell elements .* got no foreground"):
        separate_foreground(image, elements, background=image[..., 0] < 0.7, width=24.0, height=24.0)
