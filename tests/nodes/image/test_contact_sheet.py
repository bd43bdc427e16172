import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphtex import Gap
from graphtex_nodes.image.contact_sheet import _font, _one_line, _shorten, _wrap, contact_sheet, flatten
from tests.nodes.image.files import noise

WHITE = (1.0, 1.0, 1.0)


def side_by_side(images, **style):
    """All pictures in one row."""
    return contact_sheet(images, columns=max(1, len(images)), **style)


def test_places_by_hand():
    """Column widths 5 and 2, row heights 4 and 1, padding 3; smaller pictures sit in the middle of their place."""
    images = [np.full((h, w, 1), i / 10, np.float32) for i, (h, w) in enumerate([(2, 3), (4, 2), (1, 5)])]
    sheet = contact_sheet(images, columns=2, padding=3)
    assert sheet.shape == (3 + 4 + 3 + 1 + 3, 3 + 5 + 3 + 2 + 3, 3)
    expected = np.ones((14, 16), np.float32)
    expected[3 + 1 : 3 + 3, 3 + 1 : 3 + 4] = 0.0
    expected[3:7, 11:13] = 0.1
    expected[10:11, 3:8] = 0.2
    np.testing.assert_array_equal(sheet, np.repeat(expected[..., None], 3, axis=2))


def test_top_left():
    images = [np.zeros((1, 1, 1), np.float32), np.zeros((3, 3, 1), np.float32)]
    sheet = side_by_side(images, padding=0, align="top-left")
    assert sheet[..., 0].tolist() == [[0, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]]


def test_pixels_are_copied():
    image = noise(7, 9, 3, dtype="float32")
    np.testing.assert_array_equal(side_by_side([image], padding=2)[2:-2, 2:-2], image)


@pytest.mark.parametrize(
    ("pixel", "expected"),
    [
        ([0.25], [0.25] * 3),
        ([0.25, 0.5], [0.625] * 3),
        ([0.25, 0.5, 0.75], [0.25, 0.5, 0.75]),
        ([0.25, 0.5, 0.75, 0.5], [0.625, 0.75, 0.875]),
        ([0.25, 0.5, 0.75, 0.1, 0.1], [0.25, 0.5, 0.75]),
        ([-1.0, 0.5, 7.0], [0, 0.5, 1]),
    ],
)
def test_any_channels_become_rgb(pixel, expected):
    """Alpha is laid over the background, here white."""
    np.testing.assert_allclose(flatten(np.array([[pixel]], np.float32), WHITE)[0, 0], expected)


@given(
    sizes=st.lists(st.tuples(st.integers(1, 12), st.integers(1, 12), st.integers(1, 6)), min_size=1, max_size=7),
    columns=st.none() | st.integers(1, 9),
)
def test_any_sizes(sizes, columns):
    """Each pixel of each picture is found on the sheet: the sum of darkness is that of all pictures."""
    images = [np.zeros(size, np.float32) for size in sizes]
    images = [np.dstack([i[..., :1], np.ones_like(i[..., :1])]) if i.shape[2] == 2 else i for i in images]
    images = [np.dstack([i[..., :3], np.ones_like(i[..., :1])]) if i.shape[2] == 4 else i for i in images]
    sheet = contact_sheet(images, columns=columns, padding=1)
    assert (1 - sheet[..., 0]).sum() == sum(h * w for h, w, _ in sizes)


def test_labels_stand_below_and_do_not_touch_the_picture():
    image = np.full((30, 80, 1), 0.5, np.float32)
    sheet = side_by_side([image], labels=["exemplar"], padding=4)
    np.testing.assert_array_equal(sheet[4:34, 4:84], np.full((30, 80, 3), 0.5, np.float32))
    below = sheet[34:]
    assert below.shape[0] == 14 + 7 + 4
    assert below.min() < 0.3
    np.testing.assert_array_equal(sheet[:4], np.ones((4, 88, 3), np.float32))


def test_text_is_light_on_dark():
    sheet = side_by_side([np.zeros((20, 60, 3), np.float32)], labels=["label"], background=(0.0, 0.0, 0.0))
    assert sheet.max() > 0.8


def test_headings_of_rows_and_columns():
    image = np.full((20, 50, 1), 0.5, np.float32)
    plain = contact_sheet([image] * 4, columns=2)
    headed = contact_sheet([image] * 4, columns=2, column_labels=["a", "b"], row_labels=["first", "second"])
    assert headed.shape[0] == plain.shape[0] + 21
    assert headed.shape[1] > plain.shape[1]
    assert headed[:21].min() < 0.3
    assert headed[21:, : headed.shape[1] - plain.shape[1]].min() < 0.3


def test_a_gap_is_labelled_and_hatched():
    """It has the size of the pictures around; its label and reason are in it."""
    image = np.zeros((60, 90, 3), np.float32)
    sheet = side_by_side([image, Gap("cell[0,1]", "no foreground was found")], padding=0)
    assert sheet.shape == (60, 180, 3)
    field = sheet[:, 90:, 0]
    other = side_by_side([image, Gap("cell[0,1]", "")], padding=0)[:, 90:, 0]
    assert len(np.unique(field)) > 10
    assert np.count_nonzero(field < 0.5) > np.count_nonzero(other < 0.5) > 20


def test_only_gaps_tiny_gaps_and_long_reasons():
    assert contact_sheet([Gap("a", "b")], padding=0).shape == (96, 96, 3)
    tiny = [np.zeros((1, 1, 1), np.float32), Gap("a long label", "a long reason " * 50)]
    assert contact_sheet(tiny, padding=0, labels=["", "x" * 99]).shape[1] == 2


def test_numbers_are_labels_as_they_are_written():
    numbers, words = (
        side_by_side([np.zeros((20, 60, 3), np.float32)] * 2, labels=given) for given in ([30, 0.5], ["30", "0.5"])
    )
    np.testing.assert_array_equal(numbers, words)


def test_labels_fit_or_end_in_an_ellipsis():
    font = _font(14)
    assert _shorten("short", 200, font) == "short"
    cut = _shorten("a label that is far too long", 80, font)
    assert cut.endswith("…")
    assert font.getlength(cut) <= 80
    assert _shorten("anything", 2, font) == ""
    assert all(font.getlength(line) <= 70 for line in _wrap("words of a reason incomprehensibilities", 70, font))


def test_characters_that_the_font_lacks():
    assert _one_line("é ü\nñ → 石") == "e u n ? ?"


def test_refuses():
    image = np.zeros((2, 2, 1), np.float32)
    with pytest.raises(ValueError, match="images: expected at least one"):
        contact_sheet([])
    with pytest.raises(ValueError, match="images: expected at least one"):
        side_by_side([])
    with pytest.raises(ValueError, match="labels: expected 2, got 1"):
        side_by_side([image, image], labels=["a"])
    with pytest.raises(ValueError, match="row_labels: expected 2, got 3"):
        contact_sheet([image] * 3, columns=2, row_labels=["a", "b", "c"])
    with pytest.raises(ValueError, match="background"):
        contact_sheet([image], background=(2.0, 0.0, 0.0))


def test_text_grows_with_large_pictures():
    """A line takes one and a half times the text's height: 14 pixels, or a fortieth of the widest picture."""
    for width, line in ((100, 21), (1000, 37)):
        sheet = contact_sheet([np.zeros((1, width, 1), np.float32)], labels=["x"], padding=0)
        assert sheet.shape == (1 + line, width, 3)
