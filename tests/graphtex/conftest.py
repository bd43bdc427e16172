import sys

import pytest

from graphtex.packs import Registry, nodes_of
from tests.graphtex import pack, tiny


def make_only_pack(patch, module=pack):
    """Make the nodes of `tests.graphtex.pack` the only ones at hand, wherever the registry is asked for."""
    nodes = nodes_of(module)
    small = Registry(nodes, dict.fromkeys(nodes, "pack"), ())
    for name in ("packs", "links", "check", "schema"):
        __import__(f"graphtex.{name}")
        patch.setattr(sys.modules[f"graphtex.{name}"], "registry", lambda: small)
    return small


@pytest.fixture
def small_pack(monkeypatch):
    return make_only_pack(monkeypatch)


@pytest.fixture
def tiny_nodes(monkeypatch):
    """Make the nodes of `tests.graphtex.tiny` the only ones at hand; nothing has been called."""
    tiny.CALLS.clear()
    tiny.ALIVE.clear()
    tiny.ENTERED.clear()
    return make_only_pack(monkeypatch, tiny)
