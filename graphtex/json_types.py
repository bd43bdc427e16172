"""Which JSON types a parameter accepts, told from its JSON Schema."""

import functools
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

JSON_TYPES = frozenset({"integer", "number", "string", "boolean", "array", "object", "null"})
_JSON_TYPE = {int: "integer", float: "number", str: "string", bool: "boolean", list: "array", dict: "object"}


def json_types(model: type[BaseModel], name: str) -> frozenset[str]:
    """Return the JSON types that a parameter accepts; a number may be an integer."""
    whole = _schema(model)
    found = _types_of(whole["properties"][name], whole.get("$defs", {}))
    return found | {"integer"} if "number" in found else found


@functools.cache
def _schema(model: type[BaseModel]) -> dict[str, Any]:
    return model.model_json_schema()


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
