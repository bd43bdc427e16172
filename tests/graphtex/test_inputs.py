"""Values of graph inputs: types, ranges, choices, typed text, folders and patterns."""

from pathlib import Path

import numpy as np
import pytest

from graphtex.document import Input
from graphtex.inputs import check_scalar, check_seed, default_faults, expand_paths, read_text, split_type
from tests.graphtex import pack  # noqa: F401 (registers what opens .tex files)


@pytest.mark.parametrize(
    ("kind", "given", "value"),
    [
        (Input("int"), np.int32(3), 3),
        (Input("float"), 3, 3.0),
        (Input("list[float]"), (1, 2.5), [1.0, 2.5]),
        (Input("bool"), True, True),
        (Input("file"), Path("a/b"), "a/b"),
        (Input("data"), {"a": (1, 2)}, {"a": [1, 2]}),
        (Input("float", choices=(1, 2)), 2, 2.0),
        (Input("int", min=1, max=3), 3, 3),
    ],
)
def test_values_become_plain_data_of_the_type(kind, given, value):
    made = check_scalar(kind, given)
    assert made == value
    assert type(made) is type(value)


@pytest.mark.parametrize(
    ("kind", "given", "told"),
    [
        (Input("int"), 3.0, "expected int, got 3.0"),
        (Input("int"), True, "expected int, got True"),
        (Input("float"), "3", "expected float, got '3'"),
        (Input("float"), float("nan"), "expected a finite number, got nan"),
        (Input("float"), 10**400, "expected float, got 1000"),
        (Input("str"), 3, "expected str, got 3"),
        (Input("bool"), 1, "expected true or false, got 1"),
        (Input("file"), "", "expected a file, got an empty text"),
        (Input("list[int]"), 3, "expected a list of int, got 3"),
        (Input("list[int]"), [1, "x"], "item 1: expected int, got 'x'"),
        (Input("int", min=1), 0, "should be at least 1, got 0"),
        (Input("list[float]", max=1.5), [1, 2], "item 1: should be at most 1.5, got 2"),
        (Input("str", choices=("ridges", "edges")), "ridge", "'ridge' is no choice; did you mean 'ridges'?"),
        (Input("data", choices=(1, 2)), True, "True is no choice"),
    ],
)
def test_what_does_not_fit_is_told(kind, given, told):
    with pytest.raises(ValueError) as caught:
        check_scalar(kind, given)
    assert str(caught.value).startswith(told)


@pytest.mark.parametrize(
    ("kind", "text", "value"),
    [
        (Input("int"), "3", 3),
        (Input("float"), "1e3", 1000.0),
        (Input("str"), "12:30", "12:30"),
        (Input("str"), "3", "3"),
        (Input("bool"), "true", True),
        (Input("list[int]"), "1,2, 3", [1, 2, 3]),
        (Input("list[int]"), "[1, 2]", [1, 2]),
        (Input("list[int]"), "4", [4]),
        (Input("list[str]"), "a", ["a"]),
        (Input("list[str]"), "[a, b]", ["a", "b"]),
        (Input("Image"), "a,b.png", "a,b.png"),
        (Input("list[Image]"), "a.png,b.png", ["a.png", "b.png"]),
        (Input("list[Image]"), "folder", "folder"),
        (Input("list[file]"), "*.txt", "*.txt"),
        (Input("data"), "{a: [1, x]}", {"a": [1, "x"]}),
    ],
)
def test_typed_text_is_read_as_the_type(kind, text, value):
    assert read_text(kind, text) == value


def test_types_are_split_and_unknown_ones_told():
    assert split_type("list[Image]") == ("Image", True)
    with pytest.raises(ValueError, match="unknown type 'Imag'; did you mean 'Image'"):
        split_type("Imag")


@pytest.fixture
def folder(tmp_path):
    here = tmp_path / "odd [1]"
    for name in ("b.tex", "a.tex", "10.TEX", ".hidden.tex", "note.txt", "deep/c.tex"):
        (here / name).parent.mkdir(parents=True, exist_ok=True)
        (here / name).write_text("1")
    (here / "f.tex").mkdir()
    return here


@pytest.mark.parametrize(
    ("kind", "value", "names"),
    [
        ("list[Image]", ".", ["10.TEX", "a.tex", "b.tex"]),
        ("list[Image]", "*.tex", ["a.tex", "b.tex"]),
        ("list[Image]", "**/*.tex", ["a.tex", "b.tex", "deep/c.tex"]),
        ("list[Image]", "deep", ["deep/c.tex"]),
        ("list[file]", "deep/../*.txt", ["deep/../note.txt"]),
        ("list[file]", ".", ["10.TEX", "a.tex", "b.tex", "note.txt"]),
    ],
)
def test_folders_and_patterns_give_their_files_sorted(folder, kind, value, names):
    assert expand_paths(value, Input(kind), folder) == [str(folder / name) for name in names]
    assert expand_paths(Path(value), Input(kind), folder) == [str(folder / name) for name in names]


def test_a_single_name_is_one_item_even_if_it_looks_like_a_pattern(folder):
    (folder / "odd[2].tex").write_text("1")
    kind = Input("list[Image]")
    assert expand_paths("odd[2].tex", kind, folder) == ["odd[2].tex"]
    assert expand_paths("made:stone", kind, folder) == ["made:stone"]
    assert expand_paths(["a", 3], kind, folder) == ["a", 3]


@pytest.mark.parametrize(
    ("value", "told"),
    [("*.png", "no file matches '*.png'"), ("empty", "'empty' holds no file that opens as Image"),
     (3, "expected a list, a folder or a pattern such as *.png, got int"),
     (np.zeros((2, 2, 2, 1)), "expected a list, a folder or a pattern such as *.png, got ndarray")],
)  # fmt: skip
def test_what_gives_no_list_is_told(folder, value, told):
    (folder / "empty").mkdir()
    (folder / "empty" / "note.txt").write_text("")
    with pytest.raises(ValueError) as caught:
        expand_paths(value, Input("list[Image]"), folder)
    assert str(caught.value) == told


@pytest.mark.parametrize(
    ("kind", "places"),
    [
        (Input("list[Image]", "*.png"), []),
        (Input("list[file]", "folder"), []),
        (Input("list[Image]", ["made:a", "a.nix", 3]), [(1,), (2,)]),
        (Input("list[int]", [1, "a"], min=2), [(0,), (1,)]),
        (Input("list[int]", "1,2"), [()]),
        (Input("Image", 3), [()]),
        (Input("float", 2, max=1), [()]),
    ],
)
def test_defaults_are_checked_item_by_item(kind, places):
    assert [place for place, _ in default_faults(kind)] == places


@pytest.mark.parametrize("value", [-1, True, 1.0, "1", None])
def test_seeds_are_whole_numbers_from_0(value):
    assert check_seed(2**80) == 2**80
    with pytest.raises(ValueError, match="a seed is a whole number from 0"):
        check_seed(value)
