"""Views, writers and openers: what may be registered, what is found, and what is told where nothing fits."""

from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
from pydantic import Field

from graphtex import DeclarationError, FilePath, Gap, Image, Mask, handlers, node, opener, view, writer
from graphtex.handlers import find_opener, find_writer, picture_of, suffixes_of
from graphtex.sockets import TYPES

IMAGE, MASK = TYPES["Image"], TYPES["Mask"]


@pytest.fixture(autouse=True)
def nothing_registered(monkeypatch):
    for name, empty in (("VIEWS", {}), ("WRITERS", {}), ("DEFAULT_SUFFIX", {}), ("OPENERS", [])):
        monkeypatch.setattr(handlers, name, empty)


def show(value):
    return np.zeros((1, 1, 3), np.uint8)


def show_again(value):
    return np.ones((1, 1, 3), np.uint8)


def save(value, path: Path, *, digits: Annotated[int, Field(ge=1)] = 6) -> None:
    path.write_text("x")


def save_again(value, path: Path) -> None: ...
def save_nowhere(value) -> None: ...
def save_all(*values) -> None: ...


@node
def from_name(*, name: str) -> Image:
    """Open a name."""
    return np.zeros((1, 1, 1), np.float32)


@node
def from_file(*, path: FilePath, gain: float = 1.0) -> Image:
    """Open a file."""
    return np.zeros((1, 1, 1), np.float32)


@node
def from_two(*, name: str, other: str) -> Image:
    """Need two."""
    return np.zeros((1, 1, 1), np.float32)


@node
def from_picture(image: Image, *, name: str) -> Image:
    """Need a picture."""
    return image


def test_views_writers_and_openers_are_found():
    assert view(Image)(show) is show
    assert writer(Image, suffixes=(".png", ".PPM"), default=".png")(save) is save
    assert opener(Image, suffixes=(".png",))(from_file) is from_file
    opener(Image, scheme="sample")(from_name)
    assert picture_of(IMAGE, np.zeros((2, 2, 1))).shape == (1, 1, 3)
    assert find_writer(IMAGE, ".Ppm").function is save
    assert list(find_writer(IMAGE, ".png").options.model_fields) == ["digits"]
    assert find_opener(IMAGE, "a/b.PNG")[1] == "a/b.PNG"
    assert find_opener(IMAGE, "sample:pebbles: 2")[1] == "pebbles: 2"
    assert find_opener(IMAGE, "C:/a.png")[0].node is from_file
    assert suffixes_of(IMAGE) == {".png"}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a.jpg", "nothing opens a file ending in '.jpg' as Image; known: .png"),
        ("a", "nothing opens 'a', which has no file ending, as Image; known: .png"),
        ("sampel:x", "nothing opens 'sampel:' as Image; did you mean 'sample:'?"),
        ("", "expected a path or scheme:name to open as Image, got an empty text"),
    ],
)
def test_what_nothing_opens_is_told_with_what_would_fit(text, told):
    opener(Image, suffixes=(".png",))(from_file)
    opener(Image, scheme="sample")(from_name)
    with pytest.raises(ValueError) as caught:
        find_opener(IMAGE, text)
    assert str(caught.value).startswith(told)


def no_digits(suffix: str, *, digits: int) -> None:
    if suffix == ".ppm" and digits != 3:
        raise ValueError(f"PPM has 3 digits; got {digits}")


def test_a_writer_s_check_tells_what_options_a_suffix_goes_with():
    writer(Image, suffixes=(".png", ".ppm"), check=no_digits)(save)
    found = find_writer(IMAGE, ".PPM")
    found.require(".PNG", found.options(digits=2))
    found.require(".PPM", found.options(digits=3))
    with pytest.raises(ValueError, match="PPM has 3 digits; got 2"):
        found.require(".PPM", found.options(digits=2))


def test_what_cannot_be_written_is_told_with_what_would_fit():
    writer(Image, suffixes=(".png",))(save)
    with pytest.raises(ValueError, match=r"Image cannot be written as '.pmg'; did you mean '.png'"):
        find_writer(IMAGE, ".pmg")
    with pytest.raises(ValueError, match=r"Mask cannot be written as '.png'; there is no format at all"):
        find_writer(MASK, ".png")


@pytest.mark.parametrize(
    ("register", "told"),
    [
        (lambda: view(np.ndarray)(show), "a view is for a socket type"),
        (lambda: view(Image)(lambda value: value), "not a lambda"),
        (lambda: view(Image)(save), r"a view is written f\(value\)"),
        (lambda: writer(Image, suffixes=(".png",))(save_nowhere), r"a writer is written f\(value, path\)"),
        (lambda: writer(Image, suffixes=(".png",))(save_all), r"a writer is written f\(value, path\)"),
        (lambda: writer(Image, suffixes=("png",))(save), "a suffix begins with a dot, got 'png'"),
        (lambda: writer(Image, suffixes=(".png",), default=".jpg")(save), "the default suffix is one of .png, got '.jpg'"),
        (lambda: opener(Image, scheme="x")(save), "put @opener above @node"),
        (lambda: opener(Image, scheme="x")(from_two), "one required parameter and no required socket"),
        (lambda: opener(Image, scheme="x")(from_picture), "one required parameter and no required socket"),
        (lambda: opener(Mask, scheme="x")(from_name), "its first output is Image, an opener of Mask gives Mask"),
        (lambda: opener(Image)(from_name), "for some suffixes or for a scheme"),
    ],
)  # fmt: skip
def test_refuses(register, told):
    with pytest.raises(DeclarationError, match=told):
        register()


def test_what_is_taken_is_refused_but_not_the_same_again():
    for _ in range(2):  # a module that is reloaded
        view(Image)(show)
        writer(Image, suffixes=(".png", ".tif"), default=".png")(save)
        opener(Image, suffixes=(".png",))(from_file)
        opener(Image, scheme="sample")(from_name)
    assert len(handlers.OPENERS) == 2
    with pytest.raises(DeclarationError, match=r"a view of Image already, .*\.show"):
        view(Image)(show_again)
    with pytest.raises(DeclarationError, match=r"a writer of Image as \.tif already, .*\.save"):
        writer(Image, suffixes=(".gif", ".tif"))(save_again)
    with pytest.raises(DeclarationError, match=r"an opener of \.png as Image already, .*\.from_file"):
        opener(Image, suffixes=(".gif", ".png"))(from_name)
    with pytest.raises(DeclarationError, match=r"an opener of sample: as Image already, .*\.from_name"):
        opener(Image, scheme="sample")(from_file)
    with pytest.raises(ValueError, match=r"cannot be written as '.gif'"):
        find_writer(IMAGE, ".gif")


def test_a_value_without_a_view_is_told_in_words():
    assert picture_of(MASK, np.zeros((2, 3), bool)) == "Mask bool (2, 3)"
    assert picture_of(TYPES["Number"], 2.5) == "2.5"
    assert picture_of(IMAGE, Gap("cell[1]", "bad")) == "cell[1] failed: bad"
