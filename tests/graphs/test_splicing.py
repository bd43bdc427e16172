"""The graphs of texture splicing, from file to file."""

from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import label

import graphtex as gt
from graphtex.document import Output
from graphtex.events import Event, Started
from graphtex.outputs import write_outputs
from graphtex_nodes import prepare_texture, sample_texture, shrink_image, textons
from graphtex_nodes.image.save import save_image

FOLDER = Path(__file__).parents[2] / "graphs" / "splicing"
SMALL = {"width": 96, "height": 80}


def cropped(name: str, side: int = 96) -> gt.Texture:
    """A corner of a sample, so that tests are quick."""
    texture = sample_texture(name=name)
    inside = (texture.points < side - 0.5).all(axis=1)
    return gt.Texture(texture.image[:side, :side], texture.mask[:side, :side], texture.points[inside], texture.tag)


def prepared(name: str, side: int = 96):
    return prepare_texture(cropped(name, side))


def rederived(result: gt.RunResult) -> list[str]:
    """Warnings that derived files were not used."""
    return [text for report in result.reports.values() for text in report.warnings if "derived" in text]


def ran(graph: gt.Graph, inputs: dict[str, object], cache: Path) -> tuple[gt.RunResult, set[str]]:
    started: set[str] = set()

    def note(event: Event) -> None:
        if isinstance(event, Started):
            started.add(event.task)

    return gt.run(graph, inputs, cache=cache, emit=note), started


def test_a_picture_in_place_of_a_texture_is_told_which_graph_takes_it(tmp_path: Path):
    picture = tmp_path / "dots.png"
    save_image(sample_texture(name="leaves").image, picture)
    with pytest.raises(ValueError, match="splicing/splice-pictures takes plain pictures"):
        gt.run(gt.load(FOLDER / "splice.yaml"), {"elements": picture}, cache=None)


def test_another_arrangement_uses_what_was_made(tmp_path: Path):
    """Extension, factors and similar pixels of another size are of the elements alone."""
    graph = gt.load(FOLDER / "splice.yaml")
    inputs = {"elements": prepared("oranges"), "width": 80}
    first, started = ran(graph, {**inputs, "arrangement": cropped("leaves")}, tmp_path)
    assert "own" in started
    second, started = ran(graph, {**inputs, "arrangement": cropped("blossoms")}, tmp_path)
    assert "own" not in started
    assert first["image"].shape == second["image"].shape == (96, 80, 3)
    assert not np.array_equal(first["image"], second["image"])


def test_an_element_at_each_place():
    """Whole elements: the mask within half a radius of a place is all foreground, and elsewhere there is none."""
    graph = gt.load(FOLDER / "splice.yaml")
    graph.outputs["places"] = Output("target.target")
    elements = sample_texture(name="oranges")
    result = gt.run(graph, {"elements": "sample:oranges", "arrangement": "sample:leaves"}, cache=False)
    radius = np.sqrt(elements.mask.mean() * 192 * 192 / len(elements.points) / np.pi)
    y, x = np.mgrid[:192, :192]
    distance = np.min([np.hypot(x - px, y - py) for px, py in result["places"].points], axis=0)
    assert result["mask"][distance < 0.5 * radius].mean() > 0.99
    assert result["mask"][distance > 1.3 * radius].mean() < 0.01


def test_from_two_pictures():
    """Discs of a square lattice are found, and most lie whole in the rows of a hexagonal one; that is not prepared."""
    one = textons(width=96, height=96, size=18.0, arrangement="square", rng=1)
    other = textons(width=96, height=96, size=18.0, arrangement="hexagonal", rng=2)
    inputs = {"elements": one.image, "arrangement": other.image}
    result = gt.run(gt.load(FOLDER / "splice-pictures.yaml"), inputs, cache=False)
    assert [task for task in result.reports if "prepared" in task] == ["own/prepared"]
    assert result["image"].shape == (96, 96, 3)
    parts, count = label(result["mask"])
    areas = np.bincount(parts.ravel())[1:]
    whole = np.bincount(one.labels.ravel())[1:].max()
    assert count >= 8
    assert np.mean(np.abs(areas - whole) < 0.15 * whole) > 0.4  # the border cuts others


@pytest.mark.parametrize(("executor", "workers"), [("threads", 1), ("threads", 2)])
def test_same_bytes(executor: str, workers: int):
    inputs = {"elements": prepared("leaves"), "arrangement": cropped("tiles"), **SMALL}
    graph = gt.load(FOLDER / "splice.yaml")
    result = gt.run(graph, inputs, cache=False, executor=executor, workers=workers)
    reference = gt.run(graph, inputs, cache=False)
    assert result["image"].shape == (80, 96, 3)
    assert result["image"].tobytes() == reference["image"].tobytes()
    assert result["mask"].tobytes() == reference["mask"].tobytes()


def test_a_pair_that_cannot_be_spliced_leaves_a_gap(tmp_path: Path):
    graph = gt.load(FOLDER / "splice-matrix.yaml")
    twice = prepare_texture(cropped("oranges")._replace(points=np.array([[40.0, 40.0], [40.0, 40.0]])))
    result = gt.run(graph, {"textures": [prepared("tiles"), twice]}, cache=tmp_path)
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
    spliced = gt.run(
        gt.load(FOLDER / "splice.yaml"), {"elements": str(file), "arrangement": cropped("leaves")}, cache=False
    )
    assert spliced["image"].shape == (128, 128, 3)


def test_a_database_is_built_named_and_spliced_as_it_stands(tmp_path: Path):
    """Pictures become folders of their names; splices of these prepare nothing, and a damaged one costs only its own."""
    pictures, database = tmp_path / "pictures", tmp_path / "database"
    pictures.mkdir()
    for name in ("oranges", "leaves"):
        save_image(cropped(name, 128).image, pictures / f"{name}.png")
    save_image(np.full((64, 64, 3), 0.5, np.float32), pictures / "nothing.png")
    built = gt.run(gt.load(FOLDER / "database.yaml"), {"pictures": pictures, "width": 64, "height": 64}, cache=False)
    write_outputs(built, database)
    assert sorted(path.name for path in database.iterdir()) == ["leaves.texture", "oranges.texture", "overview.png"]
    assert built.failed
    graph = gt.load(FOLDER / "splice-matrix.yaml")
    result, started = ran(graph, {"textures": database}, tmp_path / "cache")
    assert [image.shape for image in result["images"]] == [(64, 64, 3)] * 4
    assert not any("Prepare" in task for task in started)
    assert not rederived(result)
    (database / "leaves.texture" / "points.csv").write_text("x,y\n1,2\nnear,far\n")
    damaged = gt.run(graph, {"textures": database}, cache=tmp_path / "cache")
    assert [isinstance(image, gt.Gap) for image in damaged["images"]] == [True, True, True, False]
    assert (
        "leaves.texture/points.csv:3: expected numbers x,y, got 'near,far'" in damaged.reports["$textures[0]"].message
    )
    np.testing.assert_array_equal(damaged["images"][3], result["images"][3])


def test_an_edited_database_is_prepared_anew(tmp_path: Path):
    """The warning that points were edited goes once the database was updated; entries that are right stay as they are."""
    database, update = tmp_path / "database", gt.load(FOLDER / "database-update.yaml")
    given = {"textures": ["sample:oranges", "sample:tiles"], "width": 64, "height": 64}
    write_outputs(gt.run(update, given, cache=False), database)
    points = database / "oranges.texture" / "points.csv"
    points.write_text("".join(points.read_text().splitlines(keepends=True)[:-3]))
    untouched = (database / "tiles.texture").stat().st_ino
    splice, inputs = gt.load(FOLDER / "splice.yaml"), {"arrangement": str(database / "tiles.texture")}
    inputs["elements"] = str(database / "oranges.texture")
    first = gt.run(splice, inputs, cache=False)
    (warning,) = rederived(first)
    assert "points.csv changed since files were derived: the texture is prepared anew" in warning
    write_outputs(gt.run(update, {"textures": database, "width": 64, "height": 64}, cache=False), database)
    again = gt.run(splice, inputs, cache=False)
    assert not rederived(again)
    np.testing.assert_array_equal(again["image"], first["image"])
    assert (database / "tiles.texture").stat().st_ino == untouched
    assert sorted(path.name for path in database.iterdir()) == [
        "oranges.texture", "oranges.texture.old", "overview.png", "tiles.texture",
    ]  # fmt: skip


def test_a_large_picture_is_shrunk_to_an_entry():
    """Points and mask are those of the picture that the entry holds."""
    picture = sample_texture(name="oranges").image
    inputs = {"exemplar": picture, "size": 96, "width": 64, "height": 48}
    made = gt.run(gt.load(FOLDER / "database-entry.yaml"), inputs, only=["texture"], cache=False)["texture"]
    np.testing.assert_array_equal(made.texture.image, shrink_image(picture, longest=96))
    assert made.texture.mask.shape == (96, 96)
    assert (made.extension.width, made.extension.height) == (64, 48)
    assert 20 <= len(made.texture.points) <= 30  # 25 in the picture
