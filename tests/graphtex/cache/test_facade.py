import contextlib
import json
import os
import pickle
import tempfile
from pathlib import Path

import numpy as np
import pytest

from graphtex.cache import Cache, CacheUnavailable, CodeDigest, EntryLost, KeyParts, Output, Record, base_directory
from tests.graphtex.cache.helpers import CLASSES, Pair, block, file_of, grow_old, keep, key, record_of, same


@pytest.fixture
def cache(tmp_path):
    return Cache(tmp_path / "cache", "1 MB", resolve=CLASSES.get)


def parts(**changed):
    values = {"node": "Blur", "params": {"window": 16}, "inputs": {"image": "a" * 64}} | changed
    base = {"format": 1, "version": 1, "code": CodeDigest.of({"pack.blur": "b" * 64}), "entropy": (7, 1)}
    return KeyParts(**base, **values, environment={"numpy": "2.0"})


def test_a_record_comes_back(cache):
    pair = Pair(block(1), block(2), "a", 0.5)
    outputs = {"pair": Output("Pair", cache.put("Pair", pair)), "n": Output("Number", cache.put("Number", 3))}
    written = cache.record(key(1), "MakePair", outputs, 1.25, ("clamped 3 %",))
    found = cache.lookup(key(1))
    assert found == written == Record(key(1), "MakePair", outputs, 1.25, ("clamped 3 %",))
    values = cache.load(found)
    assert same(values["pair"], pair)
    assert values["n"] == 3


def test_nothing_is_made_before_something_is_stored(cache):
    assert cache.lookup(key(1)) is None
    assert cache.last_run("graph") is None
    assert cache.info().records == 0
    assert cache.verify().checked == 0
    assert not cache.directory.exists()


def test_a_later_record_replaces(cache):
    keep(cache, 1, block(1))
    keep(cache, 1, block(2))
    assert np.all(cache.load(cache.lookup(key(1)))["out0"] == 2)


def test_a_record_whose_output_is_gone_is_dropped(cache):
    """Also if it is a part of an output that is gone."""
    inner = cache.put("Pair", Pair(block(1), block(2), "a", 0.5))
    cache.record(key(1), "Node", {"pair": Output("Pair", inner)}, 0.1)
    next(cache.directory.glob("objects/??/*.npy")).unlink()
    assert cache.lookup(key(1)) is None
    assert not record_of(cache, 1).exists()


def test_every_flipped_bit_of_a_record_is_a_miss(cache):
    keep(cache, 1, block(1))
    path = record_of(cache, 1)
    good = path.read_bytes()
    for position in range(len(good)):
        path.write_bytes(good[:position] + bytes([good[position] ^ 1]) + good[position + 1 :])
        assert cache.lookup(key(1)) is None
        assert not path.exists()


@pytest.mark.parametrize("content", [b"", b"{}", b"[]", b"null", b"\xff", b'{"body": 1, "sha256": 2}', b"[" * 100_000])
def test_rubbish_for_a_record_is_a_miss(cache, content):
    keep(cache, 1, block(1))
    record_of(cache, 1).write_bytes(content)
    assert cache.lookup(key(1)) is None
    assert not record_of(cache, 1).exists()


def test_a_record_under_another_key_is_a_miss(cache):
    keep(cache, 1, block(1))
    path = record_of(cache, 2)
    path.parent.mkdir(exist_ok=True)
    record_of(cache, 1).rename(path)
    assert cache.lookup(key(2)) is None


@pytest.mark.parametrize("wrong", ["", "../" * 20 + "0000", "Z" * 64])
def test_what_is_no_key(cache, wrong):
    with pytest.raises(ValueError, match="key"):
        cache.lookup(wrong)


def test_verify_finds_what_is_wrong(cache):
    """One damaged object that a record names, one damaged record, one good pair of both, one stray file."""
    (damaged,) = keep(cache, 1, block(1), node="Blur")
    keep(cache, 2, block(2))
    keep(cache, 3, block(3))
    path = file_of(cache, damaged)
    path.write_bytes(path.read_bytes()[:-3])
    record_of(cache, 2).write_text("{}")
    (cache.directory / "objects" / "notes.txt").write_text("mine")
    found = cache.verify()
    assert found.checked == 6
    assert [path.name in text for text, path in zip(found.damaged, (path, record_of(cache, 2)), strict=True)] == [
        True,
        True,
    ]
    assert len(found.dangling) == 1
    assert "Blur's out0" in found.dangling[0]
    assert [cache.lookup(key(n)) is not None for n in (1, 2, 3)] == [False, False, True]
    assert cache.verify() == type(found)(3, (), ())  # block 2 has no record now, but is whole
    assert (cache.directory / "objects" / "notes.txt").exists()


def test_clear_leaves_what_is_not_the_caches(cache):
    keep(cache, 1, block(1))
    cache.record_run("graph", {"blur": parts()})
    (cache.directory / "mine.txt").write_text("mine")
    cache.clear()
    assert cache.info().bytes == 0
    assert cache.last_run("graph") is None
    assert [path for path in cache.directory.rglob("*") if path.is_file()] == [cache.directory / "mine.txt"]


def test_info(cache):
    keep(cache, 1, block(1), block(2))
    grow_old(cache, seconds=100)
    keep(cache, 2, block(3))
    with cache.session():
        info = cache.info()
    files = [*cache.directory.glob("objects/??/*"), *cache.directory.glob("index/??/*")]
    assert (info.records, info.objects, info.limit, info.live_runs) == (2, 3, 1_000_000, 1)
    assert info.bytes == sum(path.stat().st_size for path in files)
    assert 100 <= info.most_recent_use - info.least_recent_use < 130
    assert cache.info().live_runs == 0


def test_the_last_run_of_a_graph(cache):
    first, second = (
        parts(),
        parts(params={"window": 32, "limit": float("inf")}, inputs={"images": ["a" * 64, "b" * 64]}),
    )
    cache.record_run("/a/graph.yaml", {"one": first, "cell[1]/two": second})
    cache.record_run("/b/graph.yaml", {"one": second})
    assert cache.last_run("/a/graph.yaml") == {"one": first, "cell[1]/two": second}
    assert cache.last_run("/a/graph.yaml")["cell[1]/two"].key() == second.key()
    assert cache.last_run("/b/graph.yaml") == {"one": second}
    assert cache.last_run("/c/graph.yaml") is None


@pytest.mark.parametrize("content", ["", "{}", '{"body":{"graph":"g"},"sha256":"%s"}'])
def test_a_damaged_last_run_is_none(cache, content):
    cache.record_run("g", {"one": parts()})
    (path,) = (cache.directory / "history").iterdir()
    path.write_text(content)
    assert cache.last_run("g") is None


def test_shared_code_is_written_once(cache):
    """A matrix of many cells must not repeat the digests of thirty modules in each."""
    code = CodeDigest.of({f"pack.module{n}": f"{n:064x}" for n in range(30)})
    cache.record_run("h", {f"cell[{n}]": KeyParts(1, "N", 1, code, {"n": n}, {}, None, {}) for n in range(100)})
    (path,) = (cache.directory / "history").iterdir()
    assert path.read_text().count('"pack.module7"') == 1


def test_a_folder_that_cannot_be_written(tmp_path):
    """Looking up is a miss; storing, recording and starting a session say what is wrong."""
    (tmp_path / "file").write_text("")
    cache = Cache(tmp_path / "file" / "cache")
    assert cache.lookup(key(1)) is None
    assert cache.info().bytes == 0
    for attempt in (
        lambda: cache.put("Map", block(1)),
        lambda: cache.record(key(1), "Node", {}, 0.1),
        lambda: cache.record_run("g", {}),
        lambda: cache.session().__enter__(),
        lambda: cache.prune(),
    ):
        with pytest.raises(CacheUnavailable, match="cannot be written"):
            attempt()


def test_a_read_only_cache_still_serves(cache, monkeypatch):
    """Use cannot be marked there, and need not be."""
    keep(cache, 1, block(1))

    def refuse(path, *args, **kwargs):
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr("os.utime", refuse)
    assert np.all(cache.load(cache.lookup(key(1)))["out0"] == 1)


@contextlib.contextmanager
def unprivileged():
    """For root no folder is read-only."""
    if os.geteuid() != 0:
        yield
        return
    os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(0)


@pytest.fixture
def locked():
    """A cache with one entry, and a function that sets the mode of all its folders."""
    with tempfile.TemporaryDirectory() as folder:
        cache = Cache(Path(folder) / "cache")
        with cache.session():
            keep(cache, 1, block(1))

        def set_mode(mode):
            for path in sorted([cache.directory, *cache.directory.rglob("*")], reverse=mode < 0o700):
                path.chmod(mode if path.is_dir() else 0o444)

        Path(folder).chmod(0o755)
        yield cache, set_mode
        set_mode(0o755)


def refuses_to_write(cache):
    for attempt in (lambda: cache.put("Map", block(2)), lambda: cache.session().__enter__(), lambda: cache.prune(0)):
        with pytest.raises(CacheUnavailable, match="cannot be written"):
            attempt()


def test_a_folder_of_somebody_else_that_can_be_read(locked):
    """It serves what it has, even `put` of that; the rest is told."""
    cache, set_mode = locked
    set_mode(0o555)
    with unprivileged():
        found = cache.lookup(key(1))
        assert np.all(cache.load(found)["out0"] == 1)
        assert cache.put("Map", block(1)) == found.outputs["out0"].digest
        refuses_to_write(cache)
        assert cache.info().records == 1


def test_a_folder_of_somebody_else_that_cannot(locked):
    cache, set_mode = locked
    set_mode(0)
    with unprivileged():
        assert cache.lookup(key(1)) is None
        assert cache.last_run("graph") is None
        refuses_to_write(cache)
        assert cache.info().records == 0


def test_workers_get_the_same_folder(cache):
    (digest,) = keep(cache, 1, block(1))
    twin = pickle.loads(pickle.dumps(Cache(cache.directory, 12345)))
    assert (twin.directory, twin.size_limit) == (cache.directory, 12345)
    assert np.all(twin.get("Map", digest) == 1)


def test_where_and_how_large(tmp_path, monkeypatch):
    """Argument before environment before default."""
    monkeypatch.setenv("GRAPHTEX_CACHE_DIR", str(tmp_path / "base"))
    monkeypatch.setenv("GRAPHTEX_CACHE_SIZE", "3 MiB")
    assert base_directory() == tmp_path / "base"
    assert Cache().directory == tmp_path / "base" / "results"
    assert Cache().size_limit == 3 << 20
    assert Cache(tmp_path / "mine", "5 kB").directory == tmp_path / "mine"
    assert Cache(tmp_path / "mine", "5 kB").size_limit == 5000
    monkeypatch.setenv("GRAPHTEX_CACHE_SIZE", "much")
    with pytest.raises(ValueError, match=r"GRAPHTEX_CACHE_SIZE.*'much'"):
        Cache()
    monkeypatch.delenv("GRAPHTEX_CACHE_SIZE")
    assert 0 < Cache().size_limit <= 10 << 30
    monkeypatch.delenv("GRAPHTEX_CACHE_DIR")
    assert base_directory().name == "graphtex"


def test_a_session_tags_the_folder_for_backups(cache):
    with cache.session():
        pass
    assert (cache.directory / "CACHEDIR.TAG").read_bytes().startswith(b"Signature: 8a477f597d28d172789f06886806bc55")


def test_a_lost_value_is_told(cache):
    (digest,) = keep(cache, 1, block(1))
    file_of(cache, digest).write_bytes(json.dumps({"type": "Map"}).encode())
    with pytest.raises(EntryLost):
        cache.load(cache.lookup(key(1)))
    assert cache.lookup(key(1)) is None
