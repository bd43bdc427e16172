"""Values that are stored as folders, and outputs that are named after the files of a list."""

from pathlib import Path

import numpy as np
import pytest

from graphtex import DeclarationError, FilePath, GraphError, Image, handlers, node, opener, run, writer
from graphtex.cache import file_digest
from graphtex.graph import loads
from graphtex.outputs import OutputError, write_outputs
from tests.graphtex import pack, tiny  # noqa: F401 (what opens .tex files)

OPENED: list[str] = []


@node
def open_rows(*, path: FilePath) -> Image:
    """Read the rows of a picture from the files of a folder."""
    OPENED.append(path.name)
    rows = [np.loadtxt(file, dtype=np.float32, ndmin=1) for file in sorted(path.glob("*.txt"))]
    return np.stack(rows)[..., None]


def save_rows(value, path: Path) -> None:
    path.mkdir()
    for number, row in enumerate(value[..., 0]):
        if row.max() > 9:
            raise ValueError("numbers up to 9 are written, got more")
        np.savetxt(path / f"{number}.txt", row)


@node
def other(*, path: FilePath) -> Image:
    """Open it in another way."""
    return np.zeros((1, 1, 1), np.float32)


@pytest.fixture(autouse=True)
def pictures_in_folders(monkeypatch, tiny_nodes):
    """Let ``.pix`` folders be pictures."""
    monkeypatch.setattr(handlers, "OPENERS", list(handlers.OPENERS))
    monkeypatch.setattr(handlers, "WRITERS", dict(handlers.WRITERS))
    opener(Image, suffixes=(".pix",), folder=True)(open_rows)
    writer(Image, suffixes=(".pix",), folder=True)(save_rows)
    OPENED.clear()


def folder(path: Path, *rows: str) -> Path:
    path.mkdir(parents=True)
    for number, row in enumerate(rows):
        (path / f"{number}.txt").write_text(row)
    return path


ADDED = """graphtex: 1
inputs: {{picture: {{type: Image}}, amount: {{type: float, default: 1.0}}}}
nodes: {{sum: {{node: Add, image: $picture, amount: $amount}}}}
outputs: {{sum: {{from: sum, file: {file}}}}}
"""
EACH = """graphtex: 1
inputs: {{pictures: {{type: "list[Image]"}}}}
nodes:
  sum: {{node: Add, each: {{image: $pictures}}, on_error: keep}}
  one: {{node: Const}}
outputs: {{sums: {{from: {source}, file: "{file}"}}}}
"""


def written(text: str, out: Path, **inputs) -> list[str]:
    result = run(loads(text), inputs, cache=False)
    return sorted(str(file.relative_to(out)) for files in write_outputs(result, out).values() for file in files)


def test_a_folder_is_opened_and_written_as_one_value(tmp_path):
    folder(tmp_path / "a.pix", "1 2", "3 4")
    assert written(ADDED.format(file="b.pix"), tmp_path, picture=tmp_path / "a.pix") == ["b.pix"]
    assert [np.loadtxt(tmp_path / "b.pix" / f"{n}.txt").tolist() for n in (0, 1)] == [[2, 3], [4, 5]]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pix", "b.pix"]


def test_a_run_sees_what_changed_in_a_folder(tmp_path):
    source, graph = folder(tmp_path / "a.pix", "1 2"), loads(ADDED.format(file="b.pix"))
    for _ in range(2):
        run(graph, {"picture": source}, cache=tmp_path / "cache")
    assert len(OPENED) == 1
    (source / ".hidden").write_text("left by a file manager")
    run(graph, {"picture": source}, cache=tmp_path / "cache")
    assert len(OPENED) == 1
    (source / "0.txt").write_text("5 2")
    assert run(graph, {"picture": source}, cache=tmp_path / "cache")["sum"].ravel().tolist() == [6, 3]
    (source / "0.txt").rename(source / "7.txt")
    run(graph, {"picture": source}, cache=tmp_path / "cache")
    assert len(OPENED) == 3


def test_digest_of_a_folder_covers_names_and_contents(tmp_path):
    one, two = folder(tmp_path / "one", "1", "2"), folder(tmp_path / "two", "1", "2")
    assert file_digest(one) == file_digest(two)
    folder(two / "deep", "1")
    deep = file_digest(two)
    assert deep != file_digest(one)
    (two / "deep" / "0.txt").rename(two / "0deep.txt")
    assert file_digest(two) not in (deep, file_digest(one))


def test_lists_take_folders_that_are_values_and_look_into_others(tmp_path):
    for name in ("b", "a"):
        folder(tmp_path / "many" / f"{name}.pix", "1")
    (tmp_path / "many" / "c.tex").write_text("3")
    (tmp_path / "many" / "notes.txt").write_text("no picture")
    text = EACH.format(source="sum", file="x.tex")
    for given, count in ((tmp_path / "many", 3), (tmp_path / "many" / "a.pix", 1), (tmp_path / "many" / "*.pix", 2)):
        assert len(run(loads(text), {"pictures": given}, cache=False)["sums"]) == count


def test_items_are_named_after_files_and_samples(tmp_path):
    folder(tmp_path / "in" / "leaves.pix", "1 1")
    (tmp_path / "in" / "old stones.tex").write_text("2 2")
    (tmp_path / "in" / "bad.tex").write_text("no number")
    out = tmp_path / "out"
    made = written(EACH.format(source="sum", file="made/{pictures}-1.pix"), out, pictures=tmp_path / "in")
    assert made == ["made/leaves-1.pix", "made/old stones-1.pix"]
    (tmp_path / "in" / "at 12:30.tex").write_text("2 2")
    noon = written(EACH.format(source="sum", file="{pictures}.tex"), out, pictures=tmp_path / "in" / "at*.tex")
    assert noon == ["at 12:30.tex"]
    items = ["made:sand", str(tmp_path / "in" / "leaves.pix"), np.zeros((1, 1, 1), np.float32)]
    assert written(EACH.format(source="sum", file="{pictures}.tex"), out, pictures=items) == [
        "2.tex", "leaves.tex", "sand.tex",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("source", "file", "told"),
    [
        ("sum", "{picture}.tex", "{picture} is no list input whose files the output's could be named after; did you mean 'pictures'?"),
        ("one", "{pictures}.tex", "{pictures} names the items of a list, and this output is one Image"),
        ("sum", "{pictures}/{pictures}.tex", "expected one {input} in a file's name, got 2"),
    ],
)  # fmt: skip
def test_wrong_names_are_told_before_the_run(source, file, told):
    with pytest.raises(GraphError, match=r"outputs\.sums\.file") as caught:
        loads(EACH.format(source=source, file=file))
    assert caught.value.problems[0].message == told


def test_names_that_clash_or_do_not_suffice_are_told(tmp_path):
    for name in ("a.tex", "A/a.tex"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("1")
    graph = loads(EACH.format(source="sum", file="{pictures}.tex"))
    with pytest.raises(GraphError, match=r"two files of \{pictures\} would be written as 'a'"):
        run(graph, {"pictures": [tmp_path / "a.tex", tmp_path / "A" / "a.tex"]}, cache=False)
    twice = "each: {image: $pictures, amount: [1.0, 2.0]}"
    text = EACH.format(source="sum", file="{pictures}.tex").replace("each: {image: $pictures}", twice)
    with pytest.raises(GraphError, match=r"\{pictures\} has 1 names, and the output 2 items"):
        run(loads(text), {"pictures": [tmp_path / "a.tex"]}, cache=False)


def test_what_was_there_is_kept_unless_it_is_the_same(tmp_path):
    source, text = folder(tmp_path / "a.pix", "1"), ADDED.format(file="b.pix")
    for _ in range(2):
        written(text, tmp_path, picture=source)
        assert not (tmp_path / "b.pix.old").exists()
    (tmp_path / "b.pix" / "mine.txt").write_text("7")
    for number in range(2):
        written(text, tmp_path, picture=source, amount=float(number))
    assert sorted(path.name for path in (tmp_path / "b.pix").iterdir()) == ["0.txt"]
    assert np.loadtxt(tmp_path / "b.pix.old" / "0.txt") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pix", "b.pix", "b.pix.old"]


def test_a_failed_write_leaves_the_old_folder_whole(tmp_path, monkeypatch):
    source, text = folder(tmp_path / "a.pix", "1", "2"), ADDED.format(file="b.pix")
    written(text, tmp_path, picture=source)
    with pytest.raises(OutputError, match=r"b\.pix: numbers up to 9 are written, got more"):
        written(text, tmp_path, picture=source, amount=8.0)
    rename = Path.rename

    def breaks(self, target):
        if self.name.startswith(".b-"):  # the new folder; the old one has been moved away by now
            raise OSError(5, "the disk broke")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", breaks)
    with pytest.raises(OutputError, match=r"b\.pix: the disk broke"):
        written(text, tmp_path, picture=source, amount=3.0)
    assert [float(np.loadtxt(tmp_path / "b.pix" / f"{n}.txt")) for n in (0, 1)] == [2, 3]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.pix", "b.pix"]


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("file.pix", "is a file, not a folder"),
        ("none.pix", "there is no file"),
        ("plain", "is a folder; Image is opened from one file"),
    ],
)
def test_what_is_no_such_folder_is_told(tmp_path, name, told):
    (tmp_path / "file.pix").write_text("1")
    (tmp_path / "plain").mkdir()
    with pytest.raises(GraphError, match=told):
        run(loads(ADDED.format(file="b.pix")), {"picture": tmp_path / name}, cache=False)


def test_a_file_in_the_place_of_a_folder_stays(tmp_path):
    (tmp_path / "b.pix").write_text("mine")
    with pytest.raises(OutputError, match="a file of this name"):
        written(ADDED.format(file="b.pix"), tmp_path, picture=folder(tmp_path / "a.pix", "1"))
    assert (tmp_path / "b.pix").read_text() == "mine"


def test_a_suffix_has_one_opener():
    with pytest.raises(DeclarationError, match=r"an opener of \.pix as Image already"):
        opener(Image, suffixes=(".pix",))(other)
