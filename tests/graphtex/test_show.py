import hashlib
import itertools
import os
import re
import subprocess
import sys
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import ImageFont

from graphtex.errors import GraphError
from graphtex.graph import Graph
from graphtex.show import Mark, html, mermaid, svg
from graphtex.show.boxes import Body
from graphtex.show.layers import arrange, assign
from graphtex.show.layout import _spread
from graphtex.show.scene import Box, Link, Port, brief, scene
from graphtex.show.style import STATUS_COLOURS, TYPE_COLOURS, colours_of, escape, fitted, text_width
from graphtex.sockets import Image
from tests.graphtex import pack

SVG = "{http://www.w3.org/2000/svg}"
NASTY = '<b> & "quotes" \' ]]> --> #34; `code` \x07 [x](y) {z} | end'

INNER = """\
graphtex: 1
inputs:
  picture: {type: Image, default: "made:p"}
  level: {type: float, default: 0.5}
nodes:
  mask: {node: Threshold, image: $picture, level: $level}
outputs:
  mask: mask
"""


def small_graph() -> Graph:
    """Two inputs, a measured number, lists, a stack of six cells."""
    g = Graph(title="Small")
    exemplar = g.input("exemplar", Image, default="made:pebbles")
    width = g.input("width", "int", default=8)
    levels = g.input("levels", "list[float]", default=[0.2, 0.5, 0.7])
    noise = g.add(pack.noise, width=width, seed=3)
    mean = g.add(pack.average, "mean", image=exemplar)
    parts = g.add(pack.split, "parts", image=exemplar)
    blended = g.add(pack.blend, "blended", images=[parts.base, parts.detail, noise], weights=[1.0, 2.0, 3.0])
    mask = g.add(pack.threshold, "mask", image=blended, level=mean)
    masks = g.add(
        pack.threshold, "masks", image=noise, each={"level": levels, "method": ["fixed", "adaptive"]}, on_error="keep"
    )
    g.output("mask", mask)
    g.output("masks", masks)
    g.output("same", exemplar)
    return g


SMALL_LINKS = {
    ("$width", "noise.width"),
    ("$exemplar", "mean.image"),
    ("$exemplar", "parts.image"),
    ("parts.base", "blended.images"),
    ("parts.detail", "blended.images"),
    ("noise.result", "blended.images"),
    ("blended.result", "mask.image"),
    ("mean.result", "mask.level"),
    ("noise.result", "masks.image"),
    ("$levels", "masks.level"),
    ("mask.result", ">mask"),
    ("masks.result", ">masks"),
    ("$exemplar", ">same"),
}


def random_graph(number: int, seed: int = 0) -> Graph:
    """Nodes that each blend up to three of the ten before them."""
    rng = np.random.default_rng(seed)
    g = Graph(title="Random")
    made = [g.input("start", Image, default="made:x")]
    for i in range(number):
        sources = rng.integers(max(0, len(made) - 10), len(made), int(rng.integers(1, 4)))
        made.append(g.add(pack.blend, f"blend{i}", images=[made[j] for j in sources]))
    g.output("image", made[-1])
    return g


def boxes_of(root):
    """Return x, y, width and height of every box by its id, ports by box and name, and texts."""
    frames, ports, texts = {}, {}, []
    for group in root.iter(f"{SVG}g"):
        if "data-id" not in group.attrib:
            continue
        key = group.get("data-id")
        x, y = map(float, re.fullmatch(r"translate\((.+),(.+)\)", group.get("transform")).groups())
        frame = next(r for r in group.iter(f"{SVG}rect") if "gx-frame" in r.get("class"))
        width, height = float(frame.get("width")), float(frame.get("height"))
        assert key not in frames
        frames[key] = (x, y, width, height)
        for dot in group:
            side, _, name = (dot.get("data-port") or "").partition(":")
            if side:
                at = (
                    (float(dot.get("cx")), float(dot.get("cy")))
                    if dot.tag == f"{SVG}circle"
                    else (float(dot.get("x")) + 4, float(dot.get("y")) + 4)
                )
                ports[side, f"{key}.{name}" if name else key] = (x + at[0], y + at[1])
        texts += [(t, width, height) for t in group.iter(f"{SVG}text")]
    return frames, ports, texts


def links_of(root):
    return [path for path in root.iter(f"{SVG}path") if "data-source" in path.attrib]


def points_of(path: str):
    """Return points along a line of M, H and C, and its two ends."""
    numbers = [
        [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", part)] for part in re.findall(r"[MHC][^MHC]*", path)
    ]
    x, y = numbers[0]
    points = [(x, y)]
    for part in numbers[1:]:
        if len(part) == 1:
            points += [(x + t * (part[0] - x), y) for t in np.linspace(0, 1, 9)]
            x = part[0]
            continue
        (ax, ay), (bx, by), (ex, ey) = part[:2], part[2:4], part[4:]
        for t in np.linspace(0, 1, 17):
            u = 1 - t
            points.append(
                (
                    u**3 * x + 3 * u * u * t * ax + 3 * u * t * t * bx + t**3 * ex,
                    u**3 * y + 3 * u * u * t * ay + 3 * u * t * t * by + t**3 * ey,
                )
            )
        x, y = ex, ey
    return points


def real_width(text: str, size: float) -> float:
    """Return a text's width in Pillow's own font, measured large so that no rounding to pixels counts."""
    return ImageFont.load_default(200).getlength(text) * size / 200


def is_inside(point, frame, margin=0.5):
    (px, py), (x, y, width, height) = point, frame
    return x + margin < px < x + width - margin and y + margin < py < y + height - margin


def test_everything_is_drawn():
    """Every input, node and output is a box, every connection a line with the right ends."""
    root = ElementTree.fromstring(svg(small_graph()))
    frames, _, _ = boxes_of(root)
    nodes = ["noise", "mean", "parts", "blended", "mask", "masks"]
    assert list(frames) == ["$exemplar", "$width", "$levels", *nodes, ">mask", ">masks", ">same"]
    assert len(links_of(root)) == len(SMALL_LINKS)
    assert {(p.get("data-source"), p.get("data-target")) for p in links_of(root)} == SMALL_LINKS


def test_kinds_of_lines():
    """Measured numbers are dashed, lists thick, scalars thin; each line has its type's colour class."""
    classes = {
        p.get("data-target"): p.get("class").split() for p in links_of(ElementTree.fromstring(svg(small_graph())))
    }
    assert classes["mask.level"] == ["gx-edge", "gx-t-Number", "gx-measured"]
    assert classes[">masks"] == ["gx-edge", "gx-t-Mask", "gx-many"]
    assert classes["noise.width"] == ["gx-edge", "gx-t-int", "gx-scalar"]
    assert classes["mean.image"] == ["gx-edge", "gx-t-Image"]


def test_what_boxes_say():
    """Id, node, parameters that are no defaults, cells of an `each:`, types and defaults of inputs."""
    found = {box.key: box for box in scene(small_graph()).boxes}
    assert found["blended"].subtitle == "Blend"
    assert found["blended"].lines == ("weights=1, 2, 3",)
    assert found["mask"].lines == ()
    assert found["noise"].lines == ("seed=3",)
    assert found["masks"].stack == "× 3 × 2"
    assert found["masks"].lines == ("method in fixed, adaptive", "on_error=keep")
    assert found["masks"].ins == (Port("image", "Image"), Port("level", "float"))
    assert found["masks"].outs == (Port("result", "Mask", True),)
    assert (found["$levels"].subtitle, found["$levels"].lines) == ("list of float", ("0.2, 0.5, 0.7",))
    assert found[">masks"].subtitle == "list of Mask"


def test_legend_names_what_occurs():
    legend = next(
        g for g in ElementTree.fromstring(svg(small_graph())).iter(f"{SVG}g") if g.get("class") == "gx-legend"
    )
    assert [t.text for t in legend.iter(f"{SVG}text")] == [
        "Image", "Number", "Mask", "int, float", "a list", "a measured number feeds a parameter",
        "runs once for each item",
    ]  # fmt: skip


@pytest.mark.parametrize("number", [1, 2, 17, 60, 200])
def test_geometry(number):
    """No two boxes touch, lines start and end on their ports, no line runs across a box, nothing leaves the page."""
    root = ElementTree.fromstring(svg(random_graph(number)))
    frames, ports, _ = boxes_of(root)
    assert len(frames) == number + 2
    for (x, y, w, h), (u, v, p, q) in itertools.combinations(frames.values(), 2):
        assert x + w < u or u + p < x or y + h < v or v + q < y
    page = (-24, -24, float(root.get("width")), float(root.get("height")))
    for path in links_of(root):
        points = points_of(path.get("d"))
        assert points[0] == ports["out", path.get("data-source")]
        assert points[-1] == ports["in", path.get("data-target")]
        for point in points:
            assert is_inside(point, page)
        if number <= 60:
            assert not [key for point in points for key, frame in frames.items() if is_inside(point, frame)]


def test_texts_stay_in_their_boxes(small_pack):
    """Measured in another font than the estimate was made for, each text lies inside its box, and no two overlap."""
    g = small_graph()
    g.add(pack.label, "W" * 90, image=g.add(pack.made, "i" * 90, name="m" * 300), text="@" * 300)
    marks = dict.fromkeys(g.nodes, Mark("failed", "120 failed, 3 skipped, 100 ran · 3 min 20 s"))
    _, _, texts = boxes_of(ElementTree.fromstring(svg(g, marks=marks)))
    sizes = {"title": 13, "dim": 11, "port": 11, "count": 11, "mark": 11, "code": 10.5}
    for text, width, height in texts:
        kind = text.get("class").split()[0].removeprefix("gx-")
        long = real_width(text.text, sizes[kind]) * (1.08 if kind == "code" else 1)
        x = float(text.get("x"))
        left, right = (x - long, x) if text.get("text-anchor") == "end" else (x, x + long)
        assert left >= 4
        assert right <= width - 4
        assert 8 < float(text.get("y")) < height


@given(
    st.text(alphabet=st.characters(min_codepoint=32, max_codepoint=126), max_size=40),
    st.sampled_from([10.5, 11.0, 13.0]),
)
def test_width_is_estimated_from_above(text, size):
    assert text_width(text, size) >= 0.99 * real_width(text, size)


@given(st.text(max_size=60), st.floats(20, 300))
def test_fitted_texts_fit(text, limit):
    """A text is whole or ends in an ellipsis, and is never wider than the limit."""
    shown = fitted(text, 11.0, limit)
    assert text_width(shown, 11.0) <= limit
    assert shown == text or (shown.endswith("…") and text.startswith(shown[:-1]))


def drawings() -> str:
    """Return a digest of everything drawn of two graphs."""
    text = "".join(draw(g) for g in (small_graph(), random_graph(40)) for draw in (svg, html, mermaid))
    return hashlib.sha256(text.encode()).hexdigest()


def test_same_graph_same_drawing():
    """Twice in this process, and in another one, where strings hash otherwise."""
    code = "from tests.graphtex.test_show import drawings; print(drawings())"
    environment = {**os.environ, "PYTHONHASHSEED": "1"}
    there = subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True, text=True)
    assert drawings() == drawings() == there.stdout.strip()


def test_layers_of_a_small_graph():
    """Longest paths by hand; an input stands just before its first reader, an output just behind its node."""
    boxes = [Box(key, "node", key, "") for key in "abcdxy"]
    links = [Link(s, "", t, "", "Image") for s, t in ("ab", "bc", "cd", "ad", "xd", "by")]
    assert assign(boxes, links) == {"a": 0, "b": 1, "c": 2, "d": 3, "x": 2, "y": 2}


def test_order_removes_crossings():
    """Two links that cross in the written order do not in the drawn one."""
    boxes = [Box(k, "node", k, "", ins=(Port("", "Image"),), outs=(Port("", "Image"),)) for k in ("a", "b", "p", "q")]
    links = [Link("a", "", "q", "", "Image"), Link("b", "", "p", "", "Image")]
    first, second = arrange(boxes, links).columns
    assert [second.index("q") < second.index("p")] == [first.index("a") < first.index("b")]


def test_boxes_that_want_one_place_share_it_out():
    """Three boxes of height 40, 20 apart, all wishing for the top 100: the least squares have the middle one there."""
    bodies = {k: Body(Box(k, "node", k, ""), 50, 40, (), {}, {}) for k in "abc"}
    assert _spread(["a", "b", "c"], [(100, 1), (100, 1), (100, 1)], bodies) == [40, 100, 160]
    assert _spread(["a", "b", "c"], [(0, 1), (100, 1), (300, 1)], bodies) == [0, 100, 300]
    assert _spread(["a", "b"], [(30, 3), (30, 1)], {k: bodies[k] for k in "ab"}) == [15, 75]


def nasty_graph() -> Graph:
    g = Graph(title=NASTY, source=NASTY, description=NASTY)
    picture = g.input("picture", Image, default="made:x", description=NASTY)
    g.output("image", g.add(pack.label, image=picture, text=NASTY, tags={NASTY: NASTY}))
    return g


def test_escaping_in_svg():
    """Well-formed XML whose texts are what was written; what XML forbids is replaced."""
    root = ElementTree.fromstring(svg(nasty_graph()))
    assert root.find(f"{SVG}title").text == NASTY.replace("\x07", "\ufffd")
    assert not [e for e in root.iter() if e.tag == f"{SVG}b"]
    assert any(t.text.startswith("text=<b> &") for t in root.iter(f"{SVG}text"))


def test_escape_replaces_what_xml_forbids():
    assert escape("a\x00b\ud800c\nd") == "a\ufffdb\ufffdc\nd"


def test_mermaid_text():
    """The whole flowchart of a small graph, compared with one written by hand (which Mermaid 11 draws)."""
    g = Graph()
    picture = g.input("picture", Image, default="made:x")
    mean = g.add(pack.average, "mean", image=picture)
    mask = g.add(pack.threshold, "mask", image=picture, level=mean, each={"method": ["fixed", "adaptive"]})
    g.output("masks", mask)
    assert (
        mermaid(g)
        == """\
flowchart LR
  n0(["picture<br/>Image<br/>made#58;x"]):::port
  n1["mean<br/>Average"]
  n2["mask × 2<br/>Threshold<br/>method in fixed, adaptive"]:::each
  n3(["masks<br/>list of Mask"]):::port
  n0 -->|"image"| n1
  n0 -->|"image"| n2
  n1 -.->|"result → level"| n2
  n2 ==>|"result"| n3
  linkStyle 0 stroke:#1769aa
  linkStyle 1 stroke:#1769aa
  linkStyle 2 stroke:#c92a2a
  linkStyle 3 stroke:#6b4fbb
  classDef each stroke-width:3px
  classDef port stroke-dasharray:2 2
"""
    )


def test_mermaid_labels_hold_no_syntax():
    """Between the quotes of a label stand no quotes, brackets, entities or backticks but Mermaid's own numbers."""
    for line in mermaid(nasty_graph()).splitlines():
        for label in re.findall(r'"(.*)"', line):
            assert re.fullmatch(r"([\w ,.()×=+/→…\ufffd-]|#\d+;|<br/>)*", label), label


class Checker(HTMLParser):
    """Collects tags and texts, and fails where elements are not closed in order."""

    VOID = frozenset({"meta", "link", "img", "br", "rect", "path", "circle"})

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str]]] = []
        self.texts: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in self.VOID or (tag in ("rect", "path", "circle")):
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)

    def resources(self):
        """Return what the page would load."""
        found = [a.get("src") for _, a in self.tags if a.get("src")]
        found += [a["href"] for t, a in self.tags if t in ("link", "image", "use") and "href" in a]
        return [address for address in found if not address.startswith("data:")]


def test_page():
    """A well-formed page that loads nothing, with tables of inputs and outputs."""
    g = small_graph()
    g.source, g.description = "A paper, 2008", "First.\n\nSecond."
    page = Checker(html(g))
    assert page.resources() == []
    assert {"Small", "A paper, 2008", "First.\n\nSecond.", "made:pebbles", "list[float]", "list of Mask"} <= set(
        page.texts
    )
    assert sum(tag == "tr" for tag, _ in page.tags) == 1 + 3 + 1 + 3
    assert sum(tag == "svg" for tag, _ in page.tags) == 1


def test_page_escapes():
    page = Checker(html(nasty_graph()))
    shown = NASTY.replace("\x07", "\ufffd")
    assert page.texts.count(shown) >= 4  # title, heading, source, description, an input's description
    assert not [tag for tag, _ in page.tags if tag == "b"]


def test_subgraphs(tmp_path, small_pack):
    """A sub-graph has a double border, its file's name, and only the ports that are wired."""
    (tmp_path / "inner.yaml").write_text(INNER)
    g = Graph(file=tmp_path / "outer.yaml")
    picture = g.input("picture", Image, default="made:x")
    g.output("mask", g.add("inner.yaml", "part", picture=picture, level=0.25))
    box = {box.key: box for box in scene(g).boxes}["part"]
    assert (box.kind, box.subtitle, box.lines) == ("graph", "inner.yaml", ("level=0.25",))
    assert (box.ins, box.outs) == ((Port("picture", "Image"),), (Port("mask", "Mask"),))
    group = next(e for e in ElementTree.fromstring(svg(g)).iter(f"{SVG}g") if e.get("data-id") == "part")
    assert [r.get("class") for r in group.iter(f"{SVG}rect")] == ["gx-box gx-frame", "gx-inner"]
    assert "[[" in mermaid(g)


def test_marks():
    """A marked box says what became of it, wears its colour and leads to its section."""
    root = ElementTree.fromstring(svg(small_graph(), marks={"mask": Mark("failed", "failed & gone", "#g5")}))
    link = root.find(f".//{SVG}a")
    assert link.get("href") == "#g5"
    assert link[0].get("data-id") == "mask"
    assert "failed & gone" in [t.text for t in link.iter(f"{SVG}text")]
    assert "gx-failed" in next(iter(link.iter(f"{SVG}rect"))).get("class")


def test_faulty_graphs_are_refused():
    g = small_graph()
    g.nodes["mask"].arguments["image"] = "nothing"
    with pytest.raises(GraphError, match="unknown node 'nothing'"):
        svg(g)


def contrast(first: str, second: str) -> float:
    """Return the contrast ratio of WCAG 2."""

    def luminance(colour):
        parts = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    high, low = sorted((luminance(first), luminance(second)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def test_colours_can_be_told_from_both_grounds():
    """Lines have a contrast of at least 3, words of a status of 4.5, on the page and on boxes; types differ."""
    pairs = [*TYPE_COLOURS.values(), colours_of("int", True), *(colours_of(f"Own{i}") for i in range(40))]
    for light, dark in pairs:
        assert contrast(light, "#ffffff") >= 3
        assert contrast(dark, "#14171b") >= 3
    for status, (light, dark) in STATUS_COLOURS.items():
        least = 3 if status == "waiting" else 4.5
        assert min(contrast(light, "#ffffff"), contrast(light, "#f6f7f9")) >= least
        assert min(contrast(dark, "#14171b"), contrast(dark, "#20252b")) >= least
    assert len(set(TYPE_COLOURS.values())) == len(TYPE_COLOURS)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.5, "0.5"), (True, "true"), (None, "none"), ("a\nb", "a b"), ("x" * 40, "x" * 25 + "…"), ([], "0 items"),
        (list(range(40)), "40 items"), ([[1, 2], [3]], "1, 2, 3"), ({"a": 1, "b": [2]}, "{a, b}"),
    ],
)  # fmt: skip
def test_brief(value, text):
    assert brief(value) == text
