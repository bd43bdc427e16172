"""What one source file says: a digest of its syntax tree, its imports, and what its top level binds.

Comments, formatting, positions and strings that stand alone (docstrings) do not count in the digest. Imports are taken
from everywhere in the file, functions included, except under ``if TYPE_CHECKING``.
"""

import ast
import hashlib
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Import:
    """One imported name.

    ``import a.b`` is ("a.b", None, "a"), ``import a.b as c`` ("a.b", None, "c"), ``from a import b as c``
    ("a", "b", "c"), ``from a import *`` ("a", "*", ""), ``import_module("a.b")`` ("a.b", None, "").
    """

    module: str
    name: str | None
    local: str


@dataclass(frozen=True)
class Syntax:
    """What `read_syntax` finds.

    Attributes
    ----------
    digest
        SHA-256 of the syntax tree, hex.
    imports
        All imports of the file, absolute.
    uses
        Imported local name -> the chains of attributes that follow it: ``c.x.y`` gives ("x", "y"), a bare ``c`` ().
    bindings
        Name bound at top level -> the imports that bind it; None among them if something else does.
    strings
        All string constants, if the module makes attributes on demand (``__getattr__``): they may name modules.
    """

    digest: str
    imports: tuple[Import, ...]
    uses: dict[str, frozenset[tuple[str, ...]]]
    bindings: dict[str, frozenset[Import | None]]
    strings: tuple[str, ...]

    @property
    def stars(self) -> tuple[str, ...]:
        """Return the modules that are imported by ``from module import *``."""
        return tuple(found.module for found in self.imports if found.name == "*")


def read_syntax(source: str | bytes, filename: str, package: str) -> Syntax:
    """Parse a file.

    Parameters
    ----------
    source, filename
        The text, and where it is from, for messages.
    package
        What relative imports start from.

    Raises
    ------
    SyntaxError, ValueError
        If it is not Python.
    """
    tree = ast.parse(source, filename)
    chains: dict[str, set[tuple[str, ...]]] = defaultdict(set)
    imports: list[Import] = []
    strings: list[str] = []
    digest = _walk(tree, package, imports, chains, strings)
    local = {found.local for found in imports}
    bindings = _bindings(tree.body, package)
    return Syntax(
        digest,
        tuple(dict.fromkeys(imports)),
        {name: frozenset(found) for name, found in chains.items() if name in local},
        bindings,
        tuple(strings) if "__getattr__" in bindings else (),
    )


def _walk(
    tree: ast.AST, package: str, imports: list[Import], chains: dict[str, set[tuple[str, ...]]], strings: list[str]
) -> str:
    """Collect imports, attribute chains and strings; return the digest. One pass: this is most of the time spent.

    The tree is written as tokens in the order of the walk. Each node type has a fixed number of fields and each list
    its length before it, so two trees have equal tokens only if they are equal.
    """
    tokens: list[str] = []
    stack: list[Any] = [tree]
    inner: set[int] = set()  # ids of nodes within a chain that was seen from its outer end
    untyped: set[int] = set()  # ids of imports for type checkers only
    while stack:
        item = stack.pop()
        if isinstance(item, ast.AST):
            tokens.append(type(item).__name__)
            if isinstance(item, ast.Attribute | ast.Name):
                _note_chain(item, inner, chains)
            elif isinstance(item, ast.Import | ast.ImportFrom):
                if id(item) not in untyped:
                    imports += _imports(item, package)
            elif isinstance(item, ast.If):
                untyped |= _for_type_checkers(item)
            elif isinstance(item, ast.Call):
                imports += _dynamic_import(item, package)
            elif isinstance(item, ast.Constant) and isinstance(item.value, str):
                strings.append(item.value)
            for name in item._fields:
                if name not in ("ctx", "kind", "type_comment", "type_ignores"):  # no meaning of their own
                    stack.append(getattr(item, name, None))
        elif isinstance(item, list):
            item = [part for part in item if not _is_bare_string(part)]
            tokens.append(f"[{len(item)}")
            stack += item
        else:
            tokens.append(repr(item))
    return hashlib.sha256("\0".join(tokens).encode("utf-8", "surrogatepass")).hexdigest()


def _is_bare_string(node: Any) -> bool:
    return type(node) is ast.Expr and type(node.value) is ast.Constant and isinstance(node.value.value, str)


def _note_chain(node: Any, inner: set[int], chains: dict[str, set[tuple[str, ...]]]) -> None:
    if id(node) in inner:
        return
    names: list[str] = []
    while isinstance(node, ast.Attribute):
        names.append(node.attr)
        node = node.value
        inner.add(id(node))
    if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        chains[node.id].add(tuple(reversed(names)))


def _imports(node: ast.Import | ast.ImportFrom, package: str) -> list[Import]:
    if isinstance(node, ast.Import):
        return [Import(item.name, None, item.asname or item.name.partition(".")[0]) for item in node.names]
    module = _absolute(node.module or "", node.level, package)
    if not module:
        return []
    return [Import(module, item.name, "" if item.name == "*" else item.asname or item.name) for item in node.names]


def _absolute(module: str, level: int, package: str) -> str:
    """Return the absolute name of a relative import; empty if it leads out of the top-level package."""
    if level == 0:
        return module
    start = package.split(".")
    if not package or level > len(start):
        return ""
    return ".".join([*start[: len(start) - level + 1], *([module] if module else [])])


def _dynamic_import(call: ast.Call, package: str) -> list[Import]:
    """Return the module of ``importlib.import_module("literal")`` or ``__import__("literal")``."""
    function = call.func
    called = (
        function.attr if isinstance(function, ast.Attribute) else function.id if isinstance(function, ast.Name) else ""
    )
    if called not in ("import_module", "__import__") or not call.args:
        return []
    first = call.args[0]
    if not (isinstance(first, ast.Constant) and isinstance(first.value, str)):
        return []
    name = first.value.lstrip(".")
    module = _absolute(name, len(first.value) - len(name), package)
    return [Import(module, None, "")] if module else []


def _for_type_checkers(node: ast.If) -> set[int]:
    """Return the ids of imports in the branch that never runs, if the test is TYPE_CHECKING or its negation."""
    test, branch = node.test, node.body
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        test, branch = test.operand, node.orelse
    name = test.attr if isinstance(test, ast.Attribute) else test.id if isinstance(test, ast.Name) else ""
    if name != "TYPE_CHECKING":
        return set()
    return {id(inner) for part in branch for inner in ast.walk(part) if isinstance(inner, ast.Import | ast.ImportFrom)}


def _bindings(body: list[ast.stmt], package: str) -> dict[str, frozenset[Import | None]]:
    found: dict[str, set[Import | None]] = defaultdict(set)
    untyped: set[int] = set()
    for node in _top_level(body):
        if isinstance(node, ast.If):
            untyped |= _for_type_checkers(node)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            if id(node) not in untyped:
                for item in _imports(node, package):
                    found[item.local].add(item)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found[node.name].add(None)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            found[node.id].add(None)
    return {name: frozenset(bound) for name, bound in found.items()}


def _top_level(body: list[ast.stmt]) -> Iterator[ast.AST]:
    """Yield what runs when a module is imported: everything outside of functions, classes and lambdas."""
    stack: list[ast.AST] = list(reversed(body))
    while stack:
        node = stack.pop()
        yield node
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Lambda):
            stack += ast.iter_child_nodes(node)
