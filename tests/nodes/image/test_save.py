import hashlib
import time
import zipfile
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
import tifffile
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image as Pictures

from graphtex import Elements, GraphError, Texture, ViewStack
from graphtex.graph import loads
from graphtex.handlers import DEFAULT_SUFFIX, WRITERS
from graphtex.packs import registry
from graphtex_nodes.image.files.colour import decode_srgb, encode_srgb, to_samples
from graphtex_nodes.image.files.encode import encode
from graphtex_nodes.image.files.formats import FORMATS, MOST_PIXELS, table
from graphtex_nodes.image.load import load_image, load_mask, load_scale
from graphtex_nodes.image.load_data import (
    load_angles,
    load_displacement,
    load_elements,
    load_labels,
    load_points,
    load_source_map,
    load_texture,
    load_view_stack,
)
from graphtex_nodes.image.save import (
    save_angles,
    save_displacement,
    save_elements,
    save_image,
    save_labels,
    save_mask,
    save_points,
    save_scale,
    save_source,
    save_texture,
    save_views,
)
from tests.nodes.image.files import noise

DOCS = Path(__file__).parents[3] / "docs" / "pictures.md"
DEPTHS = (8, 16, "half", "float")
SUFFIXES = [suffix for entry in FORMATS for suffix in entry.suffixes]
ENTRY = {suffix: entry for entry in FORMATS for suffix in entry.suffixes}

POINTS = np.array([[0.1, 2.0], [1 / 3, -1e-17], [12345.678901234567, 5e20]])
ELEMENTS = Elements(POINTS, np.array([0.0, -90.0, 1 / 7]), np.array([1.0, 0.5, 2.0]))
TEXTURE = Texture(noise(4, 5, 3, dtype="float32"), noise(4, 5) > 99, POINTS, "rigid")
VIEWS = ViewStack(noise(3, 4, 5, 1, dtype="float32"), np.arange(12.0).reshape(3, 4))


@pytest.mark.parametrize("channels", [1, 2, 3, 4, 5, 16])
@pytest.mark.parametrize("depth", [None, *DEPTHS])
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_cell_of_the_table(tmp_path, suffix, depth, channels):
    """It round-trips, to the last bit where the format is lossless, or says what the format holds."""
    entry = ENTRY[suffix]
    picture = noise(6, 7, channels, dtype="float32")
    path = tmp_path / f"a{suffix}"
    if channels not in entry.channels:
        with pytest.raises(ValueError, match=rf"{entry.name} holds .* channels; got {channels}: write "):
            save_image(picture, path, depth=depth)
        return
    if depth is not None and depth not in entry.depths:
        with pytest.raises(ValueError, match=rf"{entry.name} (holds|has) .*; got depth {depth}: write \.\w+"):
            save_image(picture, path, depth=depth)
        return
    save_image(picture, path, depth=depth, encoding="raw")
    back = load_image(path=str(path), encoding="raw")
    assert back.shape == picture.shape
    if not entry.lossless:
        np.testing.assert_allclose(back, picture, atol=0.15)
        return
    kept = to_samples(picture, depth or entry.depths[0])
    top = np.iinfo(kept.dtype).max if kept.dtype.kind == "u" else 1
    np.testing.assert_array_equal(back, kept.astype(np.float32) / np.float32(top))


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("encoding", ["auto", "srgb", "linear"])
@pytest.mark.parametrize("suffix", [".exr", ".tif"])
def test_load_undoes_save(tmp_path, suffix, encoding, channels):
    """Transfer function and premultiplication are inverse, where there is cover."""
    picture = 0.05 + 0.9 * noise(6, 7, channels, dtype="float32")
    save_image(picture, tmp_path / f"a{suffix}", depth="float", encoding=encoding)
    np.testing.assert_allclose(load_image(path=str(tmp_path / f"a{suffix}"), encoding=encoding), picture, atol=2e-7)


def test_exr_holds_linear_premultiplied_light(tmp_path):
    """A second reader: grey 0.5 is 0.2140 of light, times alpha 0.25."""
    save_image(np.full((1, 1, 4), [0.5, 0.5, 0.5, 0.25], np.float32), tmp_path / "a.exr", depth="float")
    file = oiio.ImageInput.open(str(tmp_path / "a.exr"))
    np.testing.assert_allclose(file.read_image(0, 0, 0, 4, "float")[0, 0], [0.2140411 / 4] * 3 + [0.25], rtol=1e-6)


def test_hdr_is_within_its_mantissa(tmp_path):
    """Light has 8 bits below the largest channel."""
    picture = noise(9, 9, 3, dtype="float32")
    save_image(picture, tmp_path / "a.hdr")
    light, back = decode_srgb(picture), decode_srgb(load_image(path=str(tmp_path / "a.hdr")))
    assert np.all(np.abs(light - back) <= light.max(axis=2, keepdims=True) / 128)


def test_values_beyond_1_survive_in_floats_and_clip_in_integers(tmp_path):
    picture = np.array([[[-0.5], [3.0]]], np.float32)
    save_image(picture, tmp_path / "a.exr", depth="float")
    with pytest.warns(UserWarning, match="are kept"):
        np.testing.assert_allclose(load_image(path=str(tmp_path / "a.exr")), picture, rtol=1e-6)
    save_image(picture, tmp_path / "a.png")
    assert load_image(path=str(tmp_path / "a.png")).ravel().tolist() == [0, 1]
    with pytest.raises(ValueError, match="half holds numbers up to 65504"):
        save_image(picture * 1e5, tmp_path / "a.tif", depth="half")


@given(level=st.integers(0, 65535))
def test_16_bits_survive_as_float32(level):
    assert to_samples(np.float32(level) / np.float32(65535) * np.ones(1, np.float32), 16) == level


@given(value=st.floats(-100, 100, width=32))
def test_transfer_function_is_undone(value):
    back = decode_srgb(encode_srgb(np.array([value], np.float32)))
    np.testing.assert_allclose(back, value, rtol=2e-6, atol=1e-9)


@pytest.mark.parametrize("suffix", [".png", ".tif", ".webp"])
def test_pillow_reads_the_same(tmp_path, suffix):
    """A second reader for 8 bits."""
    samples = noise(6, 7, 4)
    save_image(samples / np.float32(255), tmp_path / f"a{suffix}", depth=8)
    with Pictures.open(tmp_path / f"a{suffix}") as opened:
        np.testing.assert_array_equal(np.asarray(opened), samples)


def test_tifffile_reads_the_same(tmp_path):
    picture = noise(6, 7, 11, dtype="float32")
    save_image(picture, tmp_path / "a.tiff", depth="float")
    np.testing.assert_array_equal(tifffile.imread(tmp_path / "a.tiff"), picture)


def test_quality(tmp_path):
    """Less quality, fewer bytes; only where there is such a thing."""
    picture = noise(40, 40, 3, dtype="float32")
    for suffix in (".jpg", ".webp"):
        for quality in (20, 90):
            save_image(picture, tmp_path / f"{quality}{suffix}", quality=quality)
        assert (tmp_path / f"20{suffix}").stat().st_size < (tmp_path / f"90{suffix}").stat().st_size
    with pytest.raises(ValueError, match=r"PNG has no quality; got quality 90: write \.jpg or \.webp"):
        save_image(picture, tmp_path / "a.png", quality=90)


def test_too_large_for_webp(tmp_path):
    with pytest.raises(ValueError, match="WebP holds sides up to 16383 pixels; got 16384 x 1"):
        save_image(np.zeros((1, 16384, 3), np.float32), tmp_path / "a.webp")


def test_unknown_suffix(tmp_path):
    with pytest.raises(ValueError, match=r"pictures are written as \.png, .*; got|, got \.xyz"):
        encode(np.zeros((1, 1, 3), np.float32), tmp_path / "a.xyz")


def test_png_is_tagged_as_srgb(tmp_path):
    for depth in (8, 16):
        save_image(np.zeros((1, 1, 3), np.float32), tmp_path / "a.png", depth=depth)
        assert b"sRGB" in (tmp_path / "a.png").read_bytes()
        save_image(np.zeros((1, 1, 3), np.float32), tmp_path / "b.png", depth=depth, encoding="raw")
        assert b"sRGB" not in (tmp_path / "b.png").read_bytes()


def everything():
    """(writer, value, file) of every type and suffix."""
    picture = noise(6, 7, 3, dtype="float32")
    for suffix in SUFFIXES:
        yield save_image, picture, f"image{suffix}"
    for name, write, value, suffixes in (
        ("mask", save_mask, noise(6, 7) > 99, (".png", ".npy")),
        ("scale", save_scale, 0.5 + noise(6, 7, dtype="float32"), (".tiff", ".exr", ".npy", ".png")),
        ("labels", save_labels, noise(6, 7).astype(np.int32), (".tiff", ".npy", ".png")),
        ("displacement", save_displacement, noise(6, 7, 2, dtype="float32"), (".npy", ".exr", ".tiff")),
        ("source", save_source, noise(6, 7, 6, dtype="float32"), (".npy", ".exr", ".tiff")),
        ("points", save_points, POINTS, (".csv", ".npy")),
        ("elements", save_elements, ELEMENTS, (".csv",)),
        ("texture", save_texture, TEXTURE, (".npz",)),
        ("views", save_views, VIEWS, (".npz",)),
    ):
        for suffix in suffixes:
            yield write, value, name + suffix


def test_equal_values_give_equal_bytes(tmp_path, monkeypatch):
    """Whatever the clock says."""

    def digests():
        for write, value, name in everything():
            write(value, tmp_path / name)
        return {name: hashlib.sha256((tmp_path / name).read_bytes()).hexdigest() for _, _, name in everything()}

    first = digests()
    monkeypatch.setattr(time, "time", lambda: 2_000_000_000.0)
    monkeypatch.setattr(time, "localtime", lambda *_: time.gmtime(2_000_000_000))
    assert digests() == first


def test_exr_has_a_fixed_date(tmp_path):
    """OpenImageIO reads the clock in C, where no test can set it."""
    save_image(noise(6, 7, 3, dtype="float32"), tmp_path / "a.exr")
    assert b"1970:01:01 00:00:00" in (tmp_path / "a.exr").read_bytes()


@pytest.mark.parametrize("depth", [None, 1, 8])
def test_mask(tmp_path, depth):
    mask = noise(9, 13) > 99
    save_mask(mask, tmp_path / "a.png", depth=depth)
    np.testing.assert_array_equal(load_mask(path=str(tmp_path / "a.png")), mask)
    with Pictures.open(tmp_path / "a.png") as opened:
        assert opened.mode == ("1" if depth == 1 else "L")
    save_mask(mask, tmp_path / "a.npy")
    np.testing.assert_array_equal(load_mask(path=str(tmp_path / "a.npy")), mask)
    with pytest.raises(ValueError, match=r"depth is for \.png"):
        save_mask(mask, tmp_path / "a.npy", depth=8)


@pytest.mark.parametrize("suffix", [".tiff", ".tif", ".exr", ".npy"])
def test_scale_survives(tmp_path, suffix):
    scale = np.float32(2) ** (6 * noise(5, 6, dtype="float32") - 3)
    save_scale(scale, tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(load_scale(path=str(tmp_path / f"a{suffix}")), scale)


def test_scale_view(tmp_path):
    """128 is 1; beyond 255 / 128 the view is white."""
    save_scale(np.array([[1.0, 0.5, 1.5, 8.0]], np.float32), tmp_path / "a.png")
    with Pictures.open(tmp_path / "a.png") as opened:
        assert np.asarray(opened).tolist() == [[128, 64, 192, 255]]
    save_scale(np.array([[1.0, 0.70001]], np.float32), tmp_path / "b.png", depth=16)
    np.testing.assert_allclose(load_scale(path=str(tmp_path / "b.png")), [[1, 0.70001]], atol=2e-5)


@pytest.mark.parametrize("suffix", [".tiff", ".npy"])
def test_labels_survive(tmp_path, suffix):
    labels = np.array([[-1, 0, 255], [256, 2**31 - 1, -(2**31)]], np.int32)
    save_labels(labels, tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(load_labels(path=str(tmp_path / f"a{suffix}")), labels)


def test_labels_in_a_palette(tmp_path):
    """The file shows distinct colours and holds the labels; a grey PNG is read by its levels."""
    labels = np.arange(256, dtype=np.int32).reshape(16, 16)
    save_labels(labels, tmp_path / "a.png")
    np.testing.assert_array_equal(load_labels(path=str(tmp_path / "a.png")), labels)
    assert len(np.unique(load_image(path=str(tmp_path / "a.png")).reshape(-1, 3), axis=0)) > 200
    Pictures.fromarray(np.array([[0, 7]], np.uint8)).save(tmp_path / "b.png")
    assert load_labels(path=str(tmp_path / "b.png")).tolist() == [[0, 7]]
    with pytest.raises(ValueError, match=r"PNG holds labels from 0 to 255; got -1 to 3: write \.tiff or \.npy"):
        save_labels(np.array([[-1, 3]], np.int32), tmp_path / "c.png")


@pytest.mark.parametrize("suffix", [".npy", ".tiff", ".tif", ".exr"])
def test_fields_survive(tmp_path, suffix):
    shift, source = noise(5, 6, 2, dtype="float32") - 0.5, noise(5, 6, 6, dtype="float32") * 300
    angles = shift[..., 0] * 360
    save_angles(angles, tmp_path / f"angles{suffix}")
    np.testing.assert_array_equal(load_angles(path=str(tmp_path / f"angles{suffix}")), angles)
    save_displacement(shift, tmp_path / f"shift{suffix}")
    save_source(source, tmp_path / f"source{suffix}")
    np.testing.assert_array_equal(load_displacement(path=str(tmp_path / f"shift{suffix}")), shift)
    np.testing.assert_array_equal(load_source_map(path=str(tmp_path / f"source{suffix}")), source)
    with pytest.raises(ValueError, match=r"a source map is floats \(h, w, 6\), got float32 \(5, 6, 2\)"):
        load_source_map(path=str(tmp_path / f"shift{suffix}"))


@pytest.mark.parametrize("suffix", [".csv", ".npy"])
@pytest.mark.parametrize("points", [POINTS, np.zeros((0, 2))])
def test_points_survive(tmp_path, suffix, points):
    save_points(points, tmp_path / f"a{suffix}")
    np.testing.assert_array_equal(load_points(path=str(tmp_path / f"a{suffix}")), points)


def test_csv_as_people_write_it(tmp_path):
    (tmp_path / "a.csv").write_text("﻿x, y\r\n1, 2\r\n\r\n3,4.5", encoding="utf-8")
    assert load_points(path=str(tmp_path / "a.csv")).tolist() == [[1, 2], [3, 4.5]]
    (tmp_path / "b.csv").write_text("1,2\n3,four\n")
    with pytest.raises(ValueError, match=r"b\.csv:2: expected numbers x,y, got '3,four'"):
        load_points(path=str(tmp_path / "b.csv"))
    (tmp_path / "c.csv").write_text("1,2,3\n")
    with pytest.raises(ValueError, match=r"c\.csv:1: expected .* numbers .*x,y.*, got '1,2,3'"):
        load_points(path=str(tmp_path / "c.csv"))


def test_bundles_survive(tmp_path):
    save_elements(ELEMENTS, tmp_path / "a.csv")
    save_texture(TEXTURE, tmp_path / "a.npz")
    save_views(VIEWS, tmp_path / "b.npz")
    for back, value in (
        (load_elements(path=str(tmp_path / "a.csv")), ELEMENTS),
        (load_texture(path=str(tmp_path / "a.npz")), TEXTURE),
        (load_view_stack(path=str(tmp_path / "b.npz")), VIEWS),
    ):
        for one, other in zip(back, value, strict=True):
            np.testing.assert_array_equal(one, other)
    with pytest.raises(ValueError, match=r"a\.npz: .* its fields are"):
        load_view_stack(path=str(tmp_path / "a.npz"))


def test_archives_that_are_damaged_or_hold_objects(tmp_path):
    (tmp_path / "a.npz").write_bytes(b"PK nonsense")
    with pytest.raises(ValueError, match=r"a\.npz: not such an archive, or damaged"):
        load_view_stack(path=str(tmp_path / "a.npz"))
    np.savez(tmp_path / "b.npz", views=np.array([{}]), directions=np.zeros((1, 4)))
    with pytest.raises(ValueError, match="allow_pickle"):
        load_view_stack(path=str(tmp_path / "b.npz"))
    np.savez(tmp_path / "c.npz", views=np.zeros((1, 1, 1, 1), np.float32), directions=np.full((1, 4), np.nan))
    with pytest.raises(ValueError, match=r"c\.npz: field directions: expected finite numbers"):
        load_view_stack(path=str(tmp_path / "c.npz"))


def test_numpy_reads_the_archive(tmp_path):
    save_texture(TEXTURE, tmp_path / "a.npz")
    with np.load(tmp_path / "a.npz", allow_pickle=False) as fields:
        assert str(fields["tag"]) == "rigid"
    with zipfile.ZipFile(tmp_path / "a.npz") as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def types_table() -> str:
    """What is written for each type, from what is registered."""
    registry()  # the framework's own writer of numbers too
    own = [
        key for key, made in WRITERS.items() if made.function.__module__.split(".")[0] in ("graphtex", "graphtex_nodes")
    ]
    rows = ["| type | written by default | also |", "|---|---|---|"]
    for name in sorted({name for name, _ in own}):
        default = DEFAULT_SUFFIX[name]
        others = [suffix for other, suffix in own if other == name and suffix != default]
        rows.append(f"| {name} | {default} | {' '.join(others)} |")
    return "\n".join(rows)


def test_docs_are_true(tmp_path):
    text = DOCS.read_text(encoding="utf-8")
    with pytest.raises(ValueError, match="JPEG holds") as caught:
        save_image(np.zeros((1, 1, 4), np.float32), tmp_path / "a.jpg")
    assert str(caught.value) in " ".join(text.split())
    assert f"{MOST_PIXELS:,} pixels" in text
    assert table() in text
    assert types_table() in text


@pytest.mark.parametrize(
    ("output", "told"),
    [
        ("{from: a, file: ‸x.jpg, depth: 16}", "JPEG holds 8 bit; got depth 16: write .png or .tif"),
        ("{from: a, file: ‸x.png, depth: half}", "PNG holds 8 bit or 16 bit; got depth half: write .tif or .exr"),
        ("{from: a, file: ‸x.hdr, depth: float}", "Radiance HDR has one depth of its own; got depth float"),
        ("{from: ‸a, quality: 90}", "PNG has no quality; got quality 90: write .jpg or .webp or leave it out"),
        ("{from: s, file: ‸x.npy, depth: 16}", "depth is for .png, the other formats hold the data itself; got 16"),
        ("{from: m, file: ‸x.npy, depth: 1}", "depth is for .png, the other formats hold the data itself; got 1"),
        ("{from: m, file: ‸a.png}", "a.png is written by the output a too"),
    ],
)
def test_options_that_a_format_has_not_are_told_before_anything_runs(output, told):
    text = f"""\
graphtex: 1
nodes:
  a: {{node: Sample, name: gravel}}
  m: {{node: MaskFromImage, image: a}}
  s: {{node: FeatureScale, mask: m}}
outputs:
  a: a
  out: {output}
"""
    line = next(line for line in text.splitlines() if "‸" in line)
    with pytest.raises(GraphError) as caught:
        loads(text.replace("‸", ""))
    (problem,) = caught.value.problems
    assert (problem.line, problem.column) == (8, line.index("‸") + 1)
    assert problem.message.startswith(told)


@pytest.mark.parametrize("load", [load_points, load_elements, load_texture, load_view_stack])
def test_tables_and_archives_that_cannot_be_read_are_told_in_one_line(tmp_path, load):
    for path, told in ((tmp_path, "Is a directory"), (tmp_path / "none", "No such file or directory")):
        with pytest.raises(ValueError) as caught:
            load(path=str(path))
        assert str(caught.value) == f"{path}: cannot be read: {told}"
    (tmp_path / "latin.csv").write_bytes(b"x,y\n1,2 \xfc\n")
    with pytest.raises(ValueError, match=r"latin\.csv: (no text in UTF-8|not such an archive)"):
        load(path=str(tmp_path / "latin.csv"))
