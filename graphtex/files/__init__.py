"""Graph files: strict YAML in, canonical YAML out."""

from graphtex.files.disk import read_file, save
from graphtex.files.reader import read
from graphtex.files.writer import dumps
from graphtex.files.yamltree import read_scalar

__all__ = ["dumps", "read", "read_file", "read_scalar", "save"]
