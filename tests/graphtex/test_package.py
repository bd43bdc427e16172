"""The package's public names: imported on demand, and never hidden by modules of the same name."""

import subprocess
import sys
from importlib import import_module

import pytest

import graphtex


def run_python(code: str) -> str:
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


@pytest.mark.parametrize("name", graphtex.__all__)
def test_each_public_name_is_there_and_defined_where_it_is_said_to_be(name: str) -> None:
    assert getattr(graphtex, name) is getattr(import_module(graphtex._HOME[name]), name)


def test_all_lists_exactly_what_is_imported_on_demand() -> None:
    assert sorted(graphtex.__all__) == sorted(graphtex._HOME)
    assert set(graphtex.__all__) <= set(dir(graphtex))


def test_unknown_names_are_attribute_errors() -> None:
    with pytest.raises(AttributeError, match="'graphtex' has no attribute 'nonsense'"):
        graphtex.nonsense  # noqa: B018


def test_importing_the_package_alone_imports_nothing_heavy() -> None:
    heavy = ("numpy", "pydantic", "networkx", "yaml", "scipy", "numba")
    code = f"import sys, graphtex; print([name for name in {heavy} if name in sys.modules])"
    assert run_python(code) == "[]"


@pytest.mark.parametrize("name", ["node", "run"])
def test_a_function_is_not_hidden_by_its_module_of_the_same_name(name: str) -> None:
    code = f"import graphtex.{name}; from graphtex import {name}; print(type({name}).__name__)"
    assert run_python(code) == "function"


def test_numbers_can_be_written_whatever_was_imported_first() -> None:
    code = "from graphtex import Image; from graphtex.handlers import DEFAULT_SUFFIX; print(DEFAULT_SUFFIX['Number'])"
    assert run_python(code) == ".json"
