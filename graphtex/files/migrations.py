"""Brings the tree of an older graph file up to the present format, one version at a time.

A step takes the whole document as plain data and returns it in the next version's form. It runs before anything
is checked, so it must leave alone what does not look as it expects: the reader then says what is wrong. Places of
what a step moves are lost; an error there is reported at the nearest place that is still known.
"""

from collections.abc import Callable, Mapping
from typing import Any

from graphtex.document import FORMAT

Document = dict[str, Any]
Step = Callable[[Document], Document]

STEPS: Mapping[int, Step] = {}  # STEPS[n] brings format n to n + 1; format 1 is the first


def bring_up(document: Document, version: int, steps: Mapping[int, Step] = STEPS) -> Document:
    """Return the document in the present format.

    Raises
    ------
    ValueError
        If the version is newer than this graphtex, or older than its first step.
    """
    oldest = FORMAT
    while oldest - 1 in steps:
        oldest -= 1
    known = f"known is format {FORMAT}" if oldest == FORMAT else f"known are formats {oldest} to {FORMAT}"
    if version > FORMAT:
        raise ValueError(f"this file needs a newer graphtex: it has format {version}, {known}")
    if version < oldest:
        raise ValueError(f"there is no format {version}; {known}")
    for number in range(version, FORMAT):
        document = {**steps[number](document), "graphtex": number + 1}
    return document
