"""Parameters as plain data: strict checks in words, files, and values that are known only later."""

import inspect
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import pytest
from pydantic import BaseModel, ConfigDict, Field

from graphtex import DeclarationError, FilePath
from graphtex.json_types import json_types
from graphtex.parameters import files_of, parameters_model, plain, shorten, validate, with_files


class Point(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")
    x: float
    y: float = 0.0


class Source(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")
    file: FilePath
    scale: float = 1.0


class Grow(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")
    do: Literal["grow"] = "grow"


class Shrink(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")
    do: Literal["shrink"] = "shrink"


def model_of(**hints: Any) -> type[BaseModel]:
    """Make a model; a hint may come with a default as a pair."""
    pairs = {name: hint if isinstance(hint, tuple) else (hint, inspect.Parameter.empty) for name, hint in hints.items()}
    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [inspect.Parameter(name, keyword, default=default) for name, (_, default) in pairs.items()]
    return parameters_model("Node", parameters, {name: hint for name, (hint, _) in pairs.items()})


@pytest.mark.parametrize(
    ("hint", "value", "told"),
    [
        (int, 1.5, "should be a valid integer, got 1.5"),
        (int, True, "should be a valid integer, got True"),
        (int, "3", "should be a valid integer, got '3'"),
        (float, False, "should be a valid number, got False"),
        (float, float("inf"), "should be a finite number, got inf"),
        (bool, "no", "should be true or false, got 'no'"),
        (bool, 1, "should be true or false, got 1"),
        (str, 5, "should be a valid string, got 5"),
        (Literal["ridges", "edges"], "ridge", "should be 'ridges' or 'edges', got 'ridge'; did you mean 'ridges'?"),
        (Annotated[int, Field(ge=1, le=9)], 10, "should be less than or equal to 9, got 10"),
        (int | Literal["auto"], "x", "should be a valid integer, got 'x'; or should be 'auto', got 'x'"),
    ],
)
def test_messages_say_what_would_fit_and_what_was_got(hint, value, told):
    assert validate(model_of(value=hint), {"value": value}) == (None, [(("value",), told)])


@pytest.mark.parametrize(
    ("hint", "value", "place"),
    [
        (list[Point], [{"x": 1}, {"y": 2}], ("value", 1, "x")),
        (list[Point], [{"x": "a"}], ("value", 0, "x")),
        (Point | None, {"x": 1, "z": 2}, ("value", "z")),
        (dict[str, int], {"a": 1, "b": "c"}, ("value", "b")),
        (tuple[int, float], [1, "c"], ("value", 1)),
        (list[int | str], ["a", 1.5], ("value", 1)),
    ],
)
def test_faults_are_placed_within_the_value(hint, value, place):
    assert [where for where, _ in validate(model_of(value=hint), {"value": value})[1]] == [place]


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"edits": [{"do": "growe"}]}, "'do' should be 'grow', 'shrink', got 'growe'; did you mean 'grow'?"),
        ({"edits": [{}]}, "'do' is required, got {}"),
        ({"edits": [3]}, "should be a mapping, got 3"),
        ({"edits": "grow"}, "should be a list, got 'grow'"),
        ({"columns": []}, "should have at least 1 item, got []"),
        ({"columns": [1, 2, 3]}, "should have at most 2 items, got [1, 2, 3]"),
        ({"closed": 1}, "should be true or false, got 1"),
    ],
)
def test_what_would_fit_is_said_in_the_words_of_a_graph_file(given, told):
    edit = Annotated[Grow | Shrink, Field(discriminator="do")]
    columns = Annotated[list[int], Field(min_length=1, max_length=2)]
    model = model_of(edits=(list[edit], []), closed=(bool, True), columns=(columns, [1]))
    assert [text for _, text in validate(model, given)[1]] == [told]


def test_a_name_that_is_no_text_is_told():
    """A file's name in another encoding than the system's comes as surrogates."""
    assert validate(model_of(path=FilePath), {"path": "m\udcfcn.png"})[1] == [
        ((), "should be text; a name that is no UTF-8 cannot be used: rename the file")
    ]


def test_all_faults_are_told_at_once_with_unknown_and_missing_names():
    faults = validate(model_of(window=int, level=float), {"widow": 3, "level": "x"})[1]
    assert sorted(faults) == [
        (("level",), "should be a valid number, got 'x'"),
        (("widow",), "unknown parameter 'widow'; did you mean 'window'?"),
        (("window",), "a value is required"),
    ]


def test_values_that_come_later_are_left_out():
    model, faults = validate(model_of(window=int, level=(float, 2)), {}, unknown={"window"})
    assert faults == []
    assert model.model_dump() == {"level": 2.0}


@pytest.mark.parametrize("value", [object(), {1, 2}, b"x", 1j])
def test_objects_are_refused_by_name(value):
    (place, told), = validate(model_of(level=float), {"level": value})[1]  # fmt: skip
    assert place == ("level",)
    assert told.startswith("not plain data")


def test_defaults_are_read_as_from_a_file():
    made = model_of(a=(float, 1), b=(tuple[float, ...], (1, 2)), c=(list[Point], [Point(x=1)]), d=(FilePath, Path("x")))
    values, faults = validate(made, {})
    assert faults == []
    assert values == validate(made, {"a": 1.0, "b": [1, 2], "c": [{"x": 1}], "d": "x"})[0]
    assert type(values.a) is float
    assert values.b == (1.0, 2.0)


def test_a_mutable_default_is_not_shared():
    made = model_of(a=(list[int], [1]))
    validate(made, {})[0].a.append(2)
    assert validate(made, {})[0].a == [1]


@pytest.mark.parametrize("hint", [Any, object, set[int], frozenset[str], bytes, complex, np.ndarray, dict[int, int],
                                  list, tuple, list[Any], type, "x"])  # fmt: skip
def test_types_that_are_no_plain_data_are_refused(hint):
    with pytest.raises(DeclarationError, match=r"value: .* is unknown or not plain data"):
        model_of(value=hint)


def test_models_within_must_be_strict_and_hold_plain_data():
    class Deep(BaseModel):
        model_config = ConfigDict(frozen=True, extra="forbid")
        when: bytes

    with pytest.raises(DeclarationError, match=r"value\.when: bytes"):
        model_of(value=list[Deep])


def test_plain_unfolds_models_tuples_paths_and_numpy():
    given = {"a": (Point(x=1), Path("x")), "b": np.float64(2), "c": np.arange(2)}
    assert plain(given) == {"a": [{"x": 1.0, "y": 0.0}, "x"], "b": 2.0, "c": [0, 1]}


def test_files_are_found_and_replaced_wherever_they_stand():
    made = model_of(one=FilePath, many=list[Source], named=dict[str, FilePath], text=str)
    given = {"one": "a", "many": [{"file": "b"}], "named": {"k": "c"}, "text": "d"}
    values = validate(made, given)[0]
    assert [str(path) for path in files_of(values)] == ["a", "b", "c"]
    changed = with_files(values, lambda path: f"<{path}>")
    assert changed == {"one": "<a>", "many": [{"file": "<b>", "scale": 1.0}], "named": {"k": "<c>"}, "text": "d"}


def test_json_types_say_what_a_parameter_accepts():
    made = model_of(a=int, b=float | None, c=Literal["x", 1], d=list[int], e=Point, f=bool)
    assert {name: sorted(json_types(made, name)) for name in "abcdef"} == {
        "a": ["integer"], "b": ["integer", "null", "number"], "c": ["integer", "string"],
        "d": ["array"], "e": ["object"], "f": ["boolean"]}  # fmt: skip


def test_shorten():
    assert shorten("a" * 100, 10) == "'aaaaaa..."
