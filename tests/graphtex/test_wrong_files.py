"""Mistakes that people make in graph files: for each, where it is told and in which words.

``‸`` stands in front of each place that must be named; it is taken out before the file is read. A case gives one
fragment of a message for each mark, in order, and nothing else may be told.
"""

import re

import pytest

from graphtex.errors import GraphError
from graphtex.graph import load

MARK = "‸"
HEAD = "graphtex: 1\n"
NOISE = "  n: {node: Noise, width: 4}\n"  # gives an Image
MASK = "  m: {node: Threshold, image: n}\n"  # gives a Mask

FORM = {
    "not a mapping": ("‸- node: Noise\n", "a graph file is a mapping that begins with `graphtex: 1`, got a list of 1"),
    "empty": ("‸", "got an empty file"),
    "colon without space": ("‸graphtex:1\n", "a space is needed after the colon: `graphtex: 1`"),
    "no version": ("‸nodes:\n" + NOISE, "the format's version is missing: write `graphtex: 1`"),
    "version misspelt": ("‸‸graphtec: 1\nnodes:\n" + NOISE, "(instead there is 'graphtec')", "unknown key 'graphtec'; did you mean 'graphtex'?"),
    "version as text": ('graphtex: ‸"1"\nnodes:\n' + NOISE, "the format's version is a whole number, got the text '1'"),
    "version with a point": ("graphtex: ‸1.0\nnodes:\n" + NOISE, "a whole number, got the number 1.0"),
    "newer version": ("graphtex: ‸99\nwhatever: true\n", "this file needs a newer graphtex: it has format 99"),
    "older version": ("graphtex: ‸0\nnodes:\n" + NOISE, "there is no format 0"),
    "no nodes": ("‸graphtex: 1\ntitle: x\n", "the key `nodes` is missing"),
    "nodes misspelt": ("‸graphtex: 1\n‸node:\n" + NOISE, "(instead there is 'node')", "unknown key 'node'; did you mean 'nodes'?"),
    "nodes as a list": (HEAD + "nodes:\n  ‸- {node: Noise, width: 4}\n", "write the name in place of the '-'"),
    "nodes empty": (HEAD + "nodes:‸\n", "a graph has at least one node"),
    "inputs as text": (HEAD + "inputs: ‸exemplar\nnodes:\n" + NOISE, "expected a mapping, `name: {type: Image}`, got the text 'exemplar'"),
    "input as text": (HEAD + 'inputs:\n  exemplar: ‸"made:stone"\nnodes:\n' + NOISE, "expected a mapping, `{type: Image}`, got the text 'made:stone'"),
    "input without type": (HEAD + "inputs:\n  width: ‸{default: 4}\nnodes:\n" + NOISE, "the key `type` is missing"),
    "input type as a list": (HEAD + "inputs:\n  p: {type: ‸[Image]}\nnodes:\n" + NOISE, 'a list of pictures is written "list[Image]"'),
    "list type without quotes": (HEAD + "inputs:\n  p: {type: list‸[Image]}\nnodes:\n" + NOISE, 'needs quotes, as in type: "list[Image]"'),
    "unknown key of an input": (HEAD + "inputs:\n  w: {type: int, ‸defualt: 4}\nnodes:\n" + NOISE, "unknown key 'defualt'; did you mean 'default'?"),
    "bound as text": (HEAD + "inputs:\n  w: {type: int, min: ‸one, max:‸ }\nnodes:\n" + NOISE, "min is a number, got the text 'one'", "max is a number, got nothing"),
    "choices as text": (HEAD + "inputs:\n  w: {type: str, choices: ‸ridges}\nnodes:\n" + NOISE, "choices are a list with at least one item, got the text 'ridges'"),
    "no choices": (HEAD + "inputs:\n  w: {type: str, choices: ‸[]}\nnodes:\n" + NOISE, "choices are a list with at least one item"),
    "title as a number": (HEAD + "title: ‸2008\nnodes:\n" + NOISE, "title is text, got the number 2008; quote it"),
    "title with a colon": (HEAD + "title: Stone‸: a study\nnodes:\n" + NOISE, "text with ': ' in it needs quotes"),
    "description as a list": (HEAD + "description:\n  ‸- a\nnodes:\n" + NOISE, "description is text, got a list of 1"),
    "negative seed": (HEAD + "seed: ‸-1\nnodes:\n" + NOISE, "a seed is a whole number from 0, got the number -1"),
    "seed as text": (HEAD + "seed: ‸seven\nnodes:\n" + NOISE, "a seed is a whole number from 0, got the text 'seven'"),
    "seed true": (HEAD + "seed: ‸true\nnodes:\n" + NOISE, "a seed is a whole number from 0, got true"),
    "seed from an input": (HEAD + "seed: ‸$s\nnodes:\n" + NOISE, "an input can be the seed of a node, not of the graph"),
    "unknown key": (HEAD + "‸autor: me\nnodes:\n" + NOISE, "unknown key 'autor'"),
    "name with a space": (HEAD + "nodes:\n  ‸my noise: {node: Noise, width: 4}\n", "a name is letters, digits, _ and -, and begins with a letter or _; got 'my noise'"),
    "name with a dot": (HEAD + "nodes:\n  ‸n.a: {node: Noise, width: 4}\n", "got 'n.a'"),
    "name as a number": (HEAD + "nodes:\n" + NOISE + "  ‸1: {node: Noise, width: 4}\n", "a key is text, got the number 1; quote it"),
    "node as text": (HEAD + "nodes:\n  n: ‸Noise\n", "got the text 'Noise'; write {node: Noise}"),
    "node without space": (HEAD + "nodes:\n  n: ‸node:Noise\n", "a space is needed after the colon: `node: Noise`"),
    "node without space in braces": (HEAD + "nodes:\n  n: ‸{node:Noise, width: 4}\n", "a space is needed after the colon: `node: Noise`"),
    "node as nothing": (HEAD + "nodes:\n  n:‸\n", "expected a mapping, `{node: FeatureMask, ...}`, got nothing"),
    "neither node nor graph": (HEAD + "nodes:\n  n: ‸{type: Noise, width: 4}\n", "expected `node: <name>` or `graph: <file>`, got neither (instead there is 'type')"),
    "both node and graph": (HEAD + "nodes:\n  n: {node: Noise, width: 4, ‸graph: x.yaml}\n", "an entry is either a `node` or a `graph`, got both"),
    "node's name as a list": (HEAD + "nodes:\n  n: {node: ‸[Noise], width: 4}\n", "expected the name of a node, got a list of 1"),
    "each as a list": (HEAD + "nodes:\n  n: {node: Noise, width: 4, each: ‸[4, 8]}\n", "each is a mapping of arguments to lists"),
    "on_error misspelt": (HEAD + "nodes:\n  n: {node: Noise, width: 4, on_error: ‸continue}\n", "on_error is stop or keep, got the text 'continue'"),
    "seed of a node as nothing": (HEAD + "nodes:\n  n: {node: Noise, width: 4, seed:‸ }\n", "a seed is a whole number from 0 or $input, got nothing"),
    "output as a list": (HEAD + "nodes:\n" + NOISE + "outputs:\n  image: ‸[n]\n", "expected node.socket or {from: node.socket, ...}, got a list of 1; give each of them an output of its own"),
    "output without from": (HEAD + "nodes:\n" + NOISE + "outputs:\n  image: ‸{file: a.tex}\n", "the key `from` is missing"),
    "outputs as a list": (HEAD + "nodes:\n" + NOISE + "outputs:\n  ‸- n\n", "write the name in place of the '-'"),
    "output's file as a number": (HEAD + "nodes:\n" + NOISE + "outputs:\n  image: {from: n, file: ‸5}\n", "expected a file's name, got the number 5"),
    "duplicate node": (HEAD + "nodes:\n" + NOISE + "  ‸n: {node: Noise, width: 5}\n", "the key 'n' is there twice, first at 3:3"),
    "duplicate argument": (HEAD + "nodes:\n  n: {node: Noise, width: 4, ‸width: 5}\n", "the key 'width' is there twice"),
    "tab": (HEAD + "nodes:\n‸\tn: {node: Noise, width: 4}\n", "a tab; YAML is indented and separated by spaces"),
    "quote not closed": (HEAD + "title: ‸'Stone\nnodes:\n" + NOISE, "this quoted text is not closed"),
    "brace not closed": (HEAD + "nodes:\n  n: ‸{node: Noise, width: 4\n", "this '{' is not closed by '}'"),
    "bad indentation": (HEAD + "nodes:\n    n: {node: Noise, width: 4}\n  ‸b: {node: Noise, width: 4}\n", "the indentation does not fit"),
    "tag": (HEAD + "nodes:\n  n: ‸!!python/object:os.system {node: Noise, width: 4}\n", "tags are not part of a graph file"),
    "alias": (HEAD + "nodes:\n  n: ‸&base {node: Noise, width: 4}\n  b: ‸*base\n", "anchors and aliases", "anchors and aliases"),
    "merge": (HEAD + "nodes:\n  n: {node: Noise, width: 4, ‸<<: {height: 3}}\n", "merge keys"),
    "second document": (HEAD + "nodes:\n" + NOISE + "‸---\n" + HEAD, "a second document begins here"),
    "pattern without quotes": (HEAD + 'inputs:\n  p: {type: "list[Image]", default: ‸*.tex}\nnodes:\n' + NOISE, "text that begins with '*' needs quotes"),
}  # fmt: skip

MEANING = {
    "unknown node": ("  n: {node: ‸Nois, width: 4}\n", "unknown node 'Nois'; did you mean 'Noise'?"),
    "function's name for the node's": (NOISE + "  a: {node: ‸open_text, path: x.tex}\n", "did you mean 'OpenText'?"),
    "unknown argument": ("  n: {node: Noise, width: 4, ‸heigth: 4}\n", "no argument 'heigth'; did you mean 'height'?"),
    "missing parameter": ("  n: ‸{node: Noise}\n", "width: a value is required"),
    "missing socket": ("  m: ‸{node: Threshold, level: 0.5}\n", "needs image"),
    "text for a number": ("  n: {node: Noise, width: ‸wide}\n", "should be a valid integer"),
    "float for an integer": ("  n: {node: Noise, width: ‸4.5}\n", "should be a valid integer"),
    "quoted number": ('  n: {node: Noise, width: ‸"4"}\n', "should be a valid integer, got '4'"),
    "YAML 1.1 words": (NOISE + "  p: {node: Paint, image: n, strokes: [], closed: ‸yes}\n", "should be true or false, got 'yes'"),
    "number too large": ("  n: {node: Noise, width: ‸5000}\n", "should be less than or equal to 4096, got 5000"),
    "number too small": (NOISE + "  m: {node: Threshold, image: n, level: ‸-0.5}\n", "greater than or equal to 0, got -0.5"),
    "not a number": (NOISE + "  m: {node: Threshold, image: n, level: ‸.nan}\n", "finite number"),
    "no such choice": (NOISE + "  m: {node: Threshold, image: n, method: ‸adaptiv}\n", "should be 'fixed' or 'adaptive', got 'adaptiv'; did you mean 'adaptive'?"),
    "inside of a nested parameter": (NOISE + "  p: {node: Paint, image: n, strokes: [{points: [[1, 2]], radius: ‸0}]}\n", "greater than 0, got 0"),
    "unknown key of a nested parameter": (NOISE + "  p: {node: Paint, image: n, strokes: [{points: [], ‸width: 3}]}\n", "unknown parameter 'width'"),
    "unknown reference": (NOISE + "  m: {node: Threshold, image: ‸noise}\n", "unknown node 'noise'"),
    "unknown socket": ("  n: {node: Noise, width: 4}\n  m: {node: Threshold, image: ‸n.image}\n", "no output 'image'"),
    "unknown socket with a near one": (NOISE + "  s: {node: Split, image: n}\n  m: {node: Threshold, image: ‸s.detial}\n", "no output 'detial'; did you mean 'detail'?"),
    "one of several outputs": (NOISE + "  s: {node: Split, image: n}\n  m: {node: Threshold, image: ‸s}\n", "several outputs; write one of s.base, s.detail"),
    "type mismatch": (NOISE + MASK + "  x: {node: Threshold, image: ‸m}\n", "expected Image, got Mask"),
    "sample in a socket's place": ('  m: {node: Threshold, image: ‸"made:x"}\n', "unknown node 'made:x'; nodes: m; a file or a sample is the default of a graph input"),
    "file in a socket's place": ("  m: {node: Threshold, image: ‸photo.tex}\n", "unknown node 'photo'; nodes: m; a file or a sample is the default of a graph input"),
    "literal in a socket's place": ("  m: {node: Threshold, image: ‸0.5}\n", "expected a reference: node, node.socket or $input, got 0.5"),
    "measured form in a socket's place": (NOISE + "  m: {node: Threshold, image: ‸{from: n}}\n", "expected a reference"),
    "nothing in a socket's place": (NOISE + "  b: {node: Blend, images: [n], mask:‸ }\n", "expected a reference"),
    "itself": ("  ‸m: {node: Blend, images: [m]}\n", "circle: m -> m"),
    "cycle": (NOISE + "  ‸a: {node: Blend, images: [b]}\n  b: {node: Blend, images: [n, a]}\n", "circle: a -> b -> a"),
    "list for a single socket": (NOISE + "  m: {node: Threshold, image: ‸[n, n]}\n", "expected one Image, got a list of 2"),
    "single for a list socket": (NOISE + "  b: {node: Blend, images: ‸n}\n", "expected list[Image], got Image; write a list"),
    "wrong item in a list": (NOISE + MASK + "  b: {node: Blend, images: [n, ‸m, ‸7, ‸x]}\n", "expected Image, got Mask", "expected a reference", "unknown node 'x'"),
    "list of lists": (NOISE + "  b: {node: Blend, images: [‸[n]]}\n", "expected a reference"),
    "reference in a parameter's place": (NOISE + "  a: {node: Average, image: n}\n  m: {node: Threshold, image: n, level: ‸a}\n", "a measured number is written {from: a}"),
    "measured from an image": (NOISE + "  m: {node: Threshold, image: n, level: ‸{from: n}}\n", "fed by a Number, got Image"),
    "measured from nowhere": (NOISE + "  m: {node: Threshold, image: n, level: ‸{from: a}}\n", "unknown node 'a'"),
    "measured number for text": (NOISE + "  a: {node: Average, image: n}\n  l: {node: Label, image: n, text: ‸{from: a}}\n", "takes no number"),
    "unknown input in a parameter": ("  n: {node: Noise, width: ‸$widht}\n", "unknown graph input $widht"),
    "unknown input in a socket": ("  m: {node: Threshold, image: ‸$exemplar}\n", "unknown graph input $exemplar"),
    "input inside of a parameter": (NOISE + "  l: {node: Label, image: n, text: x, tags: {a: ‸$t}}\n", "can only be a whole argument"),
    "each over an unknown argument": ("  n: {node: Noise, width: 4, each: {‸heigth: [4]}}\n", "no argument 'heigth'; did you mean 'height'?"),
    "each over nothing": ("  n: {node: Noise, each: {width: ‸[]}}\n", "a list with at least one item"),
    "each over a number": ("  n: {node: Noise, each: {width: ‸4}}\n", "a list with at least one item"),
    "each over a computed list": (NOISE + "  m: {node: Threshold, each: {image: ‸n}}\n", "computed values cannot be ranged over"),
    "each over computed items": (NOISE + "  m: {node: Threshold, each: {image: [‸n]}}\n", "computed values cannot be ranged over"),
    "each with a wrong item": ("  n: {node: Noise, each: {width: [4, ‸0, ‸x]}}\n", "greater than or equal to 1, got 0", "valid integer"),
    "each and beside it": ("  n: {node: Noise, width: 4, each: {‸width: [4, 5]}}\n", "width is given twice"),
    "each over a bad seed": ("  n: {node: Noise, width: 4, each: {seed: [1, ‸-1]}}\n", "a seed is a whole number from 0, got -1"),
    "each over a node's words": ("  n: {node: Noise, width: 4, each: {‸on_error: [stop]}}\n", "no argument 'on_error'"),
    "keep without each": ("  n: {node: Noise, width: 4, on_error: ‸keep}\n", "on_error: keep belongs to each"),
    "the list of an each in a single socket": ("  n: {node: Noise, each: {width: [4, 5]}}\n  m: {node: Threshold, image: ‸n}\n", "expected Image, got list[Image]; to go on with each item, put both nodes into a graph file"),
    "bad seed": ("  n: {node: Noise, width: 4, seed: ‸x}\n", "a seed is a whole number from 0, got 'x'"),
    "list as a seed": ("  n: {node: Noise, width: 4, seed: ‸[1, 2]}\n", "a seed is a whole number from 0"),
    "missing sub-graph": ("  g: {graph: ‸splice.yml, elements: [a]}\n", "there is no graph file 'splice.yml'", ),
    "missing sub-graph with a near one": ("  g: {graph: ‸iner.yaml}\n", "did you mean 'inner.yaml'?"),
    "sub-graph that is a folder": ("  g: {graph: ‸.}\n", "there is no graph file '.'"),
    "sub-graph with a null character": ('  g: {graph: ‸"a\\0.yaml"}\n', "there is no graph file"),
    "unknown argument of a sub-graph": (NOISE + "  g: {graph: inner.yaml, picture: n, ‸lvl: 0.5}\n", "has no argument 'lvl'"),
    "missing argument of a sub-graph": ("  g: ‸{graph: inner.yaml}\n", "needs picture"),
    "wrong value for a sub-graph": (NOISE + "  g: {graph: inner.yaml, picture: n, level: ‸2}\n", "at most 1, got 2"),
    "wrong item for a sub-graph": (NOISE + "  g: {graph: inner.yaml, picture: n, each: {level: [0, ‸2]}}\n", "at most 1, got 2"),
    "wrong type for a sub-graph": (NOISE + MASK + "  g: {graph: inner.yaml, picture: ‸m}\n", "expected Image, got Mask"),
    "unknown output of a sub-graph": (NOISE + "  g: {graph: inner.yaml, picture: n}\n  m: {node: Threshold, image: ‸g.image}\n", "no output 'image'; outputs: fine, rough"),
    "include of itself": ("  g: {graph: ‸graph.yaml}\n", "circle: graph.yaml -> graph.yaml"),
}  # fmt: skip

INPUTS = {
    "unknown type": ("{type: ‸Imgae}", "unknown type 'Imgae'; did you mean 'Image'?"),
    "python's type": ("{type: ‸string}", "unknown type 'string'"),
    "default of another type": ("{type: int, default: ‸wide}", "expected int, got 'wide'"),
    "default that is a float": ("{type: int, default: ‸4.0}", "expected int, got 4.0"),
    "default above the range": ("{type: int, default: ‸9, min: 1, max: 8}", "should be at most 8, got 9"),
    "default below the range": ("{type: float, default: ‸0.5, min: 1}", "should be at least 1, got 0.5"),
    "default that is no choice": ("{type: str, default: ‸rigdes, choices: [ridges, valleys]}", "did you mean 'ridges'?"),
    "range upside down": ("{type: int, min: ‸8, max: 1}", "min 8 is above max 1"),
    "default that cannot be opened": ("{type: Image, default: ‸stone.xcf}", "nothing opens a file ending in '.xcf' as Image"),
    "default of an unknown scheme": ('{type: Image, default: ‸"mad:stone"}', "nothing opens 'mad:' as Image; did you mean 'made:'?"),
    "default number for a picture": ("{type: Image, default: ‸5}", "expected a path or scheme:name to open as Image, got 5"),
    "single default for a list": ('{type: "list[int]", default: ‸5}', "expected a list of int, got 5"),
    "wrong item in a default": ('{type: "list[Image]", default: ["made:a", ‸5]}', "expected a path or scheme:name"),
    "choice of another type": ("{type: int, choices: [1, ‸two]}", "expected int, got 'two'"),
    "unknown option of opening": ("{type: Image, open: {‸gian: 2}}", "nothing that opens a file as Image has 'gian'; did you mean 'gain'?"),
    "option of opening out of range": ("{type: Image, open: {gain: ‸0}}", "greater than 0, got 0"),
    "options of opening that are none": ("{type: Image, open: ‸raw}", "open is a mapping, `{encoding: raw}`, got the text 'raw'"),
    "opening a number": ("{type: int, ‸open: {gain: 2}}", "open is for what a file is opened as, not for int"),
    "range of a picture": ("{type: Image, ‸min: 1}", "min is for numbers, not for Image"),
}  # fmt: skip

USES = {
    "scalar input in a socket": ("width: {type: int, default: 4}", "m: {node: Threshold, image: ‸$width}", "$width is int"),
    "picture in a parameter": ('p: {type: Image, default: "made:x"}', "n: {node: Noise, width: ‸$p}", "$p is Image"),
    "default that does not fit its use": ("w: {type: int, default: 0}", "n: {node: Noise, width: ‸$w}", "the default of $w does not fit"),
    "input without default of another type": ("w: {type: str}", "n: {node: Noise, width: ‸$w}", "$w is str"),
    "input without dollar": ('p: {type: Image, default: "made:x"}', "m: {node: Threshold, image: ‸p}", "the graph input is written $p"),
    "input of another type": ('p: {type: "list[Image]", default: []}', "m: {node: Threshold, image: ‸$p}", "expected Image, got list[Image]"),
    "each over a single input": ("w: {type: int, default: 4}", "n: {node: Noise, each: {width: ‸$w}}", "each ranges over lists; $w is int"),
    "each over a list of another type": ('p: {type: "list[Image]", default: []}', "n: {node: Noise, each: {width: ‸$p}}", "$p is list[Image]"),
    "seed from text": ("s: {type: str, default: x}", "n: {node: Noise, width: 4, seed: ‸$s}", "a seed is a whole number from 0, got 'x'"),
    "socket of an input": ('p: {type: Image, default: "made:x"}', "m: {node: Threshold, image: ‸$p.image}", "unknown graph input $p.image"),
    "input of unknown type, told once": ("p: {type: ‸Imag}", "m: {node: Threshold, image: $p}", "unknown type 'Imag'"),
    "input without type, told once": ("p: ‸{default: x}", "m: {node: Threshold, image: $p, level: $p}", "the key `type` is missing"),
}  # fmt: skip

OUTPUTS = {
    "unknown node": ("image: ‸x", "unknown node 'x'; nodes: m, n"),
    "unknown socket": ("image: ‸n.detail", "no output 'detail'"),
    "unknown input": ("image: ‸$x", "unknown graph input $x"),
    "unknown format": ("image: {from: n, file: ‸out.tx}", "Image cannot be written as '.tx'"),
    "no format": ("image: {from: n, file: ‸out}", "Image cannot be written as ''"),
    "format of another type": ("mask: {from: m, file: ‸out.tex}", "Mask cannot be written as '.tex'"),
    "unknown option": ("image: {from: n, file: out.tex, ‸depth: 16}", "unknown option 'depth'; options: digits"),
    "option out of range": ("image: {from: n, file: out.tex, digits: ‸20}", "less than or equal to 9, got 20"),
    "outside of the folder": ("image: {from: n, file: ‸../out.tex}", "inside of the output folder"),
    "absolute": ("image: {from: n, file: ‸/tmp/out.tex}", "inside of the output folder"),
    "one file twice": ("a: {from: n, file: a.tex}\n  b: {from: n, file: ‸a.tex}", "a.tex is written by the output a too"),
    "from unknown": ("image: {from: ‸x, file: out.tex}", "unknown node 'x'"),
}  # fmt: skip

CASES = {f"form: {name}": case for name, case in FORM.items()}
CASES |= {f"nodes: {name}": (f"{HEAD}nodes:\n{text}", *told) for name, (text, *told) in MEANING.items()}
CASES |= {
    f"input: {name}": (f"{HEAD}inputs:\n  x: {text}\nnodes:\n{NOISE}", *told) for name, (text, *told) in INPUTS.items()
}
CASES |= {
    f"use: {name}": (f"{HEAD}inputs:\n  {one}\nnodes:\n  {two}\n", *told) for name, (one, two, *told) in USES.items()
}
CASES |= {
    f"output: {name}": (f"{HEAD}nodes:\n{NOISE}{MASK}outputs:\n  {text}\n", *told)
    for name, (text, *told) in OUTPUTS.items()
}

INNER = """\
graphtex: 1
inputs:
  picture: {type: Image}
  level: {type: float, default: 0.5, min: 0, max: 1}
nodes:
  split: {node: Split, image: $picture}
  mark: {node: Threshold, image: split.base, level: $level}
outputs:
  fine: split.detail
  rough: mark
"""


def unmarked(text):
    """Return the text without marks, and line and column of each."""
    places = []
    for number, line in enumerate(text.split("\n"), 1):
        places += [(number, match.start() + 1 - index) for index, match in enumerate(re.finditer(MARK, line))]
    return text.replace(MARK, ""), places


def problems_of(path):
    with pytest.raises(GraphError) as caught:
        load(path)
    return caught.value.problems


@pytest.mark.parametrize("name", CASES)
def test_is_told(name, tmp_path, small_pack):
    text, *fragments = CASES[name]
    text, places = unmarked(text)
    (tmp_path / "inner.yaml").write_text(INNER)
    (tmp_path / "graph.yaml").write_text(text)
    problems = problems_of(tmp_path / "graph.yaml")
    shown = "\n".join(str(problem) for problem in problems)
    assert [(p.line, p.column) for p in problems] == places, shown
    for problem, fragment in zip(problems, fragments, strict=True):
        assert problem.file == str(tmp_path / "graph.yaml")
        assert fragment in problem.message


def test_all_at_once(tmp_path, small_pack):
    """Mistakes of every stage, in order of place, each told once."""
    text, places = unmarked("""\
graphtex: 1
seed: ‸-1
inputs:
  w: {type: int, default: ‸x}
nodes:
  a: {node: ‸Nois, width: $w}
  b: {node: Threshold, image: a, ‸lvel: 1, level: ‸7, ‸level: 2}
  c: {node: Noise, width: ‸$v}
outputs:
  o: ‸d
  p: {from: b, ‸from: c}
""")
    (tmp_path / "graph.yaml").write_text(text)
    problems = problems_of(tmp_path / "graph.yaml")
    assert [(p.line, p.column) for p in problems] == places, "\n".join(map(str, problems))


def test_graphs_that_include_each_other(tmp_path, small_pack):
    for one, other in (("a", "b"), ("b", "a")):
        text = f"graphtex: 1\nnodes:\n  g: {{graph: {other}.yaml}}\noutputs:\n  x: g.x\n"
        (tmp_path / f"{one}.yaml").write_text(text)
    problems = problems_of(tmp_path / "a.yaml")
    assert any("circle: a.yaml -> b.yaml -> a.yaml" in p.message for p in problems)


def test_a_mistake_in_a_sub_graph_is_told_at_its_own_place(tmp_path, small_pack):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "inner.yaml").write_text(INNER.replace("Threshold", "Treshold"))
    (tmp_path / "graph.yaml").write_text(
        f"{HEAD}nodes:\n{NOISE}  g: {{graph: parts/inner.yaml, picture: n}}\noutputs:\n  x: g.fine\n"
    )
    problems = problems_of(tmp_path / "graph.yaml")
    assert [(p.file, p.line, p.column) for p in problems] == [(str(tmp_path / "parts" / "inner.yaml"), 7, 16)]


def test_graphs_without_mistakes(tmp_path, small_pack):
    """What the cases vary is right without its mistake."""
    (tmp_path / "inner.yaml").write_text(INNER)
    (tmp_path / "graph.yaml").write_text(f"""\
{HEAD}inputs:
  p: {{type: Image, default: "made:x"}}
nodes:
{NOISE}{MASK}  g: {{graph: inner.yaml, picture: n, each: {{level: [0, 0.5]}}}}
  h: {{graph: inner.yaml, level: 1, picture: $p}}
  b: {{node: Blend, images: g.fine, mask: m}}
outputs:
  a: {{from: b, file: a.tex, digits: 3}}
  b: {{from: h.rough}}
""")
    assert load(tmp_path / "graph.yaml").nodes["h"].graph == "inner.yaml"
