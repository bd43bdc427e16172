import numpy as np
import pytest

from graphtex_nodes import bricks, optimize, pebbles, sample, woven_cloth
from graphtex_nodes.numerics.lattice import FAR, in_step, repeats, stretched
from graphtex_nodes.numerics.levels import automatic_levels, coarse_repeats
from graphtex_nodes.numerics.pyramid import pyramid

Y, X = np.mgrid[:128, :128].astype(np.float64)
HEXAGONS = np.array([[0.0, 14.0], [12.1, 7.0]])


def periodic(shifts):
    """A picture of round spots on a lattice."""
    phases = np.linalg.inv(shifts)
    turns = [2 * np.pi * (Y * phases[0, axis] + X * phases[1, axis]) for axis in (0, 1)]
    return np.exp(2 * (np.cos(turns[0]) + np.cos(turns[1]))).astype(np.float32)[..., None]


def courses(period):
    """Rows of blocks of random lengths."""
    rng = np.random.default_rng(3)
    rows = [rng.normal(size=24).repeat(rng.integers(6, 14, 24))[:128] for _ in range(128)]
    row = (Y[:, 0] // period).astype(int)
    image = np.stack([rows[number] for number in row])
    image[(Y[:, 0] % period) < 2] = -3
    return image.astype(np.float32)[..., None]


def faults(source, shifts):
    """Pairs of neighbours out of step by more than a seventh of a period, of a thousand pixels."""
    places = source[..., 1:3] - np.stack(np.mgrid[: source.shape[0], : source.shape[1]], axis=-1)
    phases = places @ np.linalg.inv(shifts)
    pairs = np.diff(phases, axis=0), np.diff(phases, axis=1)
    apart = sum((np.abs(pair - np.rint(pair)) > 1 / 7).any(axis=-1).sum() for pair in pairs)
    return 1000 * float(apart) / places[..., 0].size


@pytest.mark.parametrize(
    "shifts", [HEXAGONS, np.array([[0.0, 11.5], [16.0, 0.0]]), np.array([[13.0, -3.0], [3.0, 13.0]])]
)
def test_cells(shifts):
    """Found shifts are whole multiples of the true ones with the same area of a cell; noise does not hide them."""
    noise = np.random.default_rng(1).normal(0, 3, (128, 128, 1)).astype(np.float32)
    for image in (periodic(shifts), periodic(shifts) + noise):
        found = repeats(image, 2)
        assert found is not None
        assert found.cells
        multiples = found.shifts @ np.linalg.inv(shifts)
        assert np.abs(multiples - np.rint(multiples)).max() < 0.03
        assert abs(np.linalg.det(np.rint(multiples))) == 1


@pytest.mark.parametrize("period", [9, 14, 21])
def test_rows_and_columns(period):
    image = courses(period)
    found = repeats(image, 2)
    assert found is not None
    assert not found.cells
    assert found.period == pytest.approx(period, abs=0.2)
    assert found.shifts == pytest.approx(np.diag([found.period, 1]))
    across = repeats(image.swapaxes(0, 1), 2)
    assert across is not None
    assert across.shifts == pytest.approx(np.diag([1, found.period]))


@pytest.mark.parametrize(
    "image",
    [
        np.random.default_rng(0).random((128, 128, 3), np.float32),
        np.ones((128, 128, 1), np.float32),
        np.zeros((1, 40, 1), np.float32),
        (X + Y).astype(np.float32)[..., None],
        periodic(HEXAGONS * 3.5),
        courses(7),
        pebbles(width=128, height=128, rng=1).image,
        sample(name="gravel")[:128, :128],
    ],
)
def test_nothing_repeats(image):
    """Nor does what is seen less than four times, or has too small a period."""
    assert repeats(image, 2) is None


def test_repeats_in_pixels_of_the_coarsest_level():
    image = periodic(HEXAGONS)
    found = coarse_repeats(pyramid(image, 3))
    assert found is not None
    assert found.period * 4 == pytest.approx(14, abs=0.2)
    assert coarse_repeats(pyramid(image[:1, :1], 1)) is None


def test_a_level_less_for_cells():
    """Cells of 20 pixels have 2.5 of them on a fourth level."""
    cloth = woven_cloth(width=256, height=256, rng=1).image
    assert automatic_levels(cloth) == 3


@pytest.mark.parametrize("periods", [(64, 0), (0, 50), (64, 50), (0, 0)])
def test_around(periods):
    """Whole multiples lead to the period of each axis, and shifts hardly change."""
    found = stretched(HEXAGONS / 2, periods)
    for axis, period in enumerate(periods):
        if period:
            multiples = period * np.eye(2)[axis] @ np.linalg.inv(found)
            assert multiples == pytest.approx(np.rint(multiples))
    assert np.abs(found - HEXAGONS / 2).max() <= FAR * 9
    assert (found == HEXAGONS / 2).all() == (periods == (0, 0))


def test_around_keeps_shifts_that_do_not_fit():
    """Between 1 and 2 shifts of 10 there is none of about 10."""
    shifts = np.diag([10.0, 10.0])
    assert (stretched(shifts, (15, 0)) == shifts).all()
    assert (stretched(shifts, (2, 2)) == shifts).all()


def test_in_step():
    """Places stand in their cells as corners do, hardly between pixels, near where they were, and inside."""
    rng = np.random.default_rng(0)
    corners = np.stack(np.meshgrid(np.arange(0, 200, 4), np.arange(0, 160, 4), indexing="ij"), axis=-1)
    places = rng.integers(-5, 60, corners.shape).astype(np.int32)
    own, there = HEXAGONS / 2, HEXAGONS / 2 * [1.02, 0.97]
    found = in_step(places, corners, ((-3, -3), (47, 39)), own, there)
    assert found.dtype == np.int32
    assert ((found >= -3) & (found <= [47, 39])).all()
    phase = found @ np.linalg.inv(own) - corners @ np.linalg.inv(there)
    off = np.abs((phase - np.rint(phase)) @ own)
    assert off.max() <= 0.5 + 1e-6
    inside = np.clip(places, -3, [47, 39])
    assert np.hypot(*np.moveaxis(found - inside, -1, 0)).max() < 3 * 7


@pytest.mark.parametrize(
    ("make", "shifts", "before"),
    [(bricks, np.diag([17.4, 1e9]), 10), (woven_cloth, np.array([[14.0, -14.0], [14.0, 14.0]]), 5)],
)
def test_lattices_join_without_faults(make, shifts, before, monkeypatch):
    """On pieces that begin at random there are several times as many places out of step."""
    exemplar = make(width=256, height=256, rng=1).image
    assert faults(optimize(exemplar, width=384, height=384, rng=2).source, shifts) < 4
    monkeypatch.setattr("graphtex_nodes.numerics.synthesis.repeated", lambda *_: None)
    assert faults(optimize(exemplar, width=384, height=384, rng=2).source, shifts) > before
