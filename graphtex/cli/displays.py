"""Which display a run has."""

import sys

from graphtex.cli.display import Display, PlainDisplay, QuietDisplay


def make_display(quiet: bool) -> Display:
    """Return the display that fits stderr."""
    if quiet:
        return QuietDisplay()
    if sys.stderr.isatty():
        from graphtex.cli.live import LiveDisplay

        return LiveDisplay()
    return PlainDisplay()
