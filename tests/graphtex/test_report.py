import base64
import io
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from PIL import Image as Pictures

import graphtex_nodes.image.views  # noqa: F401 (registers the views of all types)
from graphtex.context import QUIET, Context, Rng
from graphtex.errors import NodeFailed
from graphtex.graph import Graph
from graphtex.handlers import picture_of
from graphtex.node import node
from graphtex.outputs import OutputError
from graphtex.plan import Slot
from graphtex.report import report_html, write_report
from graphtex.report.album import Album, size_for
from graphtex.report.parts import owner
from graphtex.report.tasks import _DEFAULT, _parameter_tables
from graphtex.report.words import duration, tally
from graphtex.run import run
from graphtex.show.style import TYPE_COLOURS
from graphtex.sockets import (
    TYPES,
    AngleMap,
    Directions,
    Displacement,
    Elements,
    Gap,
    Image,
    LabelMap,
    Mask,
    Number,
    Points,
    ScaleMap,
    SourceMap,
    Texture,
    Vector,
    Views,
    ViewStack,
)
from tests.graphtex.test_show import NASTY, Checker

PICTURE = np.linspace(0, 1, 8 * 12 * 3, dtype=np.float32).reshape(8, 12, 3)


class Everything(NamedTuple):
    image: Image
    mask: Mask
    scale: ScaleMap
    angle: AngleMap
    labels: LabelMap
    points: Points
    vector: Vector
    shift: Displacement
    source: SourceMap
    number: Number
    views: Views
    directions: Directions
    elements: Elements
    texture: Texture
    stack: ViewStack


@node
def everything(image: Image) -> Everything:
    """Make a value of every type."""
    height, width = image.shape[:2]
    mask = image[..., 0] > 0.5
    points = np.array([[1.0, 2.0], [3.0, 1.0]])
    labels = np.arange(height * width, dtype=np.int32).reshape(height, width) % 3
    source, ones = np.zeros((height, width, 6), np.float32), np.ones((height, width), np.float32)
    views = np.stack([image, image / 2])
    return Everything(
        image, mask, ones, 90 * ones, labels, points, np.array([1.0, 2.0]), source[..., :2], source,
        0.25, views, np.zeros((2, 4)), Elements(points, np.zeros(2), np.ones(2)), Texture(image, mask, points, "rigid"),
        ViewStack(views, np.zeros((2, 4))),
    )  # fmt: skip


@node
def crop(image: Image, *, size: int = 4, rng: Rng = 0, ctx: Context = QUIET) -> Image:
    """Cut the top left corner ``out``.

    More is said here.
    """
    if size > image.shape[0]:
        raise ValueError(f"size: expected at most {image.shape[0]}, got {size} <&>")
    if size == 1:
        ctx.warn("a very small piece <&>")
    return image[:size, :size]


@node
def darken(image: Image, *, amount: float = 0.5) -> Image:
    """Darken."""
    return image * np.float32(amount)


@node
def brightness(image: Image) -> Number:
    """Measure the mean."""
    return 0.25


@node
def repeated(image: Image, *, times: int = 3) -> list[Image]:
    """Repeat a picture."""
    return [image] * times


@node
def first_of(images: list[Image]) -> Image:
    """Take the first of all, which must all be there."""
    return images[0]


@node
def left_of(images: list[Image | Gap]) -> Image:
    """Take the first that is there."""
    return next(image for image in images if not isinstance(image, Gap))


def matrix(sizes=(1, 4, 9)) -> Graph:
    """Cells of which the largest fail, and what becomes of their readers."""
    g = Graph(title="Matrix", seed=5)
    picture = g.input("picture", Image)
    cells = g.add(crop, "cell", image=picture, each={"size": list(sizes), "seed": [1, 2]}, on_error="keep")
    g.output("cells", cells)
    g.output("left", g.add(left_of, "left", images=cells))
    g.output("first", g.add(first_of, "first", images=cells))
    return g


def simple() -> Graph:
    g = Graph(title="Simple", seed=5)
    picture = g.input("picture", Image)
    piece = g.add(crop, "piece", image=picture, size=6)
    mean = g.add(brightness, "mean", image=piece)
    g.output("image", g.add(darken, "dark", image=piece, amount=mean))
    return g


def pictures(text: str) -> list[np.ndarray]:
    """Return the pictures of a page, decoded."""
    found = re.findall(r"data:image/png;base64,([A-Za-z0-9+/=]+)", text)
    return [np.asarray(Pictures.open(io.BytesIO(base64.b64decode(data)))) for data in found]


def section(text: str, name: str) -> str:
    """Return the part of a page about one node or input."""
    return next(p for p in re.findall(r'<section id="g\d+".*?</section>', text, re.DOTALL) if f"<h2>{name} <span" in p)


def plain(text: str) -> str:
    """Return the words of a piece of HTML."""
    return " ".join(re.sub(r"<[^>]*>", " ", text).split())


def test_a_run_that_went_well():
    """Status, reason, parameters, sources and the picture of every node, byte for byte as its view gives it."""
    result = run(simple(), {"picture": PICTURE}, cache=False, keep_all=True)
    page = report_html(result, seconds=1.5)
    checked = Checker(page)
    assert checked.resources() == []
    assert "Tasks 3: 3 ran" in plain(page)
    assert "Seed 5" in plain(page)
    dark = plain(section(page, "dark"))
    assert "Why it ran no cache" in dark
    assert "amount 0.25 measured by mean" in dark
    piece = section(page, "piece")
    assert "Cut the top left corner <code>out</code>." in piece
    assert "More is said" not in piece
    assert "size 6" in plain(piece)
    assert "6 default" not in plain(piece)
    assert "picture: given, Image float32 (8, 12, 3)" in piece
    expected = picture_of(TYPES["Image"], PICTURE[:6, :6])
    assert any(np.array_equal(found, expected) for found in pictures(piece))
    assert np.array_equal(pictures(section(page, "picture"))[0], picture_of(TYPES["Image"], PICTURE))


def test_every_link_on_the_page_leads_somewhere():
    result = run(matrix(), {"picture": PICTURE}, cache=False, keep_all=True)
    tags = Checker(report_html(result, seconds=1)).tags
    places = [attrs["id"] for _, attrs in tags if "id" in attrs]
    assert len(places) == len(set(places))
    targets = {a["href"][1:] for t, a in tags if t == "a" and a.get("href", "").startswith("#")} - {"close"}
    assert targets <= set(places)
    assert {attrs.get("data-id") for tag, attrs in tags if tag == "g"} >= {
        "$picture",
        "cell",
        "left",
        "first",
        ">cells",
    }


def test_every_type_has_a_view():
    """Each socket type, composites included, has a picture that is what its view gives; numbers are told."""
    g = Graph()
    made = g.add(everything, "all", image=g.input("picture", Image))
    g.output("image", made.image)
    result = run(g, {"picture": PICTURE}, cache=False, keep_all=True)
    page = section(report_html(result, seconds=1), "all")
    shown = pictures(page)
    for name, socket in everything.outputs.items():
        picture = picture_of(socket.type.base, result.value(Slot("all", name)))
        figure = next(f for f in re.findall(r"<figure>.*?</figure>", page, re.DOTALL) if f"<b>{name}</b>" in f)
        assert socket.type.base.name in figure
        if isinstance(picture, str):
            assert picture in plain(figure).replace("&#x27;", "'")
        elif max(picture.shape[:2]) <= 256:
            assert any(np.array_equal(found, picture) for found in shown), name
        else:
            assert f"view {picture.shape[1]} × {picture.shape[0]} · shown at" in figure
    assert {socket.type.base.name for socket in everything.outputs.values()} == set(TYPE_COLOURS)
    assert "0.25" in plain(page)


def test_failed_cells():
    """Gaps are labelled with their reason, readers that need them are skipped, those that do not have run."""
    result = run(matrix(), {"picture": PICTURE}, cache=False, keep_all=True)
    page = report_html(result, seconds=1)
    Checker(page)
    assert "Tasks 8: 2 failed, 1 skipped, 5 ran" in plain(page)
    assert "Ended with failures" in page
    assert "2 failed, 4 ran" in plain(page)  # in the drawing
    cells = section(page, "cell")
    assert "cell[2,0] failed" in cells
    assert "size: expected at most 8, got 9 &lt;&amp;&gt;" in cells
    assert "Skipped. needs cell[2,0], which failed" in plain(section(page, "first"))
    assert len(pictures(section(page, "left"))) == 1
    heads = re.findall(r'<th scope="(col|row)">((?:size|seed) \d)</th>', cells)
    assert heads == [("col", "seed 1"), ("col", "seed 2"), ("row", "size 1"), ("row", "size 4"), ("row", "size 9")]
    assert "cell[0,0] a very small piece &lt;&amp;&gt;" in plain(page)


def test_cached_and_changed(tmp_path):
    """A second run tells what was cached; one with another parameter what has changed."""
    run(simple(), {"picture": PICTURE}, cache=tmp_path)
    again = report_html(run(simple(), {"picture": PICTURE}, cache=tmp_path), seconds=1)
    assert "Tasks 3: 3 cached" in plain(again)
    assert "Why its result was in the cache" in plain(section(again, "piece"))
    assert len(pictures(section(again, "piece"))) == 1
    assert re.search(r"Key [0-9a-f]{64}", plain(section(again, "piece")))
    g = simple()
    g.nodes["piece"].arguments["size"] = 5
    changed = report_html(run(g, {"picture": PICTURE}, cache=tmp_path), seconds=1)
    assert "Why it ran parameter size: 6 -&gt; 5" in plain(section(changed, "piece"))


def test_values_that_were_not_kept():
    """Without cache and `keep_all` only outputs have pictures; the others say why they have none."""
    page = report_html(run(simple(), {"picture": PICTURE}, cache=False), seconds=1)
    assert "not kept: the run had no cache" in plain(section(page, "piece"))
    assert len(pictures(section(page, "dark"))) == 1


def test_evicted_values(tmp_path):
    """A value that the store has lost says so."""
    result = run(simple(), {"picture": PICTURE}, cache=tmp_path)
    for file in tmp_path.rglob("*.npy"):
        file.unlink()
    page = report_html(result, seconds=1)
    assert "no longer in the cache" in plain(section(page, "piece"))


def test_a_run_that_stopped():
    """What was not reached is told, with what had run before."""
    g = Graph()
    picture = g.input("picture", Image)
    early = g.add(darken, "early", image=picture)
    broken = g.add(crop, "broken", image=early, size=99)
    g.output("image", g.add(darken, "late", image=broken))
    with pytest.raises(NodeFailed) as failed:
        run(g, {"picture": PICTURE}, cache=False, keep_all=True)
    page = report_html(failed.value.result, seconds=1)
    Checker(page)
    assert "Tasks 3: 1 failed, 1 not run, 1 ran" in plain(page)
    assert "Failed. size: expected at most 8, got 99 &lt;&amp;&gt; [inputs: image float32 (8, 12, 3)]" in plain(
        section(page, "broken")
    )
    assert "the run ended before it" in section(page, "late")
    assert len(pictures(section(page, "early"))) == 1


def test_lists_are_galleries():
    g = Graph()
    g.output("many", g.add(repeated, "many", image=g.input("picture", Image), times=70))
    page = section(report_html(run(g, {"picture": PICTURE}, cache=False, keep_all=True), seconds=1), "many")
    assert len(pictures(page)) == 64
    assert "6 of 70 items are not shown" in page
    assert 'alt="many: result, item 63"' in page


def test_subgraph_cells(tmp_path, small_pack):
    """The table of cells shows what the sub-graph gives; the tasks inside have sections of their own."""
    (tmp_path / "inner.yaml").write_text(
        "graphtex: 1\ninputs: {picture: {type: Image}, level: {type: float, default: 0.5}}\nnodes:\n"
        "  parts: {node: Split, image: $picture}\n  mask: {node: Threshold, image: parts.base, level: $level}\n"
        "outputs: {mask: mask, detail: parts.detail}\n"
    )
    g = Graph(file=tmp_path / "outer.yaml")
    each = {"picture": g.input("pictures", "list[Image]"), "level": [0.25, 0.75]}
    g.output("masks", g.add("inner.yaml", "cell", each=each).mask)
    result = run(g, {"pictures": ["made:ab", "made:c"]}, cache=False, keep_all=True)
    cells = section(report_html(result, seconds=1), "cell")
    table = re.search(r'<table class="matrix">.*?</table>', cells, re.DOTALL)[0]
    assert re.findall(r'scope="\w+">(.*?)</th>', table) == ["level 0.25", "level 0.75", "picture ab", "picture c"]
    assert len(pictures(table)) == 4
    assert "<code>cell[1,0]/mask</code>" in cells
    assert "<code>cell[1,0]/parts</code>" in cells


def test_escaping():
    """Names, texts and reasons never become elements."""
    g = Graph(title=NASTY, source=NASTY, description=NASTY)
    g.output("image", g.add(crop, image=g.input("picture", Image, description=NASTY)))
    result = run(g, {"picture": PICTURE}, cache=False)
    page = report_html(result, seconds=1, warnings=[NASTY], outputs={"image": [Path("a<b>&\"'.png")]}, folder=Path())
    checked = Checker(page)
    assert sum("\ufffd" in text for text in checked.texts) >= 5
    assert "<b> " not in page
    assert any(a.get("href") == "a%3Cb%3E%26%22%27.png" for _, a in checked.tags)


def test_same_run_same_page():
    result = run(matrix(), {"picture": PICTURE}, cache=False, keep_all=True)
    assert report_html(result, seconds=1) == report_html(result, seconds=1)


def test_inputs_of_a_run():
    """Values that were asked for, defaults, and values that were given."""
    g = Graph()
    amount = g.input("amount", "float", default=0.5)
    size = g.input("size", "int", default=4)
    piece = g.add(crop, "piece", image=g.input("picture", Image), size=size)
    g.output("image", g.add(darken, "dark", image=piece, amount=amount))
    result = run(g, {"picture": PICTURE, "amount": 0.75}, cache=False)
    page = report_html(result, seconds=1, inputs={"amount": 0.75})
    told = plain(re.search(r'<section id="inputs">.*?</section>', page, re.DOTALL)[0])
    assert told == "Inputs Name Type Value What it is amount float 0.75 size int 4 default picture Image given"
    drawing = plain(re.search(r"<svg.*?</svg>", page, re.DOTALL)[0])
    assert "amount float 0.75" in drawing
    assert "size int 4" in drawing
    assert g.inputs["amount"].default == 0.5  # the graph itself is as it was


def test_many_parameters_with_their_defaults_are_folded():
    rows = [(f"p{i}", "1", _DEFAULT, "") for i in range(9)]
    _, shown, hidden = _parameter_tables([*rows[:4], ("own", "2", "", ""), *rows[4:]])
    assert plain(shown) == "Name Value What it is own 2"
    assert "9 have their defaults" in plain(hidden)
    assert plain("".join(_parameter_tables(rows[:6]))).startswith("Parameters Name Value What it is p0 1 default")
    assert _parameter_tables([]) == []


def test_large_pictures_are_reduced():
    """A picture of 2000 x 1000 is shown at 512 x 256, and both sizes are told."""
    figure = Album().figure(TYPES["Mask"], np.ones((1000, 2000), bool), "", "a mask", 512)
    assert pictures(figure)[0].shape[:2] == (256, 512)
    assert "bool (1000, 2000) · shown at 512 × 256" in figure


def test_small_pictures_are_enlarged_by_whole_factors():
    figure = Album().figure(TYPES["Mask"], np.ones((3, 10), bool), "", "a mask", 512)
    assert pictures(figure)[0].shape[:2] == (3, 10)
    assert 'class="tiny"' in figure
    assert 'width="90" height="27"' in figure


def test_many_tasks_are_folded_away():
    result = run(matrix(range(1, 14)), {"picture": PICTURE}, cache=False, keep_all=True)
    assert "<summary>All 26 tasks</summary>" in report_html(result, seconds=1)


def test_budget():
    """A page never holds more bytes of pictures than allowed, and says what it left out."""
    result = run(matrix(range(1, 9)), {"picture": PICTURE}, cache=False, keep_all=True)
    whole, part = report_html(result, seconds=1), report_html(result, seconds=1, budget=1500)
    data = re.findall(r"base64,([A-Za-z0-9+/=]+)", part)
    assert 0 < sum(len(base64.b64decode(d)) for d in data) <= 1500
    left_out = len(pictures(whole)) - len(data)
    assert f"{left_out} pictures left out" in part
    assert part.count("left out: the page is full") == left_out
    Checker(part)


@pytest.mark.parametrize("value", [np.zeros((2, 2), np.float32), np.zeros((2, 2, 3, 1), np.float32)])
def test_a_broken_view_costs_no_report(value):
    figure = Album().figure(TYPES["Image"], value, "", "broken", 64)
    assert "the view of Image" in figure


def test_write_report(tmp_path):
    """The file is whole or not there, in a folder that is made; files of outputs are linked from where it stands."""
    result = run(simple(), {"picture": PICTURE}, cache=False)
    file = tmp_path / "new" / "report.html"
    outputs = {"image": [tmp_path / "out" / "image 1.png"]}
    write_report(file, result, seconds=1, outputs=outputs)
    assert file.read_text(encoding="utf-8") == report_html(result, seconds=1, outputs=outputs, folder=file.parent)
    assert 'href="../out/image%201.png"' in file.read_text(encoding="utf-8")
    assert [p.name for p in file.parent.iterdir()] == ["report.html"]
    (tmp_path / "folder").mkdir()
    with pytest.raises(OutputError, match="folder"):
        write_report(tmp_path / "folder", result, seconds=1)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["folder", "new"]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0, "under 1 ms"), (0.0123, "12 ms"), (0.9999, "1 s"), (3.214, "3.21 s"), (59.96, "60 s"), (125.3, "2 min 5 s")],
)
def test_duration(seconds, text):
    assert duration(seconds) == text


def test_small_pieces():
    assert tally(["ran", "failed", "ran", "waiting"]) == "1 failed, 1 not run, 2 ran"
    assert [owner(t) for t in ("$a[0]", "cell[2,3]/warp", "cell.b[1]", "cell[0]/$c", "x")] == [
        "$a", "cell", "cell", "cell", "x",
    ]  # fmt: skip
    assert [size_for(n, 512) for n in (1, 4, 5, 24, 25, 100, 101)] == [512, 512, 256, 256, 128, 128, 72]
