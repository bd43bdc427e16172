"""A field of directions from strokes that show some of it."""

from itertools import pairwise
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, AngleMap, Context, node
from graphtex_nodes.numerics.strokes import Strokes
from graphtex_nodes.perspective._sizes import Pixels

Array = NDArray[Any]

GRID = 128  # longest side that sums are made on: between its places the field is smooth


@node
def flow_from_strokes(
    *,
    strokes: Annotated[Strokes, Field(description="lines that the flow follows")],
    width: Pixels,
    height: Pixels,
    arrows: Annotated[bool, Field(description="whether it matters in which sense strokes were drawn")] = False,
    ctx: Context = QUIET,
) -> AngleMap:
    r"""Direction field that runs along strokes and goes over from one to the other between them.

    With t(s) the tangent at the place s of a stroke of radius r, and d its distance from p, the direction at p is that
    of

    .. math:: \sum_{strokes} \int \frac{t(s)}{(d(p, s)^2 + r^2)^2} ds

    where tangents are doubled in angle unless they are ``arrows``, so that strokes drawn to and fro agree.

    Parameters
    ----------
    strokes
        A wide brush makes the flow smoother near its stroke. Dabs have no direction and do not count.

    Returns
    -------
    AngleMap
        (height, width), degrees clockwise from right, in [-180, 180].

    Raises
    ------
    ValueError
        No stroke has a direction, or the file of strokes cannot be read.

    Examples
    --------
    >>> from graphtex_nodes.numerics.strokes import Stroke
    >>> down = Stroke(points=((1, 0), (1, 5)), radius=1)
    >>> flow_from_strokes(strokes=Strokes(lines=(down,)), width=3, height=2).round(3)
    array([[90., 90., 90.],
           [90., 90., 90.]], dtype=float32)
    """
    from graphtex_nodes.numerics.guidance import resampled
    from graphtex_nodes.perspective.flow_pattern import wrapped

    strokes = strokes.read()
    rows, columns = (min(side, GRID) for side in (height, width))
    y = ((np.arange(rows) + 0.5) * height / rows - 0.5)[:, None]
    x = (np.arange(columns) + 0.5) * width / columns - 0.5
    total = np.zeros((2, rows, columns))
    for stroke in strokes.lines:
        radius = max(strokes.length(stroke.radius, width, height), 0.5)
        points = strokes.places(np.array(stroke.points, np.float64), width, height)
        for place, tangent, length in _pieces(points, max(radius, max(width, height) / GRID)):
            ctx.check()
            turn = np.arctan2(tangent[1], tangent[0]) * (1 if arrows else 2)
            weight = length / ((x - place[0]) ** 2 + (y - place[1]) ** 2 + radius**2) ** 2
            total += weight * np.array([np.cos(turn), np.sin(turn)])[:, None, None]
    if not total.any():
        raise ValueError("strokes: expected at least one line of two different points, got none")
    total /= np.maximum(np.hypot(*total), np.finfo(np.float64).tiny)
    right, down = (resampled(part.astype(np.float32), (height, width)) for part in total)
    return wrapped(np.degrees(np.arctan2(down, right, dtype=np.float64)) / (1 if arrows else 2))


def _pieces(points: Array, step: float) -> list[tuple[Array, Array, float]]:
    """Middle, direction and length of the pieces of a polyline, none longer than a step."""
    result = []
    for start, end in pairwise(points):
        length = float(np.hypot(*(end - start)))
        count = int(np.ceil(length / step))
        for number in range(count):
            middle = start + (end - start) * (number + 0.5) / count
            result.append((middle, (end - start) / length, length / count))
    return result
