"""The graphs of texture splicing, from file to file."""

from pathlib import Path

import numpy as np
import pytest

import graphtex as gt
from graphtex.document import Output
from graphtex.events import Event, Started
from graphtex.outputs import write_outputs
from graphtex_nodes import sample_texture

FOLDER = Path(__file__).parents[2] / "graphs" / "splicing"
SMALL = {"width": 96, "height": 80}


def cropped(name: str, side: int = 96) -> gt.Texture:
    """A corner of a sample, so that tests are quick."""
    texture = sample_texture(name=name)
    inside = (texture.points < side - 0.5).all(axis=1)
    return gt.Texture(texture.image[:side, :side], texture.mask[:side, :side], texture.points[inside], texture.tag)


def ran(graph: gt.Graph, inputs: dict[str, object], cache: Path) -> tuple[gt.RunResult, set[str]]:
    started: set[str] = set()

    def note(event: Event) -> None:
        if isinstance(event, Started):
            started.add(event.task)

    return gt.run(graph, inputs, cache=cache, emit=note), started


def test_another_arrangement_uses_what_was_made(tmp_path: Path):
    """Extension, factors and similar pixels are of the elements alone."""
    graph = gt.load(FOLDER / "splice.yaml")
    elements = cropped("oranges")
    first, started = ran(graph, {"elements": elements, "arrangement": cropped("leaves")}, tmp_path)
    assert {"extended", "factors", "sets"} < started
    second, started = ran(graph, {"elements": elements, "arrangement": cropped("blossoms")}, tmp_path)
    assert not {"extended", "factors", "sets"} & started
    assert first["image"].shape == second["image"].shape == (96, 96, 3)
    assert not np.array_equal(first["image"], second["image"])


def test_an_element_at_each_place():
    """Whole elements: the mask within half a radius of a place is all foreground, and elsewhere there is none."""
    graph = gt.load(FOLDER / "splice.yaml")
    graph.outputs["places"] = Output("target.target")
    elements = sample_texture(name="oranges")
    result = gt.run(graph, {"elements": elements, "arrangement": sample_texture(name="leaves")}, cache=False)
    radius = np.sqrt(elements.mask.mean() * 192 * 192 / len(elements.points) / np.pi)
    y, x = np.mgrid[:192, :192]
    distance = np.min([np.hypot(x - px, y - py) for px, py in result["places"].points], axis=0)
    assert result["mask"][distance < 0.5 * radius].mean() > 0.99
    assert result["mask"][distance > 1.3 * radius].mean() < 0.01


@pytest.mark.parametrize(("executor", "workers"), [("threads", 1), ("threads", 2)])
def test_same_bytes(executor: str, workers: int):
    inputs = {"elements": cropped("leaves"), "arrangement": cropped("tiles"), **SMALL}
    graph = gt.load(FOLDER / "splice.yaml")
    result = gt.run(graph, inputs, cache=False, executor=executor, workers=workers)
    reference = gt.run(graph, inputs, cache=False)
    assert result["image"].shape == (80, 96, 3)
    assert result["image"].tobytes() == reference["image"].tobytes()
    assert result["mask"].tobytes() == reference["mask"].tobytes()


def test_a_pair_that_cannot_be_spliced_leaves_a_gap(tmp_path: Path):
    graph = gt.load(FOLDER / "splice-matrix.yaml")
    lonely = cropped("oranges")._replace(points=np.array([[40.0, 40.0]]))
    result = gt.run(graph, {"textures": [cropped("tiles"), lonely]}, cache=tmp_path)
    gaps = [isinstance(image, gt.Gap) for image in result["images"]]
    assert gaps[:2] == [False, True]


def test_a_pattern_turns_and_sizes_elements():
    """The area of the foreground grows with the square of the size, a little more where the border cuts elements."""
    graph = gt.load(FOLDER / "self-splice.yaml")
    graph.nodes["target"].arguments["scale"] = 1.3
    inputs = {"elements": cropped("oranges"), "pattern": "square", "density": 0.5}
    large = gt.run(graph, inputs, cache=False)["mask"].mean()
    usual = gt.run(gt.load(FOLDER / "self-splice.yaml"), inputs, cache=False)["mask"].mean()
    assert large / usual == pytest.approx(1.3**2, rel=0.15)


def test_a_picture_becomes_a_texture(tmp_path: Path):
    """What is found of a sample is what is there, and the file that is written can be spliced."""
    true = cropped("oranges", 128)
    found = gt.run(gt.load(FOLDER / "find-textons.yaml"), {"exemplar": true.image, "turn": 0.0}, cache=False)
    texture = found["texture"]
    both = (texture.mask & true.mask).sum() / (texture.mask | true.mask).sum()
    nearest = np.hypot(*(texture.points[:, None] - true.points[None]).transpose(2, 0, 1)).min(axis=0)
    assert texture.tag == "F=d"
    assert both > 0.9
    assert nearest.max() < 2
    (file,) = write_outputs(found, tmp_path)["texture"]
    spliced = gt.run(gt.load(FOLDER / "splice.yaml"), {"elements": str(file), "arrangement": true}, cache=False)
    assert spliced["image"].shape == (128, 128, 3)
