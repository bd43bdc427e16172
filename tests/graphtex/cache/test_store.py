import contextlib
import pickle
import resource
import shutil

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from graphtex.cache import CacheUnavailable, DamagedEntry, EntryLost, MissingEntry, digest_value
from graphtex.cache.store import Store
from graphtex.sockets import Elements, Gap, Texture
from tests.graphtex.cache.helpers import CLASSES, Nest, Pair, same

ARRAYS = hnp.arrays(
    st.sampled_from(["bool", "u1", "<i4", ">i4", "<f2", "<f4", "<f8", ">f8", "<c16"]),
    hnp.array_shapes(min_dims=0, max_dims=4, min_side=0, max_side=3),
)
SCALARS = st.one_of(st.integers(), st.floats(), st.booleans(), st.text(st.characters()))
PAIRS = st.builds(Pair, ARRAYS, ARRAYS, st.text(), st.floats())
NESTS = st.builds(Nest, PAIRS, st.lists(PAIRS, max_size=2), st.integers())
SHARED = settings(deadline=None, max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "cache", CLASSES.get)


def only_file(store: Store):
    (path,) = store.files()
    return path


@SHARED
@given(value=st.one_of(ARRAYS, SCALARS, st.lists(st.one_of(ARRAYS, SCALARS), max_size=3)))
def test_round_trip(store, value):
    """What comes back has the same type, dtype (little-endian), shape and bytes, and the digest that was told."""
    digest = store.put("Thing", value)
    assert digest == digest_value("Thing", value)
    assert store.has(digest)
    back = store.get("Thing", digest)
    assert digest_value("Thing", back) == digest
    if isinstance(value, np.ndarray):
        assert back.dtype == value.dtype.newbyteorder("<")
        assert same(back, value.astype(back.dtype))
        assert back.flags.c_contiguous
        assert not back.flags.writeable
    elif not isinstance(value, list):
        assert same(back, value)


@SHARED
@given(nest=NESTS)
def test_composites_come_back_as_their_class(store, nest):
    back = store.get("Nest", store.put("Nest", nest))
    assert type(back) is Nest
    assert type(back.pair) is Pair
    assert all(type(pair) is Pair for pair in back.pairs)
    assert digest_value("Nest", back) == digest_value("Nest", nest)


def test_registered_types_need_no_resolver(tmp_path):
    """Elements with no element, a Texture, lists of them with a gap."""
    store = Store(tmp_path)
    elements = Elements(np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    texture = Texture(np.ones((2, 3, 3), np.float32), np.ones((2, 3), bool), np.zeros((1, 2)), "rigid")
    assert same(store.get("Elements", store.put("Elements", elements)), elements)
    back = store.get("list[Texture]", store.put("list[Texture]", [texture, Gap("cell[1]", "no seam"), texture]))
    assert same(back[0], texture)
    assert back[1] == Gap("cell[1]", "no seam")
    assert same(back[2], texture)


def test_numpy_reads_the_files(store):
    array = np.arange(6, dtype=np.float32).reshape(2, 3)
    store.put("Map", array)
    np.testing.assert_array_equal(np.load(only_file(store)), array)


@pytest.mark.parametrize("shape", [(), (1,), (7,), (2, 3), (0, 5), (1, 2, 3, 4)])
def test_numpy_reads_every_shape(store, shape):
    store.put("Map", np.full(shape, 2, np.int32))
    loaded = np.load(only_file(store))
    assert loaded.shape == shape
    assert np.all(loaded == 2)


def test_equal_values_are_stored_once(store):
    first, second = np.zeros((4, 4)), np.zeros((8, 8))[::2, ::2]
    assert store.put("Map", first) == store.put("Map", second)
    assert len(list(store.files())) == 1
    assert store.written == only_file(store).stat().st_size


def test_shared_parts_are_stored_once(store):
    zeros = np.zeros(100)
    store.put("list[Map]", [zeros, zeros, zeros])
    assert len(list(store.files())) == 2


def test_missing(store):
    with pytest.raises(MissingEntry, match="does not hold"):
        store.get("Map", "0" * 64)
    assert not store.has("0" * 64)
    assert not store.touch("0" * 64)


@pytest.mark.parametrize("digest", ["", "../../etc/passwd", "A" * 64, "0" * 63])
def test_what_is_no_digest_leads_nowhere(store, digest):
    with pytest.raises(MissingEntry):
        store.get("Map", digest)


def test_a_part_that_is_gone(store):
    digest = store.put("Pair", Pair(np.zeros(3), np.ones(3), "a", 1.0))
    next(path for path in store.files() if path.suffix == ".npy").unlink()
    assert not store.has(digest)
    with pytest.raises(MissingEntry):
        store.get("Pair", digest)
    store.put("Pair", Pair(np.zeros(3), np.ones(3), "a", 1.0))
    assert store.has(digest)


@pytest.mark.parametrize("value", [np.arange(5, dtype=np.int32), 0.25, [1.0, 2.0], Pair(1, 2, "a", 0.0)])
def test_every_flipped_bit_is_found(store, value):
    """In the header, the data and the line at the end; a damaged file is removed, and can be stored again."""
    digest = store.put("Pair", value)
    path = only_file(store)
    good = path.read_bytes()
    for position in range(len(good)):
        path.write_bytes(good[:position] + bytes([good[position] ^ 4]) + good[position + 1 :])
        with pytest.raises(DamagedEntry, match="removed"):
            store.get("Pair", digest)
        assert not path.exists()
    assert store.put("Pair", value) == digest
    assert path.read_bytes() == good


@pytest.mark.parametrize("value", [np.arange(5, dtype=np.int32), "text"])
def test_every_truncation_is_found(store, value):
    """Also one byte more, and an empty file."""
    digest = store.put("Map", value)
    path = only_file(store)
    good = path.read_bytes()
    for content in [*(good[:length] for length in range(len(good))), good + b"\n", good + b"\0"]:
        path.write_bytes(content)
        with pytest.raises(DamagedEntry):
            store.get("Map", digest)
        assert not path.exists()


@settings(SHARED, max_examples=100)
@given(content=st.binary(max_size=300), suffix=st.sampled_from([".npy", ".json"]))
def test_rubbish_is_found(store, content, suffix):
    path = store.objects / "00" / ("0" * 64 + suffix)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    with pytest.raises(EntryLost):
        store.get("Map", "0" * 64)
    assert not path.exists()


class Bomb:
    """Unpickling this would be noticed."""

    def __reduce__(self):
        return pytest.fail, ("a pickle was loaded",)


def test_pickles_are_never_loaded(store):
    digest = store.put("Map", np.zeros(3))
    path = only_file(store)
    tail = path.read_bytes().rsplit(b"\n", 2)[-2]
    for content in (pickle.dumps(Bomb()), pickle.dumps(Bomb()) + b"\n" + tail + b"\n"):
        path.write_bytes(content)
        with pytest.raises(DamagedEntry):
            store.get("Map", digest)
    with path.open("wb") as file:
        np.save(file, np.array([Bomb()], dtype=object), allow_pickle=True)
    with pytest.raises(DamagedEntry):
        store.get("Map", digest)


def test_a_huge_claim_allocates_nothing(store):
    digest = store.put("Map", np.zeros(3))
    only_file(store).write_bytes(b'\n{"dtype":"<f8","shape":[1000000000,1000000000],"type":"Map"}\n')
    with pytest.raises(DamagedEntry, match="size"):
        store.get("Map", digest)


def test_deeply_nested_rubbish(store):
    digest = store.put("Map", np.zeros(3))
    only_file(store).write_bytes(b"\n" + b"[" * 4000 + b"\n")
    with pytest.raises(DamagedEntry):
        store.get("Map", digest)


@pytest.mark.parametrize("value", [np.zeros((2, 2)), 1.5, [1.5]])
def test_wrong_type(store, value):
    digest = store.put("Map", value)
    with pytest.raises(DamagedEntry, match="not a Mask"):
        store.get("Mask", digest)


def test_another_values_file(store):
    """A whole and valid file under the wrong name."""
    a, b = store.put("Map", np.zeros(3)), store.put("Map", np.ones(3))
    path_a, path_b = (store.objects / digest[:2] / f"{digest}.npy" for digest in (a, b))
    shutil.copy(path_b, path_a)
    with pytest.raises(DamagedEntry, match="digest"):
        store.get("Map", a)
    np.testing.assert_array_equal(store.get("Map", b), np.ones(3))


def test_a_type_that_got_other_fields(tmp_path):
    class Wider(Pair):
        _fields = ("left", "right", "label", "weight", "height")

        def __new__(cls, left, right, label, weight, height):
            raise AssertionError

    digest = Store(tmp_path, CLASSES.get).put("Pair", Pair(1, 2, "a", 1.0))
    with pytest.raises(DamagedEntry, match="unlike Pair"):
        Store(tmp_path, lambda name: Wider).get("Pair", digest)


def test_a_type_that_nobody_declares(tmp_path):
    """The file may be good: it stays for those who have the pack."""
    digest = Store(tmp_path, CLASSES.get).put("Pair", Pair(1, 2, "a", 1.0))
    with pytest.raises(MissingEntry, match="no pack"):
        Store(tmp_path).get("Pair", digest)
    assert Store(tmp_path, CLASSES.get).get("Pair", digest) == (1, 2, "a", 1.0)


def test_a_cut_file_is_written_anew(store):
    digest = store.put("Map", np.arange(9))
    path = only_file(store)
    whole = path.read_bytes()
    for length in (100, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(DamagedEntry, match="it does not end as it must"):
            store.get("Map", digest)
    path.write_bytes(whole[:-1])
    store.put("Map", np.arange(9))
    np.testing.assert_array_equal(store.get("Map", digest), np.arange(9))


@contextlib.contextmanager
def files_up_to(size: int):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_disk_that_is_full(store):
    """The operating system refuses in the middle of a write: nothing is left behind, and later it works again."""
    store.put("Map", np.zeros(2))
    with files_up_to(1000), pytest.raises(CacheUnavailable, match="cannot be written"):
        store.put("Map", np.zeros(10_000))
    assert len(list(store.files())) == 1
    assert list(store.scratch.iterdir()) == []
    assert store.has(store.put("Map", np.zeros(10_000)))


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    store = Store(tmp_path / "file" / "cache")
    with pytest.raises(CacheUnavailable, match="cannot be written"):
        store.put("Map", np.zeros(2))
    assert not store.has("0" * 64)
    assert list(store.files()) == []
