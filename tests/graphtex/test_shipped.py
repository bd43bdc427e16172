"""Graphs that ship: found by name, also after an install."""

import pytest

from graphtex import GraphError, load, shipped
from graphtex.shipped import find_graph, graph_identity, shipped_folder, shipped_names


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout with two graphs; its package folder."""
    for name in ("perspective/feature-mask", "design/chaos.v2"):
        file = tmp_path / "graphs" / f"{name}.yaml"
        file.parent.mkdir(parents=True)
        file.write_text("graphtex: 1\n")
    (tmp_path / "graphs" / "design" / "note.txt").write_text("")
    package = tmp_path / "graphtex"
    package.mkdir()
    monkeypatch.setattr(shipped, "_HERE", package)
    monkeypatch.chdir(package)
    return package


def test_graphs_are_found_beside_the_package_in_a_checkout_and_in_it_after_an_install(checkout):
    assert shipped_folder() == checkout.parent / "graphs"
    assert shipped_names() == ["design/chaos.v2", "perspective/feature-mask"]
    (checkout / "_graphs").mkdir()
    assert shipped_folder() == checkout / "_graphs"
    assert shipped_names() == []


@pytest.mark.parametrize(
    "name", ["perspective/feature-mask", "perspective/feature-mask.yaml", "graphs/perspective/feature-mask"]
)
def test_a_shipped_graph_has_a_name(checkout, name):
    assert find_graph(name) == checkout.parent / "graphs" / "perspective" / "feature-mask.yaml"


def test_a_dot_in_a_name_is_part_of_it(checkout):
    assert find_graph("design/chaos.v2").name == "chaos.v2.yaml"


def test_a_file_goes_before_a_shipped_graph(checkout):
    (checkout / "mine.yaml").write_text("")
    assert find_graph("mine.yaml").read_text() == ""


def test_python_loads_a_shipped_graph_by_its_name(checkout):
    (checkout.parent / "graphs" / "perspective" / "feature-mask.yaml").write_text(
        "graphtex: 1\ntitle: Mine\nnodes:\n  n: {node: Sample, name: gravel}\n"
    )
    for name in ("perspective/feature-mask", "graphs/perspective/feature-mask.yaml"):
        assert load(name).title == "Mine"
    with pytest.raises(GraphError, match="did you mean 'perspective/feature-mask'"):
        load("perspective/feature-msk")


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("perspective/feature-msk", "'perspective/feature-msk' is no file and no graph that ships; did you mean 'perspective/feature-mask'?"),
        ("feature-mask", "'feature-mask' is no file and no graph that ships; did you mean 'perspective/feature-mask'?"),
        ("design", "'design' is no file and no graph that ships; there are design/chaos.v2"),
        ("mien.yaml", "'mien.yaml' is no file and no graph that ships; did you mean 'mine.yaml'?"),
        ("of/none", "'of/none' is no file and no graph that ships; `graphtex graphs` lists those that ship"),
        (".", "'.' is a folder, not a graph file"),
        ("/perspective/feature-mask", "'/perspective/feature-mask' is no file and no graph that ships"),
    ],
)  # fmt: skip
def test_what_is_not_there_is_told(checkout, name, told):
    (checkout / "mine.yaml").write_text("")
    with pytest.raises(GraphError) as caught:
        find_graph(name)
    assert str(caught.value).startswith(told)


def test_a_graph_is_remembered_by_its_shipped_name_or_its_absolute_path(checkout):
    assert graph_identity(find_graph("perspective/feature-mask")) == "perspective/feature-mask"
    (checkout / "mine.yaml").write_text("")
    assert graph_identity(find_graph("mine.yaml")) == str(checkout / "mine.yaml")
    assert graph_identity(None) == "(built in Python)"
