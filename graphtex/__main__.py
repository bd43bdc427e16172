"""``python -m graphtex`` and the command ``graphtex``."""

import sys


def main() -> int:
    """Run the command line and return its exit status."""
    from graphtex.cli.app import call

    return call(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
