import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex_nodes.image.convert import grey, image_from_mask, mask_from_image, pick_channels
from graphtex_nodes.image.exemplars.sample import sample
from graphtex_nodes.image.files.colour import encode_srgb
from graphtex_nodes.image.maps import CHANNELS, select_map, split_maps, stack_maps
from graphtex_nodes.numerics.materials import UP
from tests.nodes.image.files import noise


def normals(*shape, seed=0):
    """Unit normals that point out of the surface, encoded."""
    vector = np.random.default_rng(seed).normal(size=(*shape, 3))
    vector[..., 2] = 1 + np.abs(vector[..., 2])
    vector /= np.linalg.norm(vector, axis=2, keepdims=True)
    return ((vector + 1) / 2).astype(np.float32)


def one_of(kind, seed):
    if kind in UP:
        return normals(4, 5, seed=seed)
    return noise(4, 5, CHANNELS[kind], dtype="float32", seed=seed)


@given(kinds=st.lists(st.sampled_from(sorted(CHANNELS)), min_size=1, max_size=4))
def test_split_undoes_stack(kinds):
    maps = [one_of(kind, seed) for seed, kind in enumerate(kinds)]
    stack = stack_maps(maps, kinds=kinds)
    assert stack.shape == (4, 5, sum(CHANNELS[kind] for kind in kinds))
    for index, (back, given_map) in enumerate(zip(split_maps(stack, kinds=kinds), maps, strict=True)):
        np.testing.assert_array_equal(back, given_map)
        np.testing.assert_array_equal(select_map(stack, kinds=kinds, index=index), given_map)


def test_normals_of_8_bits_are_not_touched():
    rounded = np.rint(normals(30, 30) * 255).astype(np.float32) / 255
    np.testing.assert_array_equal(split_maps(rounded, kinds=["normal"])[0], rounded)


def test_blended_normals_become_unit_again():
    """The mean of x and y is (1, 1, 0) / 2; its unit vector is (1, 1, 0) / sqrt 2."""
    mean = np.array([[[0.5, 0.5, 0.0]]])
    (unit,) = split_maps((mean + 1) / 2, kinds=["normal"])
    np.testing.assert_allclose(unit * 2 - 1, [[[0.5**0.5, 0.5**0.5, 0]]], atol=1e-6)
    (kept,) = split_maps((mean + 1) / 2, kinds=["normal"], renormalise=False)
    np.testing.assert_allclose(kept * 2 - 1, mean, atol=1e-6)


def test_a_normal_of_no_length_points_up():
    np.testing.assert_array_equal(split_maps(np.full((1, 1, 3), 0.5), kinds=["normal"])[0], [[[0.5, 0.5, 1]]])


def test_told_when_it_is_no_normal_map():
    """Grey, a colour picture whose median length is 0.98, and unit vectors that point into the surface."""
    with pytest.warns(UserWarning, match=r"maps\[0\]: 100% of its normals are longer .* is it a normal map"):
        stack_maps([np.full((2, 2, 3), 0.5, np.float32)], kinds=["normal"])
    with pytest.warns(UserWarning, match=r"72% of its normals .* is it a normal map"):
        stack_maps([noise(40, 40, 3, dtype="float32")], kinds=["normal-down"])
    inwards = np.full((2, 2, 3), (0.5, 0.5, 0.0), np.float32)
    with pytest.warns(UserWarning, match=r"third component of its normals is -1.00 in the mean"):
        stack_maps([inwards], kinds=["normal"])


def test_rounded_normals_pass(recwarn):
    normals = np.float32(np.rint(sample(name="bricks-normal") * 255) / 255)
    stack_maps([normals], kinds=["normal"])
    assert not recwarn


def test_stack_refuses():
    colour, small = noise(4, 5, 3, dtype="float32"), noise(4, 4, 1, dtype="float32")
    with pytest.raises(ValueError, match="kinds: expected one for each of 2 maps, got 1"):
        stack_maps([colour, colour], kinds=["colour"])
    with pytest.raises(ValueError, match=r"maps\[1\]: expected the size of maps\[0\], \(4, 5\), got \(4, 4\)"):
        stack_maps([colour, small], kinds=["colour", "scalar"])
    with pytest.raises(ValueError, match=r"maps\[0\]: scalar has 1 channels, got 3; Grey makes one"):
        stack_maps([colour], kinds=["scalar"])
    with pytest.raises(ValueError, match="up to 16 channels, got 18"):
        stack_maps([colour] * 6, kinds=["colour"] * 6)
    with pytest.raises(ValueError, match="kinds"):
        stack_maps([colour], kinds=["colours"])


def test_split_refuses():
    with pytest.raises(ValueError, match=r"kinds: colour \+ scalar are 4 channels, the picture has 3"):
        split_maps(noise(4, 5, 3, dtype="float32"), kinds=["colour", "scalar"])
    with pytest.raises(ValueError, match=r"index: expected 0 to 0 \(colour\), got 1"):
        select_map(noise(4, 5, 3, dtype="float32"), kinds=["colour"], index=1)


def test_grey():
    pixel = np.array([[[1.0, 0.5, 0.0, 0.3]]], np.float32)  # alpha does not count
    np.testing.assert_allclose(grey(pixel), [[[0.2126 + 0.3576]]], rtol=1e-6)
    np.testing.assert_allclose(grey(pixel, method="mean"), [[[0.5]]])
    light = 0.2126 + 0.7152 * 0.2140411
    np.testing.assert_allclose(grey(pixel, method="luminance"), encode_srgb(np.full((1, 1, 1), light)), rtol=1e-5)
    np.testing.assert_array_equal(grey(pixel[..., :2]), [[[1]]])
    with pytest.raises(ValueError, match="luma is for up to 4 channels, got 5"):
        grey(np.zeros((1, 1, 5), np.float32))


def test_pick_channels():
    pixel = np.array([[[0.1, 0.2, 0.3]]], np.float32)
    np.testing.assert_array_equal(pick_channels(pixel, channels=[2, 0, 0]), pixel[..., [2, 0, 0]])
    with pytest.raises(ValueError, match="channels: the picture has 0 to 2, got 3"):
        pick_channels(pixel, channels=[3])


def test_mask_from_image_and_back():
    mask = noise(5, 6) > 99
    np.testing.assert_array_equal(mask_from_image(image_from_mask(mask)), mask)
    np.testing.assert_array_equal(mask_from_image(image_from_mask(mask), invert=True), ~mask)


@pytest.mark.parametrize(("channel", "expected"), [("grey", False), ("alpha", True), (0, True), (1, False), (3, True)])
def test_channel_of_a_mask(channel, expected):
    pixel = np.array([[[0.9, 0.1, 0.1, 0.6]]], np.float32)
    assert mask_from_image(pixel, channel=channel).item() is expected


def test_threshold_is_met():
    """0.1 as float32 is at least 0.1."""
    assert mask_from_image(np.full((1, 1, 1), 0.1, np.float32), threshold=0.1).all()


def test_mask_from_image_refuses():
    with pytest.raises(ValueError, match="alpha is the last of 2 or 4 channels, got 3"):
        mask_from_image(np.zeros((1, 1, 3), np.float32), channel="alpha")
    with pytest.raises(ValueError, match="channel: the picture has 0 to 2, got 3"):
        mask_from_image(np.zeros((1, 1, 3), np.float32), channel=3)
