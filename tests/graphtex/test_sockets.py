"""Values of socket types: what is cast, what is refused and in which words, what comes out read-only."""

from typing import NamedTuple

import numpy as np
import pytest

from graphtex import DeclarationError, Elements, Gap, Image, LabelMap, Mask, Number, Points, ScaleMap, struct_type
from graphtex.kinds import TYPES, ArrayType, NumberType, find_type
from graphtex.sockets import ValueType, check_axes, parse_type


def check(hint, value):
    return find_type(hint).check(value, "x")


@pytest.mark.parametrize(
    ("hint", "given", "dtype"),
    [
        (Image, np.zeros((2, 3, 1), np.float64), np.float32),
        (Image, np.zeros((2, 3, 1), np.float16), np.float32),
        (Image, np.zeros((2, 3, 1), ">f4"), np.float32),
        (LabelMap, np.array([[0, 255]], np.uint8), np.int32),
        (LabelMap, np.array([[-1, 7]], np.int64), np.int32),
        (Points, np.array([[1, 2]]), np.float64),
        (Points, np.zeros((0, 2), np.float32), np.float64),
    ],
)
def test_what_loses_nothing_is_cast(hint, given, dtype):
    made = check(hint, given)
    assert made.dtype == dtype
    assert made.dtype.isnative
    np.testing.assert_array_equal(made, given)


@pytest.mark.parametrize(
    ("hint", "given", "told"),
    [
        (Image, np.zeros((2, 3, 1), np.uint8), "x: Image is float32, got uint8; convert it: x / 255 as float32"),
        (Image, np.zeros((2, 3, 1), np.uint16), "x: Image is float32, got uint16; convert it: x / 65535 as float32"),
        (Image, np.zeros((2, 3, 1), bool), "x: Image is float32, got bool; convert it: x.astype('float32')"),
        (Image, np.zeros((2, 3, 1), complex), "x: Image is float32, got complex128"),
        (Image, np.zeros((2, 3), np.float32), "x: expected Image: float32 (h, w, c), got shape (2, 3); a grey picture is (h, w, 1): image[..., None]"),
        (Image, np.zeros((2, 3, 17), np.float32), "x: axis c of Image has size 1 to 16, got shape (2, 3, 17)"),
        (Image, np.zeros((0, 3, 1), np.float32), "x: axis h of Image has size 1 to 1048576, got shape (0, 3, 1)"),
        (Image, np.full((2, 2, 1), np.nan), "x: Image holds finite numbers, got 4 NaN or infinite of 4"),
        (Image, np.array([[[np.inf], [-np.inf], [1]]]), "x: Image holds finite numbers, got 2 NaN or infinite of 3"),
        (Image, np.array([[[0], [1e300]]]), "x: Image holds finite numbers, got 1 NaN or infinite of 2"),
        (Image, [[0.0]], "x: expected Image: float32 (h, w, c), got list"),
        (Image, np.ma.zeros((2, 2, 1), np.float32), "x: expected Image: float32 (h, w, c), got MaskedArray; fill it first"),
        (Mask, np.zeros((2, 2), np.uint8), "x: Mask is bool, got uint8; convert it by a comparison: x > 0"),
        (Mask, np.zeros((2, 2, 1), bool), "x: expected Mask: bool (h, w), got shape (2, 2, 1)"),
        (ScaleMap, np.array([[1, 9.0]]), "x: ScaleMap lies in [0.125, 8], got 1 to 9"),
        (ScaleMap, np.array([[0, 1.0]]), "x: ScaleMap lies in [0.125, 8], got 0 to 1"),
        (ScaleMap, np.full((2, 2), 128, np.uint8), "x: ScaleMap is float32, got uint8; convert it: x.astype('float32')"),
        (LabelMap, np.array([[2**40]]), f"x: LabelMap is int32, got {2**40} to {2**40}"),
        (LabelMap, np.zeros((1, 1), np.float32), "x: LabelMap is int32, got float32"),
        (Points, np.zeros((3, 3)), "x: axis xy of Points has size 2, got shape (3, 3)"),
    ],
)  # fmt: skip
def test_messages_name_the_socket_what_was_expected_and_what_was_got(hint, given, told):
    with pytest.raises(ValueError) as caught:
        check(hint, given)
    assert str(caught.value) == told


def test_finite_numbers_may_have_a_sum_that_is_not():
    given = np.full((2, 2, 1), 3e38, np.float32)
    np.testing.assert_array_equal(check(Image, given), given)


def test_checked_arrays_are_read_only_and_contiguous_and_the_given_one_stays_as_it_was():
    given = np.zeros((4, 6, 3), np.float32)
    made = check(Image, given[::2, ::2])
    assert made.flags.c_contiguous
    assert not made.flags.writeable
    same = check(Image, given)
    assert np.shares_memory(same, given)
    assert not same.flags.writeable
    assert given.flags.writeable


@pytest.mark.parametrize(
    ("given", "made"), [(3, 3), (2.5, 2.5), (np.float32(0.5), 0.5), (np.array(7), 7), (10**400, 10**400)]
)
def test_numbers_become_python_s(given, made):
    assert check(Number, given) == made
    assert type(check(Number, given)) in (int, float)


@pytest.mark.parametrize("given", [True, "3", None, np.zeros(1), float("nan"), float("inf"), 1j])
def test_what_is_no_finite_number_is_refused(given):
    with pytest.raises(ValueError, match=r"^x: expected a "):
        check(Number, given)


def test_named_tuples_check_each_field():
    points, along = np.array([[1, 2]]), np.array([3.0])
    made = check(Elements, (points, along, along))
    assert isinstance(made, Elements)
    assert made.points.dtype == np.float64
    with pytest.raises(ValueError, match=r"^x\.scales: Vector holds finite numbers"):
        check(Elements, (points, along, along * np.nan))
    with pytest.raises(ValueError, match=r"^x: expected Elements: \(points: Points, angles: Vector, scales: Vector\)"):
        check(Elements, (points, along))


def test_scalar_fields_are_strict_but_for_whole_floats(monkeypatch):
    monkeypatch.setattr("graphtex.kinds.TYPES", dict(TYPES))

    @struct_type("for this test")
    class Sized(NamedTuple):
        picture: Image
        size: float
        name: str

    picture = np.zeros((1, 1, 1), np.float32)
    made = check(Sized, (picture, 3, "a"))
    assert type(made.size) is float
    for wrong, told in (((picture, True, "a"), "x.size: expected float, got bool"), ((picture, 1.0, 5), "x.name")):
        with pytest.raises(ValueError, match=told):
            check(Sized, wrong)


def test_a_name_means_one_specification_and_a_reloaded_module_may_say_it_again(monkeypatch):
    monkeypatch.setattr("graphtex.kinds.TYPES", dict(TYPES))
    first = ArrayType("Soft", "soft", "float32", ("h", "w"))
    assert ArrayType("Soft", "said in other words", "float32", ("h", "w")) == first
    with pytest.raises(DeclarationError, match="'Soft' is declared twice"):
        ArrayType("Soft", "soft", "float64", ("h", "w"))
    with pytest.raises(DeclarationError, match="'Soft' is declared twice"):
        NumberType("Soft", "soft")
    classes = []
    for _ in range(2):

        class Cloud(NamedTuple):
            points: Points

        classes.append(struct_type("of points")(Cloud))
    assert find_type(classes[0]) == find_type(classes[1])
    assert isinstance(find_type(classes[1]).check((np.zeros((1, 2)),), "x"), classes[1])


def test_a_struct_of_something_else_is_refused():
    class Wrong(NamedTuple):
        data: bytes

    with pytest.raises(DeclarationError, match=r"Wrong\.data: a field is a socket type, int, float, bool or str"):
        struct_type("wrong")(Wrong)


def test_lists_check_each_item_and_take_gaps_only_where_they_are_asked_for():
    gap, item = Gap("cell[0]", "it failed"), np.zeros((1, 1, 1))
    kind = TYPES["Image"]
    assert ValueType(kind, many=True, gaps=True).check([item, gap], "x")[1] is gap
    with pytest.raises(ValueError, match=r"^x\[1\]: expected Image: .*, got Gap"):
        ValueType(kind, many=True).check([item, gap], "x")
    with pytest.raises(ValueError, match=r"^x: expected list\[Image\], got ndarray"):
        ValueType(kind, many=True).check(item, "x")


def test_types_are_written_by_name():
    assert str(parse_type("Image")) == "Image"
    assert parse_type("list[Mask]") == ValueType(TYPES["Mask"], many=True)
    with pytest.raises(ValueError, match="unknown type 'Imag'; did you mean 'Image'"):
        parse_type("Imag")
    with pytest.raises(ValueError, match="unknown type"):
        parse_type("list[list[Image]]")


def test_axes_of_one_name_agree_also_within_lists():
    wide, tall, gap = np.zeros((2, 5)), np.zeros((5, 2)), Gap("a", "b")
    check_axes([("a", ("h", "w"), wide), ("b", ("w", "h"), tall), ("c", ("h", "w"), [wide, gap])])
    with pytest.raises(ValueError, match=r"^b: axis h has size 5 \(shape \(5, 2\)\), but a has 2; they must agree$"):
        check_axes([("a", ("h", "w"), wide), ("b", ("h", "w"), tall)])
    with pytest.raises(ValueError, match=r"^c\[1\]: axis h has size 5 .* but c\[0\] has 2"):
        check_axes([("c", ("h", "w"), [wide, tall])])
