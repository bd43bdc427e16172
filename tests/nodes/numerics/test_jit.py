import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from graphtex import Cancelled
from graphtex_nodes.numerics import jit

FACTORS = "FACTOR = {factor}\n"
SCALED = """
from graphtex_nodes.numerics.factor_kernels import FACTOR
from graphtex_nodes.numerics.jit import kernel


@kernel("const f4[:], f4[:]")
def scale(values, out):
    for index in range(values.size):
        out[index] = FACTOR * values[index]
"""
RUN = """
import numpy as np
from graphtex_nodes.numerics import jit
cold = jit.is_cold("scaled_kernels")
from graphtex_nodes.numerics.scaled_kernels import scale
values = np.ones(1, np.float32)
values.flags.writeable = False
out = np.zeros(1, np.float32)
scale(values, out)
print(cold, out[0], jit.is_cold("scaled_kernels"), sum(scale.stats.cache_hits.values()))
"""


@pytest.fixture
def package(tmp_path):
    """A copy of the kernel decorator beside two kernel files, one of which uses a constant of the other."""
    folder = tmp_path / "code" / "graphtex_nodes" / "numerics"
    folder.mkdir(parents=True)
    for place in (folder.parent, folder):
        (place / "__init__.py").write_text("")
    shutil.copy(jit.__file__, folder / "jit.py")
    (folder / "factor_kernels.py").write_text(FACTORS.format(factor=2))
    (folder / "scaled_kernels.py").write_text(SCALED)
    return folder


def run(package: Path, cache: Path) -> list[str]:
    environment = os.environ | {"PYTHONPATH": str(package.parent.parent), "GRAPHTEX_CACHE_DIR": str(cache)}
    command = [sys.executable, "-c", RUN]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, cwd=package)
    return done.stdout.split()


def test_constant_of_another_kernel_file(package, tmp_path):
    """The second run reads the cache; after a change in the other file the kernel is compiled anew."""
    assert run(package, tmp_path) == ["True", "2.0", "False", "0"]
    assert run(package, tmp_path) == ["False", "2.0", "False", "1"]
    (package / "factor_kernels.py").write_text(FACTORS.format(factor=3))
    assert run(package, tmp_path) == ["True", "3.0", "False", "0"]
    assert len(list((tmp_path / "kernels").iterdir())) == 2


def test_works_where_nothing_can_be_written(package, tmp_path):
    (tmp_path / "file").write_text("not a folder")
    assert run(package, tmp_path / "file")[:2] == ["True", "2.0"]
    assert run(package, tmp_path / "file")[3] == "0"


def test_old_folders_are_removed(tmp_path):
    for age in range(7):
        folder = tmp_path / f"digest{age}"
        folder.mkdir()
        os.utime(folder, (1000 - age, 1000 - age))
    jit._remove_old(tmp_path, tmp_path / "digest6")
    assert sorted(path.name[-1] for path in tmp_path.iterdir()) == ["0", "1", "2", "3", "6"]


def test_refuses_a_kernel_that_the_digest_would_not_see():
    with pytest.raises(ValueError, match=r"_kernels\.py"):
        jit.kernel("f4[:]")(lambda values: None)


class Listener:
    """Notes what is told, and stops what is at work when it has been told something `patience` times."""

    def __init__(self, patience=99):
        self.said = []
        self.patience = patience

    def progress(self, fraction, message=""):
        self.said.append(message)
        if len(self.said) > self.patience:
            raise Cancelled


@pytest.fixture
def compiled(monkeypatch):
    """Files that were compiled; those named cold have to be."""
    done = []
    files = [jit._PACKAGE / "numerics" / f"{name}_kernels.py" for name in ("cold", "cool", "warm")]
    monkeypatch.setattr(jit, "kernel_files", lambda: files)
    monkeypatch.setattr(jit, "is_cold", lambda name: name != "warm_kernels")
    monkeypatch.setattr(jit, "import_module", done.append)
    return done


def test_compiles_and_tells_of_only_what_is_cold(compiled):
    listener = Listener()
    jit.announce(listener, "warm_kernels")
    assert (listener.said, compiled) == ([], [])
    jit.announce(listener, "warm_kernels", "cool_kernels", "cold_kernels")
    assert listener.said == ["compiling kernels, once (1 of 2)", "compiling kernels, once (2 of 2)"]
    assert compiled == ["graphtex_nodes.numerics.cold_kernels", "graphtex_nodes.numerics.cool_kernels"]


def test_can_be_stopped_between_two_files(compiled):
    with pytest.raises(Cancelled):
        jit.announce(Listener(patience=1), "cold_kernels", "cool_kernels")
    assert compiled == ["graphtex_nodes.numerics.cold_kernels"]
