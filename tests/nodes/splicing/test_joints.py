import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from graphtex import Context, Elements
from graphtex_nodes import find_textons, separate_foreground
from graphtex_nodes.splicing._joints import REACH, along_joints, divisions, joint_depths, joints_around
from graphtex_nodes.splicing._partitions import even_and_small, packed, partitions


def pavement(seed=0, step=(30, 20)):
    """Stones of many tones with cracks in them; joints are dark, 3 px wide, and one has a gap."""
    rng = np.random.default_rng(seed)
    labels, tones = np.zeros((121, 151), np.int64), [0.35]
    for row, top in enumerate(range(0, 121, step[1])):
        for left in range(-step[0] // 2 * (row % 2), 151, step[0]):
            labels[top + 3 : top + step[1], max(left + 3, 0) : max(left + step[0], 0)] = len(tones)
            tones.append(rng.uniform(0.55, 0.9))
    light = np.array(tones)[labels]
    light[60 + 3 : 60 + 20, 60:63] = tones[labels[70, 50]]  # a gap: two stones are one
    for x, y in zip(rng.integers(10, 140, 30), rng.integers(8, 112, 30), strict=True):
        light[y, x : x + 7] *= 0.8
    image = (light + rng.normal(0, 0.01, light.shape)).clip(0, 1).astype(np.float32)
    return image[..., None], labels


def test_divided_where_stones_meet():
    """Cracks part nothing; all whole stones but the two with the gap are parts of their own."""
    image, truth = pavement()
    inner = np.unique(truth[20:-20, 32:-32])[1:]

    def own(labels):
        return [int(np.bincount(labels[truth == stone]).argmax()) for stone in inner]

    found = [own(labels) for labels, clearness in packed(even_and_small(image).picture) if clearness > 0.5]
    assert max(len(set(parts) - {0}) for parts in found) >= len(inner) - 1


def test_noise_has_no_joints():
    """Its borders are all alike, whichever are kept."""
    noise = gaussian_filter(np.random.default_rng(1).normal(0, 1, (120, 120)), 2)
    stones = even_and_small(pavement()[0]).picture[..., 0]
    noisy, clear = (max(c for _, c in divisions(joint_depths(light, REACH))) for light in (noise, stones))
    assert noisy < 0.55
    assert clear > noisy
    assert not list(divisions(np.zeros((20, 20))))


def test_stones_of_all_tones_are_found_and_cut_out():
    """By colours alone most of them would be of the joints' kind or of another."""
    image, truth = pavement(2)
    found = find_textons(image)
    assert found.confidence > 0.6
    hit = truth[np.rint(found.points[:, 1]).astype(int), np.rint(found.points[:, 0]).astype(int)]
    assert len(set(hit[hit > 0])) > 0.85 * len(np.unique(truth[10:-10, 15:-15]))
    cut = separate_foreground(image, found.elements, width=found.width, height=found.height)
    inner = np.s_[4:-4, 4:-4]
    mask, wanted = cut.mask[inner], truth[inner] > 0
    assert (mask & wanted).sum() / (mask | wanted).sum() > 0.9


def test_large_pictures_are_cut_along_joints():
    """From every third pixel: nearer to the truth than what was cut there, enlarged."""
    image, truth = pavement(3)
    large, wanted = np.kron(image[..., 0], np.ones((3, 3), np.float32))[..., None], np.kron(truth, np.ones((3, 3))) > 0
    centres = 3 * np.array([np.argwhere(truth == stone).mean(axis=0)[::-1] for stone in np.unique(truth)[1:]])
    found = joints_around(large, centres, 60.0)
    assert found.sign == 1
    assert found.step > 2
    known = np.zeros(wanted.shape, np.int8)
    known[200:210, 200:210] = -1
    mask = along_joints(found, large, known, lambda part: (np.zeros(part.shape[:2]),) * 2, Context())
    assert not mask[200:210, 200:210].any()
    inner = np.s_[12:-12, 12:-12]
    enlarged = found.mask[np.ix_(*(np.minimum((np.arange(n) / found.step).round().astype(int), m - 1)
                                   for n, m in zip(wanted.shape, found.mask.shape, strict=True)))]  # fmt: skip
    assert (mask == wanted)[inner].mean() > max(0.95, (enlarged == wanted)[inner].mean())


def test_colours_are_kept_where_they_tell_more():
    """Discs on a ground: joints do not part them better."""
    y, x = np.mgrid[:96, :96]
    disc = np.hypot(x % 24 - 12, y % 24 - 12) < 8
    image = np.where(disc[..., None], [0.8, 0.5, 0.3], [0.2, 0.3, 0.5]).astype(np.float32)
    points = np.stack(np.meshgrid(np.arange(12.0, 96, 24), np.arange(12.0, 96, 24)), axis=2).reshape(-1, 2)
    cut = separate_foreground(image, Elements(points, np.zeros(16), np.ones(16)), width=16.0, height=16.0)
    assert (cut.mask == disc).mean() > 0.99
    assert len(partitions(even_and_small(image))) > 0


def test_one_stone_stands_for_all_between_joints():
    """No other has its tone, so correlation alone finds few; a box that fits no stone does not stand for any."""
    image, truth = pavement(2)
    row, column = (values.mean() for values in np.nonzero(truth == truth[50, 70]))
    example = {"x": column, "y": row, "width": 28, "height": 18}
    stones = np.unique(truth[10:-10, 15:-15])[1:]
    found = find_textons(image, examples=[example])
    hit = truth[np.rint(found.points[:, 1]).astype(int), np.rint(found.points[:, 0]).astype(int)]
    assert len(np.intersect1d(hit, stones)) > 0.85 * len(stones)
    assert np.quantile(found.elements.scales, [0.2, 0.8]) == pytest.approx(1, abs=0.15)
    told: list[str] = []
    loose = find_textons(image, examples=[{**example, "width": 12, "height": 10}], ctx=Context(on_warning=told.append))
    assert "are they whole elements?" in told[0]
    assert len(loose.points) != len(found.points)
