"""The factorisation that all warps of a texture share (Liu et al. 2009, section 4.2 and 5)."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from graphtex import QUIET, Context, node
from graphtex_nodes.splicing._stiffness import RULES, Constraint, centre_rows, matrix, pixel_rows
from graphtex_nodes.splicing.tags import checked_tag
from graphtex_nodes.splicing.texton_labels import RIM
from graphtex_nodes.splicing.values import Extension, Factor

Array = NDArray[Any]
LEAF, SEPARATOR = 6, 2
Hold = Annotated[
    Constraint, Field(description="what of a texton is moved: its centre, or all its pixels, so that it can turn")
]


class Factors(NamedTuple):
    """Factors of the matrices of the x and the y component."""

    x: Factor
    y: Factor


@node
def factor_warp(elements: Extension, *, hold: Hold = "centres", ctx: Context = QUIET) -> Factors:
    r"""Factorise the matrix of equation 5, which depends on a texture and not on where its textons go.

    One component of the displacement minimises

    .. math:: \lambda_G \sum_{p \in C} (\Delta(p) - d_p)^2
              + \lambda_R \sum_{p \in S} \Big(\Delta(p) - \sum_{q \in N_4(p)} \tilde u_{pq} \Delta(q)\Big)^2
              + \mu \sum_{pq} (\Delta(p) - \Delta(q))^2

    with C the textons (all, so that the matrix is one for every arrangement), S all pixels (where the background is
    rigid, B=c, those of elements count a fifty-thousandth), and weights u by table 1:
    :math:`u_{pq} = M(q) + \varepsilon`, times :math:`\lambda_P` for neighbours across the component's direction unless
    both are not rigid or both lie along a border of the rigid part.

    Parameters
    ----------
    elements
        An extension of ``n`` pixels.
    hold
        ``centres`` is the paper's. ``elements`` constrains all pixels of a texton, and the rim around them, to a
        similarity; then the smoothness counts outside of them only.

    Returns
    -------
    Factors
        For tags F=c and F=d both are the same; for B=c, with :math:`\lambda_P = 0`, they differ.

    Raises
    ------
    ValueError
        There is no texton, or the tag is not known.

    Notes
    -----
    Departures. The paper's second sum runs over the rigid pixels alone, which leaves the others open: the membrane
    (:math:`\mu = 10^{-6} \lambda_R`) determines them. Where the foreground is rigid, S is all pixels, so that elements
    keep crisp rims. Where the background is, a little stiffness lets elements follow their centres, at which a membrane
    alone would be drawn to a point, and pass that on to the joints. Disjoint elements (F=d) that touch hold each other
    no more than the ground does. Textons between pixels are constrained bilinearly.
    """
    if len(elements.points) == 0:
        raise ValueError("elements: expected at least one texton, got none")
    tag = checked_tag(elements.tag, "elements.tag")
    rules = RULES[tag]
    rigid = elements.mask if rules.foreground else ~elements.mask
    rows, free = constraint_rows(elements, hold)
    ctx.progress(0.0, "factorising")
    order = dissected(*rigid.shape)
    bodies = elements.labels if tag == "F=d" else None
    x = _factor(matrix(rigid, rules, rows, free, bodies, False), order)
    if rules.crossing == 1:  # neighbours across and along a component's direction count alike
        return Factors(x, x)
    ctx.progress(0.5, "factorising")
    return Factors(x, _factor(matrix(rigid, rules, rows, free, bodies, True), order))


def constraint_rows(elements: Extension, hold: Constraint) -> tuple[Any, Array | None]:
    """Rows of the constraint, and the pixels (h, w) that it holds all over; None for the centres."""
    if hold == "centres":
        return centre_rows(elements.points, elements.mask.shape), None
    held = held_labels(elements)
    return pixel_rows(held), held >= 0


def held_labels(elements: Extension) -> Array:
    """Texton of each pixel that moves with one as a whole: its own and the rim around them, where colours mix."""
    from scipy.ndimage import grey_dilation

    labels = elements.labels
    return np.where(labels >= 0, labels, grey_dilation(labels, (2 * RIM + 1, 2 * RIM + 1)))


def _factor(system: Any, order: Array) -> Factor:
    """Factor of a symmetric positive definite matrix in a given order, without pivoting."""
    from scipy.sparse.linalg import splu

    permuted = system[order][:, order].tocsc()
    found = splu(permuted, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    lower = found.L.tocsc()
    if (lower.indices[lower.indptr[:-1]] != np.arange(len(order))).any():
        lower.sort_indices()
    return Factor(order.astype(np.int32), lower.indptr, lower.indices, lower.data, found.U.diagonal())


def dissected(height: int, width: int) -> Array:
    """Order of a grid's pixels by nested dissection: halves first, then the lines that part them.

    Lines are two pixels wide, since the matrix couples pixels at a distance of two.
    """
    found: list[Array] = []

    def cut(pixels: Array) -> None:
        if pixels.shape[0] < pixels.shape[1]:
            pixels = pixels.T
        if pixels.shape[0] <= LEAF:
            found.append(pixels.ravel())
            return
        middle = (pixels.shape[0] - SEPARATOR) // 2
        cut(pixels[:middle])
        cut(pixels[middle + SEPARATOR :])
        found.append(pixels[middle : middle + SEPARATOR].T.ravel())

    cut(np.arange(height * width).reshape(height, width))
    return np.concatenate(found)
