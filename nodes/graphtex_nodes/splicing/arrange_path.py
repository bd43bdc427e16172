"""Arrangements by design: along drawn lines, or from points (Liu et al. 2009, Fig. 9)."""

from typing import Annotated

import numpy as np
from pydantic import Field

from graphtex import Elements, Points, node
from graphtex_nodes.numerics.strokes import Strokes
from graphtex_nodes.splicing.values import Extension


@node
def arrange_path(
    elements: Extension,
    *,
    path: Annotated[Strokes, Field(description="lines on the window that places follow")],
    spacing: Annotated[
        float, Field(ge=0, description="distance along the path in pixels; 0 = as far as the textons are apart")
    ] = 0.0,
    follow: Annotated[bool, Field(description="turn each element as the path runs there")] = True,
) -> Elements:
    """Lay places along drawn lines, the first at the beginning of each.

    Parameters
    ----------
    elements
        The extension that is rearranged; lines are drawn on its window.
    path
        A line of one point is one place. Radius and softness do not matter.
    follow
        An element keeps its direction where the path runs to the right, and is turned by 90 degrees where it runs down.

    Returns
    -------
    Elements
        Places in pixels of the window.

    Raises
    ------
    ValueError
        The path has no line, the file of strokes cannot be read, or there is no texton.
    """
    if len(elements.points) == 0:
        raise ValueError("elements: expected at least one texton, got none")
    lines = path.read()
    if not lines.lines:
        raise ValueError("path: expected at least one line, got none")
    distance = spacing or float(np.sqrt(elements.mask.size / len(elements.points)))
    places, angles = [], []
    for line in lines.lines:
        corners = lines.places(np.array(line.points, np.float64), elements.width, elements.height)
        steps = np.diff(corners, axis=0)
        lengths = np.hypot(*steps.T)
        corners = np.concatenate([corners[:1], corners[1:][lengths > 0]])
        steps, lengths = steps[lengths > 0], lengths[lengths > 0]
        along = np.concatenate([[0.0], np.cumsum(lengths)])
        where = np.arange(0, along[-1] + 1e-9, distance)
        places.append(np.stack([np.interp(where, along, corners[:, axis]) for axis in (0, 1)], axis=1))
        side = np.clip(np.searchsorted(along, where, side="right") - 1, 0, max(len(steps) - 1, 0))
        turned = np.degrees(np.arctan2(steps[:, 1], steps[:, 0])) if len(steps) else np.zeros(1)
        angles.append(turned[side] if follow else np.zeros(len(where)))
    found = np.concatenate(places)
    return Elements(found, np.concatenate(angles), np.ones(len(found)))


@node
def arrange_points(points: Points) -> Elements:
    """Take points as places in pixels of the window, neither turned nor sized; a file of points is one ``x,y`` a line.

    Examples
    --------
    >>> arrange_points(np.array([[3.0, 4.0]])).scales.tolist()
    [1.0]
    """
    return Elements(points.copy(), np.zeros(len(points)), np.ones(len(points)))
