"""All that is needed to use one node, as text: read from its signature and its docstring."""

import inspect
import json
import sys
from collections.abc import Iterable, Mapping
from typing import Any

from graphtex import docstrings
from graphtex.cli.terminal import table
from graphtex.node import Node, Socket

_BOUNDS = (("minimum", ">= {}"), ("exclusiveMinimum", "> {}"), ("maximum", "<= {}"), ("exclusiveMaximum", "< {}"),
           ("multipleOf", "a multiple of {}"), ("minLength", "at least {} characters"),
           ("maxLength", "at most {} characters"), ("pattern", "like {}"))  # fmt: skip
_PLAIN = {"integer": "int", "number": "float", "string": "str", "boolean": "bool", "null": "null", "object": "mapping"}


def describe(made: Node[Any, Any], pack: str) -> str:
    """Return a node's page."""
    random = "random: its result depends on the seed" if "rng" in made.injected else "not random"
    function = made.function
    parts = [
        f"{made.name}: {made.summary}",
        f"pack {pack}, version {made.version}, {random}\nin Python: from {_home(made)} import {function.__name__}",
        _section("Inputs", _sockets(made.inputs.values())),
        _section("Parameters", _parameters(made)),
        _section("Outputs", _sockets(made.outputs.values())),
        "Example\n" + _indented(example(made)),
    ]
    body = (inspect.getdoc(function) or "").partition("\n\n")[2].strip()
    if body:
        parts.append("Documentation\n" + _indented(body))
    return "\n\n".join(part for part in parts if part)


def _home(made: Node[Any, Any]) -> str:
    """Return the module to import a node's function from: the pack itself if it offers it."""
    top = made.function.__module__.partition(".")[0]
    offered = getattr(sys.modules.get(top), made.function.__name__, None)
    return top if offered is made else made.function.__module__


def _section(title: str, rows: list[tuple[str, ...]]) -> str:
    return f"{title}\n{table(rows, indent='  ')}" if rows else f"{title}: none"


def _indented(text: str) -> str:
    return "\n".join(f"  {line}".rstrip() for line in text.splitlines())


def _sockets(sockets: Iterable[Socket]) -> list[tuple[str, ...]]:
    return [(socket.name, str(socket), socket.doc or socket.type.base.summary) for socket in sockets]


def _parameters(made: Node[Any, Any]) -> list[tuple[str, ...]]:
    schema = made.parameters.model_json_schema()
    texts = docstrings.section(made.function.__doc__, "Parameters")
    rows: list[tuple[str, ...]] = []
    for name, given in schema.get("properties", {}).items():
        default = f"default {written(given['default'])}" if "default" in given else "required"
        doc = given.get("description", "") or texts.get(name, "")
        rows.append((name, kind_of(given, schema.get("$defs", {})), default, doc))
    return rows


def kind_of(schema: Mapping[str, Any], models: Mapping[str, Any]) -> str:
    """Return a parameter's type, choices and range, from its JSON Schema.

    >>> kind_of({"type": "integer", "minimum": 1, "maximum": 9}, {})
    'int, >= 1, <= 9'
    >>> kind_of({"enum": ["fast", "good"], "type": "string"}, {})
    'fast or good'
    """
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        fields = models.get(name, {}).get("properties", {})
        inner = ", ".join(f"{key}: {kind_of(field, models)}" for key, field in fields.items())
        return f"{{{inner}}}" if inner else name
    if "enum" in schema:
        return " or ".join(map(written, schema["enum"]))
    if "const" in schema:
        return written(schema["const"])
    for key in ("anyOf", "oneOf"):
        if key in schema:
            return " or ".join(dict.fromkeys(kind_of(each, models) for each in schema[key]))
    if "allOf" in schema and len(schema["allOf"]) == 1:
        return kind_of(schema["allOf"][0], models)
    if schema.get("type") == "array":
        return _array(schema, models)
    kind = "file" if schema.get("format") == "path" else _PLAIN.get(str(schema.get("type")), "any")
    return ", ".join([kind, *(text.format(_number(schema[key])) for key, text in _BOUNDS if key in schema)])


def _array(schema: Mapping[str, Any], models: Mapping[str, Any]) -> str:
    if "prefixItems" in schema:
        return f"[{'; '.join(kind_of(item, models) for item in schema['prefixItems'])}]"
    inner = kind_of(schema.get("items", {}), models)
    least, most = schema.get("minItems"), schema.get("maxItems")
    size = ""
    if least is not None and least == most:
        size = f" of {least}"
    elif least is not None or most is not None:
        size = f" of {least or 0} to {most}" if most is not None else f" of at least {least}"
    return f"list{size} [{inner}]"


def _number(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def written(value: Any) -> str:
    """Return plain data as YAML's flow form writes it, so that it can be copied into a graph file."""
    if isinstance(value, str):
        from graphtex.files import read_scalar

        try:
            if read_scalar(value) == value and not set(value) & set(",[]{}"):
                return value
        except ValueError:  # no YAML as it stands
            pass
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {written(item)}' for key, item in value.items())}}}"
    return json.dumps(value)


def example(made: Node[Any, Any]) -> str:
    """Return an entry of a graph file: required sockets and parameters, and parameters with their defaults.

    Names of nodes are made up; a value in place of a required parameter is of the right type where one can be told.
    """
    schema = made.parameters.model_json_schema()
    lines = [f"{made.function.__name__}:", f"  node: {made.name}"]
    for name, socket in made.inputs.items():
        reference = f"[{_node_for(socket)}]" if socket.type.many else _node_for(socket)
        if not socket.optional:
            lines.append(f"  {name}: {reference}")
    for name, given in schema.get("properties", {}).items():
        value = given["default"] if "default" in given else sample(given, schema.get("$defs", {}))
        if value is not None:
            lines.append(f"  {name}: {written(value)}")
    return "\n".join(lines)


def _node_for(socket: Socket) -> str:
    return f"some_{socket.name}"


def sample(schema: Mapping[str, Any], models: Mapping[str, Any]) -> Any:
    """Return a value that a JSON Schema of a parameter admits, as far as types and ranges tell."""
    if "$ref" in schema:
        model = models.get(schema["$ref"].rpartition("/")[2], {})
        wanted = model.get("required", [])
        return {key: sample(field, models) for key, field in model.get("properties", {}).items() if key in wanted}
    if schema.get("examples"):
        return schema["examples"][0]
    for key in ("anyOf", "oneOf", "allOf"):
        if key in schema:
            return _tagged(schema, sample(schema[key][0], models))
    if "enum" in schema or "const" in schema:
        return schema["enum"][0] if "enum" in schema else schema["const"]
    kind = schema.get("type")
    if kind == "array":
        if "prefixItems" in schema:
            return [sample(item, models) for item in schema["prefixItems"]]
        return [sample(schema.get("items", {}), models)] * schema.get("minItems", 1)
    if kind in ("integer", "number"):
        return _sample_number(schema)
    return {"boolean": True, "null": None, "object": {}}.get(str(kind), "file.txt" if "format" in schema else "text")


def _tagged(schema: Mapping[str, Any], value: Any) -> Any:
    """Add the tag by which a union is told apart, though the model itself gives it a default."""
    union = schema.get("discriminator", {})
    if not union:
        return value
    first = schema["oneOf"][0]["$ref"]
    tag = next(tag for tag, reference in union["mapping"].items() if reference == first)
    return {union["propertyName"]: tag, **value}


def _sample_number(schema: Mapping[str, Any]) -> int | float:
    step = schema.get("multipleOf", 1)
    if "minimum" in schema:
        value = schema["minimum"]
    elif "exclusiveMinimum" in schema:
        top = schema.get("maximum", schema.get("exclusiveMaximum"))
        low = schema["exclusiveMinimum"]
        value = low + step if top is None or low + step < top else (low + top) / 2
    else:
        value = min(step, schema.get("maximum", step))
    return int(value) if schema.get("type") == "integer" else value
