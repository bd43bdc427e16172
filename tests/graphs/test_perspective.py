"""The graphs of perspective-aware synthesis, from file to file."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import graphtex as gt
from graphtex.document import Output
from graphtex.events import Event, Started
from graphtex.outputs import write_outputs
from graphtex_nodes import feature_mask, feature_scale, optimize, pebbles, resize_scale, sample, sample_mask
from graphtex_nodes.image.save import save_image
from tests.truth import scale_slope, source_scale_correlation

GRAPH = Path(__file__).parents[2] / "graphs" / "perspective" / "feature-mask.yaml"
SIZE = {"width": 512, "height": 512}


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("store")


def _graph() -> gt.Graph:
    graph = gt.load(GRAPH)
    graph.outputs["plain"] = Output("plain.image")
    return graph


def test_element_size_follows_the_exemplar(store: Path):
    """At least 0.8 of the exemplar's own slope of size against true scale, in the mean of three seeds; plain below 0.2.

    The maps that guide the synthesis are those that the graph finds by itself; the truth only judges.
    """
    exemplar = pebbles(slant=55.0, rng=11)
    truth = resize_scale(exemplar.scale, **SIZE)
    own = scale_slope(exemplar.image, exemplar.scale)
    runs = [gt.run(_graph(), {"exemplar": exemplar.image, **SIZE}, seed=seed, cache=store) for seed in (1, 2, 3)]
    assert np.mean([scale_slope(run["image"], truth) for run in runs]) >= 0.8 * own
    # below, not near 0: where its large and small elements lie is chance, which leaves 0.1 up or down for a seed
    assert np.mean([scale_slope(run["plain"], truth) for run in runs]) < 0.2 * own


def test_weight_zero_is_plain():
    """With scale weight 0 the maps change nothing, to the byte."""
    exemplar = sample(name="paving")
    scale = feature_scale(feature_mask(exemplar))
    target = resize_scale(scale, width=96, height=80)
    plain = optimize(exemplar, width=96, height=80, scale_weight=0.0, rng=1)
    guided = optimize(exemplar, scale, target, scale_weight=0.0, rng=1)
    assert guided.image.tobytes() == plain.image.tobytes()


def test_second_run_works_nothing_and_one_parameter_little(store: Path, tmp_path: Path):
    inputs = {"width": 64, "height": 48}
    first = gt.run(gt.load(GRAPH), inputs, cache=store)
    started: list[str] = []

    def note(event: Event) -> None:
        if isinstance(event, Started):
            started.append(event.task)

    again = gt.run(gt.load(GRAPH), inputs, cache=store, emit=note)
    assert started == []
    assert again["image"].tobytes() == first["image"].tobytes()
    gt.run(gt.load(GRAPH), {**inputs, "scale_weight": 0.5}, cache=store, emit=note)
    assert Counter(started) == Counter(["result", "overview"])
    files = write_outputs(first, tmp_path)
    assert [path.name for paths in files.values() for path in paths] == ["image.png", "scale.tiff", "overview.png"]


@pytest.mark.parametrize(("executor", "workers"), [("serial", 1), ("threads", 1), ("threads", 2)])
def test_same_bytes(executor: str, workers: int):
    """Whatever carries the work out."""
    inputs = {"width": 72, "height": 56, "exemplar": "sample:flowers"}
    result = gt.run(gt.load(GRAPH), inputs, cache=False, executor=executor, workers=workers)
    reference = gt.run(gt.load(GRAPH), inputs, cache=False)
    assert {name: np.asarray(value).tobytes() for name, value in result.items()} == {
        name: np.asarray(value).tobytes() for name, value in reference.items()
    }


@pytest.mark.parametrize("size", [(7, 5), (33, 1), (64, 301)])
def test_odd_sizes(size: tuple[int, int]):
    result = gt.run(gt.load(GRAPH), {"width": size[0], "height": size[1]}, only=["image"], cache=False)
    assert result["image"].shape == (size[1], size[0], 3)


def test_grey_and_16_channels():
    rng = np.random.default_rng(4)
    for channels in (1, 4, 16):
        exemplar = rng.random((48, 60, channels)).astype(np.float32)
        result = gt.run(gt.load(GRAPH), {"exemplar": exemplar, "width": 40, "height": 40}, only=["image"], cache=False)
        assert result["image"].shape == (40, 40, channels)


SHIPPED = ("angles", "angles-estimated", "drawn-scale", "edited-scale", "scale-pattern", "slant", "slant-comparison")


@pytest.mark.parametrize("name", SHIPPED)
def test_runs_on_any_picture(name: str, store: Path):
    """As it ships but small, and on a picture of another size and one channel."""
    graph = gt.load(GRAPH.with_name(f"{name}.yaml"))
    assert set(gt.run(graph, {"width": 64, "height": 48}, cache=store)) >= {"image", "overview"}
    grey = sample(name="brick")[:150, :180]
    images = gt.run(graph, {"exemplar": grey, "width": 41, "height": 50}, cache=store, only=["image"])["image"]
    for image in images if isinstance(images, list) else [images]:
        assert image.shape == (50, 41, 1)


def test_estimated_angles_guide_like_given_ones(store: Path):
    """The graph that needs no input puts elements where one that is told the plane's angles puts them."""
    exemplar = pebbles(slant=50.0, tilt=0.0, rng=24)
    size = {"width": 256, "height": 256}
    graph = gt.load(GRAPH.with_name("angles-estimated.yaml"))
    graph.outputs["source"] = Output("result.source")
    run = gt.run(graph, {"exemplar": exemplar.image, **size}, cache=store, only=["source", "confidence"])
    truth = resize_scale(exemplar.scale, **size)
    assert run["confidence"] > 0.4
    assert source_scale_correlation(run["source"], [exemplar.scale], truth) > 0.95


def test_a_mask_from_a_file_gives_the_scale(tmp_path: Path):
    """White lines, dense on the left: small elements there, on a picture in which nothing else tells."""
    mask = np.zeros((64, 80, 1), np.float32)
    mask[:, 0:40:4] = mask[:, 40::10] = 1
    save_image(mask, tmp_path / "mask.png")
    exemplar = np.random.default_rng(3).random((64, 80, 3), np.float32)
    inputs = {"exemplar": exemplar, "mask": str(tmp_path / "mask.png"), "width": 96, "height": 48}
    scale = gt.run(gt.load(GRAPH.with_name("own-mask.yaml")), inputs, only=["scale"], cache=False)["scale"]
    assert scale.shape == (48, 96)
    assert scale[:, :24].mean() < 0.7
    assert scale[:, -24:].mean() > 1.2
    with pytest.raises(gt.NodeFailed, match=r"scale: image: axis h has size 64 .*, but mask has 60"):
        gt.run(gt.load(GRAPH.with_name("own-mask.yaml")), {**inputs, "mask": mask[:60, :, 0] > 0}, cache=False)
    shipped = gt.run(gt.load(GRAPH.with_name("own-mask.yaml")), {"width": 40, "height": 31}, cache=False)
    assert shipped["image"].shape == (31, 40, 3)


def test_a_drawing_from_a_file_is_the_scale(tmp_path: Path):
    """Black above, light grey below, in another size and shape: the range of scales from top to bottom."""
    drawing = np.zeros((30, 20, 3), np.float32)
    drawing[15:] = 0.6
    save_image(drawing, tmp_path / "drawing.png")
    inputs = {"drawing": str(tmp_path / "drawing.png"), "low": 0.6, "high": 1.5, "width": 60, "height": 60}
    graph = gt.load(GRAPH.with_name("drawn-scale.yaml"))
    scale = gt.run(graph, inputs, only=["scale"], cache=False)["scale"]
    np.testing.assert_allclose(scale[[0, -1]], np.array([[0.6], [1.5]]) * np.ones((1, 60)), rtol=1e-4)
    kept = gt.run(graph, {**inputs, "stretch": False}, only=["scale"], cache=False)["scale"]
    np.testing.assert_allclose(kept[-1], 0.6 * 2.5**0.6, rtol=1e-4)


def test_slants_show_in_the_scale():
    """The steeper, the larger the range of scales."""
    graph = gt.load(GRAPH.with_name("slant-comparison.yaml"))
    graph.outputs["scales"] = Output("seen.scale")
    scales = gt.run(graph, {"width": 32, "height": 32}, cache=False, only=["scales"])["scales"]
    ranges = [float(scale.max() / scale.min()) for scale in scales]
    np.testing.assert_allclose(ranges, [1 / np.cos(np.radians(slant)) ** 2 for slant in (30, 45, 60)], rtol=1e-4)


def test_a_pattern_is_completed_where_inpainting_breaks_it(store: Path):
    """Threads of the default's weave go on as they do in the truth: about half the error of what does not know scale."""
    graph = gt.load(GRAPH.with_name("completion.yaml"))
    graph.outputs |= {"plain": Output("plain.image"), "baseline": Output("baseline.image")}
    run = gt.run(graph, cache=store)
    photo, hole = sample(name="matting"), sample_mask(name="hole")
    errors = {name: np.sqrt(np.mean((run[name] - photo)[hole] ** 2)) for name in ("image", "plain", "baseline")}
    assert errors["image"] < 0.6 * min(errors["plain"], errors["baseline"])
