"""Parameters: one pydantic model from the keyword-only part of a signature.

Parameters are data: they are checked as JSON would be, strictly, so ``"no"`` is never a bool and ``1.5`` never an int.
"""

import functools
import inspect
import json
import math
import re
import types
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, PydanticInvalidForJsonSchema, ValidationError, create_model
from pydantic.fields import FieldInfo
from pydantic.json_schema import WithJsonSchema

from graphtex.errors import DeclarationError, did_you_mean

# A file that a parameter names: relative to the graph file; its content, not its name, enters the cache key.
FilePath: TypeAlias = Annotated[Path, WithJsonSchema({"type": "string", "format": "path"})]

_STRICT = ConfigDict(
    extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=False, protected_namespaces=()
)


def parameters_model(owner: str, parameters: Iterable[inspect.Parameter], hints: Mapping[str, Any]) -> type[BaseModel]:
    """Build the model that `owner`'s keyword-only parameters form.

    Defaults are kept as they would be read from a file, so that leaving a parameter out and writing its default are
    the same.

    Raises
    ------
    DeclarationError
        For a type that JSON cannot write and read back the same, or a default that does not fit.
    """
    required: dict[str, Any] = {}
    defaults: dict[str, Any] = {}
    for parameter in parameters:
        name, hint, default = parameter.name, hints[parameter.name], parameter.default
        if hasattr(BaseModel, name) or name.startswith("_"):
            raise DeclarationError(f"{owner}: a parameter cannot be called {name!r}, a name of pydantic's models")
        _require_plain(hint, f"{owner}: {name}")
        if isinstance(default, FieldInfo):
            text = f"a default is a plain value: {name}: Annotated[float, Field(gt=0)] = 1.0"
            raise DeclarationError(f"{owner}: {text}")
        required[name] = (hint, ...)
        if default is not inspect.Parameter.empty:
            defaults[name] = default
    fields = dict(required)
    if defaults:
        checked, problems = validate(_made(owner, {name: required[name] for name in defaults}), defaults)
        if checked is None:
            place, message = problems[0]
            raise DeclarationError(f"{owner}: the default of {place[0]} does not fit its own type: {message}")
        fields |= {name: (required[name][0], getattr(checked, name)) for name in defaults}
    return _with_schema(owner, _made(owner, fields))


def _made(owner: str, fields: dict[str, Any]) -> type[BaseModel]:
    try:
        model: type[BaseModel] = create_model(owner, __config__=_STRICT, **fields)
    except Exception as error:  # pydantic has no common base for what it finds wrong with a type
        raise _not_plain(owner, error) from error
    return model


def _with_schema(owner: str, model: type[BaseModel]) -> type[BaseModel]:
    """Return the model; DeclarationError if its types have no JSON Schema."""
    try:
        model.model_json_schema()
    except PydanticInvalidForJsonSchema as error:
        raise _not_plain(owner, error) from error
    return model


def _not_plain(owner: str, error: Exception) -> DeclarationError:
    return DeclarationError(f"{owner}: a parameter's type is unknown or not plain data: {error}")


def _require_plain(hint: Any, where: str) -> None:
    """Raise DeclarationError for a type whose values JSON cannot hold, or not in one way only."""
    origin, arguments = get_origin(hint), get_args(hint)
    if hint in (bool, int, float, str, Path, type(None), None) or origin is Literal:
        return
    if origin is Annotated:
        _require_plain(arguments[0], where)
    elif origin in (Union, types.UnionType) or (origin in (list, tuple) and arguments):
        for inner in arguments:
            if inner is not Ellipsis:
                _require_plain(inner, where)
    elif origin is dict and arguments[0] is str:
        _require_plain(arguments[1], where)
    elif isinstance(hint, type) and issubclass(hint, BaseModel):
        if not (hint.model_config.get("frozen") and hint.model_config.get("extra") == "forbid"):
            config = 'model_config = ConfigDict(frozen=True, extra="forbid")'
            raise DeclarationError(f"{where}: the model {hint.__name__} has to be frozen and strict: {config}")
        for name, info in hint.model_fields.items():
            _require_plain(info.annotation, f"{where}.{name}")
    else:
        got = getattr(hint, "__name__", None) or str(hint)
        wanted = "bool, int, float, str, Literal, FilePath, list, tuple, dict[str, ...] and small pydantic models"
        raise DeclarationError(f"{where}: {got} is unknown or not plain data; plain are {wanted}")


def plain(value: Any) -> Any:
    """Return a parameter's value as JSON types: models, tuples, paths and numpy scalars are unfolded."""
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    return value


@functools.cache
def without(model: type[BaseModel], names: frozenset[str]) -> type[BaseModel]:
    """Return a model without some of its parameters: those whose values are known only later."""
    if not names:
        return model
    fields: dict[str, Any] = {
        name: (info.annotation, info) for name, info in model.model_fields.items() if name not in names
    }
    return create_model(model.__name__, __config__=_STRICT, **fields)


def validate(
    model: type[BaseModel], values: Mapping[str, Any], *, unknown: Iterable[str] = ()
) -> tuple[BaseModel | None, list[tuple[tuple[str | int, ...], str]]]:
    """Check values against a model.

    Parameters
    ----------
    unknown
        Names whose values are known only later; they are not in the model that is returned.

    Returns
    -------
    The model, or None and the list of (path, message).
    """
    model = without(model, frozenset(unknown))
    data = plain(values)
    try:
        text = json.dumps(data)
    except (TypeError, ValueError) as error:
        bad = next((key for key, value in values.items() if not _is_plain(value)), "")
        return None, [((bad,), f"not plain data ({error}); numbers, text, true/false, lists and mappings are")]
    try:
        found = model.model_validate_json(text, strict=True)
    except ValidationError as error:
        return None, _merged(model, data, error.errors(include_url=False))
    if "NaN" in text or "Infinity" in text:  # models within the model may not have said that they take none
        infinite = [key for key, value in data.items() if not _is_finite(value)]
        if infinite:
            return None, [((key,), "should be made of finite numbers, got NaN or infinity") for key in infinite]
    return found, []


def _merged(model: type[BaseModel], data: Any, faults: Iterable[Any]) -> list[tuple[tuple[str | int, ...], str]]:
    """Return one message for each place; of a union of types each has its say."""
    texts: dict[tuple[str | int, ...], list[str]] = {}
    for fault in faults:
        text = _message(model, fault)
        told = texts.setdefault(_place(fault, data), [])
        if text not in told:
            told.append(text)
    return [(place, "; or ".join(told)) for place, told in texts.items()]


def _place(fault: Any, data: Any) -> tuple[str | int, ...]:
    """Return where a fault is in the data, without the names of a union's types, which pydantic puts in between."""
    place: list[str | int] = []
    for part in fault["loc"]:
        if (isinstance(data, Mapping) and part in data) or (
            isinstance(data, list) and isinstance(part, int) and part < len(data)
        ):
            place.append(part)
            data = data[part]
    return (*place, fault["loc"][-1]) if fault["type"] == "missing" else tuple(place)


def _is_finite(value: Any) -> bool:
    if isinstance(value, Mapping):
        return all(map(_is_finite, value.values()))
    if isinstance(value, list):
        return all(map(_is_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


def _is_plain(value: Any) -> bool:
    try:
        json.dumps(plain(value))
    except (TypeError, ValueError):
        return False
    return True


def _message(model: type[BaseModel], fault: Any) -> str:
    kind, got = fault["type"], fault.get("input")
    if kind == "extra_forbidden":
        name = str(fault["loc"][-1])
        known = model.model_fields if len(fault["loc"]) == 1 else ()
        return f"unknown parameter {name!r}{did_you_mean(name, known, label='parameters') if known else ''}"
    if kind == "missing":
        return "a value is required"
    if kind == "json_invalid":  # the text was written by ourselves: only surrogates make it wrong
        return "should be text; a name that is no UTF-8 cannot be used: rename the file"
    text = fault["msg"][0].lower() + fault["msg"][1:]
    text = text.replace("input should be", "should be").replace("value error, ", "")
    for theirs, ours in _WORDS:
        text = re.sub(theirs, ours, text)
    if kind == "literal_error":
        return f"should be {_choice(fault['ctx']['expected'], got)}"
    if kind == "union_tag_invalid":
        return (
            f"{fault['ctx']['discriminator']} should be {_choice(fault['ctx']['expected_tags'], fault['ctx']['tag'])}"
        )
    if kind == "union_tag_not_found":
        return f"{fault['ctx']['discriminator']} is required, got {shorten(got)}"
    return f"{text}, got {shorten(got)}"


_WORDS = (
    ("a valid array", "a list"),
    ("an object", "a mapping"),
    ("a valid boolean", "true or false"),
    (r"^list (should have .*) after validation, not \d+$", r"\1"),
)


def _choice(expected: str, got: Any) -> str:
    near = did_you_mean(str(got), expected.replace("'", "").replace(" or ", ", ").split(", "))
    return f"{expected}, got {got!r}{near if 'did you mean' in near else ''}"


def shorten(value: Any, limit: int = 60) -> str:
    """Return the value's repr, cut to `limit` characters."""
    text = repr(value)
    return text if len(text) <= limit else f"{text[: limit - 3]}..."


def files_of(value: Any) -> list[Path]:
    """Return the files that a parameter's value names, in order."""
    if isinstance(value, Path):
        return [value]
    if isinstance(value, BaseModel):
        return [path for name in type(value).model_fields for path in files_of(getattr(value, name))]
    if isinstance(value, list | tuple):
        return [path for item in value for path in files_of(item)]
    if isinstance(value, Mapping):
        return [path for item in value.values() for path in files_of(item)]
    return []


def with_files(value: Any, change: Callable[[Path], Any]) -> Any:
    """Return a parameter's value as JSON types, with each file replaced by ``change(file)``."""
    if isinstance(value, Path):
        return change(value)
    if isinstance(value, BaseModel):
        return {name: with_files(getattr(value, name), change) for name in type(value).model_fields}
    if isinstance(value, list | tuple):
        return [with_files(item, change) for item in value]
    if isinstance(value, Mapping):
        return {key: with_files(item, change) for key, item in value.items()}
    return plain(value)
