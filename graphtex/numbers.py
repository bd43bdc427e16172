"""Numbers in files and reports: the one socket type whose handlers need no picture library."""

import json
from pathlib import Path

from graphtex.handlers import writer
from graphtex.sockets import Number


@writer(Number, suffixes=(".json", ".txt"), default=".json")
def write_number(value: float, path: Path) -> None:
    """Write a number so that it reads back as the same number."""
    path.write_text(json.dumps(value) + "\n", encoding="utf-8")
