"""The rules of the house that an import linter cannot say."""

import ast
import subprocess
import sys
from pathlib import Path

import graphtex

ROOT = Path(__file__).parent.parent


def _imports(path: Path) -> list[tuple[str, tuple[str, ...]]]:
    found = []
    for item in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(item, ast.Import):
            found += [(alias.name, ()) for alias in item.names]
        elif isinstance(item, ast.ImportFrom):
            found.append((item.module or "", tuple(alias.name for alias in item.names)))
    return found


def test_nodes_use_public_names_only():
    """`nodes` imports graphtex by its public names: ``from graphtex import ...`` of what ``__all__`` lists."""
    wrong = []
    for path in sorted((ROOT / "nodes").rglob("*.py")):
        for module, names in _imports(path):
            if module.split(".")[0] == "graphtex" and (module != "graphtex" or not set(names) <= set(graphtex.__all__)):
                wrong.append(f"{path.name}: {module} {names}")
    assert not wrong


def test_public_names_are_there():
    assert all(hasattr(graphtex, name) for name in graphtex.__all__)


def test_nodes_import_lightly():
    """All nodes load without the heavy libraries: they are imported where they are needed."""
    heavy = ("numba", "scipy", "skimage", "OpenImageIO", "PIL", "tifffile")
    code = f"import sys, graphtex_nodes; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
