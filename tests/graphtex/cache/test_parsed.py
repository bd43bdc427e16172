import json
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

import pytest

from graphtex.cache import Cache, code, module_digest
from graphtex.cache.files import write_checked
from graphtex.cache.parsed import ParsedFiles
from graphtex.cache.syntax import read_syntax

SOURCE = b'''
"""Docstring."""
import a.b, a.b as c
from . import near
from .near import *
from ..far import thing as other
x = c.d.e(a.b.f, near.g, "\\ud800 text")
def __getattr__(name):
    import lazy
    return lazy
'''


@pytest.fixture
def parsed(tmp_path):
    return ParsedFiles(tmp_path)


@pytest.fixture
def parses(monkeypatch):
    """The files that were parsed, in order."""
    told = []

    def counted(source, filename, package):
        told.append(filename)
        return read_syntax(source, filename, package)

    monkeypatch.setattr("graphtex.cache.parsed.read_syntax", counted)
    return told


def test_what_comes_back_is_what_parsing_finds(parsed, parses):
    expected = read_syntax(SOURCE, "m.py", "top.pack")
    assert None in expected.bindings["x"]
    for _ in range(2):
        assert parsed.read("top.pack.m", SOURCE, "m.py", "top.pack") == expected
    assert parses == ["m.py"]


@pytest.mark.parametrize("other", [(SOURCE + b" ", "top.pack"), (SOURCE, "top")])
def test_other_bytes_or_another_place_are_parsed_anew(parsed, parses, other):
    parsed.read("m", SOURCE, "m.py", "top.pack")
    source, package = other
    assert parsed.read("m", source, "m.py", package) == read_syntax(source, "m.py", package)
    assert len(parses) == 2
    assert len(parsed.paths()) == 1  # one file a module, however often it is edited


def test_another_version_of_graphtex_or_of_python_reads_anew(parsed, parses, monkeypatch):
    parsed.read("m", SOURCE, "m.py", "top")
    monkeypatch.setattr("graphtex.cache.parsed._reader", lambda: b"another")
    assert parsed.read("m", SOURCE, "m.py", "top") == read_syntax(SOURCE, "m.py", "top")
    assert len(parses) == 2


def test_every_flipped_bit_is_a_miss(parsed, parses):
    expected = parsed.read("m", b"import a", "m.py", "")
    (path,) = parsed.paths()
    whole = path.read_bytes()
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 4]) + whole[place + 1 :])
        assert parsed.read("m", b"import a", "m.py", "") == expected
        assert path.read_bytes() == whole
    assert len(parses) == 1 + len(whole)


@pytest.mark.parametrize("content", [b"", b"{", b"[]\n", b"\xff", b"null"])
def test_rubbish_is_a_miss(parsed, content):
    expected = parsed.read("m", b"import a", "m.py", "")
    (path,) = parsed.paths()
    path.write_bytes(content)
    assert parsed.read("m", b"import a", "m.py", "") == expected


def test_an_object_of_another_kind_is_a_miss(parsed, tmp_path):
    expected = parsed.read("m", b"import a", "m.py", "")
    (path,) = parsed.paths()
    write_checked(path, tmp_path / "tmp", {"something": "else"})
    assert parsed.read("m", b"import a", "m.py", "") == expected


def test_what_is_no_python_is_not_kept(parsed):
    for _ in range(2):
        with pytest.raises(SyntaxError, match="invalid syntax"):
            parsed.read("m", b"a b", "m.py", "")
    assert parsed.paths() == []


def test_nothing_is_made_where_there_is_no_cache(tmp_path):
    absent = tmp_path / "absent"
    assert ParsedFiles(absent).read("m", SOURCE, "m.py", "").digest == read_syntax(SOURCE, "m.py", "").digest
    assert not absent.exists()


def test_a_folder_that_cannot_be_written_is_tried_once(tmp_path, parsed):
    (tmp_path / "syntax").write_text("a file where the folder should be")
    for name in ("m", "n"):
        assert parsed.read(name, b"import a", "m.py", "") == read_syntax(b"import a", "m.py", "")
    assert list((tmp_path / "tmp").iterdir()) == []
    assert parsed.paths() == []


def test_pruning_keeps_the_newest_and_clearing_nothing(tmp_path):
    cache = Cache(tmp_path)
    for n in range(5):
        cache.parsed.read(f"m{n}", b"import a", "m.py", "")
        for path in cache.parsed.paths():
            os.utime(path, ns=(0, path.stat().st_mtime_ns - 10_000_000_000))
    newest = cache.parsed.paths()[2:]
    cache.parsed.prune(kept=3)
    assert cache.parsed.paths() == newest
    cache.prune(0)
    assert cache.parsed.paths() == newest
    cache.clear()
    assert cache.parsed.paths() == []


@pytest.fixture
def pack(tmp_path, monkeypatch):
    """A package of two modules that is never imported."""
    folder = tmp_path / "kept_pack"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "node.py").write_text("from kept_pack.helper import FACTOR\n")
    (folder / "helper.py").write_text("FACTOR = 2\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(code, "_parsed", {})
    return folder


def test_a_digest_from_kept_files_is_that_from_parsing(pack, parsed, parses, monkeypatch):
    """Also for an edit that leaves the size and the time stamp of the file as they were."""
    first = module_digest("kept_pack.node")
    assert module_digest("kept_pack.node", parsed) == first  # this process knows the files: nothing is kept
    assert parses == []

    def in_new_process():
        monkeypatch.setattr(code, "_parsed", {})
        return module_digest("kept_pack.node", parsed)

    assert [in_new_process(), in_new_process()] == [first, first]
    assert [Path(name).name for name in parses] == ["node.py", "helper.py"]
    helper = pack / "helper.py"
    status = helper.stat()
    helper.write_text("FACTOR = 3\n")
    os.utime(helper, ns=(status.st_atime_ns, status.st_mtime_ns))
    edited = in_new_process()
    assert edited.modules["kept_pack.helper"] != first.modules["kept_pack.helper"]
    assert edited.modules["kept_pack.node"] == first.modules["kept_pack.node"]
    monkeypatch.setattr(code, "_parsed", {})
    assert module_digest("kept_pack.node") == edited
    assert [Path(name).name for name in parses[2:]] == ["helper.py"]


def read_often(folder, results):
    """Read modules that other processes are reading in another version."""
    parsed = ParsedFiles(folder)
    wrong = 0
    for turn in range(150):
        source = f"import a{turn % 2}".encode()
        wrong += parsed.read(f"m{turn % 3}", source, "m.py", "") != read_syntax(source, "m.py", "")
    results.put(wrong)


def test_several_processes_write_at_once(tmp_path):
    context = multiprocessing.get_context("spawn")
    results = context.Queue()
    processes = [context.Process(target=read_often, args=(tmp_path, results)) for _ in range(2)]
    for process in processes:
        process.start()
    assert [results.get(timeout=60) for _ in processes] == [0, 0]
    for process in processes:
        process.join(timeout=60)
    for path in ParsedFiles(tmp_path).paths():
        assert json.loads(path.read_text())["body"]["made_of"]
    assert list((tmp_path / "tmp").iterdir()) == []


def test_a_second_process_parses_no_module_of_its_nodes(tmp_path):
    program = (
        "import sys, graphtex.cache.parsed as parsed\n"
        "from graphtex.run import run\n"
        "from graphtex.graph import loads\n"
        "told = []\n"
        "read = parsed.read_syntax\n"
        "parsed.read_syntax = lambda source, name, package: told.append(name) or read(source, name, package)\n"
        "graph = loads('{graphtex: 1, nodes: {a: {node: Sand, width: 8, height: 8}}, outputs: {a: a.image}}')\n"
        "run(graph, cache=sys.argv[1])\n"
        "print(len(told))\n"
    )
    counts = [
        int(
            subprocess.run(
                [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, check=True
            ).stdout
        )
        for _ in range(2)
    ]
    assert counts[0] > 0
    assert counts[1] == 0
