"""Prints the figures of some groups; status 1 if a bound is missed."""

import argparse
import importlib
import json
import sys
from pathlib import Path

from benchmarks.figures import Figure, table

GROUPS = ("engine", "perspective", "plain", "speed", "completion", "materials", "splicing", "pairs")
WITH_TEXTURES = {"plain", "materials", "perspective", "pairs"}  # groups that can measure the user's own pictures


def main() -> int:
    """Run the groups that the command line names, all without names."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=f"one of {', '.join(GROUPS)}; all without it")
    parser.add_argument("--json", action="store_true", help="print a list of objects")
    parser.add_argument("--pictures", type=Path, metavar="DIR", help="write the pictures that were measured")
    parser.add_argument("--textures", type=Path, metavar="DIR", help="measure a folder's pictures, where a group can")
    arguments = parser.parse_args()
    unknown = set(arguments.groups) - set(GROUPS)
    if unknown:
        parser.error(f"unknown group {', '.join(sorted(unknown))}; known: {', '.join(GROUPS)}")
    found: list[Figure] = []
    for group in arguments.groups or GROUPS:
        module = importlib.import_module(f"benchmarks.{group}")
        if not arguments.json:
            print(f"{group}:", flush=True)
        options = {"textures": arguments.textures} if group in WITH_TEXTURES else {}
        figures: list[Figure] = list(module.figures(arguments.pictures, **options))
        found += figures
        if not arguments.json:
            print(table(figures), flush=True)
    if arguments.json:
        print(json.dumps([figure.to_json() for figure in found], indent=1))
    return int(any(figure.ok is False for figure in found))


if __name__ == "__main__":
    sys.exit(main())
