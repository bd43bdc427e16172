"""Kernel that prices the seams between pieces of a picture."""

# mypy: allow-untyped-defs

import numpy as np

from graphtex_nodes.numerics.jit import kernel


@kernel("const f4[:,:,:], i8[:], i8[:], const i8[:], const i8[:], f8, f8, f8[:]")
def join_costs(copies, ones, others, first, second, join, factor, costs):
    """Cost of each edge (m,) whose ends show the pieces ``ones`` and ``others``; 0 where they are the same.

    ``copies`` (k, n, c) are the colours of all pieces at all pixels, ``first`` and ``second`` the pixels at the edges'
    ends. A seam costs ``join`` and ``factor`` times the distances of the two pieces' colours at both ends.
    """
    for edge in range(first.size):
        a, b = ones[edge], others[edge]
        costs[edge] = 0
        if a == b:
            continue
        p, q = first[edge], second[edge]
        here = np.float32(0)
        there = np.float32(0)
        for c in range(copies.shape[2]):
            here += (copies[a, p, c] - copies[b, p, c]) ** 2
            there += (copies[a, q, c] - copies[b, q, c]) ** 2
        costs[edge] = join + factor * (np.sqrt(here) + np.sqrt(there))
