import hashlib
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from graphtex.cache import canonical_json, digest_value, file_digest
from graphtex.sockets import Gap
from tests.graphtex.cache.helpers import Nest, Pair, same

DTYPES = st.sampled_from(["bool", "u1", "<i2", "<i4", "<i8", "<f2", "<f4", "<f8", "<c8"])
ARRAYS = hnp.arrays(DTYPES, hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3))


def test_array_worked_by_hand():
    """The header line, a newline, the bytes in C order."""
    line = b'{"dtype":"<i2","shape":[1,2],"type":"Tiny"}\n'
    expected = hashlib.sha256(line + b"\x01\x00\x00\x02").hexdigest()
    assert digest_value("Tiny", np.array([[1, 512]], np.int16)) == expected


def test_scalar_worked_by_hand():
    assert digest_value("Number", 0.5) == hashlib.sha256(b'{"float":"0.5","type":"Number"}').hexdigest()


def test_list_worked_by_hand():
    """Like a git tree: the digest of the items' digests."""
    items = [np.zeros(2, np.float32), np.ones(2, np.float32)]
    inner = ",".join(f'{{"digest":"{digest_value("Image", item)}","type":"Image"}}' for item in items)
    text = f'{{"items":[{inner}],"type":"list[Image]"}}'
    assert digest_value("list[Image]", items) == hashlib.sha256(text.encode()).hexdigest()


@settings(deadline=None, max_examples=200)
@given(a=ARRAYS, b=ARRAYS)
def test_arrays_share_a_digest_only_if_equal(a, b):
    assert (digest_value("Map", a) == digest_value("Map", b)) == same(a, b)


@settings(deadline=None)
@given(a=ARRAYS)
def test_layout_and_byte_order_do_not_count(a):
    """Fortran order, big-endian, strided, reversed and broadcast views of equal content are equal."""
    expected = digest_value("Map", a)
    wide = np.zeros((*a.shape, 2), a.dtype)
    wide[..., 0] = a
    flipped = np.asarray(np.flip(np.ascontiguousarray(np.flip(a)).reshape(a.shape)))
    views = [np.asfortranarray(a).reshape(a.shape), a.astype(a.dtype.newbyteorder(">")), wide[..., 0], flipped, a[...]]
    assert {digest_value("Map", view) for view in views} == {expected}


def test_broadcast_view():
    view = np.broadcast_to(np.float32(3), (4, 5))
    assert digest_value("Map", view) == digest_value("Map", np.full((4, 5), 3, np.float32))


def test_array_digest_covers_type_dtype_and_shape():
    zeros = np.zeros((2, 3), np.float32)
    others = [
        ("Mask", zeros),
        ("Map", zeros.astype("i4")),
        ("Map", zeros.reshape(3, 2)),
        ("Map", zeros.reshape(6)),
        ("Map", -zeros),
    ]
    assert len({digest_value("Map", zeros), *(digest_value(name, array) for name, array in others)}) == 6


def test_empty_shapes_differ():
    shapes = [(0,), (0, 3), (3, 0), (1, 0), ()]
    assert len({digest_value("Map", np.zeros(shape)) for shape in shapes}) == len(shapes)


def test_scalars_differ():
    """1, 1.0, True, "1" and an array of 1 are five values; so are the zeros."""
    ones = [1, 1.0, True, "1", np.array(1), 0.0, -0.0, 0, False, "0", math.inf, -math.inf, math.nan, "nan"]
    assert len({digest_value("Number", one) for one in ones}) == len(ones)


def test_nan_equals_itself():
    assert digest_value("Number", math.nan) == digest_value("Number", float("nan"))


@pytest.mark.parametrize(
    "pair", [(np.float64(0.1), 0.1), (np.int64(3), 3), (np.bool_(True), True), (np.str_("a"), "a")]
)
def test_numpy_scalars_are_pythons(pair):
    assert digest_value("Number", pair[0]) == digest_value("Number", pair[1])


def test_composites_differ_by_any_part():
    zeros, ones = np.zeros(3), np.ones(3)
    base = Pair(zeros, ones, "a", 1.0)
    others = [
        Pair(ones, zeros, "a", 1.0),
        Pair(zeros, ones, "b", 1.0),
        Pair(zeros, ones, "a", 1),
        Pair(zeros, ones, "a", 2.0),
    ]
    nested = [Nest(base, [], 0), Nest(base, [base], 0), Nest(others[0], [base], 0), Nest(base, [base, base], 0)]
    values = [base, *others, *nested, [base], [base, base], []]
    assert len({digest_value("Pair", value) for value in values}) == len(values)


def test_an_array_is_not_its_list():
    a = np.zeros(2)
    assert digest_value("Map", a) != digest_value("Map", [a])


def test_gaps_in_lists():
    first, second = Gap("cell[0]", "no seam"), Gap("cell[1]", "no seam")
    digests = {digest_value("list[Image]", value) for value in ([first], [second], [first, second], [])}
    assert len(digests) == 4


@pytest.mark.parametrize(
    "value",
    [
        np.array([{}]),
        np.array(["a"]),
        np.zeros(2, "i4,f4"),
        np.zeros(2, "M8[s]"),
        np.zeros(2, np.longdouble),
        np.ma.masked_array([1, 2], [True, False]),
        (1, 2),
        {"a": 1},
        None,
        {1},
        b"bytes",
        1j,
    ],
)
def test_refuses(value):
    with pytest.raises(TypeError, match="Thing"):
        digest_value("Thing", value)


def test_canonical_json():
    assert canonical_json({"b": [1, 1.0, True, None], "a": {"é": (0.1, -0.0)}}) == (
        '{"a":{"\\u00e9":[0.1,-0.0]},"b":[1,1.0,true,null]}'
    )
    assert canonical_json([math.nan, math.inf]) == "[NaN,Infinity]"


@pytest.mark.parametrize("wrong", [{1: 2}, {"a": {None: 1}}, {1, 2}, np.zeros(2), [object()], 1j, b"a"])
def test_canonical_json_refuses(wrong):
    with pytest.raises(TypeError, match="canonical JSON"):
        canonical_json(wrong)


def test_file_digest(tmp_path):
    path = tmp_path / "strokes.json"
    path.write_bytes(b"abc")
    assert (
        file_digest(path) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    )  # FIPS 180-2, example 1
    with pytest.raises(OSError, match="absent"):
        file_digest(tmp_path / "absent")
