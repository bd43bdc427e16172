"""Shipped graphs with more than colours and scales: tiles, material maps, replays, flows, two pictures of one ground."""

import numpy as np
import pytest

import graphtex as gt
from graphtex_nodes import bricks, normals_from_height, sand
from graphtex_nodes.numerics.measures import seam_energy
from graphtex_nodes.numerics.orientation import orientation_error
from graphtex_nodes.numerics.sources import INDEX

SIZE = {"width": 90, "height": 76}


@pytest.fixture(scope="module")
def wall() -> dict[str, np.ndarray]:
    """Small bricks: colour, normals and height."""
    made = bricks(width=96, height=96, size=24.0, rng=6)
    return {"exemplar": made.image, "normal": normals_from_height(made.height, relief=3.0), "relief": made.height}


def run(name: str, **inputs: object) -> gt.RunResult:
    return gt.run(gt.load(f"perspective/{name}"), inputs, cache=False)


def test_tileable():
    result = run("tileable", exemplar=sand(width=96, height=96, rng=1).image, **SIZE)
    assert all(seam_energy(result["image"], axis)[1] < 1 for axis in (0, 1))


def test_flow_follows_strokes():
    result = run("flow", exemplar=sand(width=96, height=96, rng=11).image, width=120, height=120)
    assert orientation_error(result["image"], result["flow"]) < 20
    assert result["image"].shape == (120, 120, 3)


def test_material_maps_come_from_one_place(wall: dict[str, np.ndarray]):
    """With discrete votes each pixel of each map is that of the source map."""
    result = run("material-maps", vote="discrete", **wall, **SIZE)
    row, column = (result["source"][..., axis].astype(int) for axis in (1, 2))
    for output, name in (("image", "exemplar"), ("normal", "normal"), ("relief", "relief")):
        np.testing.assert_array_equal(result[output], wall[name][row, column])


def test_replay_of_larger_maps(wall: dict[str, np.ndarray]):
    larger = {name: wall[name].repeat(2, axis=0).repeat(2, axis=1) for name in ("normal", "relief")}
    result = run("replay", exemplar=wall["exemplar"], mirror=True, factor=2.0, **larger, **SIZE)
    assert result["image"].shape == (76, 90, 3)
    assert result["normal"].shape == (152, 180, 3)
    assert result["relief"].shape == (152, 180, 1)
    assert np.abs(np.linalg.norm(result["normal"] * 2.0 - 1, axis=2) - 1).max() < 0.0101


def test_near_and_far():
    """The upper rows come from the far picture, the lower ones from the near."""
    result = gt.run(gt.load("perspective/near-and-far"), dict(SIZE), only=["source"], cache=False)
    index = result["source"][..., INDEX]
    assert index[:15].mean() > 0.75  # 0.74 to 0.93 over seeds; 0.13 to 0.50 without scales
    assert index[-15:].mean() < 0.1
