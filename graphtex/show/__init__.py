"""Draws a graph as a person wants to see it: an SVG, a Mermaid flowchart, or a page of its own."""

from graphtex.show.flowchart import mermaid
from graphtex.show.page import html
from graphtex.show.paint import svg
from graphtex.show.scene import Mark

__all__ = ["Mark", "html", "mermaid", "svg"]
