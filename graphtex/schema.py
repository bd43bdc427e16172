"""The JSON Schema (draft 2020-12) of a graph file, made from the nodes at hand, so that editors complete and check it.

An entry's arguments depend on its `node`: each node has a definition of its own, chosen by ``if``/``then`` on the
name, which editors follow to complete sockets and parameters. What a schema cannot say (that a reference leads to
something, and that its type fits) is left to `graphtex.check`.
"""

from collections.abc import Iterable, Mapping
from typing import Any

from pydantic import BaseModel

from graphtex import docstrings
from graphtex.document import FORMAT, NAME, SCALAR_TYPES
from graphtex.handlers import WRITERS
from graphtex.json_types import json_types
from graphtex.node import Node, Socket
from graphtex.packs import registry
from graphtex.sockets import TYPES, SocketType

Schema = dict[str, Any]

_REFERENCE = {"$ref": "#/$defs/reference"}
_INPUT_REFERENCE = {"$ref": "#/$defs/inputReference"}
_SCALARS: dict[str, tuple[Schema, str]] = {
    "int": ({"type": "integer"}, "a whole number"),
    "float": ({"type": "number"}, "a number"),
    "str": ({"type": "string"}, "a text"),
    "bool": ({"type": "boolean"}, "true or false"),
    "file": ({"type": "string"}, "a path, relative to the graph file"),
    "data": ({}, "any plain data"),
}


def graph_schema() -> Schema:
    """Return the schema of graph files that use the installed nodes, as plain data.

    >>> graph_schema()["required"]
    ['graphtex', 'nodes']
    """
    nodes = dict(sorted(registry().nodes.items()))
    definitions: Schema = {
        "reference": {
            "type": "string",
            "pattern": rf"^(\${NAME.pattern}|{NAME.pattern}(\.{NAME.pattern})?)$",
            "description": "node, node.socket where it has several outputs, or $input",
        },
        "inputReference": {
            "type": "string",
            "pattern": rf"^\${NAME.pattern}$",
            "description": "$name: the value of a graph input",
        },
        "measured": _mapping({"from": _REFERENCE}, ["from"], "a number that a node measures"),
        "seed": {
            "anyOf": [{"type": "integer", "minimum": 0}, _INPUT_REFERENCE],
            "description": "replaces the random stream that follows from the graph's seed and the node's name",
        },
        "onError": {
            "enum": ["stop", "keep"],
            "description": "keep: a failed cell of `each` is a gap",
            "default": "stop",
        },
        "input": _input(),
        "entry": _entry(nodes.values()),
        "subgraph": _subgraph(),
    }
    definitions |= _output()
    for node in nodes.values():
        definitions |= _node(node)
    sections = {
        "inputs": {**_named("input", "what a run can be given"), "type": ["object", "null"]},
        "nodes": {**_named("entry", "the steps, each under a name of its own"), "minProperties": 1},
        "outputs": {**_named("output", "what a run returns and writes"), "type": ["object", "null"]},
    }
    head = {
        "graphtex": {"const": FORMAT, "description": "the format's version"},
        "title": {"type": "string", "description": "a line on what the graph does"},
        "source": {"type": "string", "description": "the publication that the graph follows"},
        "description": {"type": "string", "description": "what a reader should know"},
        "seed": {"type": "integer", "minimum": 0, "default": 0, "description": "of all random streams"},
    }
    graph = _mapping({**head, **sections}, ["graphtex", "nodes"], "a graph of texture synthesis nodes")
    schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "graphtex graph file"}
    return {**schema, **graph, "$defs": definitions}


def _mapping(properties: Schema, required: list[str], description: str) -> Schema:
    closed: Schema = {"type": "object", "properties": properties, "additionalProperties": False}
    return {"description": description, **closed, **({"required": required} if required else {})}


def _named(definition: str, description: str) -> Schema:
    names = {"pattern": f"^{NAME.pattern}$"}
    items = {"$ref": f"#/$defs/{definition}"}
    return {"description": description, "type": "object", "propertyNames": names, "additionalProperties": items}


def _input() -> Schema:
    types: list[Schema] = []
    rules: list[Schema] = []
    for name in (*SCALAR_TYPES, *TYPES):
        one, summary = _SCALARS[name] if name in SCALAR_TYPES else _openable(TYPES[name])
        several: Schema = {"type": "array", "items": one}
        if name in TYPES or name == "file":
            several = {"anyOf": [several, {"type": "string", "description": "a folder or a pattern"}]}
        for kind, default, text in ((name, one, summary), (f"list[{name}]", several, f"a list: {summary}")):
            types.append({"const": kind, "description": text})
            if default:
                rules.append(_if_const("type", kind, {"properties": {"default": default}}))
    properties = {
        "type": {"anyOf": types, "description": "what the input takes"},
        "default": {"description": "taken where a run gives no value; without it a value is required"},
        "min": {"type": "number", "description": "the least number allowed"},
        "max": {"type": "number", "description": "the greatest number allowed"},
        "choices": {"type": "array", "minItems": 1, "description": "the values allowed"},
        "open": {"type": "object", "description": "parameters of the node that opens a file, such as LoadImage"},
        "description": {"type": "string", "description": "what the input is for"},
    }
    return {**_mapping(properties, ["type"], "a graph input"), "allOf": rules}


def _openable(kind: SocketType) -> tuple[Schema, str]:
    return {"type": "string", "description": f"a path or scheme:name to open as {kind.name}"}, kind.summary


def _if_const(key: str, value: str, then: Schema) -> Schema:
    return {"if": {"properties": {key: {"const": value}}, "required": [key]}, "then": then}


def _entry(nodes: Iterable[Node[Any, Any]]) -> Schema:
    names = [{"const": node.name, "description": node.summary} for node in nodes]
    branches = [_if_const("node", name["const"], {"$ref": f"#/$defs/node.{name['const']}"}) for name in names]
    branches.append({"if": {"required": ["graph"]}, "then": {"$ref": "#/$defs/subgraph"}})
    return {
        "type": "object",
        "description": "a node by its name, or another graph by its file, with its arguments",
        "properties": {
            "node": {"description": "the node's name", **({"anyOf": names} if names else {"type": "string"})},
            "graph": {"type": "string", "minLength": 1, "description": "a graph file, relative to this one"},
        },
        "oneOf": [{"required": ["node"]}, {"required": ["graph"]}],
        "allOf": branches,
    }


def _own_words() -> Schema:
    return {"seed": {"$ref": "#/$defs/seed"}, "on_error": {"$ref": "#/$defs/onError"}}


def _subgraph() -> Schema:
    ranges = {"anyOf": [_INPUT_REFERENCE, {"type": "array", "minItems": 1}]}
    each = {"type": "object", "additionalProperties": ranges, "description": "inputs to range over, each a list"}
    description = "another graph as a node; its arguments are that graph's inputs"
    return {"type": "object", "description": description, "properties": {"each": each, **_own_words()}}


def _node(node: Node[Any, Any]) -> Schema:
    """Return the definitions of a node and of the models in its parameters."""
    model, definitions = _model(node.parameters, f"node.{node.name}")
    texts = docstrings.section(node.function.__doc__, "Parameters")
    arguments: Schema = {name: _socket(socket) for name, socket in node.inputs.items()}
    ranges: Schema = {name: _range({"type": "string"}, arguments[name]["description"]) for name in node.inputs}
    for name, own in model.items():
        own.setdefault("description", texts.get(name) or f"{name} of {node.name}")
        arguments[name] = _parameter(
            own, measured=not json_types(node.parameters, name).isdisjoint({"integer", "number"})
        )
        ranges[name] = _range({key: value for key, value in own.items() if key != "default"}, own["description"])
    ranges["seed"] = _range({"type": "integer", "minimum": 0}, "variants of the random stream")
    required = [name for name, socket in node.inputs.items() if not socket.optional]
    required += [name for name, info in node.parameters.model_fields.items() if info.is_required()]
    each = _mapping(ranges, [], "arguments to range over, each a list; the node runs for every combination")
    entry = _mapping({"node": {"const": node.name}, **arguments, "each": each, **_own_words()}, ["node"], node.summary)
    if required:
        entry["allOf"] = [_given(name) for name in required]
    return {f"node.{node.name}": entry, **definitions}


def _given(name: str) -> Schema:
    """An argument stands in the entry itself or in its `each`."""
    ranged = {"properties": {"each": {"required": [name]}}, "required": ["each"]}
    return {"anyOf": [{"required": [name]}, ranged]}


def _socket(socket: Socket) -> Schema:
    text = f"{socket.type}{', may be left out' if socket.optional else ''}"
    described = {"description": f"{text}: {socket.doc}" if socket.doc else text}
    if socket.type.many:
        return {**described, "anyOf": [_REFERENCE, {"type": "array", "items": _REFERENCE}]}
    return {**described, **_REFERENCE}


def _parameter(own: Schema, *, measured: bool) -> Schema:
    outer: Schema = {key: own[key] for key in ("description", "default") if key in own}
    inner = {key: value for key, value in own.items() if key not in outer}
    others = [_INPUT_REFERENCE, *([{"$ref": "#/$defs/measured"}] if measured else [])]
    return {**outer, "anyOf": [inner, *others]}


def _range(item: Schema, description: str) -> Schema:
    return {"description": description, "anyOf": [_INPUT_REFERENCE, {"type": "array", "minItems": 1, "items": item}]}


def _output() -> Schema:
    """Return the definitions of an output and of the models in its formats' options."""
    options: dict[str, list[Schema]] = {}
    definitions: Schema = {}
    for (kind, suffix), writer in sorted(WRITERS.items(), key=lambda item: item[0]):
        own, inner = _model(writer.options, f"writer.{kind}{suffix}")
        definitions |= inner
        for name, schema in own.items():
            known = options.setdefault(name, [])
            if schema not in known:
                known.append(schema)
    keys = {name: one[0] if len(one) == 1 else {"anyOf": one} for name, one in options.items()}
    file = {"type": "string", "minLength": 1, "description": "the file's name; its ending chooses the format"}
    full = _mapping({"from": _REFERENCE, "file": file, **keys}, ["from"], "an output with its file's name and format")
    output = {"description": "a reference, or a mapping with the file's name", "anyOf": [_REFERENCE, full]}
    return {"output": output, **definitions}


def _model(model: type[BaseModel], prefix: str) -> tuple[Schema, Schema]:
    """Return the schemas of a model's fields, and of the models in them under prefixed names."""
    whole = model.model_json_schema(ref_template=f"#/$defs/{prefix}.{{model}}")
    inner = {f"{prefix}.{name}": _untitled(schema) for name, schema in whole.get("$defs", {}).items()}
    return {name: _untitled(schema) for name, schema in whole.get("properties", {}).items()}, inner


def _untitled(schema: Any) -> Any:
    """Drop the titles that pydantic makes of names: editors would show them in place of the description."""
    if isinstance(schema, list):
        return [_untitled(item) for item in schema]
    if not isinstance(schema, Mapping):
        return schema
    kept = {key: value for key, value in schema.items() if key != "title" or not isinstance(value, str)}
    verbatim = ("default", "const", "enum", "examples")
    cleaned: Schema = {}
    for key, value in kept.items():
        if key == "properties":
            cleaned[key] = {name: _untitled(inner) for name, inner in value.items()}
        else:
            cleaned[key] = value if key in verbatim else _untitled(value)
    return cleaned
