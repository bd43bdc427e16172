"""``python -m graphtex`` and the command ``graphtex``."""

import gc
import io
import sys


def main() -> int:
    """Run the command line and return its exit status."""
    gc.disable()  # until nodes run: what loading makes stays, and looking through it takes a tenth of the start
    from graphtex.cli.app import call

    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # as on stderr: a letter that cannot be shown ends nothing
    return call(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
