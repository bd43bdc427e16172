"""Outputs as files: names, options, and files that are whole or as they were."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from graphtex import NodeFailed, Number, handlers, run, writer
from graphtex.graph import loads
from graphtex.outputs import OutputError, write_outputs
from tests.graphtex import pack, tiny  # noqa: F401 (what writes .tex files)

pytestmark = pytest.mark.usefixtures("tiny_nodes")


@pytest.fixture(autouse=True)
def tex_by_default(monkeypatch):
    monkeypatch.setattr(handlers, "WRITERS", dict(handlers.WRITERS))
    for name in list(handlers.DEFAULT_SUFFIX):
        monkeypatch.delitem(handlers.DEFAULT_SUFFIX, name)
    monkeypatch.setitem(handlers.DEFAULT_SUFFIX, "Image", ".tex")
    monkeypatch.setitem(handlers.DEFAULT_SUFFIX, "Number", ".json")


def write(folder: Path, nodes: str, outputs: str, **inputs) -> dict[str, list[str]]:
    result = run(loads(f"graphtex: 1\nnodes:\n{nodes}\noutputs: {{{outputs}}}\n"), inputs, cache=False)
    return {
        name: [str(file.relative_to(folder)) for file in files] for name, files in write_outputs(result, folder).items()
    }


ONE = "  one: {node: Const, value: 0.25}\n  m: {node: Average, image: one}\n  s: {node: Scatter}"


def test_outputs_are_named_after_themselves_or_as_they_say(tmp_path):
    made = write(tmp_path / "new", ONE, "a: one, m: m, b: {from: one, file: deep/b.tex, digits: 2}")
    assert made == {"a": ["a.tex"], "m": ["m.json"], "b": ["deep/b.tex"]}
    assert (tmp_path / "new" / "a.tex").read_text().split() == ["0.250000"] * 2
    assert (tmp_path / "new" / "deep" / "b.tex").read_text().split() == ["0.25"] * 2
    assert json.loads((tmp_path / "new" / "m.json").read_text()) == 0.25
    assert sorted(p.name for p in (tmp_path / "new").iterdir()) == ["a.tex", "deep", "m.json"]


def test_a_type_that_no_file_holds_is_handed_back_only(tmp_path):
    assert write(tmp_path, ONE, "s: s") == {"s": []}
    assert list(tmp_path.iterdir()) == []


def test_lists_are_numbered_and_gaps_keep_their_numbers(tmp_path):
    cells = "  c: {node: Fragile, each: {value: [0, 1, 2]}, bad: 1, on_error: keep}"
    assert write(tmp_path, cells, "c: c") == {"c": ["c-0.tex", "c-2.tex"]}
    many = f"  c: {{node: Const, each: {{value: {list(range(11))}}}}}"
    made = write(tmp_path, many, "c: {from: c, file: a.b/many.of.tex}")["c"]
    assert made[:2] == ["a.b/many.of-00.tex", "a.b/many.of-01.tex"]
    assert made[-1] == "a.b/many.of-10.tex"


def test_writing_is_never_skipped_as_cached(tmp_path):
    g = loads(f"graphtex: 1\nnodes:\n{ONE}\noutputs: {{a: one}}\n")
    for _ in range(2):
        (file,) = write_outputs(run(g, cache=tmp_path / "cache"), str(tmp_path))["a"]
        assert file.exists()
        file.unlink()


def test_files_get_the_permissions_that_new_files_get(tmp_path):
    before = os.umask(0o027)
    try:
        write(tmp_path, ONE, "a: one")
    finally:
        os.umask(before)
    assert (tmp_path / "a.tex").stat().st_mode & 0o777 == 0o640


def half(value: float, path: Path, *, how: str = "disk") -> None:
    path.write_text("half")
    raise {
        "disk": OSError(28, "No space left on device"),
        "array": OSError("9 requested and 4 written"),
        "value": ValueError("it cannot hold this"),
    }[how]


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ("disk", "No space left on device"),
        ("array", "not written whole, is the disk full? (9 requested and 4 written)"),
        ("value", "it cannot hold this"),
    ],
)
def test_a_file_that_cannot_be_written_is_as_it_was(tmp_path, how, told):
    writer(Number, suffixes=(".half",))(half)
    (tmp_path / "m.half").write_text("old")
    with pytest.raises(OutputError) as caught:
        write(tmp_path, ONE, f"m: {{from: m, file: m.half, how: {how}}}, a: one")
    assert str(caught.value) == f"{tmp_path}/m.half: {told}"
    assert (tmp_path / "m.half").read_text() == "old"
    assert caught.value.written == {"m": [], "a": [tmp_path / "a.tex"]}
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.tex", "m.half"]


def test_a_folder_that_is_none_is_told(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/a\.tex: (Not a directory|File exists)"):
        write(tmp_path / "file", ONE, "a: one")


def test_what_a_failed_run_had_made_is_written(tmp_path):
    g = loads(f"graphtex: 1\nnodes:\n{ONE}\n  f: {{node: Fragile, image: one}}\noutputs: {{a: one, f: f}}\n")
    with pytest.raises(NodeFailed) as caught:
        run(g, cache=False)
    made = write_outputs(caught.value.result, tmp_path)
    assert {name: len(files) for name, files in made.items()} == {"a": 1, "f": 0}
    assert np.loadtxt(tmp_path / "a.tex").tolist() == [0.25, 0.25]
