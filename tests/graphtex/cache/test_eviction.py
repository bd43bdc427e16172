import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from graphtex.cache import Cache, Output, parse_size
from graphtex.cache.leases import HEARTBEAT, STALE, host_name
from tests.graphtex.cache.helpers import CLASSES, Pair, block, file_of, grow_old, keep, key, record_of


@pytest.fixture
def cache(tmp_path):
    return Cache(tmp_path / "cache", "10 MB", resolve=CLASSES.get)


def alive(cache, *numbers):
    return [n for n in numbers if cache.lookup(key(n)) is not None]


def lease(cache, *, pid, host=None, started, beat):
    path = cache.directory / "runs" / f"{pid}.json"
    path.parent.mkdir(exist_ok=True)
    path.write_text(json.dumps({"pid": pid, "host": host or host_name(), "started": started}))
    os.utime(path, (beat, beat))
    return path


def clock(cache):
    """Now, by the file system."""
    probe = cache.directory / "probe"
    probe.touch()
    return probe.stat().st_mtime


@pytest.fixture
def dead():
    """The id of a process that has ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_least_recently_used_first(cache):
    """Of five entries of some 10 kB, room for three: the oldest two go, but a look at the oldest saves it."""
    for n in range(5):
        keep(cache, n, block(n, 10))
        grow_old(cache)
    assert alive(cache, 0) == [0]
    done = cache.prune(35_000)
    assert (done.records, done.objects) == (2, 2)
    assert alive(cache, 0, 1, 2, 3, 4) == [0, 3, 4]
    assert done.bytes == cache.info().bytes <= 35_000


def test_reading_saves_too(cache):
    """A worker knows digests only; what it reads is not evicted under it, though its record may be."""
    digests = [keep(cache, n, block(n, 10))[0] for n in range(2)]
    grow_old(cache)
    with cache.session():
        cache.get("Map", digests[0])
        cache.prune(0)
        assert np.all(cache.get("Map", digests[0]) == 0)
    assert not cache.has(digests[1])


def test_access_times_do_not_count(cache):
    for n in range(2):
        keep(cache, n, block(n, 10))
    grow_old(cache, seconds=50, only=[record_of(cache, 0)])
    for path in cache.directory.glob("*/??/*"):
        status = path.stat()
        os.utime(path, ns=(0 if "1" in path.stem[-1] else 1 << 62, status.st_mtime_ns))
    cache.prune(15_000)
    assert alive(cache, 0, 1) == [1]


def test_nothing_goes_below_the_bound(cache):
    keep(cache, 1, block(1))
    assert cache.prune() == type(cache.prune())(0, 0, 0, cache.info().bytes)
    assert alive(cache, 1) == [1]


def test_a_composite_goes_whole(cache):
    digest = cache.put("Pair", Pair(block(1, 10), block(2, 10), "a", 0.5))
    cache.record(key(1), "Node", {"pair": Output("Pair", digest)}, 0.1)
    grow_old(cache)
    keep(cache, 2, block(3, 10))
    done = cache.prune(21_000)
    assert (done.records, done.objects) == (1, 3)
    assert alive(cache, 1, 2) == [2]


def test_a_shared_object_stays_with_its_last_user(cache):
    keep(cache, 1, block(1, 10), block(2, 10))
    grow_old(cache)
    keep(cache, 2, block(2, 10))
    assert cache.prune(15_000).objects == 1
    assert alive(cache, 1, 2) == [2]


def test_an_object_without_a_record_is_an_entry_of_its_own(cache):
    orphan = cache.put("Map", block(1, 10))
    grow_old(cache)
    keep(cache, 2, block(2, 10))
    cache.prune(15_000)
    assert not cache.has(orphan)
    assert alive(cache, 2) == [2]


def test_records_without_their_objects_go(cache):
    (digest,) = keep(cache, 1, block(1))
    file_of(cache, digest).unlink()
    assert cache.prune().records == 1
    assert not record_of(cache, 1).exists()


def test_damaged_records_go(cache):
    keep(cache, 1, block(1))
    record_of(cache, 1).write_text("{}")
    cache.prune()
    assert not record_of(cache, 1).exists()


def test_left_over_temporary_files_go(cache):
    keep(cache, 1, block(1))
    old, new = cache.directory / "tmp" / "old", cache.directory / "tmp" / "new"
    old.write_bytes(b"half")
    new.write_bytes(b"half")
    grow_old(cache, seconds=7200, only=[old])
    cache.prune()
    assert (old.exists(), new.exists()) == (False, True)


def test_a_session_pins_what_it_touches(cache):
    """What was stored or looked up since it began stays at any bound; the rest goes."""
    for n in range(3):
        keep(cache, n, block(n, 10))
    grow_old(cache)
    with cache.session():
        assert alive(cache, 1) == [1]
        keep(cache, 5, block(5, 10))
        other = Cache(cache.directory, resolve=CLASSES.get)  # as another process sees it
        assert other.prune(0).records == 2
        other.clear()
        assert alive(cache, 0, 1, 2, 5) == [1, 5]
    assert list((cache.directory / "runs").iterdir()) == []
    cache.prune(0)
    assert alive(cache, 1, 5) == []


def test_the_first_of_several_runs_counts(cache):
    with cache.session():
        keep(cache, 1, block(1))
        with cache.session():
            pass
        cache.prune(0)
        assert alive(cache, 1) == [1]


def test_a_run_on_another_machine_counts_while_it_gives_signs_of_life(cache):
    keep(cache, 1, block(1))
    now = clock(cache)
    path = lease(cache, pid=1, host="elsewhere", started=now - 100, beat=now - STALE + 60)
    cache.prune(0)
    assert alive(cache, 1) == [1]
    lease(cache, pid=1, host="elsewhere", started=now - 100, beat=now - STALE - 60)
    cache.prune(0)
    assert alive(cache, 1) == []
    assert not path.exists()


def test_a_dead_process_pins_nothing(cache, dead):
    keep(cache, 1, block(1))
    now = clock(cache)
    path = lease(cache, pid=dead, started=now - 100, beat=now)
    assert cache.info().live_runs == 0
    cache.prune(0)
    assert alive(cache, 1) == []
    assert not path.exists()


def test_a_living_process_pins(cache):
    keep(cache, 1, block(1))
    now = clock(cache)
    lease(cache, pid=os.getpid(), started=now - 100, beat=now)
    cache.prune(0)
    assert alive(cache, 1) == [1]


@pytest.mark.parametrize("content", ["", "{", "[]", '{"pid": "x", "host": "", "started": 0}'])
def test_a_lease_that_is_being_written(cache, content):
    """It counts for a moment; rubbish that stays does not."""
    keep(cache, 1, block(1))
    now = clock(cache)
    path = lease(cache, pid=1, started=now, beat=now)
    path.write_text(content)
    cache.prune(0)
    assert alive(cache, 1) == [1]
    os.utime(path, (now - 2 * HEARTBEAT, now - 2 * HEARTBEAT))
    cache.prune(0)
    assert alive(cache, 1) == []


def test_a_lease_is_renewed_if_it_was_taken_for_dead(cache, monkeypatch):
    monkeypatch.setattr("graphtex.cache.leases.HEARTBEAT", 0.01)
    with cache.session():
        (path,) = (cache.directory / "runs").iterdir()
        text = path.read_text()
        path.unlink()
        for _ in range(500):
            if path.exists() and path.read_text() == text:
                break
            time_passes()
        assert path.read_text() == text


def time_passes():
    import threading

    threading.Event().wait(0.01)


def test_the_bound_holds_after_a_session(tmp_path):
    """Ten entries of 100 kB within 500 kB: some of the old ones go on leaving, not those of the run."""
    cache = Cache(tmp_path, "500 kB")
    with cache.session():
        for n in range(4):
            keep(cache, n, block(n, 100))
    grow_old(cache)
    with cache.session():
        for n in range(4, 8):
            keep(cache, n, block(n, 100))
        assert alive(cache, 4, 5, 6, 7) == [4, 5, 6, 7]
    assert cache.info().bytes <= 500_000
    assert 7 in alive(cache, *range(8))
    assert 0 not in alive(cache, *range(8))


def test_the_bound_holds_during_a_long_session(tmp_path):
    """What older runs have left makes room while a run is still going on."""
    cache = Cache(tmp_path, "500 kB")
    for n in range(4):
        keep(cache, n, block(n, 100))
    grow_old(cache)
    with cache.session():
        for n in range(4, 8):
            keep(cache, n, block(n, 100))
        assert cache.info().bytes <= 500_000
        assert alive(cache, *range(8)) == [4, 5, 6, 7]


def test_an_entry_that_is_touched_while_it_is_being_removed(cache, monkeypatch):
    """Another process looks the entry up between the pruner's listing and its removal."""
    from graphtex.cache import eviction

    (digest,) = keep(cache, 1, block(1))
    grow_old(cache)
    original = eviction._entries

    def look_and_be_overtaken(*args):
        found = original(*args)
        assert alive(cache, 1) == [1]
        return found

    monkeypatch.setattr(eviction, "_entries", look_and_be_overtaken)
    assert cache.prune(0).freed == 0
    assert alive(cache, 1) == [1]
    assert cache.has(digest)


def test_an_entry_that_is_touched_at_the_last_moment(cache, monkeypatch):
    """After the pruner's last look and before its renaming: it is put back."""
    (digest,) = keep(cache, 1, block(1))
    grow_old(cache)
    original = Path.rename

    def overtaken(path, target):
        os.utime(path)
        return original(path, target)

    monkeypatch.setattr(Path, "rename", overtaken)
    assert cache.prune(0).freed == 0
    assert alive(cache, 1) == [1]
    assert np.all(cache.get("Map", digest) == 1)
    assert list((cache.directory / "tmp").iterdir()) == []


def test_only_the_last_runs_of_so_many_graphs_are_kept(cache, monkeypatch):
    monkeypatch.setattr("graphtex.cache.eviction.KEPT_RUNS", 3)
    for n in range(5):
        cache.record_run(f"graph {n}", {})
        grow_old(cache, seconds=10, only=list((cache.directory / "history").iterdir()))
    cache.prune()
    assert [n for n in range(5) if cache.last_run(f"graph {n}") is not None] == [2, 3, 4]


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("0", 0),
        (17, 17),
        ("1k", 1000),
        ("1 KiB", 1024),
        ("2.5 GB", 2_500_000_000),
        ("1Ti", 1 << 40),
        (" 3mb ", 3_000_000),
    ],
)
def test_parse_size(text, size):
    assert parse_size(text) == size


@pytest.mark.parametrize("text", ["", "GB", "-1", "1 x", "1e3", "inf", "ten", "1 G B"])
def test_parse_size_refuses(text):
    with pytest.raises(ValueError, match="cache size"):
        parse_size(text)
