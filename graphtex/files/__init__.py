"""Graph files: strict YAML in, canonical YAML out."""

from graphtex.files.disk import load, loads, read_file, read_scalar, save
from graphtex.files.reader import read
from graphtex.files.writer import dumps

__all__ = ["dumps", "load", "loads", "read", "read_file", "read_scalar", "save"]
