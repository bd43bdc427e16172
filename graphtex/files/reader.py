"""From the tree of a graph file to a graph. Says all that is wrong with its form; what needs nodes is not checked here.

A part that is wrong is left out or left empty, so that the rest can still be checked: a node that says neither what
`node` nor what `graph` it is becomes ``Entry()``, an input without a type ``Input("")``.
"""

import math
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from graphtex.document import FORMAT, NAME, REQUIRED, Document, Entry, Input, Output, Place
from graphtex.errors import Problem, did_you_mean
from graphtex.files.migrations import STEPS, Step, bring_up
from graphtex.files.yamltree import Tree, described, parse
from graphtex.node import RESERVED

DOCUMENT = ("graphtex", "title", "source", "description", "seed", "inputs", "nodes", "outputs")
INPUT = ("type", "default", "min", "max", "choices", "description", "open")
SECTIONS = {
    "inputs": "name: {type: Image}",
    "nodes": "name: {node: FeatureMask, image: $exemplar}",
    "outputs": "name: node.socket",
}


def read(
    text: str, file: Path | None = None, *, steps: Mapping[int, Step] = STEPS
) -> tuple[Document | None, list[Problem]]:
    """Read a graph file's text.

    Parameters
    ----------
    file
        Where the text is from; relative paths start there, and problems name it.
    steps
        What brings older formats up to the present one.

    Returns
    -------
    graph
        As far as it could be read; None if the text is no YAML mapping, or of another format.
    problems
        All that is wrong with the form of the file, in order of place.
    """
    tree = parse(text, str(file or ""))
    if not tree.complete:
        return None, sorted(set(tree.problems))
    reader = _Reader(tree, file, steps)
    graph = reader.document(tree.data)
    told = {(problem.line, problem.column) for problem in tree.problems}  # what follows from those is left out
    rest = [problem for problem in reader.problems if (problem.line, problem.column) not in told]
    return graph, sorted({*tree.problems, *rest})


class _Reader:
    """Reads one document; collects problems."""

    def __init__(self, tree: Tree, file: Path | None, steps: Mapping[int, Step]) -> None:
        self.graph = Document(file=file, places=tree.places, key_places=tree.key_places)
        self.steps = steps
        self.problems: list[Problem] = []

    def say(self, path: Place, message: str, *, key: bool = False) -> None:
        self.problems.append(self.graph.problem(path, message, key=key))

    def document(self, data: Any) -> Document | None:
        if not isinstance(data, dict):
            got = "an empty file" if data is None else described(data)
            self.say(
                (),
                f"a graph file is a mapping that begins with `graphtex: {FORMAT}`, got {got}{_colon(data, DOCUMENT)}",
            )
            return None
        version = data.get("graphtex")
        if "graphtex" not in data:
            near = get_close_matches("graphtex", data, n=1)
            self.say((), f"the format's version is missing: write `graphtex: {FORMAT}`" + _instead(near))
        elif not isinstance(version, int) or isinstance(version, bool):
            self.say(("graphtex",), f"the format's version is a whole number, got {described(version)}")
        else:
            try:
                data = bring_up(data, version, self.steps)
            except ValueError as error:
                self.say(("graphtex",), str(error))
                return None
        self._known_keys((), data, DOCUMENT)
        graph = self.graph
        for key in ("title", "source", "description"):
            setattr(graph, key, self._text((key,), data, key))
        graph.seed = self._seed(data)
        if "nodes" not in data:
            self.say((), "the key `nodes` is missing" + _instead(get_close_matches("nodes", data, n=1)))
        graph.inputs.update({name: self._input(path, value) for name, path, value in self._section(data, "inputs")})
        graph.nodes.update({name: self._entry(path, value) for name, path, value in self._section(data, "nodes")})
        for name, path, value in self._section(data, "outputs"):
            output = self._output(path, value)
            if output is not None:
                graph.outputs[name] = output
        return graph

    def _section(self, data: dict[str, Any], name: str) -> list[tuple[str, Place, Any]]:
        value = data.get(name)
        if value is None:  # nothing below the key yet
            return []
        if not isinstance(value, dict):
            dash = "; write the name in place of the '-'" if isinstance(value, list) else ""
            self.say((name,), f"expected a mapping, `{SECTIONS[name]}`, got {described(value)}{dash}")
            return []
        for key in value:
            if not NAME.fullmatch(key):
                message = f"a name is letters, digits, _ and -, and begins with a letter or _; got {key!r}"
                self.say((name, key), message, key=True)
        return [(key, (name, key), item) for key, item in value.items()]

    def _known_keys(self, path: Place, data: dict[str, Any], known: tuple[str, ...]) -> None:
        for key in data:
            if key not in known:
                hint = _colon(key, known) or did_you_mean(key, known, label="keys")
                self.say((*path, key), f"unknown key {key!r}{hint}", key=True)

    def _text(self, path: Place, data: dict[str, Any], key: str) -> str:
        value = data.get(key, "")
        if isinstance(value, str):
            return value
        quote = "; quote it" if isinstance(value, int | float) else ""
        self.say(path, f"{key} is text, got {described(value)}{quote}")
        return ""

    def _seed(self, data: dict[str, Any]) -> int:
        value = data.get("seed", 0)
        if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
            return value
        hint = "; an input can be the seed of a node, not of the graph" if str(value).startswith("$") else ""
        self.say(("seed",), f"a seed is a whole number from 0, got {described(value)}{hint}")
        return 0

    def _input(self, path: Place, value: Any) -> Input:
        if not isinstance(value, dict):
            self.say(path, f"expected a mapping, `{{type: Image}}`, got {described(value)}{_colon(value, INPUT)}")
            return Input("")
        self._known_keys(path, value, INPUT)
        kind = value.get("type", "")
        if "type" not in value:
            self.say(path, "the key `type` is missing, as in {type: Image}")
        elif not isinstance(kind, str) or not kind:
            hint = '; a list of pictures is written "list[Image]"' if isinstance(kind, list | dict) else ""
            self.say((*path, "type"), f"a type is text, got {described(kind)}{hint}")
            kind = ""
        bounds: dict[str, float | None] = {"min": None, "max": None}
        for key in bounds:
            bound = value.get(key, 0)
            if isinstance(bound, bool) or not isinstance(bound, int | float) or not math.isfinite(bound):
                self.say((*path, key), f"{key} is a number, got {described(bound)}")
            elif key in value:
                bounds[key] = bound
        choices = value.get("choices")
        if "choices" in value and (not isinstance(choices, list) or not choices):
            self.say((*path, "choices"), f"choices are a list with at least one item, got {described(choices)}")
            choices = None
        opening = value.get("open", {})
        if not isinstance(opening, dict):
            self.say((*path, "open"), f"open is a mapping, `{{encoding: raw}}`, got {described(opening)}")
            opening = {}
        text = self._text((*path, "description"), value, "description")
        allowed = None if choices is None else tuple(choices)
        return Input(kind, value.get("default", REQUIRED), bounds["min"], bounds["max"], allowed, text, opening)

    def _entry(self, path: Place, value: Any) -> Entry:
        if not isinstance(value, dict):
            hint = _colon(value, RESERVED)
            if isinstance(value, str) and NAME.fullmatch(value):
                hint = f"; write {{node: {value}}}"
            self.say(path, f"expected a mapping, `{{node: FeatureMask, ...}}`, got {described(value)}{hint}")
            return Entry()
        if "node" in value and "graph" in value:
            self.say((*path, "graph"), "an entry is either a `node` or a `graph`, got both", key=True)
        names = {}
        for key in ("node", "graph"):
            names[key] = name = value.get(key, "")
            if key in value and (not isinstance(name, str) or not name):
                what = "the name of a node" if key == "node" else "the path of a graph file"
                self.say((*path, key), f"expected {what}, got {described(name)}")
                names[key] = ""
        if "node" not in value and "graph" not in value:
            glued = next((key for key in value if key.startswith(("node:", "graph:"))), "")
            near = get_close_matches("node", value, n=1) or [key for key in ("type", "class", "op") if key in value]
            hint = _colon(glued, RESERVED) if glued else _instead(near)
            self.say(path, f"expected `node: <name>` or `graph: <file>`, got neither{hint}")
        each = value.get("each", {})
        if not isinstance(each, dict):
            wanted = "each is a mapping of arguments to lists, `{slant: [30, 45]}`"
            self.say((*path, "each"), f"{wanted}, got {described(each)}")
            each = {}
        if "seed" in value and value["seed"] is None:
            self.say((*path, "seed"), "a seed is a whole number from 0 or $input, got nothing")
        on_error = value.get("on_error", "stop")
        if on_error not in ("stop", "keep"):
            self.say((*path, "on_error"), f"on_error is stop or keep, got {described(on_error)}")
            on_error = "stop"
        arguments = {key: item for key, item in value.items() if key not in RESERVED}
        graph = "" if names["node"] else names["graph"]
        return Entry(names["node"], graph, arguments, each, value.get("seed"), on_error)

    def _output(self, path: Place, value: Any) -> Output | None:
        if isinstance(value, str) and value:
            return Output(value)
        if not isinstance(value, dict):
            several = "; give each of them an output of its own" if isinstance(value, list) else ""
            self.say(path, f"expected node.socket or {{from: node.socket, ...}}, got {described(value)}{several}")
            return None
        source, file = value.get("from"), value.get("file")
        if "from" not in value:
            self.say(path, "the key `from` is missing, as in {from: node.socket, file: out.png}")
        elif not isinstance(source, str) or not source:
            self.say((*path, "from"), f"expected node.socket, got {described(source)}")
        if "file" in value and (not isinstance(file, str) or not file):
            self.say((*path, "file"), f"expected a file's name, got {described(file)}")
            file = None
        options = {key: item for key, item in value.items() if key not in ("from", "file")}
        return Output(source, file, options) if isinstance(source, str) and source else None


def _colon(value: Any, known: Iterable[str]) -> str:
    """Return a hint if a text looks like one of the known keys whose colon lacks its space."""
    name, _, rest = value.partition(":") if isinstance(value, str) else ("", "", "")
    if rest and name in known:
        return f"; a space is needed after the colon: `{name}: {rest:.40}`"
    return ""


def _instead(near: list[str]) -> str:
    return f" (instead there is {near[0]!r})" if near else ""
