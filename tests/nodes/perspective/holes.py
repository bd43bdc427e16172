"""Holes of all shapes in a picture of 40 x 50 pixels."""

import numpy as np

SHAPE = 40, 50
KINDS = ["pixel", "corner", "row", "frame", "sprinkled", "nearly all"]


def hole_of(kind):
    hole = np.zeros(SHAPE, bool)
    if kind == "pixel":
        hole[7, 9] = True
    elif kind == "corner":
        hole[:12, :9] = True
    elif kind == "row":
        hole[20] = True
    elif kind == "frame":
        hole[:] = True
        hole[10:30, 12:40] = False
    elif kind == "sprinkled":
        hole = np.random.default_rng(4).random(SHAPE) < 0.5
    else:
        hole[:] = True
        hole[3, 4] = hole[30, 44] = False
    return hole
