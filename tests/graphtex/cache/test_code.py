import importlib
import os
import py_compile
import subprocess
import sys
import textwrap
import zipfile

import pytest

from graphtex.cache import BadSource, NoSource, code_digest, module_digest

PACK = {
    "__init__": """
        from .nodes.main import run
        from .tools.direct import helper
        from .unrelated import nothing
        """,
    "nodes/__init__": "",
    "nodes/main": '''
        """Docstring of the module."""
        from typing import TYPE_CHECKING
        import numpy as np
        from pack.tools import shared
        from ..tools.direct import helper
        if TYPE_CHECKING:
            from ..typing_only import Thing

        def run(x: "Thing"):
            """Docstring of the node."""
            from ..lazy import slow
            return helper(x) + shared(x) + slow(np.abs(x))
        ''',
    "tools/__init__": """
        from .hidden import shared
        from .other import other
        """,
    "tools/direct": """
        from . import deep
        def helper(x):
            # a comment
            return deep.FACTOR * x
        """,
    "tools/deep": "FACTOR = 2",
    "tools/hidden": "def shared(x): return x + 1",
    "tools/other": "def other(x): return x + 2",
    "lazy": "def slow(x): return 3 * x",
    "typing_only": "class Thing: pass",
    "unrelated": "def nothing(): return 4",
}


@pytest.fixture
def pack(tmp_path, monkeypatch):
    """A function that writes files of the pack and returns the digest of its node's module; it is never imported."""
    monkeypatch.syspath_prepend(str(tmp_path))
    clock = [1_000_000_000]

    def write(**files):
        for name, text in files.items():
            path = tmp_path / "pack" / f"{name.replace('__slash__', '/')}.py"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(textwrap.dedent(text))
            clock[0] += 1  # a new time stamp for each change, however quick the test is
            os.utime(path, (clock[0], clock[0]))
        importlib.invalidate_caches()
        return module_digest("pack.nodes.main")

    write(**PACK)
    yield write
    assert "pack" not in sys.modules  # nothing was executed


def used(digest):
    return {name.removeprefix("pack.") for name in digest.modules}


def test_what_counts(pack):
    """Re-exports count as the module that defines them; no __init__, nothing for type checkers, nothing unrelated."""
    digest = pack()
    assert used(digest) == {"nodes.main", "tools.direct", "tools.deep", "tools.hidden", "lazy"}
    assert digest.packages == ("numpy",)


@pytest.mark.parametrize("where", ["nodes/main", "tools/direct", "tools/deep", "tools/hidden", "lazy"])
def test_a_change_in_any_of_them_changes_the_digest(pack, where):
    """The node's module, a helper, a helper's helper, a re-exported one, a lazily imported one."""
    before = pack()
    after = pack(**{where: textwrap.dedent(PACK[where]) + "\nEXTRA = 1\n"})
    assert after.digest != before.digest
    assert [name for name in after.modules if after.modules[name] != before.modules[name]] == [
        f"pack.{where.replace('/', '.')}"
    ]


@pytest.mark.parametrize("where", ["__init__", "tools/__init__", "tools/other", "unrelated", "typing_only"])
def test_a_change_elsewhere_does_not(pack, where):
    before = pack()
    assert pack(**{where: textwrap.dedent(PACK[where]) + "\nEXTRA = 1\n"}) == before


def test_comments_docstrings_and_layout_do_not_count(pack):
    before = pack()
    after = pack(
        **{
            "nodes/main": textwrap.dedent(PACK["nodes/main"]).replace("Docstring", "Another").replace("(x)", "(  x )"),
            "tools/direct": '''
                """Now with a docstring."""
                from . import deep


                def helper(x):
                    "And this one."
                    return (deep.FACTOR
                            * x)  # another comment
                ''',
            "tools/deep": 'FACTOR = 2\n"""What it is for."""\n',
        }
    )
    assert after == before


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("2", "3"),
        ("2", "2.0"),
        ("2", "'2'"),
        ("2", "b'2'"),
        ("2", "-2"),
        ("FACTOR = 2", "FACTOR: int = 2"),
        ("FACTOR = 2", "FACTOR = (2,)"),
        ("FACTOR = 2", "FACTOR = [2]"),
        ("FACTOR = 2", "FACTOR = f'{2}'"),
        ("FACTOR = 2", "FACTOR = 2\nassert FACTOR"),
        ("FACTOR = 2", "FACTOR = lambda: 2"),
        ("FACTOR", "FACTORS"),
    ],
)
def test_each_change_of_meaning_counts(pack, old, new):
    assert pack(**{"tools/deep": PACK["tools/deep"].replace(old, new)}).digest != pack(**PACK).digest


def test_nesting_counts(pack):
    """Two programs of the same words in another structure."""
    one = pack(**{"tools/deep": "def f():\n    if a:\n        b()\n        c()\n"})
    two = pack(**{"tools/deep": "def f():\n    if a:\n        b()\n    c()\n"})
    assert one.digest != two.digest


@pytest.mark.parametrize(
    "source",
    [
        "import pack.tools.other",
        "import pack.tools.other as o\no.other()",
        "import pack.tools as t\ndef f(): return t.other(1)",
        "import pack.tools as t\ndef f(): return t.other.attribute.of_it",
        "import pack\ndef f(): return pack.tools.other(1)",
        "from pack import tools\ndef f(): return tools.other(1)",
        "from pack.tools import other",
        "from pack.tools import other as o",
        "from ..tools import other",
        "from ..tools.other import other",
        "from .. import tools as t\ndef f(): return t.other(1)",
        "from pack.tools.other import *",
        "def f():\n    from ..tools import other",
        "import importlib\ndef f(): return importlib.import_module('pack.tools.other')",
        "from importlib import import_module\ndef f(): return import_module('..tools.other', __package__)",
        "def f(): return __import__('pack.tools.other')",
        "try:\n    from ..tools.other import other\nexcept ImportError:\n    pass",
        "class A:\n    from ..tools.other import other",
        "import typing as t\nif not t.TYPE_CHECKING:\n    from ..tools.other import other",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    pass\nelse:\n    from ..tools.other import other",
    ],
)
def test_ways_to_import(pack, source):
    """Each of them depends on pack.tools.other alone."""
    assert used(pack(**{"nodes/main": source})) == {"nodes.main", "tools.other"}


@pytest.mark.parametrize(
    "source",
    [
        "import typing\nif typing.TYPE_CHECKING:\n    from ..tools.other import other",
        "from typing import TYPE_CHECKING\nif not TYPE_CHECKING:\n    pass\nelse:\n    import pack.tools.other",
        "import numpy, os.path\nfrom scipy.ndimage import gaussian_filter",
        "from graphtex import node",
        "other = 'pack.tools.other'",
        "from ...beyond import nothing",
    ],
)
def test_what_is_no_dependency(pack, source):
    assert used(pack(**{"nodes/main": source})) == {"nodes.main"}


def test_a_package_that_is_passed_around_counts_whole(pack):
    """It cannot be told what of it is used: its __init__ and all that it imports."""
    digest = pack(**{"nodes/main": "from pack import tools\ndef f(): return getattr(tools, 'x' + 'y')"})
    assert used(digest) == {"nodes.main", "tools", "tools.hidden", "tools.other"}


def test_what_is_defined_in_an_init(pack):
    digest = pack(**{"tools/__init__": "from .hidden import shared as _inner\ndef shared(x): return _inner(x)"})
    assert used(digest) == {"nodes.main", "tools.direct", "tools.deep", "tools", "tools.hidden", "lazy"}


def test_a_chain_of_re_exports(pack):
    """Through two packages, an alias and a star."""
    pack(
        **{
            "a/__init__": "from ..b import inner as shown",
            "b/__init__": "from .c import *\nfrom .d import *",
            "b/c": "def inner(): return 1",
            "b/d": "def outer(): return 2",
        }
    )
    assert used(pack(**{"nodes/main": "from pack.a import shown"})) == {"nodes.main", "b.c"}


def test_alternatives_all_count(pack):
    either = "try:\n    from .hidden import shared\nexcept ImportError:\n    from .other import other as shared"
    pack(**{"tools/__init__": either})
    assert used(pack(**{"nodes/main": "from ..tools import shared"})) == {"nodes.main", "tools.hidden", "tools.other"}


def test_a_module_and_its_function_of_one_name(pack):
    """``from .noise import noise`` in an __init__."""
    pack(**{"tools/__init__": "from .noise import noise", "tools/noise": "def noise(): return 1"})
    assert used(pack(**{"nodes/main": "from pack.tools import noise\ndef f(): return noise()"})) == {
        "nodes.main",
        "tools.noise",
    }


def test_attributes_on_demand(pack):
    """An __init__ that imports in __getattr__: every module that a string in it names counts."""
    lazy_init = """
        import importlib
        _HOMES = {"shared": "hidden", "other": ".other"}
        def __getattr__(name):
            return getattr(importlib.import_module(f".{_HOMES[name]}", __name__), name)
        """
    digest = pack(**{"nodes/main": "from ..tools import shared", "tools/__init__": lazy_init})
    assert used(digest) == {"nodes.main", "tools", "tools.hidden", "tools.other"}


def test_import_circles_end(pack):
    """Of modules, and of names that two packages import from each other."""
    pack(
        **{
            "one": "from . import two\nfrom .circle import nowhere",
            "two": "from . import one\nA = 1",
            "circle/__init__": "from ..ring import nowhere\nfrom ..ring import *",
            "ring/__init__": "from ..circle import nowhere\nfrom ..circle import *",
        }
    )
    digest = pack(**{"nodes/main": "from .. import one"})
    assert {"nodes.main", "one", "two"} <= used(digest)
    after = pack(two="from . import one\nA = 2")
    assert after.digest != digest.digest


def test_a_syntax_error_in_a_helper(pack):
    with pytest.raises(BadSource, match=r"deep\.py:2: .*was never closed"):
        pack(**{"tools/deep": "FACTOR = 2\nx = (1"})


@pytest.mark.parametrize("content", [b"x = '\xff'", b"x = 1\0"])
def test_a_helper_that_is_no_text(pack, tmp_path, content):
    (tmp_path / "pack" / "tools" / "deep.py").write_bytes(content)
    with pytest.raises(BadSource, match=r"deep\.py"):
        pack()


def test_an_optional_part_that_is_missing_and_comes(pack):
    before = pack(**{"nodes/main": "try:\n    from ..extra import more\nexcept ImportError:\n    more = None"})
    assert used(before) == {"nodes.main", "extra"}
    after = pack(extra="more = 1")
    assert used(after) == used(before)
    assert after.digest != before.digest


def test_a_compiled_part_counts_by_its_bytes(pack, tmp_path):
    from importlib.machinery import EXTENSION_SUFFIXES

    binary = tmp_path / "pack" / f"fast{EXTENSION_SUFFIXES[0]}"
    binary.write_bytes(b"one")
    before = pack(**{"nodes/main": "from ..fast import run"})
    binary.write_bytes(b"two")
    assert used(before) == {"nodes.main", "fast"}
    assert pack().digest != before.digest


def test_a_namespace_package(pack):
    """A folder without __init__."""
    pack(**{"plain/part": "X = 1"})
    assert used(pack(**{"nodes/main": "from ..plain import part"})) == {"nodes.main", "plain.part"}
    assert used(pack(**{"nodes/main": "import pack.plain.part as p\np.X"})) == {"nodes.main", "plain.part"}


def test_a_pack_in_a_zip_archive(tmp_path, monkeypatch):
    def digest_with(factor, number):
        archive = tmp_path / f"packs{number}.zip"
        with zipfile.ZipFile(archive, "w") as file:
            file.writestr("zipped/__init__.py", "")
            file.writestr("zipped/main.py", "from . import helper")
            file.writestr("zipped/helper.py", f"FACTOR = {factor}")
        with monkeypatch.context() as patch:
            patch.setattr(sys, "path", [str(archive)])
            return module_digest("zipped.main")

    first, same, other = digest_with(1, 1), digest_with(1, 2), digest_with(2, 3)
    assert set(first.modules) == {"zipped.main", "zipped.helper"}
    assert first == same != other


def test_byte_code_alone_is_no_source(tmp_path, monkeypatch):
    package = tmp_path / "bare"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "main.py").write_text("X = 1")
    py_compile.compile(str(package / "main.py"), cfile=str(package / "main.pyc"))
    (package / "main.py").unlink()
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(NoSource, match=r"bare\.main"):
        module_digest("bare.main")


def test_no_such_module():
    with pytest.raises(NoSource, match="no_such_pack"):
        module_digest("no_such_pack.main")


def test_functions_without_source():
    """Built-in ones, and those made by exec or typed at a prompt."""
    space = {"__name__": "typed"}
    exec("def typed(): pass", space)
    for function in (len, space["typed"]):
        with pytest.raises(NoSource, match="no source file"):
            code_digest(function)


def test_a_function_is_found_through_its_wrappers(tmp_path, monkeypatch):
    """And a loaded module counts as it was loaded, until it is reloaded."""
    (tmp_path / "loose.py").write_text(
        "import functools\n"
        "import loose_helper\n"
        "def wrap(f):\n"
        "    @functools.wraps(f)\n"
        "    def inner(): return f()\n"
        "    return inner\n"
        "@wrap\n"
        "def run(): return 1\n"
    )
    (tmp_path / "loose_helper.py").write_text("X = 1")
    monkeypatch.syspath_prepend(str(tmp_path))
    try:
        loose = importlib.import_module("loose")
        before = code_digest(loose.run)
        assert set(before.modules) == {"loose", "loose_helper"}  # a file beside it counts as its own
        assert before == module_digest("loose")
        (tmp_path / "loose_helper.py").write_text("X = 22")
        assert code_digest(loose.run) == before  # the code in memory is still the old one
        importlib.reload(sys.modules["loose_helper"])
        assert code_digest(loose.run).digest != before.digest
    finally:
        for name in ("loose", "loose_helper"):
            sys.modules.pop(name, None)


SCRIPT = """
import helper
import graphtex.sockets
import numpy
from graphtex.cache import code_digest
def run(x): return helper.twice(x)
digest = code_digest(run)
print(sorted(digest.modules), digest.packages, digest.digest)
"""


def test_a_node_of_a_script(tmp_path):
    """Its file and the modules beside it; also when it is run as a module."""
    (tmp_path / "script.py").write_text(SCRIPT)
    (tmp_path / "helper.py").write_text("def twice(x): return 2 * x")

    def told(*command):
        return subprocess.run(
            [sys.executable, *command], cwd=tmp_path, capture_output=True, text=True, check=True
        ).stdout

    first = told("script.py")
    assert first.startswith("['__main__', 'helper'] ('numpy',) ")
    assert told("-m", "script").startswith("['helper', 'script'] ('numpy',) ")
    (tmp_path / "helper.py").write_text("def twice(x): return 2 * x  # x + x")
    assert told("script.py") == first
    (tmp_path / "helper.py").write_text("def twice(x): return 3 * x")
    assert told("script.py") != first
