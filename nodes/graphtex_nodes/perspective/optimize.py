"""Texture optimisation that keeps the trend of texel scales (Dong, Zhou & Paul 2008, section 4)."""

from functools import partial
from typing import Annotated, NamedTuple

import numpy as np

from graphtex import QUIET, AngleMap, Axes, Context, Image, Mask, Number, Rng, ScaleMap, SourceMap, Vector, node
from graphtex_nodes.perspective._parameters import (
    EFFORT,
    SYNTHESIS_KERNELS,
    AngleWeight,
    Arrows,
    Components,
    Detail,
    Evenness,
    Exponent,
    Gain,
    Iterations,
    Kinds,
    Largest,
    Levels,
    Mirror,
    Quality,
    ScaleMode,
    ScaleWeight,
    Sides,
    Size,
    TurnStep,
    Variance,
    Vote,
    Weights,
    Windows,
    around,
    output_size,
)

SCANT = 4
"""Side of windows, pixels, that see next to nothing."""


class Synthesis(NamedTuple):
    """A texture, where each pixel comes from, and figures to judge it by."""

    image: Image
    source: SourceMap
    energy: Number
    energies: Vector
    coherence: Number
    coverage: Number


@node
def optimize(
    exemplar: Annotated[Image, Axes("h w c")],
    exemplar_scale: Annotated[ScaleMap, Axes("h w")] | None = None,
    target_scale: ScaleMap | None = None,
    usable: Annotated[Mask, Axes("h w")] | None = None,
    start: Annotated[Image, Axes("rows columns c")] | None = None,
    known: Annotated[Mask, Axes("rows columns")] | None = None,
    exemplar_angle: Annotated[AngleMap, Axes("h w")] | None = None,
    target_angle: AngleMap | None = None,
    more: list[Image] | None = None,
    more_scale: list[ScaleMap] | None = None,
    more_usable: list[Mask] | None = None,
    more_angle: list[AngleMap] | None = None,
    *,
    width: Size = 0,
    height: Size = 0,
    scale_weight: ScaleWeight = 1.0,
    scale_mode: ScaleMode = "fixed",
    vote: Vote = "blend",
    levels: Levels = 0,
    windows: Windows = (),
    iterations: Iterations = 4,
    exponent: Exponent = 0.8,
    histogram: Gain = 20.0,
    evenness: Evenness = 2.0,
    variance: Variance = 0.95,
    detail: Detail = 0.3,
    tileable: Sides = "none",
    mirror: Mirror = False,
    resample: Largest = 1.0,
    angle_weight: AngleWeight = 1.0,
    turn_step: TurnStep = 15.0,
    arrows: Arrows = False,
    pca: Components = "apart",
    kinds: Kinds = [],  # noqa: B006 (parameters are copied)
    map_weights: Weights = (),
    quality: Quality = "default",
    rng: Rng = 0,
    ctx: Context = QUIET,
) -> Synthesis:
    r"""Texture like the exemplar whose elements follow a scale map.

    Minimises over the output x, with x_p its window around p and e_p the exemplar's window nearest to it,

    .. math:: E(x) = \sum_p \lVert x_p - e_p \rVert^r = \sum_p \omega_p \lVert x_p - e_p \rVert^2, \quad
              \omega_p = \lVert x_p - e_p \rVert^{r - 2}

    (equations 5 to 7) from coarse to fine, by turns of search (4.2) and weighted vote with histogram matching (4.3,
    equation 8). The scale is one more channel of both images, so a window of the output looks for exemplar windows with
    the colours *and* the texel scale of its place. Without maps, or with ``scale_weight=0``, this is the plain texture
    optimisation of Kwatra et al. (2005).

    Parameters
    ----------
    exemplar
        Shape (h, w, c), any value range.
    exemplar_scale
        Texel scale of each exemplar pixel.
    target_scale
        Texel scale that each output pixel should have. Its shape is the output's unless ``width`` and ``height`` ask
        for another: then it is resampled bilinearly.
    usable
        Parts of the exemplar that may be used; others are not looked at.
    start
        A picture of the output's size to start from. Its coarse forms are what the first search sees.
    known
        Pixels of the output that stay exactly as in ``start``, of which then nothing else is read. Windows are sought
        that agree with them. With ``vote="blend"`` colours of the pieces beside them are bent to meet them.
    exemplar_angle, target_angle
        Direction of the exemplar's texels, 0 (to the right) where not given, and the direction that the output's should
        have: cosine and sine of the angle (of twice the angle, unless ``arrows``) are further channels of both.
    more, more_scale, more_usable, more_angle
        Further exemplars of any size with as many channels, and their maps. Levels are chosen for the smallest of
        those that are at least half as large as the largest; smaller ones serve on fine levels only.
    width, height
        Size of the output.
    scale_weight
        Larger follows the scale more closely, smaller keeps more elements whole: 0.5 suits a target like the exemplar's
        own map; from 2 on pictures suffer. Mere noise of that map (no plane, spread below 8 %) counts a tenth.
    scale_mode
        ``fixed`` keeps the output's scale channel at the target. ``free`` synthesises it with the colours, as the paper
        is printed: a target then only rules the start.
    vote
        What becomes of the last search. ``blend`` takes for each pixel the source that most windows agree on, lets
        large pieces take over the scraps between them along minimum cuts, and pieces fade into each other over five
        pixels and their colours over about sixteen (not where outlines are torn; heights always, other maps never),
        both less in elements with outlines. ``discrete`` leaves that out, to replay exactly; ``mean`` is the paper's.
    levels, windows
        By themselves: as many levels as leave 16 pixels of the exemplar's smaller side, less where a period would no
        longer be seen, where pixels are related over short distances only and for small cells of a lattice, and down to
        8 pixels where a period is seen there; windows of 8 pixels, on the coarsest level before them of 16.
    iterations
        Half of them are on the finest level; the next one has one more than these, the third three times as many, and
        coarser ones six times as many, at most 18.
    exponent, histogram, evenness, variance, detail
        r of the energy; gain of histogram matching; charge for windows used more than once and than others of their
        scale, turned copies together, in mean distances (on coarse levels firmness of prices at which all are used
        evenly); share of variance that PCA keeps, for colours and scale apart; how far its components of colour are
        evened, from 0 to 1 (whitened).
    pca
        ``apart`` keeps the whole of the scale's and direction's main components; ``joint`` is the paper's first form.
    kinds, map_weights
        Kinds make normals turn with their copies and stay unit vectors, and heights meet without cliffs. Weights of
        maps (without kinds of channels) are those of differences in the search: 1, 0, 0 lets the first map guide.
    tileable
        Windows, votes and seams go on over these sides, so that copies of the output join without a seam. Odd sizes
        take longer. Target scales at opposite sides should be alike.
    mirror, resample
        A larger stock of windows: the exemplar's mirror image, and copies of it resampled by factors of 2 ** (1/3) up
        to ``resample``, of which the parts are used whose scale is wanted and that the exemplar has few elements of.
        ``source`` tells both; its rows and columns may then lie between pixels. ``resample=1.3`` makes near rows repeat
        visibly less; larger ones bring the foreshortening of other distances. A picture and its mirror image join
        without a seam, so ``mirror`` may leave symmetric places.
    angle_weight, turn_step, arrows
        With ``target_angle`` copies of the exemplar serve, turned by multiples of ``turn_step`` as far as directions
        are wanted; each takes as much memory as the exemplar. Without ``arrows`` one on its head is the same.
    quality
        ``fast`` halves the passes of a search and the iterations, and does not cut pieces anew: about half the time.
        ``preview`` takes a tenth, and is coarse: it leaves an eighth of the iterations and looks for nothing on the two
        finest levels, where it copies squares of 4 x 4 pixels.

    Returns
    -------
    Synthesis
        ``energy`` is the mean over windows of (mean squared difference of a pixel) ** (r / 2) at the last search,
        ``energies`` those of all searches in order, ``coherence`` the share of neighbouring pixels whose sources are
        neighbours, ``coverage`` the share of the usable exemplars that was used. ``source`` holds indices of 0 for
        ``exemplar``, from 1 for ``more``, and behind the last for known pixels with their own row and column.

    Raises
    ------
    ValueError
        If one map comes without the other, sizes or channels of exemplars disagree, more levels are asked for than the
        exemplar allows, nothing is usable, or ``known`` comes without ``start``.

    Notes
    -----
    Departures from the paper, each because it measured better: the output's scale is held by default; the search is
    PatchMatch from an exact search on the coarsest level; bins of equation 8 are those of pixels and surpluses are
    relative (see ``numerics/histogram.py``); components of colour are partly evened, so that thin lines
    between large areas count; windows in frequent use are charged, as in Kaspar et al. (2015), on coarse levels by the
    prices of optimal transport (Gutierrez et al. 2017), so that all parts keep their share of the area; windows of a
    plain synthesis pay there for copies of what they show up to half an exemplar away, so that repeats keep apart;
    windows reach over the exemplar's border by a quarter of their side or more, where it is mirrored, so that what lies
    there is shown too (nothing mirrored is copied); where nothing else rules what is where, pieces of exemplars that
    repeat themselves, such as paving, walls and cloth, begin in step with each other, so that lattices have no faults,
    and parts of others that get lost are put in (``numerics/completeness.py``); long copies are charged in exemplars
    without outlines; five levels for 256 pixels instead of three; the final image is not the mean: it smudges seams.

    The result depends on the inputs, the parameters and the seed only, not on the number of threads.

    Examples
    --------
    >>> stripes = np.tile(np.float32([0, 0, 1, 1]), (12, 3))[..., None]
    >>> result = optimize(stripes, width=20, height=9, vote="discrete")
    >>> result.image.shape, bool(np.isin(result.image, stripes).all())
    ((9, 20, 1), True)
    """
    from graphtex_nodes.numerics.jit import announce

    announce(ctx, *SYNTHESIS_KERNELS)
    from graphtex_nodes.numerics import atlas, request, seams, sources
    from graphtex_nodes.numerics import levels as plans
    from graphtex_nodes.numerics.materials import bending, renormalised, require_stack
    from graphtex_nodes.numerics.parallel import aside
    from graphtex_nodes.numerics.problem import Settings
    from graphtex_nodes.numerics.synthesis import synthesise

    size = output_size(start, target_angle if target_scale is None else target_scale, exemplar, height, width)
    require_stack("exemplar", exemplar, kinds, ctx.warn)
    weights = request.channel_weights(map_weights, kinds, exemplar.shape[2])
    turned = angle_weight > 0 and (target_angle is not None or exemplar_angle is not None)
    if turned and target_angle is None:
        raise ValueError("target_angle: expected a map beside exemplar_angle (or angle_weight=0), got none")
    exemplars = request.gathered(
        [exemplar, *(more or [])],
        [exemplar_scale, *(more_scale or [])] if scale_weight > 0 else None,
        [usable, *(more_usable or [])],
        [exemplar_angle, *(more_angle or [])] if turned else None,
    )
    stock = atlas.Stock(
        mirror,
        target_scale if scale_weight > 0 else None,
        resample,
        target_angle if turned else None,
        turn_step,
        arrows,
    )
    leader = atlas.leading(exemplars, turned=turned and turn_step > 0)
    sheet = atlas.enlarged(exemplars, stock, 1 << (plans.most_levels(leader.shape) - 1), kinds)
    problem = request.pose(
        sheet.picture,
        size,
        request.Scales(sheet.scale, target_scale, scale_weight, scale_mode == "fixed", exemplars),
        ctx,
        directions=request.Directions(sheet.angle, target_angle, angle_weight, arrows),
        usable=sheet.usable,
        start=start,
        known=known,
        wrap=around(tileable),
        weights=weights,
        origin=sheet.origin[..., :3] if turned and turn_step > 0 else None,
    )
    effort = EFFORT[quality]
    if windows and max(windows) > min(leader.shape[:2]) // 2:
        ctx.warn(
            f"windows: {max(windows)} is more than half of an exemplar of shape {leader.shape}: it is made smaller"
        )
    plan = plans.eased(plans.plan(leader, problem.usable, levels, windows, iterations), effort.fine, effort.coarse)
    room = plan[-1].window
    if room <= SCANT and (not windows or min(windows) > room):
        part = f"shape {leader.shape}" if usable is None and more_usable is None else "its usable part"
        ctx.warn(f"exemplar: {part} has room for windows of {room} x {room} pixels only: too little to see elements in")
    settings = Settings(
        exponent,
        histogram,
        evenness,
        variance,
        effort.directions,
        detail,
        effort.passes,
        joint=pca == "joint",
        weights=weights,
        replay=problem.plain and vote != "mean",
    )
    result = synthesise(problem, plan, settings, rng, ctx)
    if vote == "mean":
        image, places = result.image[..., : exemplar.shape[2]], result.source
    else:
        bends = bending(kinds, exemplar.shape[2])
        steps = seams.Steps(effort.cut, effort.moves, vote == "blend", effort.level, bends)
        image, places = seams.finish(problem, result, steps, ctx)
    coherence = aside(partial(sources.coherence, places), ctx)
    source, shown = atlas.traced(sheet, places, ctx)
    if problem.known is not None:
        source[problem.known] = 0
        source[problem.known, 0] = len(exemplars)
        source[problem.known, 1:3] = np.argwhere(problem.known)
    return Synthesis(
        image=np.ascontiguousarray(image if vote == "discrete" else renormalised(image, kinds)),
        source=source,
        energy=result.energies[-1],
        energies=np.array(result.energies),
        coherence=coherence(),
        coverage=sources.coverage(shown, [each.usable for each in exemplars]),
    )
