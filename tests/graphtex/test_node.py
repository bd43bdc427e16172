"""The decorator: what it makes of a signature, what it refuses, and direct calls on plain arrays."""

import copy
import functools
import inspect
import pickle
import pydoc
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
import pytest
from pydantic import BaseModel, ConfigDict, Field

from graphtex import QUIET, Axes, Context, DeclarationError, Elements, FilePath, Gap, Image, Mask, Number, Rng, node
from graphtex.node import Node
from tests.graphtex import tiny
from tests.graphtex.tiny import picture


class Loose(BaseModel):
    size: float = 1.0


class Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")
    size: float = Field(default=1.0, gt=0)
    shift: float = 0.0


class Nothing(NamedTuple):
    pass


class Gappy(NamedTuple):
    images: list[Image | Gap]


class Two(NamedTuple):
    """Two outputs."""

    image: Image
    size: Number


def keeps(function):
    @functools.wraps(function)
    def wrapper(*args, **kwargs):
        return function(*args, **kwargs)

    return wrapper


# Functions that are no nodes; each is tried by its name.
def starred(*images: Image) -> Image: ...
def double_starred(image: Image, **options: float) -> Image: ...
def unannotated(image) -> Image: ...
def without_result(image: Image): ...
def unknown_result(image: Image) -> np.ndarray: ...
def unknown_socket(image: np.ndarray) -> Image: ...
def forward(image: "Nowhere") -> Image: ...  # noqa: F821
def reserved(*, seed: int = 0) -> Image: ...
def reserved_socket(each: Image) -> Image: ...
def socket_default(image: Image = 3) -> Image: ...
def half_optional(image: Image = None) -> Image: ...
def optional_without_default(image: Image | None) -> Image: ...
def keyword_socket(*, image: Image) -> Image: ...
def any_parameter(*, value: Any = 0) -> Image: ...
def set_parameter(*, value: set[int]) -> Image: ...
def bytes_parameter(*, value: bytes = b"") -> Image: ...
def bare_list(*, value: list) -> Image: ...
def numbered(*, value: dict[int, str]) -> Image: ...
def array_parameter(*, value: np.ndarray) -> Image: ...
def loose_model(*, value: Loose) -> Image: ...
def wrong_default(*, value: Annotated[float, Field(gt=0)] = 0.0) -> Image: ...
def wrong_default_type(*, value: int = 1.5) -> Image: ...
def wrong_choice(*, value: Literal["a", "b"] = "c") -> Image: ...
def field_default(*, value: float = Field(1.0, gt=0)) -> Image: ...
def pydantic_name(*, copy: int = 0) -> Image: ...
def positional_rng(rng: Rng = 0) -> Image: ...
def required_rng(*, rng: Rng) -> Image: ...
def renamed_rng(*, random: Rng = 0) -> Image: ...
def plain_rng(*, rng: int = 0) -> Image: ...
def positional_ctx(ctx: Context = QUIET) -> Image: ...
def wrong_axes(image: Annotated[Image, Axes("h w")]) -> Image: ...
def axes_of_number(value: Annotated[Number, Axes("h")]) -> Image: ...
def no_outputs() -> Nothing: ...
def gives_gaps() -> Gappy: ...
def generates() -> Image:
    yield 1


async def awaits() -> Image: ...
async def streams() -> Image:
    yield 1


@keeps
def wrapped(image: Image) -> Image: ...  # fmt: skip


def closure():
    outer = 1

    def inner(image: Image) -> Image:
        return image + outer

    return inner


class Holder:
    def method(self, image: Image) -> Image: ...


REFUSED = {
    lambda image: image: "not a lambda, method or closure",
    closure(): "not a lambda, method or closure",
    Holder.method: "not a lambda, method or closure",
    Holder().method: "made from a plain function, got method",
    functools.partial(starred): "made from a plain function, got partial",
    np.sin: "made from a plain function, got ufunc",
    wrapped: "no decorator stands below @node",
    generates: "no generator or coroutine",
    awaits: "no generator or coroutine",
    streams: "no generator or coroutine",
    starred: r"starred\(images\): a node has no \*args",
    double_starred: r"double_starred\(options\): a node has no \*args or \*\*kwargs",
    unannotated: r"unannotated\(image\): an annotation is required",
    without_result: "the result's annotation is required",
    unknown_result: "unknown_result -> result: ndarray is no socket type",
    unknown_socket: r"unknown_socket\(image\): ndarray is no socket type",
    forward: "an annotation cannot be read: name 'Nowhere'",
    reserved: r"reserved\(seed\): the name is reserved in graph files",
    reserved_socket: r"reserved_socket\(each\): the name is reserved",
    socket_default: r"written `Mask \| None = None`; a socket has no other default",
    half_optional: r"written `Mask \| None = None`",
    optional_without_default: r"written `Mask \| None = None`",
    keyword_socket: "data flows through positional arguments",
    any_parameter: "value: Any is unknown or not plain data",
    set_parameter: "value: set.* is unknown or not plain data",
    bytes_parameter: "value: bytes is unknown or not plain data",
    bare_list: "value: list is unknown or not plain data",
    numbered: "value: dict.* is unknown or not plain data",
    array_parameter: "value: ndarray is unknown or not plain data",
    loose_model: "the model Loose has to be frozen and strict",
    wrong_default: "the default of value does not fit its own type: should be greater than 0, got 0",
    wrong_default_type: "the default of value does not fit its own type",
    wrong_choice: "the default of value does not fit its own type: should be 'a' or 'b', got 'c'",
    field_default: "a default is a plain value",
    pydantic_name: "cannot be called 'copy'",
    positional_rng: "write it keyword-only",
    required_rng: "write it keyword-only",
    renamed_rng: "write it keyword-only",
    plain_rng: "write it keyword-only",
    positional_ctx: "write it keyword-only",
    wrong_axes: "Image has 3 axes, Axes names 2: h w",
    axes_of_number: "Number has 0 axes",
    no_outputs: "a node has at least one output",
    gives_gaps: "a node takes them and gives none",
}


@pytest.mark.parametrize("function", REFUSED, ids=lambda f: getattr(f, "__name__", type(f).__name__))
def test_refuses(function):
    with pytest.raises(DeclarationError, match=REFUSED[function]):
        node(function)


@pytest.mark.parametrize(("options", "told"), [({"version": 0}, "counts from 1"), ({"version": "2"}, "counts from 1"),
                                               ({"name": "my node"}, "CamelCase"), ({"name": "lower"}, "CamelCase")])  # fmt: skip
def test_refuses_wrong_versions_and_names(options, told):
    with pytest.raises(DeclarationError, match=told):
        node(**options)(tiny.const.function)


@node(version=3, name="Everything")
def everything(
    image: Image,
    extra: Mask | None = None,
    many: list[Image] | None = None,
    *,
    level: Annotated[float, Field(ge=0, description="how much")] = 1,
    method: Literal["a", "b"] = "a",
    strict: Strict = Strict(),  # noqa: B008 (frozen)
    sizes: tuple[int, ...] = (1, 2),
    file: FilePath | None = None,
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Two:
    """Do all of it.

    And more.

    Parameters
    ----------
    image, extra
        What it works on.

    Returns
    -------
    image : Image
        The picture.
    """
    assert isinstance(rng, np.random.Generator)
    assert isinstance(ctx, Context)
    return Two(image * level, rng.random())


def test_the_schema_is_the_signature():
    assert (everything.name, everything.version, everything.summary) == ("Everything", 3, "Do all of it.")
    assert {name: str(socket) for name, socket in everything.inputs.items()} == {
        "image": "Image", "extra": "Mask (optional)", "many": "list[Image] (optional)"}  # fmt: skip
    assert {name: str(socket.type) for name, socket in everything.outputs.items()} == {
        "image": "Image",
        "size": "Number",
    }
    assert everything.inputs["extra"].doc == "What it works on."
    assert everything.outputs["image"].doc == "The picture."
    assert list(everything.parameters.model_fields) == ["level", "method", "strict", "sizes", "file"]
    assert everything.injected == {"rng", "ctx"}
    level = everything.parameters.model_json_schema()["properties"]["level"]
    assert (level["minimum"], level["default"], level["description"]) == (0, 1.0, "how much")


def test_a_default_is_kept_as_a_file_would_give_it():
    default = everything.parameters.model_validate_json("{}").level
    assert (type(default), default) == (float, 1.0)


def test_a_node_looks_like_its_function():
    assert str(inspect.signature(everything)).startswith("(image: ")
    assert list(inspect.signature(everything).parameters)[-2:] == ["rng", "ctx"]
    assert everything.__doc__.startswith("Do all of it.")
    assert everything.__name__ == "everything"
    assert "Do all of it." in pydoc.render_doc(everything, renderer=pydoc.plaintext)
    assert repr(everything) == "<node Everything, version 3>"


def test_nodes_travel_by_reference():
    assert pickle.loads(pickle.dumps(everything)) is everything
    assert copy.deepcopy(everything) is everything
    lost = Node(**{name: getattr(everything, name) for name in everything.__dataclass_fields__})
    with pytest.raises(pickle.PicklingError):
        pickle.dumps(lost)


def test_a_direct_call_casts_runs_and_gives_read_only_arrays():
    given = np.ones((2, 2, 1))
    made = everything(given, level=0.5)
    assert isinstance(made, Two)
    assert made.image.dtype == np.float32
    assert made.image[0, 0, 0] == 0.5
    assert not made.image.flags.writeable
    assert made.image.flags.c_contiguous
    assert given.flags.writeable
    own = picture(1, 2)
    tiny.both(own, own)
    assert own.flags.writeable


def test_the_random_stream_of_a_direct_call():
    image = picture(1)
    expected = np.random.default_rng(5).random()
    assert everything(image, rng=5).size == everything(image, rng=np.int64(5)).size == expected
    assert everything(image, rng=np.random.default_rng(5)).size == expected
    assert everything(image).size == np.random.default_rng(0).random()
    for wrong in (True, "5", 1.5, -1, np.random):
        with pytest.raises(ValueError, match=r"^rng: "):
            everything(image, rng=wrong)


def test_the_context_of_a_direct_call(recwarn):
    told = []
    ctx = Context(on_progress=lambda share, text: told.append((share, text)), on_warning=told.append)
    tiny.warns(picture(1), ctx=ctx)
    assert told == [(0.5, "half"), "it is odd"]
    for call in (tiny.warns, tiny.asks_others):
        with pytest.warns(UserWarning, match="it is odd") as caught:
            call(picture(1))
        assert caught[0].filename == __file__  # the caller's line, not the node's


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: everything(np.zeros((2, 2, 3), np.uint8)), "image: Image is float32, got uint8; convert it: x / 255 as float32"),
        (lambda: everything(np.zeros((2, 2))), "image: expected Image"),
        (lambda: everything(picture(np.nan)), "image: Image holds finite numbers, got 1 NaN"),
        (lambda: everything(None), "image: Everything needs Image, got nothing"),
        (lambda: everything(picture(1), level=-1), "level: should be greater than or equal to 0, got -1"),
        (lambda: everything(picture(1), level="1"), "level: should be a valid number, got '1'"),
        (lambda: everything(picture(1), level=np.nan), "level: should be a finite number, got nan"),
        (lambda: everything(picture(1), method="c"), "method: should be 'a' or 'b', got 'c'"),
        (lambda: everything(picture(1), strict={"size": 1, "sice": 2}), "strict.sice: unknown parameter 'sice'"),
        (lambda: everything(picture(1), strict={"shift": float("nan")}), "strict: should be made of finite numbers"),
        (lambda: everything(picture(1), sizes=(1, 2.5)), "sizes.1: should be a valid integer"),
        (lambda: everything(picture(1), sizes=object()), "sizes: not plain data"),
        (lambda: tiny.cut(picture(1, 2), [np.zeros((1, 2), bool), np.zeros((1, 3), bool)]), r"masks[1]: axis w has size 3 (shape (1, 3)), but image has 2; they must agree"),
        (lambda: tiny.total([picture(1), np.zeros(3)]), "images[1]: expected Image"),
        (lambda: tiny.total([picture(1), Gap("a", "b")]), "images[1]: expected Image: float32 (h, w, c), got Gap"),
    ],
)  # fmt: skip
def test_a_direct_call_names_what_does_not_fit(call, told):
    with pytest.raises(ValueError) as caught:
        call()
    assert str(caught.value).startswith(told)


def test_unknown_and_missing_arguments_are_type_errors_as_for_any_function():
    with pytest.raises(TypeError, match=r"\(\) .*image"):
        everything()
    with pytest.raises(TypeError, match=r"\(\) .*lewel.*; did you mean 'level'\?"):
        everything(picture(1), lewel=1)
    with pytest.raises(TypeError, match=r"too many positional arguments; parameters go by name: amount=\.\.\."):
        tiny.add(picture(1), 0.5)


def test_parameters_take_numpy_scalars_arrays_and_models():
    made = everything(picture(1), level=np.float32(0.5), sizes=np.array([1, 2]), strict=Strict(size=2))
    assert made.image[0, 0, 0] == 0.5


def test_composites_are_one_output():
    made = tiny.scatter(count=2)
    assert isinstance(made, Elements)
    assert tiny.count(made) == 2
    assert not made.points.flags.writeable
    with pytest.raises(ValueError, match=r"^elements\.angles: expected Vector"):
        tiny.count((made.points, made.points, made.scales))


def test_lists_take_gaps_where_they_are_asked_for():
    np.testing.assert_array_equal(tiny.survey([picture(3), Gap("a", "b")])[0, :, 0], [3, -1])


@pytest.mark.parametrize(
    ("what", "told"), [("dtype", "result: Image is float32, got bool"), ("rank", "result: expected Image"),
                       ("nan", "result: Image holds finite numbers"), ("none", "got NoneType")]
)  # fmt: skip
def test_a_node_that_breaks_its_own_output_s_type_is_named(what, told):
    with pytest.raises(DeclarationError, match=f"^Liar broke its own output's type: .*{told}"):
        tiny.liar(picture(1), what=what)


@node
def one_of_two() -> Two:
    """Forget an output."""
    return (picture(1),)


def test_a_node_that_forgets_an_output_is_named():
    with pytest.raises(DeclarationError, match="OneOfTwo returns Two, but gave tuple"):
        one_of_two()
