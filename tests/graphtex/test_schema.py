import json
from pathlib import Path

import jsonschema
import pytest

from graphtex.files.yamltree import parse
from graphtex.graph import loads
from graphtex.json_types import json_types
from graphtex.node import RESERVED
from graphtex.packs import registry
from graphtex.schema import graph_schema
from tests.graphtex.conftest import make_only_pack

SHIPPED = sorted((Path(__file__).parents[2] / "graphs").rglob("*.yaml"))

RIGHT = """
graphtex: 1
title: Everything at once
seed: 3
inputs:
  picture: {type: Image, default: "made:stone", description: what to look at}
  pictures: {type: "list[Image]", default: ["made:a", b.tex]}
  folder: {type: "list[Image]", default: photos}
  width: {type: int, default: 8, min: 1, max: 64}
  level: {type: float, default: 1}
  levels: {type: "list[float]", default: [0.25, 1]}
  method: {type: str, default: fixed, choices: [fixed, adaptive]}
  free: {type: data}
nodes:
  noise: {node: Noise, width: $width, seed: 5}
  many: {node: Noise, each: {width: [4, 8], seed: [1, 2]}, on_error: keep}
  mean: {node: Average, image: noise}
  mask: {node: Threshold, image: $picture, level: {from: mean}, method: $method}
  sweep: {node: Threshold, image: noise, each: {level: $levels, method: [fixed, adaptive]}}
  each: {node: Spread, mask: mask, window: 2}
  layers: {node: Split, image: noise}
  mix: {node: Blend, images: [layers.base, layers.detail, $picture], mask: mask, weights: [1, 2.5, 3]}
  mix2: {node: Blend, images: $pictures, weights: null}
  lines: {node: Paint, image: noise, strokes: [{points: [[0, 1], [2, 3.5]], radius: 2}], closed: true}
  name: {node: Label, image: noise, text: $$5, tags: {a: b}}
  over: {node: Label, text: x, each: {image: ["made:a", b.tex]}}
outputs:
  image: mix
  scale: {from: layers.base, file: base.tex, digits: 4}
  given: $picture
"""


@pytest.fixture(scope="module")
def validator():
    with pytest.MonkeyPatch.context() as patch:
        make_only_pack(patch)
        schema = graph_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(json.loads(json.dumps(schema)))


def test_the_full_check_finds_a_right_graph_right(small_pack):
    loads(RIGHT)


def test_a_right_graph_is_valid(validator):
    assert [error.message for error in validator.iter_errors(parse(RIGHT).data)] == []


@pytest.mark.parametrize(
    ("part", "instead"),
    [
        ("graphtex: 1", "graphtex: 2"),
        ("graphtex: 1", "title: no version"),
        ("seed: 3", "seed: -3"),
        ("seed: 3", "sed: 3"),
        ("{type: int, default: 8", "{type: int, default: 8.5"),
        ("{type: int, default: 8", "{type: Imag, default: 8"),
        ("{type: int, default: 8", "{default: 8"),
        ("{type: int, default: 8", "{type: int, defualt: 8"),
        ('default: "made:stone"', "default: 5"),
        ("default: [0.25, 1]", "default: 0.25"),
        ("choices: [fixed, adaptive]", "choices: fixed"),
        ("node: Noise, width: $width", "node: Nois, width: $width"),
        ("width: $width", "widht: $width"),
        ("width: $width", "height: 3"),
        ("width: $width", "width: 0"),
        ("width: $width", "width: wide"),
        ("width: $width", "width: $$"),
        ("seed: 5", "seed: x"),
        ("on_error: keep", "on_error: go_on"),
        ("width: [4, 8]", "width: []"),
        ("width: [4, 8]", "width: [4, 0]"),
        ("width: [4, 8]", "widht: [4, 8]"),
        ("Average, image: noise}", "Average, image: 0.5}"),
        ("Average, image: noise}", "Average, image: [noise]}"),
        ("Average, image: noise}", "Average, image: noise.a.b}"),
        ("level: {from: mean}", "level: {from: mean, of: x}"),
        ("method: $method", "method: best"),
        ("method: [fixed, adaptive]", "method: [fixed, best]"),
        ("images: [layers.base, layers.detail, $picture]", "images: [1, 2]"),
        ("weights: [1, 2.5, 3]", "weights: [a, b]"),
        ("{points: [[0, 1], [2, 3.5]], radius: 2}", "{points: [[0, 1, 5]]}"),
        ("{points: [[0, 1], [2, 3.5]], radius: 2}", "{points: [], radius: 0}"),
        ("{points: [[0, 1], [2, 3.5]], radius: 2}", "{radius: 2}"),
        ("closed: true", "closed: 1"),
        ("{node: Split, image: noise}", "{image: noise}"),
        ("{node: Split, image: noise}", "{node: Split, graph: x.yaml, image: noise}"),
        ("{node: Split, image: noise}", "{graph: 5, image: noise}"),
        ("{node: Split, image: noise}", "{graph: x.yaml, each: {a: b}}"),
        ("{node: Split, image: noise}", "Split"),
        ("layers: {", "my layers: {"),
        ("image: mix\n", "image: [mix]\n"),
        ("digits: 4", "digits: 40"),
        ("digits: 4", "digit: 4"),
        ("from: layers.base, file", "source: layers.base, file"),
    ],
)
def test_a_wrong_graph_is_not(validator, part, instead):
    assert RIGHT.count(part) == 1
    data = parse(RIGHT.replace(part, instead)).data
    assert not validator.is_valid(data)


def test_a_sub_graph_takes_any_arguments(validator):
    entry = {
        "graph": "../splice.yaml",
        "elements": ["a", "$b"],
        "depth": 4,
        "each": {"x": "$y", "z": [1]},
        "seed": "$s",
    }
    assert validator.is_valid({"graphtex": 1, "nodes": {"a": entry}})


def test_sections_without_anything_in_them(validator):
    nodes = {"a": {"node": "Noise", "width": 4}}
    assert validator.is_valid({"graphtex": 1, "inputs": None, "outputs": None, "nodes": nodes})
    assert not validator.is_valid({"graphtex": 1, "nodes": {}})
    assert not validator.is_valid({"graphtex": 1})


def test_every_node_and_argument_is_described(small_pack):
    definitions = graph_schema()["$defs"]
    names = {option["const"]: option["description"] for option in definitions["entry"]["properties"]["node"]["anyOf"]}
    assert names["Threshold"] == "Mark what is bright."
    assert set(names) == set(small_pack.nodes)
    for name, node in small_pack.nodes.items():
        properties = definitions[f"node.{name}"]["properties"]
        assert set(properties) == {"node", *node.inputs, *node.parameters.model_fields} | (RESERVED - {"graph"})
        for key in (*node.inputs, *node.parameters.model_fields, "each"):
            assert properties[key]["description"]


def test_what_is_known_of_a_parameter_is_in_the_schema(small_pack):
    properties = graph_schema()["$defs"]["node.Threshold"]["properties"]
    assert properties["image"]["description"] == "Image: The picture whose first channel counts."
    level = properties["level"]
    assert (level["description"], level["default"]) == ("what is above it is True", 0.5)
    assert level["anyOf"][0] == {"type": "number", "minimum": 0, "maximum": 1}
    assert properties["method"]["anyOf"][0] == {"type": "string", "enum": ["fixed", "adaptive"]}
    assert properties["each"]["properties"]["level"]["description"] == "what is above it is True"


def test_only_a_parameter_that_takes_numbers_can_be_measured(small_pack):
    definitions = graph_schema()["$defs"]
    measured = {"$ref": "#/$defs/measured"}
    assert measured in definitions["node.Threshold"]["properties"]["level"]["anyOf"]
    assert measured not in definitions["node.Threshold"]["properties"]["method"]["anyOf"]


@pytest.mark.parametrize(
    ("node", "parameter", "types"),
    [
        ("Noise", "width", {"integer"}),
        ("Threshold", "level", {"number", "integer"}),
        ("Threshold", "method", {"string"}),
        ("Blend", "weights", {"array", "null"}),
        ("Paint", "strokes", {"array"}),
        ("Paint", "closed", {"boolean"}),
        ("Label", "tags", {"object", "null"}),
        ("OpenText", "path", {"string"}),
    ],
)
def test_json_types(small_pack, node, parameter, types):
    assert json_types(small_pack.nodes[node].parameters, parameter) == types


def test_models_of_two_nodes_do_not_mix(small_pack):
    definitions = graph_schema()["$defs"]
    assert definitions["node.Paint.Stroke"]["properties"]["points"]["description"] == "(x, y) in pixels"


def test_the_installed_nodes_give_a_schema():
    schema = graph_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    assert {f"node.{name}" for name in registry().nodes} <= set(schema["$defs"])


def test_shipped_graphs_are_valid():
    validator = jsonschema.Draft202012Validator(graph_schema())
    errors = [
        (p.name, e.json_path, e.message) for p in SHIPPED for e in validator.iter_errors(parse(p.read_text()).data)
    ]
    assert errors == []
