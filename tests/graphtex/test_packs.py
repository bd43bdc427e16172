"""Packs: a broken one is reported and the others stay; names that clash are told."""

import re
import sys
from importlib.metadata import EntryPoint
from types import ModuleType

import pytest

from graphtex import DeclarationError, Graph
from graphtex.check import check
from graphtex.document import Entry
from graphtex.packs import GROUP, Registry, load_packs, nodes_of
from tests.graphtex import pack, tiny


def point(name: str, value: str) -> EntryPoint:
    return EntryPoint(name, value, GROUP)


@pytest.fixture
def modules(tmp_path, monkeypatch):
    """Make modules from texts, by name."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(**texts: str) -> None:
        for name, text in texts.items():
            monkeypatch.delitem(sys.modules, name, raising=False)
            (tmp_path / f"{name}.py").write_text(text)

    return write


def test_public_names_that_are_nodes_are_the_pack():
    found = nodes_of(tiny)
    assert found["Const"] is tiny.const
    assert set(found) >= {"Add", "Halves", "Survey"}
    with pytest.raises(TypeError, match="a pack is a module, got Node"):
        nodes_of(tiny.const)


def test_private_names_are_left_out_and_two_names_of_one_node_are_one():
    module = ModuleType("some")
    module._const, module.add, module.plus = tiny.const, tiny.add, tiny.add
    assert nodes_of(module) == {"Add": tiny.add}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("def (", "SyntaxError"),
        ("import nowhere_at_all", "ModuleNotFoundError: No module named 'nowhere_at_all'"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("from graphtex import node\n@node\ndef f(x) -> int: ...", r"DeclarationError: f\(x\): an annotation is required"),
    ],
)  # fmt: skip
def test_a_broken_pack_is_reported_and_the_others_stay(modules, text, told):
    modules(broken_pack=text)
    found = load_packs([point("broken", "broken_pack"), point("tiny", "tests.graphtex.tiny")])
    assert "Const" in found.nodes
    assert len(found.broken) == 1
    assert found.broken[0].startswith("pack 'broken' (broken_pack) did not load: ")
    assert re.search(told, found.broken[0])


def test_of_two_nodes_with_one_name_the_first_pack_s_stays():
    found = load_packs([point("b", "tests.graphtex.tiny"), point("a", "tests.graphtex.pack")])
    assert found.nodes["Average"] is pack.average
    assert found.packs["Average"] == "a"
    assert found.packs["Const"] == "b"
    assert found.broken == ("pack 'b': node Average is left out, pack 'a' has one of that name",)


def test_a_pack_that_is_installed_twice_clashes_with_nobody():
    assert load_packs([point("a", "tests.graphtex.tiny"), point("b", "tests.graphtex.tiny")]).broken == ()


def test_two_nodes_of_one_name_in_one_pack_are_its_author_s_fault():
    module = ModuleType("some")
    module.one, module.two = tiny.average, pack.average
    with pytest.raises(DeclarationError, match=r"two nodes are named Average: .*tiny.average and .*pack.average"):
        nodes_of(module)


def test_a_broken_pack_is_told_with_the_node_that_is_missing(monkeypatch):
    broken = Registry({}, {}, ("pack 'x' (x) did not load: ImportError: y",))
    monkeypatch.setattr("graphtex.links.registry", lambda: broken)
    (problem,) = check(Graph(nodes={"a": Entry(node="Gone")}))
    assert problem.message == "unknown node 'Gone'; there is no node at all (pack 'x' (x) did not load: ImportError: y)"
