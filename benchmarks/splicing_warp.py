"""Elements moved to other places: do they keep their shape, and how long does that take?"""

import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.figures import Figure, in_turns, seconds
from graphtex import QUIET, Context, Elements, Gap, Texture
from graphtex_nodes import (
    align_distributions,
    contact_sheet,
    extend_texture,
    factor_warp,
    hungarian,
    judge_splice,
    neighbour_sets,
    prepare_texture,
    rasterize,
    refine,
    retile,
    rigid_warp,
    sample_texture,
    textons,
)
from graphtex_nodes.image.save import save_image
from graphtex_nodes.splicing._stiffness import RULES, matrix
from graphtex_nodes.splicing.factor_warp import constraint_rows
from graphtex_nodes.splicing.prepare_texture import PreparedTexture
from graphtex_nodes.splicing.values import Extension, Moves

Array = NDArray[Any]

JITTER = 2.0  # pixels by which textons are moved at random, x and y
APART, TOUCHING = ("oranges", "blossoms", "leaves"), "berries"
SAMPLES = (*APART, TOUCHING, "tiles")
QUERIES = 1024  # pixels whose exact neighbours are timed
BOUNDS = {128: 0.15, 192: 0.35}
"""Seconds for a splice and the extension that it is made from, by side."""
ALONE = Context(threads=1)


def figures(pictures: Path | None) -> Iterator[Figure]:
    """Warps against bounds, all pairs of the samples, and times."""
    yield from _elements()
    yield from _joints()
    yield from _walls()
    yield from _pairs(pictures)
    for side, bound in BOUNDS.items():
        yield from _speed(side, bound)


def _elements() -> Iterator[Figure]:
    """Rigid elements; the reference is a warp in which nothing is rigid."""
    centres, strains, plain = [], [], []
    draw = partial(textons, width=128, height=128, size=24.0, spacing=1.3)
    made_of = (
        draw(arrangement="square", form="disc", rng=1),
        draw(arrangement="hexagonal", form="leaf", rng=2),
        draw(arrangement="random", form="flower", rng=3),
    )
    for seed, made in enumerate(made_of):
        extension = extend_texture(_texture(made), factor=1.25)
        moves = _shaken(extension, seed)
        warp = rigid_warp(extension, moves, *factor_warp(extension))
        centres.append(_missed(extension, moves, warp))
        strains.append(_strain(warp, extension.mask))
        soft = extension._replace(mask=np.zeros_like(extension.mask))
        plain.append(_strain(rigid_warp(soft, moves, *factor_warp(soft)), extension.mask))
    yield Figure("rigid elements: off their places, px, farthest", max(centres), "<= 0.1")
    strain, reference = (float(np.quantile(np.concatenate(each), 0.95)) for each in (strains, plain))
    yield Figure("rigid elements: strain, 95th percentile; reference nothing rigid", strain, "<= 0.005", reference)


def _joints() -> Iterator[Figure]:
    """Bed joints of bricks that are moved each by itself; the reference is the same with rigid bricks."""
    made = textons(
        width=192, height=192, size=40.0, form="tile", arrangement="brick", spacing=1.12, proportion=0.45, rng=4
    )
    extension = extend_texture(Texture(made.image, made.mask, made.centres, "B=c"), factor=1.25)
    moves = _shaken(extension, 4)
    widths, slopes = _bed_joints(extension, rigid_warp(extension, moves, *factor_warp(extension)))
    other = extension._replace(tag="F=c")
    wide, steep = _bed_joints(extension, rigid_warp(other, moves, *factor_warp(other)))
    yield Figure("bricks: change of a bed joint's width, px; reference rigid bricks", widths, "<= 0.1", wide)
    yield Figure("bricks: slope of a bed joint; reference rigid bricks", slopes, "<= 0.03", steep)


def _walls() -> Iterator[Figure]:
    """Bricks in arrangements that no warp of a wall reaches, laid anew; the reference is that warp."""
    made = textons(
        width=192, height=192, size=40.0, form="tile", arrangement="brick", spacing=1.125, proportion=0.45, rng=4
    )
    entry = prepare_texture(Texture(made.image, made.mask, made.centres, "B=c"))
    missed, plain = [], []
    for arrangement in ("hexagonal", "random"):
        other = textons(width=192, height=192, size=24.0, arrangement=arrangement, rng=5)
        moves, warp, drawn, _ = splice(entry, _texture(other))
        places = moves.targets[moves.matched > 0] - (entry.extension.left, entry.extension.top)
        for x, y in places[((places >= 24) & (places <= 167)).all(axis=1)]:
            row, column = np.nonzero(drawn.mask & (drawn.cells == drawn.cells[round(y), round(x)]))
            missed.append(float(np.hypot(column.mean() - x, row.mean() - y)))
        plain.append(_misses(entry.extension, moves, warp)[moves.matched > 0])
    off, reference = float(np.mean(missed)), float(np.mean(np.concatenate(plain)))
    yield Figure("bricks laid anew: off their places, px, mean; reference warped bricks", off, "<= 3", reference)
    period = 32.3
    ticks = np.arange(-period / 2, 192 + period, period)
    square = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    moves = hungarian(entry.extension, Elements(square, np.zeros(len(square)), np.ones(len(square)))).moves
    drawn = retile(entry.texture, entry.extension, moves, *rasterize(entry.extension, moves, warp))
    widths = [
        float(np.mean([~mask[round(y), round(x) : round(x + step * period)] for y in rows])) * period
        for mask, rows, x, step, period in (
            (made.mask, np.unique(made.centres[:, 1].round())[1:-1], made.centres[0, 0], 3, 45.0),
            (drawn.mask, ticks[2:-2], ticks[1], 4, period), (drawn.mask.T, ticks[2:-2], ticks[1], 4, period),
        )
    ]  # fmt: skip
    change = max(abs(width - widths[0]) for width in widths)
    yield Figure("bricks laid anew in squares: change of a joint's width, px", change, "<= 0.1")


def _shaken(extension: Extension, seed: int) -> Moves:
    """Every texton goes a little way."""
    count = len(extension.points)
    shift = np.random.default_rng(seed).uniform(-JITTER, JITTER, (count, 2))
    return Moves(extension.points, extension.points + shift, np.zeros(count), np.ones(count), np.ones(count))


def _missed(extension: Extension, moves: Moves, warp: Array) -> float:
    """How far the farthest element is from where it should be."""
    return float(_misses(extension, moves, warp).max())


def _misses(extension: Extension, moves: Moves, warp: Array) -> Array:
    """How far, in pixels, elements (n,) are from where they should be, in the mean of their pixels (0 if none)."""
    labels = extension.labels[extension.labels >= 0]
    count = np.maximum(np.bincount(labels, minlength=len(moves.points)), 1)
    shift = [np.bincount(labels, warp[extension.labels >= 0, axis], len(moves.points)) / count for axis in (0, 1)]
    seen = np.bincount(labels, minlength=len(moves.points)) > 0
    missed: Array = np.hypot(*(np.stack(shift, axis=1) - moves.targets + moves.points).T) * seen
    return missed


def _strain(warp: Array, mask: Array) -> Array:
    """How far the Jacobian's singular values are from 1, at pixels with their neighbours inside elements."""
    warp = warp.astype(np.float64)
    across, down = np.diff(warp, axis=1)[:-1], np.diff(warp, axis=0)[:, :-1]
    inside = mask[:-1, :-1] & mask[1:, :-1] & mask[:-1, 1:]
    jacobian = np.eye(2) + np.stack([across, down], axis=-1)[inside]
    strain: Array = np.abs(np.linalg.svd(jacobian, compute_uv=False) - 1).max(axis=1)
    return strain


def _bed_joints(extension: Extension, warp: Array) -> tuple[float, float]:
    """Mean change of width and mean slope of the horizontal joints in the window."""
    joint = np.concatenate([[False], (~extension.mask).mean(axis=1) > 0.8, [False]])
    starts, stops = np.flatnonzero(joint[1:] & ~joint[:-1]), np.flatnonzero(joint[:-1] & ~joint[1:]) - 1
    columns = slice(extension.left, extension.left + extension.width)
    widths, slopes = [], []
    for top, bottom in zip(starts, stops, strict=True):
        if extension.top <= top and bottom < extension.top + extension.height:
            widths.append(np.abs(warp[bottom, columns, 1] - warp[top, columns, 1]))
            slopes.append(np.abs(np.diff(warp[(top + bottom) // 2, columns, 1])))
    return float(np.mean(widths)), float(np.mean(slopes))


def splice(entry: PreparedTexture, arrangement: Texture, ctx: Context = QUIET) -> tuple[Any, Any, Any, Any]:
    """What was moved, warped, drawn or laid anew, and refined."""
    target = align_distributions(entry.extension, arrangement, ctx=ctx).target
    moves = hungarian(entry.extension, target, ctx=ctx).moves
    warp = rigid_warp(entry.extension, moves, entry.factor_x, entry.factor_y, ctx=ctx)
    drawn = rasterize(entry.extension, moves, warp, ctx=ctx)
    laid = retile(entry.texture, entry.extension, moves, *drawn, ctx=ctx)
    return moves, warp, laid, refine(entry.texture, entry.sets, *laid[:4], ctx=ctx)


def _pairs(pictures: Path | None) -> Iterator[Figure]:
    """What can be told of all pairs of the samples without a reference."""
    entries = [prepare_texture(sample_texture(name=name)) for name in SAMPLES]
    verdicts: dict[str, list[Any]] = {name: [] for name in SAMPLES}
    results: list[Array | Gap] = []
    for name, entry in zip(SAMPLES, entries, strict=True):
        results.append(entry.texture.image)
        for other in entries:
            moves, _, drawn, refined = splice(entry, other.texture)
            results.append(refined.image)
            if other is not entry:
                verdict = judge_splice(entry.extension, moves, refined.mask, refined.source, drawn.holes)
                verdicts[name].append(verdict)
    if pictures:
        save_image(contact_sheet(results, columns=len(SAMPLES) + 1), pictures / "splicing-pairs.png")
    apart = np.mean([verdict for name in APART for verdict in verdicts[name]], axis=0)
    yield Figure("12 splices of disjoint elements: share of elements cut", float(apart[0]), "<= 0.1")
    yield Figure("12 splices of disjoint elements: foreground where it should be, IoU", float(apart[1]), ">= 0.9")
    yield Figure("12 splices of disjoint elements: share of the picture made up", float(apart[2]))
    yield Figure("4 splices of touching elements: share of elements cut", float(np.mean(verdicts[TOUCHING], axis=0)[0]))


def _speed(side: int, bound: float) -> Iterator[Figure]:
    """Seconds of one thread for an output of side x side; compile time is not in them."""
    draw = partial(textons, width=side, height=side, size=24.0, form="leaf", jitter=0.05)
    first, second = _texture(draw(arrangement="hexagonal", rng=5)), _texture(draw(arrangement="square", rng=6))
    entry = prepare_texture(first)
    splice(entry, second)
    size = f"{side} x {side}"
    prepared, extension, new = in_turns(
        partial(splice, entry, second, ALONE),
        partial(extend_texture, first, ctx=ALONE),
        lambda: splice(prepare_texture(first, ctx=ALONE), second, ALONE),
        repeat=3,
    )
    yield Figure(f"splice from a database, {size}, s; reference two new textures", prepared, "", new)
    yield Figure(f"splice from a database, {size}, time over that of new textures", prepared / new, "<= 0.2")
    yield Figure(f"extension, {size}, s", extension)
    yield Figure(f"splice and extension, {size}, s", prepared + extension, f"<= {bound}")
    factor = seconds(partial(factor_warp, entry.extension, ctx=ALONE), 3)
    plain = seconds(_default_order(entry.extension), 3)
    yield Figure(f"factorisation, {size}, s; reference SuperLU's default order", factor, "", plain)
    yield Figure(f"factorisation, {size}, time over that of SuperLU's default order", factor / plain, "<= 0.95")
    sets, exact = seconds(partial(neighbour_sets, first, ctx=ALONE), 3), _exact(entry.sets.fine_appearance)
    yield Figure(f"similar pixels, {size}, s; reference exact search", sets, "", exact)
    yield Figure(f"similar pixels, {size}, time over that of exact search", sets / exact, "<= 0.2")


def _texture(made: Any) -> Texture:
    return Texture(made.image, made.mask, made.centres, "F=d")


def _default_order(extension: Extension) -> Callable[[], object]:
    """The same matrix factorised as SuperLU does by itself."""
    from scipy.sparse.linalg import splu

    def factorise() -> object:
        rows, free = constraint_rows(extension, "centres")
        return splu(matrix(extension.mask, RULES["F=d"], rows, free, extension.labels, False))

    return factorise


def _exact(appearance: Array) -> float:
    """Seconds that the nearest pixels of all would take by comparing each with each, at both spacings."""
    vectors = appearance.reshape(-1, appearance.shape[2])
    start = time.perf_counter()
    for query in vectors[:: max(1, len(vectors) // QUERIES)][:QUERIES]:
        np.argpartition(((vectors - query) ** 2).sum(axis=1), 12)
    return 2 * (time.perf_counter() - start) * len(vectors) / QUERIES
