"""``graphtex nodes``: the list, and all that is needed to use one node."""

import json
from dataclasses import replace
from typing import Any

import pytest

from graphtex.check import check
from graphtex.cli.describe import example, kind_of, sample, written
from graphtex.files import read, read_scalar
from graphtex.packs import Registry, registry
from tests.graphtex.cli.conftest import Command

PARTS = """\
Parts: Part a picture.

pack pack, version 1, not random
in Python: from tests.graphtex.cli.pack import parts

Inputs
  image  Image            What is parted.
  mask   Mask (optional)  True marks the feature, foreground or hole that a node names

Parameters
  method  hard or soft              default hard  how it is parted
  levels  list of at least 1 [int]  required      At which greys.
  folder  file or null              default null

Outputs
  dark    Image  The dark part.
  bright  Mask   True where it is bright.

Example
  parts:
    node: Parts
    image: some_image
    method: hard
    levels: [1]

Documentation
  Parameters
"""


def test_the_list_is_grouped_and_has_summaries(command: Command) -> None:
    told = command("nodes")
    lines = told.out.splitlines()
    assert lines[0] == "pack / graphtex"
    assert "  Brighten  Add to a picture; warn where it becomes too bright." in lines
    names = [line.split()[0] for line in lines[1:]]
    assert names == sorted(names)
    assert told.err == f"{len(names)} nodes; graphtex nodes NAME tells how one is used\n"


def test_one_node_is_told_in_full(command: Command) -> None:
    assert command("nodes", "Parts").out.startswith(PARTS)
    noise = command("nodes", "Noise").out
    assert "version 3, random: its result depends on the seed" in noise
    assert "Inputs: none" in noise
    assert "Longer text about greys." in command("nodes", "Flat").out
    assert "  value  float, >= 0  default 0.5  its grey" in command("nodes", "Flat").out


@pytest.mark.parametrize("name", ["OpenNum", "opennum", "open_num", "open-num"])
def test_a_node_is_found_in_other_spellings(command: Command, name: str) -> None:
    assert command("nodes", name).out.startswith("OpenNum: ")


def test_an_unknown_node(command: Command) -> None:
    told = command("nodes", "Nois")
    assert (told.status, told.err) == (2, "unknown node 'Nois'; did you mean 'Noise'?\n")


def test_json_has_the_same_as_data(command: Command, registry: Registry) -> None:
    one = json.loads(command("nodes", "Parts", "--json").out)
    assert (one["name"], one["pack"], one["version"], one["random"]) == ("Parts", "pack", 1, False)
    assert one["inputs"]["mask"]["optional"] is True
    assert one["inputs"]["mask"]["type"] == "Mask"
    assert list(one["outputs"]) == ["dark", "bright"]
    assert one["parameters"]["properties"]["method"]["enum"] == ["hard", "soft"]
    assert one["example"].startswith("parts:\n  node: Parts\n")
    every = json.loads(command("nodes", "--json").out)
    assert [each["name"] for each in every] == sorted(registry.nodes)
    assert one in every


def test_broken_packs_are_reported_and_the_others_work(
    command: Command, registry: Registry, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = replace(registry, broken=("pack 'bad' (bad) did not load: ImportError: no",))
    monkeypatch.setattr("graphtex.packs.registry", lambda: broken)
    told = command("nodes")
    assert told.status == 0
    assert told.err.splitlines()[0] == "warning: pack 'bad' (bad) did not load: ImportError: no"
    assert "Flat" in told.out


@pytest.mark.parametrize("name", sorted(registry().nodes))
def test_the_example_of_every_installed_node_is_a_right_entry_but_for_what_feeds_it(name: str) -> None:
    entry = "\n".join(f"  {line}" for line in example(registry().nodes[name]).splitlines())
    graph, problems = read(f"graphtex: 1\nnodes:\n{entry}\n")
    assert problems == []
    assert graph is not None
    wrong = [problem.message for problem in check(graph) if not problem.message.startswith("unknown node 'some_")]
    assert wrong == []


@pytest.mark.parametrize(
    ("schema", "words"),
    [
        ({"type": "string"}, "str"),
        ({"type": "string", "format": "path"}, "file"),
        ({"type": "number", "exclusiveMinimum": 0, "maximum": 0.5}, "float, <= 0.5, > 0"),
        ({"anyOf": [{"type": "integer"}, {"type": "null"}]}, "int or null"),
        ({"type": "array", "items": {"type": "number"}}, "list [float]"),
        ({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2}, "list of 2 [float]"),
        ({"type": "array", "items": {"type": "number"}, "maxItems": 4}, "list of 0 to 4 [float]"),
        ({"type": "array", "prefixItems": [{"type": "integer"}, {"type": "string"}]}, "[int; str]"),
        ({"$ref": "#/$defs/Dot"}, "{x: float, >= 0}"),
        ({"const": 3}, "3"),
        ({}, "any"),
    ],
)
def test_kinds(schema: dict[str, Any], words: str) -> None:
    models = {"Dot": {"properties": {"x": {"type": "number", "minimum": 0}}, "required": ["x"]}}
    assert sorted(kind_of(schema, models).split(", ")) == sorted(words.split(", "))


TAGGED = {"propertyName": "is", "mapping": {"line": "#/$defs/Line", "dot": "#/$defs/Dot"}}


@pytest.mark.parametrize(
    ("schema", "value"),
    [
        ({"type": "integer", "minimum": 8}, 8),
        ({"type": "number", "exclusiveMinimum": 0, "maximum": 0.5}, 0.25),
        ({"type": "number", "exclusiveMinimum": 0}, 1),
        ({"type": "number", "maximum": -3}, -3),
        ({"enum": ["a", "b"]}, "a"),
        ({"type": "boolean"}, True),
        ({"$ref": "#/$defs/Dot"}, {"x": 0}),
        ({"oneOf": [{"$ref": "#/$defs/Dot"}], "discriminator": TAGGED}, {"is": "dot", "x": 0}),
        ({"type": "array", "items": {"type": "boolean"}, "minItems": 2}, [True, True]),
    ],
)
def test_sample_values_fit(schema: dict[str, Any], value: Any) -> None:
    models = {"Dot": {"properties": {"x": {"type": "number", "minimum": 0}, "y": {}}, "required": ["x"]}}
    assert sample(schema, models) == value


@pytest.mark.parametrize("value", ["plain", "no", "12", "1e3", "null", "a, b", "{x}", "", "x: y", "'", "#", "$a", " a"])
def test_texts_are_written_so_that_they_read_back(value: str) -> None:
    assert read_scalar(f"[{written(value)}]") == [value]


def test_data_is_written_in_flow_form() -> None:
    value = {"a": [1, 2.5, True, None], "b": {"c": "no, thanks"}}
    assert written(value) == '{a: [1, 2.5, true, null], b: {c: "no, thanks"}}'
    assert read_scalar(written(value)) == value
