"""Parameters: one pydantic model from the keyword-only part of a signature.

Parameters are data: they are checked as JSON would be, strictly, so ``"no"`` is never a bool and ``1.5`` never an int.
"""

import functools
import inspect
import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError, create_model
from pydantic.fields import FieldInfo
from pydantic.json_schema import WithJsonSchema

from graphtex.errors import DeclarationError, did_you_mean

# A file that a parameter names: relative to the graph file; its content, not its name, enters the cache key.
FilePath: TypeAlias = Annotated[Path, WithJsonSchema({"type": "string", "format": "path"})]

_STRICT = ConfigDict(
    extra="forbid", frozen=True, allow_inf_nan=False, arbitrary_types_allowed=False, protected_namespaces=()
)


def parameters_model(owner: str, parameters: Iterable[inspect.Parameter], hints: Mapping[str, Any]) -> type[BaseModel]:
    """Build the model `owner`'s keyword-only parameters form; DeclarationError for a type that JSON cannot write."""
    fields: dict[str, Any] = {}
    for parameter in parameters:
        default = ... if parameter.default is inspect.Parameter.empty else parameter.default
        fields[parameter.name] = (hints[parameter.name], default)
    try:
        model: type[BaseModel] = create_model(owner, __config__=_STRICT, **fields)
        model.model_json_schema()
    except Exception as error:  # pydantic has no common base for what it finds wrong with a type
        raise DeclarationError(f"{owner}: a parameter's type is unknown or not plain data: {error}") from error
    for name, info in model.model_fields.items():
        _check_default(owner, name, info, model)
    return model


def _check_default(owner: str, name: str, info: FieldInfo, model: type[BaseModel]) -> None:
    if info.is_required():
        return
    others = frozenset(model.model_fields) - {name}
    problems = [text for _, text in validate(model, {name: info.default}, unknown=others)[1]]
    if problems:
        raise DeclarationError(f"{owner}: the default of {name} does not fit its own type: {problems[0]}")


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
    try:
        text = json.dumps(plain(values))
    except (TypeError, ValueError) as error:
        bad = next((key for key, value in values.items() if not _is_plain(value)), "")
        return None, [((bad,), f"not plain data ({error}); numbers, text, true/false, lists and mappings are")]
    try:
        return model.model_validate_json(text, strict=True), []
    except ValidationError as error:
        return None, [(tuple(fault["loc"]), _message(model, fault)) for fault in error.errors(include_url=False)]


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
    text = fault["msg"][0].lower() + fault["msg"][1:]
    text = text.replace("input should be", "should be").replace("value error, ", "")
    if kind == "literal_error":
        expected = fault["ctx"]["expected"]
        near = did_you_mean(str(got), expected.replace("'", "").replace(" or ", ", ").split(", "))
        return f"should be {expected}, got {got!r}{near if 'did you mean' in near else ''}"
    return f"{text}, got {shorten(got)}"


JSON_TYPES = frozenset({"integer", "number", "string", "boolean", "array", "object", "null"})
_JSON_TYPE = {int: "integer", float: "number", str: "string", bool: "boolean", list: "array", dict: "object"}


def json_types(model: type[BaseModel], name: str) -> frozenset[str]:
    """Return the JSON types that a parameter accepts; a number may be an integer."""
    whole = model.model_json_schema()
    found = _types_of(whole["properties"][name], whole.get("$defs", {}))
    return found | {"integer"} if "number" in found else found


def _types_of(schema: Mapping[str, Any], definitions: Mapping[str, Any]) -> frozenset[str]:
    if "$ref" in schema:
        return _types_of(definitions[schema["$ref"].rpartition("/")[2]], definitions)
    for key in ("anyOf", "oneOf"):
        if key in schema:
            return frozenset().union(*(_types_of(option, definitions) for option in schema[key]))
    if "type" in schema:
        return frozenset([schema["type"]] if isinstance(schema["type"], str) else schema["type"])
    if "enum" in schema or "const" in schema:
        values = schema.get("enum", [schema.get("const")])
        return frozenset(_JSON_TYPE.get(type(value), "null") for value in values)
    return JSON_TYPES


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
