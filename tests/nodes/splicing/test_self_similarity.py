import numpy as np
import pytest

from graphtex import Context
from graphtex_nodes import appearance_vectors, sample, self_similarity, textons
from graphtex_nodes.numerics.correlation import Correlator


def plain_correlation(image, template, row, column):
    """One coefficient, straight from its definition, over what of the template lies in the picture."""
    half = np.array(template.shape[:2]) // 2
    pairs = [
        (image[row + i, column + j], template[i + half[0], j + half[1]])
        for i in range(-half[0], half[0] + 1)
        for j in range(-half[1], half[1] + 1)
        if 0 <= row + i < image.shape[0] and 0 <= column + j < image.shape[1]
    ]
    a, b = (np.array(side, np.float64) for side in zip(*pairs, strict=True))
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return (a * b).sum() / np.sqrt((a**2).sum() * (b**2).sum())


def test_against_the_definition():
    rng = np.random.default_rng(4)
    image, template = rng.random((19, 23, 3)), rng.random((5, 7, 3))
    scores = Correlator(image, (5, 7)).correlate(template, np.ones((5, 7), bool))
    for row, column in [(0, 11), (9, 9), (18, 21), (2, 22), (17, 3)]:
        assert scores[row, column] == pytest.approx(plain_correlation(image, template, row, column), abs=1e-9)


def test_one_at_the_element_and_high_at_its_copies():
    tile = np.random.default_rng(1).random((12, 12, 3)).astype(np.float32)
    scores = self_similarity(np.tile(tile, (4, 5, 1)), x=18.0, y=18.0, width=9.0, height=9.0)[..., 0]
    assert scores.shape == (48, 60)
    np.testing.assert_allclose(scores[6::12, 6::12], 1, atol=1e-5)
    assert np.sort(scores.ravel())[-21] < 0.9


def test_contrast_and_brightness_do_not_count():
    image = sample(name="oranges")
    plain, other = (self_similarity(x, x=40.0, y=40.0, width=21.0, height=21.0) for x in (image, image * 0.4 + 0.3))
    np.testing.assert_allclose(plain, other, atol=2e-3)


def test_literal_takes_one_channel():
    image = sample(name="leaves")
    appearance = appearance_vectors(image).appearance
    element = {"x": 60.0, "y": 60.0, "width": 30.0, "height": 20.0}
    literal = self_similarity(appearance, **element, measure="literal")
    maps = [self_similarity(appearance[..., k : k + 1], **element) for k in range(8)]
    assert any(np.array_equal(literal, one) for one in maps)


def test_a_flat_part_scores_nothing():
    image = textons(width=64, height=64, size=16.0, rng=1).image.copy()
    image[40:, 40:] = 0.5
    assert self_similarity(image, x=20.0, y=20.0, width=15.0, height=15.0)[55, 55, 0] == 0


def test_threads_change_nothing():
    one, two = (self_similarity(sample(name="tiles"), x=50.0, y=50.0, width=40.0, height=18.0,
                                ctx=Context(threads=threads)) for threads in (1, 2))  # fmt: skip
    assert one.tobytes() == two.tobytes()


def test_element_outside():
    with pytest.raises(ValueError, match=r"x: expected an element with its centre in the picture.*got x = 70"):
        self_similarity(np.zeros((64, 64, 1), np.float32), x=70.0, y=10.0, width=9.0, height=9.0)


def test_element_without_structure():
    with pytest.raises(ValueError, match=r"x: expected an element that stands out.*one colour"):
        self_similarity(np.full((64, 64, 1), 0.5, np.float32), x=30.0, y=10.0, width=9.0, height=9.0)
