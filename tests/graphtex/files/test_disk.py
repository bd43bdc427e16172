import os
import sys

import pytest

from graphtex.document import Entry
from graphtex.errors import GraphError
from graphtex.files import dumps, read_file, read_scalar, save
from graphtex.graph import Graph, load, loads

SMALL = "graphtex: 1\nnodes:\n  a: {node: X}\n"


def only_problem(path):
    graph, problems = read_file(path)
    assert graph is None
    assert len(problems) == 1
    assert problems[0].file == str(path)
    return problems[0]


def test_reads_what_it_saves(tmp_path):
    graph = Graph(title="größe 石", nodes={"a": Entry("X")})
    save(graph, tmp_path / "a.yaml")
    again, problems = read_file(str(tmp_path / "a.yaml"))
    assert (again, problems) == (graph, [])
    assert again is not None
    assert again.file == tmp_path / "a.yaml"
    assert again.base == tmp_path


def test_a_byte_order_mark_of_utf8_is_passed_over(tmp_path):
    (tmp_path / "a.yaml").write_bytes(b"\xef\xbb\xbf" + SMALL.encode())
    graph, problems = read_file(tmp_path / "a.yaml")
    assert graph is not None
    assert problems == []
    assert graph.key_places["graphtex",] == (1, 1)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-32"])
def test_other_encodings(tmp_path, encoding):
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    (tmp_path / "a.yaml").write_bytes((mark + SMALL).encode(encoding))
    assert f"the file is {encoding[:6].upper()}; save it as UTF-8" in only_problem(tmp_path / "a.yaml").message


def test_bytes_that_are_no_utf8(tmp_path):
    (tmp_path / "a.yaml").write_bytes("graphtex: 1\r\ntitle: é".encode() + b"\xe9\n")
    problem = only_problem(tmp_path / "a.yaml")
    assert (problem.line, problem.column) == (2, 9)
    assert "not UTF-8: byte 0xe9" in problem.message


def test_a_missing_file(tmp_path):
    assert only_problem(tmp_path / "x.yaml").message == "there is no such file"


def test_a_folder_is_no_graph(tmp_path):
    assert "a folder; a graph is one file" in only_problem(tmp_path).message


def test_below_a_file(tmp_path):
    (tmp_path / "a.yaml").write_text(SMALL)
    assert "the file cannot be read" in only_problem(tmp_path / "a.yaml" / "b.yaml").message


def test_a_path_with_a_null_character():
    assert "no path" in only_problem("a\0.yaml").message


def test_an_empty_file(tmp_path):
    (tmp_path / "a.yaml").write_text("")
    assert "got an empty file" in only_problem(tmp_path / "a.yaml").message


def test_a_huge_file_is_not_read_to_its_end(tmp_path):
    with (tmp_path / "a.yaml").open("wb") as stream:
        stream.truncate(1 << 40)
    assert "larger than 1 MiB; keep strokes" in only_problem(tmp_path / "a.yaml").message


def test_a_picture_is_no_graph(tmp_path):
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
    assert "a picture is given to one of its inputs" in only_problem(tmp_path / "a.png").message


def test_saving_replaces_at_once_and_keeps_mode_and_link(tmp_path):
    real, link = tmp_path / "real.yaml", tmp_path / "link.yaml"
    real.write_text("old")
    real.chmod(0o640)
    link.symlink_to(real)
    graph = Graph(nodes={"a": Entry("X")})
    save(graph, link)
    assert link.is_symlink()
    assert real.read_bytes() == dumps(graph).encode()
    assert real.stat().st_mode & 0o777 == 0o640
    assert sorted(p.name for p in tmp_path.iterdir()) == ["link.yaml", "real.yaml"]


def test_a_failed_save_leaves_the_old_file(tmp_path, monkeypatch):
    target = tmp_path / "a.yaml"
    target.write_text("old")

    def full(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(GraphError, match="cannot be written: No space left"):
        save(Graph(nodes={"a": Entry("X")}), target)
    assert [p.name for p in tmp_path.iterdir()] == ["a.yaml"]
    assert target.read_text() == "old"


def test_saving_into_no_folder(tmp_path):
    with pytest.raises(GraphError, match=r"none.a\.yaml: cannot be written: No such file"):
        save(Graph(nodes={"a": Entry("X")}), tmp_path / "none" / "a.yaml")


def test_new_files_follow_the_umask(tmp_path):
    old = os.umask(0o027)
    try:
        save(Graph(nodes={"a": Entry("X")}), tmp_path / "a.yaml")
    finally:
        os.umask(old)
    assert (tmp_path / "a.yaml").stat().st_mode & 0o777 == 0o640


def test_load_tells_form_and_meaning_at_once(tmp_path):
    (tmp_path / "a.yaml").write_text("graphtex: 1\nseed: x\nnodes:\n  a: {node: NoSuchNode}\n")
    with pytest.raises(GraphError) as caught:
        load(tmp_path / "a.yaml")
    assert [p.line for p in caught.value.problems] == [2, 4]


def test_loads_refuses_text_that_is_no_yaml():
    with pytest.raises(GraphError, match="not closed"):
        loads("graphtex: 1\nnodes: {")


@pytest.mark.parametrize(
    ("text", "value"),
    [("3", 3), ("1e3", 1000.0), ("no", "no"), ("true", True), ("[1, a]", [1, "a"]), ("'3'", "3"), ("", None)],
)
def test_read_scalar(text, value):
    got = read_scalar(text)
    assert (got, type(got)) == (value, type(value))


@pytest.mark.parametrize("text", ["[1", "*.png", "a: b: c", "1e999", "!x"])
def test_read_scalar_refuses(text):
    with pytest.raises(ValueError):
        read_scalar(text)


@pytest.mark.skipif(sys.platform == "win32", reason="no such device")
def test_a_device_is_not_read_to_its_end():
    assert "larger than 1 MiB" in only_problem("/dev/zero").message
