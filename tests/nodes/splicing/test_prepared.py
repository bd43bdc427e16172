"""Prepared textures, and textures as folders."""

import csv
import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pictures

from graphtex import Context, Texture
from graphtex_nodes import (
    extend_texture,
    factor_warp,
    load_prepared,
    load_texture_folder,
    neighbour_sets,
    prepare_texture,
    split_prepared,
)
from graphtex_nodes.splicing.load_prepared import save_prepared, save_texture_folder
from graphtex_nodes.splicing.prepare_texture import PreparedParts, PreparedTexture
from tests.nodes.splicing.scenes import discs, grid

TEXTURE = discs(grid(), size=(64, 64))
EIGHT = TEXTURE._replace(image=(np.rint(TEXTURE.image * 255) / 255).astype(np.float32))


def leaves(value, name=""):
    if isinstance(value, tuple):
        for key, item in value._asdict().items():
            yield from leaves(item, f"{name}.{key}")
    else:
        yield name, value


def equal(one, other) -> bool:
    pairs = list(zip(leaves(one), leaves(other), strict=True))
    return all(
        a == b and np.array_equal(x, y) and getattr(x, "dtype", 0) == getattr(y, "dtype", 0) for (a, x), (b, y) in pairs
    )


@pytest.fixture(scope="module")
def stored(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("database") / "discs.texture"
    save_prepared(prepare_texture(EIGHT, width=48, height=40), folder)
    return folder


@pytest.fixture
def entry(stored, tmp_path) -> Path:
    return Path(shutil.copytree(stored, tmp_path / "discs.texture"))


def opened(folder: Path) -> tuple[object, list[str]]:
    told: list[str] = []
    return load_prepared(path=folder, ctx=Context(on_warning=told.append)), told


def test_it_is_what_the_three_steps_make():
    prepared = prepare_texture(EIGHT, width=48, height=40)
    extension = extend_texture(EIGHT, width=48, height=40)
    assert equal(prepared, PreparedTexture(EIGHT, extension, *factor_warp(extension), neighbour_sets(EIGHT)))


def test_its_parts_are_those_of_the_window_that_is_asked_for():
    prepared = prepare_texture(EIGHT, width=48, height=40)
    assert equal(split_prepared(prepared), PreparedParts(EIGHT.image[12:52, 8:56], *prepared))
    narrow = prepare_texture(EIGHT, width=40, height=40)
    assert equal(split_prepared(prepared, width=40), PreparedParts(EIGHT.image[12:52, 12:52], *narrow))


def test_a_window_without_an_element_is_told():
    corner = EIGHT._replace(points=EIGHT.points[:2])
    with pytest.raises(ValueError, match="got none of 2 for the middle 8 x 8 pixels of 64 x 64: shrink the picture"):
        prepare_texture(corner, width=8, height=8)
    with pytest.raises(ValueError, match="texture: expected at least one texton, got none"):
        prepare_texture(EIGHT._replace(points=np.empty((0, 2))))


def test_large_textures_get_a_window_that_can_be_prepared():
    wide = discs(grid(size=(32, 400)), size=(32, 400))
    extension = prepare_texture(wide).extension
    assert (extension.width, extension.height) == (256, 32)


def test_a_round_trip_changes_nothing(entry):
    prepared, told = opened(entry)
    assert told == []
    assert equal(prepared, prepare_texture(EIGHT, width=48, height=40))


@pytest.mark.parametrize(
    ("image", "name"),
    [
        (EIGHT.image, "image.png"),
        (EIGHT.image[..., :1], "image.png"),
        (np.dstack([EIGHT.image, EIGHT.image[..., :1]]), "image.png"),
        ((np.rint(TEXTURE.image * 65535) / 65535).astype(np.float32), "image.png"),
        (TEXTURE.image, "image.tiff"),
        (TEXTURE.image * 3 - 1, "image.tiff"),
        (np.dstack([EIGHT.image, EIGHT.image]), "image.tiff"),
    ],
)
def test_a_texture_keeps_its_numbers(tmp_path, image, name):
    folder = tmp_path / "t.texture"
    save_texture_folder(TEXTURE._replace(image=image), folder)
    assert (folder / name).exists()
    told: list[str] = []
    read = load_texture_folder(path=folder, ctx=Context(on_warning=told.append))
    assert equal(read, TEXTURE._replace(image=image))
    assert bool(told) == (image.min() < 0)
    assert sorted(path.name for path in folder.iterdir()) == sorted([name, "mask.png", "points.csv", "tag.txt"])


def test_it_is_read_without_graphtex(entry):
    image, mask = (np.asarray(Pictures.open(entry / name)) for name in ("image.png", "mask.png"))
    np.testing.assert_array_equal(image, np.rint(EIGHT.image * 255))
    np.testing.assert_array_equal(mask > 0, EIGHT.mask)
    with (entry / "points.csv").open() as file:
        points = [(float(row["x"]), float(row["y"])) for row in csv.DictReader(file)]
    assert points == [tuple(point) for point in EIGHT.points.tolist()]
    assert (entry / "tag.txt").read_text().strip() == "F=d"
    page = json.loads((entry / "derived" / "derived.json").read_text())
    assert page["made_from"]["points.csv"] == hashlib.sha256((entry / "points.csv").read_bytes()).hexdigest()
    factor = [np.load(entry / "derived" / page["arrays"][f"factor_x.{name}"]["file"]) for name in ("starts", "rows")]
    assert factor[0][-1] == len(factor[1])


def test_edited_files_count_and_what_was_derived_of_them_does_not(entry):
    edited = EIGHT.points[:-2]
    (entry / "points.csv").write_text("".join(f"{x},{y}\n" for x, y in edited))
    (entry / "tag.txt").write_text("F=c\n")
    prepared, told = opened(entry)
    assert equal(prepared, prepare_texture(EIGHT._replace(points=edited, tag="F=c"), width=48, height=40))
    assert len(told) == 1
    assert "points.csv, tag.txt changed since files were derived: the texture is prepared anew" in told[0]


def test_another_format_of_picture_serves(entry):
    Pictures.open(entry / "image.png").save(entry / "image.bmp")
    (entry / "image.png").unlink()
    prepared, told = opened(entry)
    np.testing.assert_array_equal(prepared.texture.image, EIGHT.image)
    assert "image.bmp, image.png changed" in told[0]


def spoil_page(folder):
    (folder / "derived" / "derived.json").write_text("{}")


def cut_page(folder):
    page = folder / "derived" / "derived.json"
    page.write_text(page.read_text()[:-40])


def edit_page(folder):
    page = folder / "derived" / "derived.json"
    page.write_text(page.read_text().replace('"extension.width": 48', '"extension.width": 47'))


def remove_array(folder):
    (folder / "derived" / "sets.fine_sets.npy").unlink()


def change_array(folder):
    file = folder / "derived" / "factor_x.values.npy"
    file.write_bytes(file.read_bytes()[:-8] + bytes(8))


def other_code(folder):
    file = folder / "derived" / "derived.json"
    page = json.loads(file.read_text())
    del page["sha256"]
    page["code"] = "0" * 64
    page["sha256"] = hashlib.sha256(json.dumps(page, sort_keys=True).encode()).hexdigest()
    file.write_text(json.dumps(page))


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (spoil_page, "derived.json is not as it was written"),
        (cut_page, "derived is damaged"),
        (edit_page, "derived.json is not as it was written"),
        (remove_array, "derived is damaged"),
        (change_array, "factor_x.values.npy is damaged"),
        (other_code, "made by another version"),
    ],
)
def test_derived_files_that_do_not_fit_are_made_anew(entry, spoil, told):
    spoil(entry)
    prepared, warnings = opened(entry)
    assert told in warnings[0]
    assert equal(prepared.texture, EIGHT)
    size = prepared.extension.width, prepared.extension.height
    assert size == (48, 40) if spoil in (remove_array, change_array, other_code) else size == (64, 64)
    shutil.rmtree(entry / "derived")
    assert opened(entry)[1] == []


def write_mask(folder, mask):
    Pictures.fromarray(mask.astype(np.uint8) * 255).save(folder / "mask.png")


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda f: (f / "mask.png").unlink(), r"mask\.png: there is no such file; a texture is image\.\*, mask\.png"),
        (lambda f: (f / "image.png").unlink(), r"discs\.texture: expected one picture called image\.png.*, got none"),
        (lambda f: shutil.copy(f / "image.png", f / "image.tif"), r"got image\.png, image\.tif"),
        (lambda f: (f / "image.png").write_bytes(b"no picture"), r"image\.png: "),
        (lambda f: write_mask(f, np.ones((64, 60))), r"mask\.png: .*60"),
        (lambda f: write_mask(f, np.ones((64, 64))), r"mask\.png: expected some foreground and some background"),
        (lambda f: (f / "points.csv").write_text("x,y\n"), r"points\.csv: expected at least one texton, got none"),
        (lambda f: (f / "points.csv").write_text("5,5\n70,3\n"), r"points\.csv: expected all in the picture.*\(70, 3\)"),
        (lambda f: (f / "points.csv").write_text("5,5\n1,2,3\n"), r"points\.csv:2: expected 2 finite numbers"),
        (lambda f: (f / "tag.txt").write_text("F"), r"tag\.txt: expected one of F=c, F=d, B=c, got 'F'"),
        (lambda f: (f / "tag.txt").write_bytes(b"\xff\xfe\x00"), r"tag\.txt: cannot be read as text"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("load", [load_texture_folder, load_prepared])
def test_a_damaged_entry_names_its_file(entry, load, spoil, told):
    spoil(entry)
    with pytest.raises(ValueError, match=told):
        load(path=entry)


def test_equal_values_give_equal_files(entry, tmp_path):
    save_prepared(prepare_texture(EIGHT, width=48, height=40), tmp_path / "again.texture")
    for file in entry.rglob("*"):
        if file.is_file():
            assert (tmp_path / "again.texture" / file.relative_to(entry)).read_bytes() == file.read_bytes()


def test_both_factors_of_bricks_are_kept(tmp_path):
    bricks = Texture(EIGHT.image, ~EIGHT.mask, grid(start=16.0), "B=c")
    made = prepare_texture(bricks, width=40, height=40)
    save_prepared(made, tmp_path / "b.texture")
    assert equal(load_prepared(path=tmp_path / "b.texture"), made)
    assert len(list((tmp_path / "b.texture" / "derived").glob("factor_*.values.npy"))) == 2
