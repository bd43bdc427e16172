"""What a graph writes is as deep as what it read: bits, and light beyond white."""

from pathlib import Path

import numpy as np
import pytest
import tifffile

from graphtex import run, write_outputs
from graphtex.graph import loads
from graphtex_nodes.image.files.decode import decode
from graphtex_nodes.image.files.follow import format_like
from graphtex_nodes.image.save import save_image
from tests.nodes.image.files import noise

CROP = """\
graphtex: 1
inputs:
  picture: {type: Image}
nodes:
  part: {node: CropImage, image: $picture, width: 5, height: 4}
outputs:
  part: {from: part, OPTIONS}
"""


def cropped(folder: Path, source: Path, options: str = "") -> Path:
    graph = loads(CROP.replace(", OPTIONS", options))
    (file,) = write_outputs(run(graph, {"picture": str(source)}, cache=False), folder / "out")["part"]
    return file


@pytest.mark.parametrize(
    ("name", "depth", "written"),
    [
        ("a.png", 8, "part.png"),
        ("a.png", 16, "part.png"),
        ("a.tif", 8, "part.tif"),
        ("a.tif", 16, "part.tif"),
        ("a.tif", "half", "part.tif"),
        ("a.tiff", "float", "part.tif"),
        ("a.exr", "half", "part.exr"),
        ("a.exr", "float", "part.exr"),
        ("a.npy", None, "part.npy"),
    ],
)
def test_no_bit_is_lost_on_the_way(tmp_path, name, depth, written):
    """Bright light too: what is cut out of a picture and written holds the very numbers of its file."""
    deep = depth not in (8, 16)
    save_image(noise(6, 7, 3, dtype="float32") * np.float32(3 if deep else 1), tmp_path / name, depth=depth)
    file = cropped(tmp_path, tmp_path / name)
    before, after = decode(tmp_path / name).samples, decode(file).samples
    assert (file.name, after.dtype) == (written, before.dtype)
    if name.endswith(".exr"):  # to sRGB and back again in float32
        np.testing.assert_allclose(after, before[:4, :5], rtol=2e-3 if depth == "half" else 1e-5)
    else:
        np.testing.assert_array_equal(after, before[:4, :5])


@pytest.mark.parametrize(
    ("options", "written", "dtype"),
    [
        (", depth: 8", "part.png", np.uint8),
        (", file: wall.png", "wall.png", np.uint16),
        (", file: wall.jpg", "wall.jpg", np.uint8),
        (", file: wall.tif", "wall.tif", np.float32),
        (", file: wall.exr, depth: half", "wall.exr", np.float16),
        (", encoding: raw", "part.exr", np.float32),
    ],
)
def test_what_the_graph_says_comes_first(tmp_path, options, written, dtype):
    save_image(noise(6, 7, 3, dtype="float32"), tmp_path / "a.exr", depth="float")
    file = cropped(tmp_path, tmp_path / "a.exr", options)
    assert (file.name, decode(file).samples.dtype) == (written, dtype)


def test_maps_that_are_opened_raw_are_written_raw(tmp_path):
    """Normals in an EXR have no transfer function on either way, and the same file as colour has both."""
    light = noise(6, 7, 3, dtype="float32")
    save_image(light, tmp_path / "a.exr", depth="float", encoding="raw")
    both = CROP.replace("}\nnodes", ", open: {encoding: raw}}\n  colour: {type: Image}\nnodes").replace(
        "part: {from: part, OPTIONS}", "part: {from: part, encoding: raw}\n  colour: $colour"
    )
    inputs = {"picture": str(tmp_path / "a.exr"), "colour": str(tmp_path / "a.exr")}
    result = run(loads(both), inputs, cache=False)
    np.testing.assert_array_equal(result["part"], light[:4, :5])
    assert result["colour"].mean() > light.mean() + 0.1
    files = write_outputs(result, tmp_path)
    np.testing.assert_array_equal(decode(files["part"][0]).samples, light[:4, :5])
    np.testing.assert_allclose(decode(files["colour"][0]).samples, light, rtol=1e-5)


def test_the_deepest_of_several_counts(tmp_path):
    files = [tmp_path / name for name in ("a.jpg", "b.png", "c.hdr", "d.exr", "e.tif")]
    for file, depth in zip(files, (None, 16, None, "half", 8), strict=True):
        save_image(noise(4, 4, 3, dtype="float32"), file, depth=depth)
    assert format_like(files[:1], None) == (".png", {"depth": 8})
    assert format_like(files[:2], None) == (".png", {"depth": 16})
    assert format_like([files[3], files[1]], None) == (".exr", {"depth": "half"})
    assert format_like(files, None) == (".exr", {"depth": "float"})  # the one of .hdr, which is kept as .exr
    assert format_like(files[1:], ".png") == (".png", {"depth": 16})
    assert format_like(files[1:], ".hdr") == (".hdr", {})
    assert format_like([files[0], files[4]], ".tif") == (".tif", {})


def test_numbers_of_32_bit_are_kept_as_floats(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", noise(4, 4, dtype="uint32"))
    np.save(tmp_path / "b.npy", noise(4, 4, dtype="uint16"))
    assert format_like([tmp_path / "a.tif"], None) == (".tif", {"depth": "float"})
    assert format_like([tmp_path / "b.npy"], None) == (".npy", {})


def test_a_file_that_has_gone_says_nothing(tmp_path):
    (tmp_path / "empty.exr").write_bytes(b"")
    (tmp_path / "cut.exr").write_bytes(b"v/1\x01")
    assert format_like([tmp_path / "gone.exr", tmp_path / "empty.exr"], None) == (".png", {})
    assert format_like([tmp_path / "cut.exr"], ".png") == (".png", {})
