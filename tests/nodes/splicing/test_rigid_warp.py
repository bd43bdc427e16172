import numpy as np
import pytest
from scipy.sparse import csc_array

from graphtex import Texture
from graphtex_nodes import factor_warp, hungarian, rigid_warp
from graphtex_nodes.splicing._stiffness import (
    CONSTRAINT,
    MEMBRANE,
    RIGIDITY,
    RULES,
    SOFT,
    centre_rows,
    matrix,
    pixel_rows,
)
from graphtex_nodes.splicing.factor_warp import dissected
from graphtex_nodes.splicing.rigid_warp import solve
from tests.nodes.splicing.scenes import discs, elements, grid, whole


def energy_by_loops(rigid, rules, values, free, labels, component):
    """The second sum and the membrane of equation 5 for one component (0 = x, 1 = y), pixel by pixel."""
    height, width = rigid.shape
    m = lambda p: rigid[p] if 0 <= p[0] < height and 0 <= p[1] < width else True  # noqa: E731
    total = 0.0
    for p in np.ndindex(height, width):
        weights = {}
        for step in ((0, 1), (0, -1), (1, 0), (-1, 0)):
            q = (p[0] + step[0], p[1] + step[1])
            if not (0 <= q[0] < height and 0 <= q[1] < width):
                continue
            total += MEMBRANE * (values[p] - values[q]) ** 2 / 2
            parted = labels is not None and labels[p] != labels[q] and labels[p] >= 0 and labels[q] >= 0
            u = (rigid[q] and not parted) + rules.leak
            across = step[0] != 0 if component == 0 else step[1] != 0
            neither = not rigid[p] and not rigid[q]
            sides = ((0, 1), (0, -1)) if component == 0 else ((1, 0), (-1, 0))
            border = rigid[p] and rigid[q] and any(
                not m((p[0] + s[0], p[1] + s[1])) and not m((q[0] + s[0], q[1] + s[1])) for s in sides
            )  # fmt: skip
            if across and not neither and not border:
                u *= rules.crossing
            weights[q] = u
        if sum(weights.values()) > 0 and not (free is not None and free[p]):
            mean = sum(u * values[q] for q, u in weights.items()) / sum(weights.values())
            share = 1 if rules.foreground or rigid[p] else SOFT
            total += share * RIGIDITY * (values[p] - mean) ** 2
    return total


@pytest.mark.parametrize("tag", ["F=c", "F=d", "B=c"])
@pytest.mark.parametrize("component", [0, 1])
@pytest.mark.parametrize("held", [False, True])
def test_matrix_is_the_energy(tag, component, held):
    rng = np.random.default_rng(7)
    rigid, points = rng.random((7, 9)) < 0.6, rng.uniform(0, 6, (3, 2))
    labels = np.where(rigid, rng.integers(0, 3, (7, 9)), -1) if tag == "F=d" else None
    some = np.where(rng.random((7, 9)) < 0.3, 0, -1)
    rows, free = (pixel_rows(some), some >= 0) if held else (centre_rows(points, rigid.shape), None)
    system = matrix(rigid, RULES[tag], rows, free, labels, component == 1)
    values = rng.random((7, 9))
    wanted = energy_by_loops(rigid, RULES[tag], values, free, labels, component)
    wanted += CONSTRAINT * np.sum((rows @ values.ravel()) ** 2)
    assert values.ravel() @ (system @ values.ravel()) == pytest.approx(wanted, rel=1e-10)


def test_centres_are_read_between_pixels():
    values = np.arange(20.0).reshape(4, 5)  # 5 y + x
    np.testing.assert_allclose(centre_rows(np.array([[1.25, 2.5], [4, 3]]), (4, 5)) @ values.ravel(), [13.75, 19])


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (23, 17)])
def test_dissection_takes_each_pixel_once(shape):
    assert sorted(dissected(*shape)) == list(range(shape[0] * shape[1]))


@pytest.mark.parametrize("tag", ["F=d", "B=c"])
def test_the_factor_solves_the_system(tag):
    """Against a dense solution."""
    extension = whole(discs(grid(10, (20, 30), 5), (20, 30), 3, tag))
    found = hungarian(extension, elements(extension.points + np.random.default_rng(2).normal(0, 1, (6, 2))))
    warp = rigid_warp(extension, found.moves, *factor_warp(extension))
    rigid = extension.mask if tag == "F=d" else ~extension.mask
    rows = centre_rows(extension.points, rigid.shape)
    shift = found.moves.targets - extension.points
    for component in (0, 1):
        system = matrix(rigid, RULES[tag], rows, None, None, component == 1)
        solution = np.linalg.solve(system.toarray(), CONSTRAINT * (rows.T @ shift[:, component]))
        np.testing.assert_allclose(warp[..., component].ravel(), solution, atol=1e-4)


def test_all_right_sides_at_once_are_as_each_by_itself():
    """Also where columns of a factor share their entries in blocks, as they do below the lines that part a grid."""
    factor = factor_warp(whole(discs(grid(10, (40, 50), 5), (40, 50), 3))).x
    size = len(factor.order)
    lower = csc_array((factor.values, factor.rows, factor.starts), shape=(size, size)).toarray()
    right_side = np.random.default_rng(3).normal(0, 1, (size, 3))
    found = solve(factor, right_side)
    permuted = lower @ (factor.pivots[:, None] * (lower.T @ found[factor.order]))
    np.testing.assert_allclose(permuted, right_side[factor.order], atol=1e-9)
    for side in range(3):
        np.testing.assert_array_equal(solve(factor, right_side[:, [side]])[:, 0], found[:, side])


@pytest.mark.parametrize("tag", ["F=d", "F=c", "B=c"])
def test_a_shift_of_all_is_a_shift(tag):
    extension = whole(discs(grid(), (64, 64), tag=tag))
    found = hungarian(extension, elements(extension.points + np.array([3, -2])))
    warp = rigid_warp(extension, found.moves, *factor_warp(extension))
    np.testing.assert_allclose(warp, np.broadcast_to([3.0, -2.0], (64, 64, 2)), atol=1e-3)


def jittered(tag, amount=3.0):
    extension = whole(discs(grid(), (64, 64), 5, tag))
    places = extension.points + np.random.default_rng(4).uniform(-amount, amount, extension.points.shape)
    moves = hungarian(extension, elements(places)).moves
    return extension, moves, rigid_warp(extension, moves, *factor_warp(extension))


def test_elements_move_as_rigid_bodies():
    """Centres within 0.1 px; inside elements the Jacobian is the identity to 0.005 at the 95th percentile."""
    extension, moves, warp = jittered("F=d")
    rows = centre_rows(extension.points, extension.mask.shape)
    moved = np.stack([rows @ warp[..., k].ravel().astype(float) for k in (0, 1)], axis=1)
    assert np.abs(moved - (moves.targets - moves.points)).max() <= 0.1
    assert np.quantile(stretch(warp, extension.mask), 0.95) <= 0.005
    assert np.quantile(stretch(warp, ~extension.mask), 0.5) > 0.05, "the ground takes it all"


def test_bricks_follow_their_centres():
    """Bricks of 13 x 13 pixels move aside by 1.5 in turn: so does most of what is near; with no stiffness 0.4 to 0.5 of it."""
    y, x = np.mgrid[:64, :64]
    points = grid(start=6.0)
    extension = whole(Texture(np.zeros((64, 64, 1), np.float32), (x % 16 < 13) & (y % 16 < 13), points, "B=c"))
    aside = np.where((np.arange(16) + np.arange(16) // 4) % 2, 1.5, -1.5)
    found = hungarian(extension, elements(points + aside[:, None] * (1, 0)))
    warp = rigid_warp(extension, found.moves, *factor_warp(extension))
    for (px, py), step in zip(points, aside, strict=True):
        assert warp[np.hypot(x - px, y - py) <= 3, 0].mean() / step > 0.57


def test_disjoint_elements_that_touch_part():
    """Two halves of a bar, each with a texton, move apart; the bar of a connected foreground is stretched."""
    bar = discs([[10, 10], [14, 10], [18, 10], [22, 10]], (20, 32), 3)._replace(points=np.array([[10.0, 10], [22, 10]]))
    halves = []
    for tag in ("F=d", "F=c"):
        extension = whole(bar._replace(tag=tag))
        moves = hungarian(extension, elements([[9, 10], [25, 10]])).moves
        halves.append(rigid_warp(extension, moves, *factor_warp(extension))[10, [8, 15, 17, 24], 0])
    np.testing.assert_allclose(halves[0], [-1, -1, 3, 3], atol=0.05)
    assert halves[1][2] - halves[1][1] < 1


def stretch(warp, mask):
    """Largest entry of the displacement's derivative at pixels whose neighbours are in the mask, too."""
    across, down = np.diff(warp, axis=1)[:-1], np.diff(warp, axis=0)[:, :-1]
    inside = mask[:-1, :-1] & mask[1:, :-1] & mask[:-1, 1:]
    return np.maximum(np.abs(across).max(axis=2), np.abs(down).max(axis=2))[inside]


def test_held_elements_turn_and_grow():
    """Each pixel of an element goes where the similarity takes it, within 0.05 px."""
    extension = whole(discs(grid(24, (72, 72), 12), (72, 72), 6))
    found = hungarian(extension, elements(extension.points, angles=30, scales=1.25))
    warp = rigid_warp(extension, found.moves, *factor_warp(extension, hold="elements"), hold="elements")
    turn = 1.25 * np.array([[np.cos(np.pi / 6), -np.sin(np.pi / 6)], [np.sin(np.pi / 6), np.cos(np.pi / 6)]])
    row, column = np.nonzero(extension.mask)
    centre = extension.points[extension.labels[row, column]]
    place = np.stack([column, row], axis=1)
    wanted = centre + (place - centre) @ turn.T
    assert np.abs(place + warp[row, column] - wanted).max() <= 0.05


def test_one_texton():
    extension = whole(discs([[20, 20]]))
    found = hungarian(extension, elements([[25, 18]]))
    warp = rigid_warp(extension, found.moves, *factor_warp(extension))
    np.testing.assert_allclose(warp, np.broadcast_to([5.0, -2.0], (40, 40, 2)), atol=1e-3)


@pytest.mark.parametrize("size", [(1, 1), (1, 20), (20, 1), (5, 3)])
@pytest.mark.parametrize("tag", ["F=d", "B=c"])
def test_small_sizes(size, tag):
    extension = whole(discs([[0, 0]], size, tag=tag))
    found = hungarian(extension, elements([[1, 1]]))
    warp = rigid_warp(extension, found.moves, *factor_warp(extension))
    assert warp.shape == (*size, 2)
    np.testing.assert_allclose(warp, 1, atol=1e-3)


def test_refuses_what_does_not_belong_together():
    one, other = whole(discs(grid(), (64, 64))), whole(discs([[20, 20]]))
    moves = hungarian(one, elements(one.points)).moves
    with pytest.raises(ValueError, match="moves: expected the 1 textons of elements"):
        rigid_warp(other, moves, *factor_warp(other))
    with pytest.raises(ValueError, match="factor_x: expected a factor of 4096 pixels, got 1600"):
        rigid_warp(one, moves, *factor_warp(other))
    with pytest.raises(ValueError, match="elements: expected at least one texton"):
        factor_warp(whole(discs([])))
