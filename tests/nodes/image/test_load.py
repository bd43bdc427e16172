import io

import numpy as np
import OpenImageIO as oiio
import pytest
import tifffile
from PIL import Image as Pictures
from PIL import ImageOps

from graphtex_nodes.image.files.colour import decode_srgb, encode_srgb
from graphtex_nodes.image.files.encode import encode, write_deep
from graphtex_nodes.image.load import load_image, load_mask, load_scale
from tests.nodes.image.files import chunk, noise, png, profile


def load(path, **options):
    return load_image(path=str(path), **options)


def write_exr(path, samples, names, **attributes):
    spec = oiio.ImageSpec(samples.shape[1], samples.shape[0], samples.shape[2], "float")
    spec.channelnames = names
    for name, value in attributes.items():
        spec.attribute(name, *value) if isinstance(value, tuple) else spec.attribute(name, value)
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), spec)
    assert file.write_image(samples)
    file.close()


@pytest.mark.parametrize(("mode", "channels"), [("L", 1), ("LA", 2), ("RGB", 3), ("RGBA", 4)])
@pytest.mark.parametrize("suffix", ["png", "tif"])
def test_8_bit_of_pillow(tmp_path, mode, channels, suffix):
    samples = noise(5, 7, channels)
    path = tmp_path / f"a.{suffix}"
    Pictures.fromarray(samples[..., 0] if channels == 1 else samples, mode=None).save(path)
    picture = load(path)
    assert picture.dtype == np.float32
    np.testing.assert_array_equal(picture, samples / np.float32(255))


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_png_made_by_hand(tmp_path, channels, interlaced, dtype):
    """Both depths, straight and Adam7; 16 bits keep all their bits."""
    samples = noise(11, 13, channels, dtype=dtype)
    (tmp_path / "a.png").write_bytes(png(samples, {1: 0, 2: 4, 3: 2, 4: 6}[channels], interlaced=interlaced))
    np.testing.assert_array_equal(load(tmp_path / "a.png"), samples / np.float32(np.iinfo(dtype).max))


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_png_transparent_colour(tmp_path, dtype):
    """A tRNS colour becomes alpha 0, all others alpha 1."""
    samples = np.array([[[1, 2, 3], [4, 5, 6]]], dtype)
    (tmp_path / "a.png").write_bytes(png(samples, 2, extra=((b"tRNS", b"\0\1\0\2\0\3"),)))
    assert load(tmp_path / "a.png")[0, :, 3].tolist() == [0, 1]


def test_palette_with_and_without_transparency(tmp_path):
    picture = Pictures.fromarray(np.array([[0, 1]], np.uint8))
    picture.putpalette([255, 0, 0, 0, 0, 255])
    picture.save(tmp_path / "a.png")
    assert load(tmp_path / "a.png").tolist() == [[[1, 0, 0], [0, 0, 1]]]
    picture.save(tmp_path / "b.png", transparency=1)
    assert load(tmp_path / "b.png")[0, :, 3].tolist() == [1, 0]


@pytest.mark.parametrize("suffix", ["png", "bmp", "tif"])
def test_one_bit(tmp_path, suffix):
    Pictures.fromarray(np.array([[True, False, True]])).save(tmp_path / f"a.{suffix}")
    assert load(tmp_path / f"a.{suffix}")[..., 0].tolist() == [[1, 0, 1]]


@pytest.mark.parametrize("suffix", ["gif", "tif", "webp"])
def test_the_first_of_several_frames_or_pages_is_read_with_a_warning(tmp_path, suffix):
    frames = [Pictures.new("RGB", (3, 2), colour) for colour in ((255, 0, 0), (0, 255, 0))]
    frames[0].save(tmp_path / f"a.{suffix}", save_all=True, append_images=frames[1:], lossless=True)
    with pytest.warns(UserWarning, match="holds several pages or frames; the first is read"):
        picture = load(tmp_path / f"a.{suffix}")
    np.testing.assert_array_equal(picture, np.broadcast_to(np.float32([1, 0, 0]), (2, 3, 3)))


def test_a_page_of_another_size_is_a_thumbnail_of_which_nothing_is_said(tmp_path):
    large, small = (Pictures.new("RGB", size, (255, 0, 0)) for size in ((4, 2), (2, 1)))
    large.save(tmp_path / "a.tif", save_all=True, append_images=[small])
    assert load(tmp_path / "a.tif").shape == (2, 4, 3)


def test_content_decides_not_the_suffix(tmp_path):
    Pictures.fromarray(noise(4, 4, 3)).save(tmp_path / "a.png")
    (tmp_path / "a.png").rename(tmp_path / "a.jpg")
    np.testing.assert_array_equal(load(tmp_path / "a.jpg"), noise(4, 4, 3) / np.float32(255))


def test_cmyk_jpeg(tmp_path):
    """Without a profile it is (1 - ink) (1 - black)."""
    ink = np.full((16, 16, 4), [51, 102, 0, 128], np.uint8)
    Pictures.fromarray(ink, mode="CMYK").save(tmp_path / "a.jpg", quality=100)
    expected = np.array([0.8, 0.6, 1.0]) * (127 / 255)
    np.testing.assert_allclose(load(tmp_path / "a.jpg")[8, 8], expected, atol=2 / 255)


def test_cmyk_tiff(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", np.full((4, 4, 4), [51, 102, 0, 0], np.uint8), photometric="separated")
    np.testing.assert_allclose(load(tmp_path / "a.tif")[0, 0], [0.8, 0.6, 1.0], atol=1e-6)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("suffix", ["jpg", "png", "webp", "tif"])
def test_orientation_against_pillow(tmp_path, orientation, suffix):
    blocks = np.kron(np.array([[0, 80, 160], [200, 120, 40]], np.uint8), np.ones((16, 16), np.uint8))
    picture = Pictures.fromarray(np.stack([blocks] * 3, axis=2))
    exif = Pictures.Exif()
    exif[0x0112] = orientation
    options = {"quality": 100} if suffix != "png" else {}
    picture.save(tmp_path / f"a.{suffix}", exif=exif, **options)
    with Pictures.open(tmp_path / f"a.{suffix}") as opened:
        expected = np.asarray(ImageOps.exif_transpose(opened))
    np.testing.assert_allclose(load(tmp_path / f"a.{suffix}"), expected / 255, atol=1 / 255)


def test_orientation_of_16_bit(tmp_path):
    """6: the top row of the file is the right side of the picture."""
    samples = np.arange(6, dtype=np.uint16).reshape(2, 3) * 1000
    tifffile.imwrite(tmp_path / "a.tif", samples, extratags=[(274, "H", 1, 6, True)])
    expected = np.array([[3, 0], [4, 1], [5, 2]]) * 1000
    np.testing.assert_array_equal(np.rint(load(tmp_path / "a.tif")[..., 0] * 65535), expected)


@pytest.mark.parametrize("byteorder", ["<", ">"])
@pytest.mark.parametrize("planar", ["contig", "separate"])
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "uint32", "float16", "float32", "float64"])
def test_tiff_of_many_channels(tmp_path, byteorder, planar, dtype):
    samples = noise(4, 5, 7, dtype=dtype)
    stored = samples if planar == "contig" else np.ascontiguousarray(samples.transpose(2, 0, 1))
    options = {"photometric": "minisblack", "planarconfig": planar, "extrasamples": [0] * 6}
    tifffile.imwrite(tmp_path / "a.tif", stored, byteorder=byteorder, **options)
    top = np.iinfo(dtype).max if dtype.startswith("u") else 1
    np.testing.assert_allclose(load(tmp_path / "a.tif"), samples / np.float64(top), rtol=1e-7)


@pytest.mark.parametrize("compression", ["tiff_lzw", "jpeg", "packbits", "tiff_adobe_deflate"])
def test_compressed_tiff(tmp_path, compression):
    samples = np.kron(noise(3, 4), np.ones((16, 16), np.uint8))
    options = {"quality": 100} if compression == "jpeg" else {}
    Pictures.fromarray(samples).save(tmp_path / "a.tif", compression=compression, **options)
    np.testing.assert_allclose(load(tmp_path / "a.tif")[..., 0], samples / 255, atol=2 / 255)


@pytest.mark.parametrize(("shape", "layout"), [((1, 5), {}), ((20, 18), {"tile": (16, 16)}), ((1, 3, 3), {})])
def test_tiff_of_doubles_in_one_row_or_in_tiles(tmp_path, shape, layout):
    """OpenImageIO alone returns uninitialised memory for these."""
    samples = noise(*shape, dtype="float64")
    tifffile.imwrite(tmp_path / "a.tif", samples, photometric="rgb" if len(shape) == 3 else "minisblack", **layout)
    expected = samples.reshape(*shape[:2], -1).astype(np.float32)
    np.testing.assert_array_equal(load(tmp_path / "a.tif"), expected)


def test_tiff_where_white_is_0(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", np.array([[0, 55, 255]], np.uint8), photometric="miniswhite")
    np.testing.assert_allclose(load(tmp_path / "a.tif")[..., 0], [[1, 200 / 255, 0]], atol=1e-6)


@pytest.mark.parametrize(("kind", "expected"), [("unassalpha", 0.25), ("assocalpha", 0.5)])
def test_alpha_is_straight(tmp_path, kind, expected):
    """Colour 0.25 at alpha 0.5 is 0.5 when the file says that it was multiplied."""
    samples = np.full((2, 2, 4), [0.25, 0.25, 0.25, 0.5], np.float32)
    tifffile.imwrite(tmp_path / "a.tif", samples, photometric="rgb", extrasamples=[kind])
    np.testing.assert_allclose(load(tmp_path / "a.tif")[0, 0], [expected] * 3 + [0.5])
    np.testing.assert_allclose(load(tmp_path / "a.tif", encoding="raw")[0, 0], [0.25] * 3 + [0.5])


@pytest.mark.parametrize(
    ("policy", "expected"),
    [("keep", [0.2, 0.4]), ("drop", [0.2]), ("over-white", [0.68]), ("over-black", [0.08])],
)
def test_alpha_policies(tmp_path, policy, expected):
    """Grey 0.2 at alpha 0.4: 0.2 * 0.4 + 1 * 0.6 over white."""
    np.save(tmp_path / "a.npy", np.array([[[0.2, 0.4]]], np.float32))
    np.testing.assert_allclose(load(tmp_path / "a.npy", alpha=policy)[0, 0], expected, rtol=1e-6)


def test_raw_premultiplied_over_white(tmp_path):
    samples = np.full((1, 1, 4), [0.25, 0.25, 0.25, 0.5], np.float32)
    tifffile.imwrite(tmp_path / "a.tif", samples, photometric="rgb", extrasamples=["assocalpha"])
    np.testing.assert_allclose(load(tmp_path / "a.tif", encoding="raw", alpha="over-white")[0, 0], [0.75] * 3)


def test_exr_is_linear_and_premultiplied(tmp_path):
    """0.25 at alpha 0.5 is linear 0.5, which sRGB encodes as 0.7354; without cover colour stays."""
    samples = np.array([[[0.25, 0.25, 0.25, 0.5], [0.5, 0.5, 0.5, 0.0]]], np.float32)
    write_deep(samples, tmp_path / "a.exr")
    np.testing.assert_allclose(load(tmp_path / "a.exr")[0, :, 0], [0.7354, 0.7354], atol=1e-4)
    np.testing.assert_allclose(load(tmp_path / "a.exr", encoding="srgb")[0, :, 0], [0.5, 0.5])
    np.testing.assert_array_equal(load(tmp_path / "a.exr", encoding="raw"), samples)


def test_exr_encodes_named_colours_only(tmp_path):
    """Depth beside R, G, B is data; channels come as R, G, B, then the rest by name."""
    samples = np.full((1, 1, 5), [9.0, 0.5, 0.25, 0.125, 0.75], np.float32)
    write_exr(tmp_path / "a.exr", samples, ("Z", "B", "G", "R", "normal.x"))
    with pytest.warns(UserWarning, match="values from"):
        picture = load(tmp_path / "a.exr")
    np.testing.assert_allclose(decode_srgb(picture[0, 0, :3]), [0.125, 0.25, 0.5], rtol=1e-6)
    assert sorted(picture[0, 0, 3:].tolist()) == [0.75, 9.0]


def test_exr_alpha_before_further_channels(tmp_path):
    samples = np.full((1, 1, 5), [0.2, 0.2, 0.2, 0.5, 0.75], np.float32)
    write_exr(tmp_path / "a.exr", samples, ("R", "G", "B", "A", "height"))
    picture = load(tmp_path / "a.exr", alpha="drop")
    np.testing.assert_allclose(picture[0, 0], [*encode_srgb(np.full(3, 0.4)), 0.75], rtol=1e-6)


def test_values_beyond_1_are_kept(tmp_path):
    write_deep(np.full((1, 1, 3), 4.0, np.float32), tmp_path / "a.exr")
    with pytest.warns(UserWarning, match="values from 1.825 to 1.825 are kept"):
        picture = load(tmp_path / "a.exr")
    np.testing.assert_allclose(picture, 1.055 * 4 ** (1 / 2.4) - 0.055, rtol=1e-6)


def test_foreign_primaries_are_told(tmp_path):
    aces = ("float[8]", (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767))
    write_exr(tmp_path / "a.exr", np.full((1, 1, 3), 0.5, np.float32), ("R", "G", "B"), chromaticities=aces)
    with pytest.warns(UserWarning, match="primaries"):
        load(tmp_path / "a.exr")


def test_linear_16_bit(tmp_path):
    (tmp_path / "a.png").write_bytes(png(np.full((1, 1, 1), 14029, np.uint16), 0))
    np.testing.assert_allclose(load(tmp_path / "a.png", encoding="linear"), 0.5, atol=1e-4)


def test_nan(tmp_path):
    write_deep(np.array([[[np.nan], [0.5], [np.inf]]], np.float32), tmp_path / "a.exr")
    with pytest.raises(ValueError, match=r"a\.exr: 2 of 3 samples are NaN or infinite"):
        load(tmp_path / "a.exr")
    np.testing.assert_allclose(load(tmp_path / "a.exr", nonfinite="zero", encoding="raw")[0, :, 0], [0, 0.5, 0])


def test_double_beyond_float(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", np.full((1, 2), 1e300))
    with pytest.raises(ValueError, match="2 of 2 samples are NaN or infinite"):
        load(tmp_path / "a.tif")


def deep_png(samples, icc):
    import zlib

    return png(samples, 2 if samples.shape[2] == 3 else 0, extra=((b"iCCP", b"x\0\0" + zlib.compress(icc)),))


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
@pytest.mark.parametrize("parametric", [False, True])
def test_profile_of_linear_light(tmp_path, dtype, parametric):
    """sRGB's primaries without a curve: the conversion is the transfer function."""
    samples = noise(4, 5, 3, dtype=dtype)
    (tmp_path / "a.png").write_bytes(deep_png(samples, profile(1.0, parametric=parametric)))
    expected = encode_srgb(samples / np.iinfo(dtype).max)
    np.testing.assert_allclose(load(tmp_path / "a.png"), expected, atol=1.5 / 255 if dtype == "uint8" else 1e-3)
    np.testing.assert_array_equal(load(tmp_path / "a.png", encoding="raw"), samples / np.float32(np.iinfo(dtype).max))


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_profile_with_swapped_primaries(tmp_path, dtype):
    """A display whose red is sRGB's green: the conversion swaps both channels."""
    samples = noise(4, 5, 3, dtype=dtype)
    (tmp_path / "a.png").write_bytes(deep_png(samples, profile(1.0, (1, 0, 2))))
    expected = encode_srgb(samples / np.iinfo(dtype).max)[..., [1, 0, 2]]
    np.testing.assert_allclose(load(tmp_path / "a.png"), expected, atol=2 / 255 if dtype == "uint8" else 1e-3)


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_grey_profile(tmp_path, dtype):
    samples = noise(4, 5, 1, dtype=dtype)
    (tmp_path / "a.png").write_bytes(deep_png(samples, profile(1.0, ())))
    expected = encode_srgb(samples / np.iinfo(dtype).max)
    np.testing.assert_allclose(load(tmp_path / "a.png"), expected, atol=2 / 255 if dtype == "uint8" else 1e-3)


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_grey_with_a_profile_for_rgb(tmp_path, dtype):
    """Some programs write it; it is not used."""
    samples = noise(4, 5, 1, dtype=dtype)
    (tmp_path / "a.png").write_bytes(deep_png(samples, profile(1.0)))
    tifffile.imwrite(tmp_path / "a.tif", samples[..., 0], iccprofile=profile(1.0))
    for name in ("a.png", "a.tif"):
        np.testing.assert_array_equal(load(tmp_path / name), samples / np.float32(np.iinfo(dtype).max))


def test_profile_leaves_alpha_alone(tmp_path):
    samples = noise(4, 5, 4)
    Pictures.fromarray(samples).save(tmp_path / "a.png", icc_profile=profile(1.0))
    np.testing.assert_array_equal(load(tmp_path / "a.png")[..., 3], samples[..., 3] / np.float32(255))


def test_srgb_profile_changes_nothing(tmp_path):
    from PIL import ImageCms

    own = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    Pictures.fromarray(noise(9, 9, 3)).save(tmp_path / "a.png", icc_profile=own)
    np.testing.assert_array_equal(load(tmp_path / "a.png"), noise(9, 9, 3) / np.float32(255))
    deep = noise(9, 9, 3, dtype="uint16")
    (tmp_path / "b.png").write_bytes(deep_png(deep, own))
    np.testing.assert_array_equal(load(tmp_path / "b.png"), deep / np.float32(65535))


def test_exr_whose_names_are_no_text(tmp_path):
    """OpenImageIO's message then quotes bytes that are no UTF-8."""
    write_deep(np.full((4, 4, 3), 0.5, np.float32), tmp_path / "a.exr")
    content = (tmp_path / "a.exr").read_bytes()
    (tmp_path / "a.exr").write_bytes(content.replace(b"channels\0chlist", b"channels\0chl\x89st"))
    with pytest.raises(ValueError, match=r"a\.exr: damaged: its header is unreadable"):
        load(tmp_path / "a.exr")


@pytest.mark.parametrize("broken", [b"nonsense" * 40, profile(1.0, ())])
@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
def test_profile_that_does_not_fit(tmp_path, broken, dtype):
    """A damaged profile, or one for grey on a picture in colour, is told and not used."""
    samples = noise(4, 5, 3, dtype=dtype)
    tifffile.imwrite(tmp_path / "a.tif", samples, photometric="rgb", iccprofile=broken)
    with pytest.warns(UserWarning, match="colour profile is not used"):
        picture = load(tmp_path / "a.tif")
    np.testing.assert_array_equal(picture, samples / np.float32(np.iinfo(dtype).max))


@pytest.mark.parametrize("share", [0.02, 0.5, 0.95])
@pytest.mark.parametrize("name", ["a.png", "deep.png", "a.jpg", "a.tif", "a.webp", "a.exr", "a.hdr", "a.npy"])
def test_cut_off(tmp_path, share, name, capfd):
    """A file of noise, so that a part of it is not the whole picture; the libraries below print nothing of their own."""
    path = tmp_path / name
    encode(noise(60, 60, 3, dtype="float32"), path, depth=16 if name == "deep.png" else None)
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    with pytest.raises(ValueError, match=rf"{name}: (no array, or )?damaged") as caught:
        load(path)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("at", [20, 300, -3])
def test_a_deep_png_with_a_wrong_byte(tmp_path, at, capfd):
    path = tmp_path / "deep.png"
    encode(noise(8, 9, 3, dtype="float32"), path, depth=16)
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(data)
    with pytest.raises(ValueError, match=r"deep\.png: damaged: a chunk does not fit its checksum"):
        load(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("name", "suffix"), [("GIF", "gif"), ("BMP", "bmp")])
def test_cut_off_of_pillow(tmp_path, name, suffix):
    whole = io.BytesIO()
    Pictures.fromarray(noise(60, 60)).save(whole, name)
    (tmp_path / f"a.{suffix}").write_bytes(whole.getvalue()[: len(whole.getvalue()) // 2])
    with pytest.raises(ValueError, match="damaged or cut off"):
        load(tmp_path / f"a.{suffix}")


def test_no_file_folder_empty_text(tmp_path):
    with pytest.raises(ValueError, match=r"none\.png: no such file"):
        load(tmp_path / "none.png")
    with pytest.raises(ValueError, match="a folder, not a picture"):
        load(tmp_path)
    (tmp_path / "empty.png").write_bytes(b"")
    with pytest.raises(ValueError, match=r"empty\.png: the file is empty"):
        load(tmp_path / "empty.png")
    (tmp_path / "text.png").write_text("hello")
    with pytest.raises(ValueError, match=r"text\.png: not a picture in a known format"):
        load(tmp_path / "text.png")


@pytest.mark.parametrize("bits", [8, 16])
def test_huge_header_is_refused_before_decoding(tmp_path, bits):
    import struct

    head = struct.pack(">IIBBBBB", 100_000, 100_000, bits, 2, 0, 0, 0)
    body = chunk(b"IDAT", b"\x78\x9c") + chunk(b"IEND", b"")
    (tmp_path / "a.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + body)
    with pytest.raises(ValueError, match="100000 x 100000 pixels are more than"):
        load(tmp_path / "a.png")


def test_pillows_own_limit_does_not_count(tmp_path, monkeypatch):
    """Pillow takes pictures over 89 million pixels for an attack; here only MOST_PIXELS counts."""
    Pictures.fromarray(noise(20, 20)).save(tmp_path / "a.png")
    monkeypatch.setattr(Pictures, "MAX_IMAGE_PIXELS", 10)
    assert load(tmp_path / "a.png").shape == (20, 20, 1)


def test_too_many_channels(tmp_path):
    tifffile.imwrite(
        tmp_path / "a.tif", np.zeros((3, 3, 17), np.float32), photometric="minisblack", planarconfig="contig"
    )
    with pytest.raises(ValueError, match=r"a\.tif: an Image has up to 16 channels, the file holds 17"):
        load(tmp_path / "a.tif")


def test_array_whose_header_is_damaged(tmp_path):
    """NumPy parses it as Python."""
    np.save(tmp_path / "a.npy", np.zeros((2, 2)))
    (tmp_path / "a.npy").write_bytes((tmp_path / "a.npy").read_bytes().replace(b"}", b"{"))
    with pytest.raises(ValueError, match=r"a\.npy: no array, or damaged"):
        load(tmp_path / "a.npy")


@pytest.mark.parametrize("wrong", [np.zeros((2, 2, 2, 2)), np.zeros((0, 3)), np.array([["a"]]), np.array([[None]])])
def test_arrays_that_are_no_picture(tmp_path, wrong):
    np.save(tmp_path / "a.npy", wrong, allow_pickle=True)
    with pytest.raises(ValueError, match=r"a\.npy: (a picture is numbers|no array, or damaged)"):
        load(tmp_path / "a.npy")


def test_mask_from_grey_alpha_and_colour(tmp_path):
    Pictures.fromarray(np.array([[0, 127, 128, 255]], np.uint8)).save(tmp_path / "grey.png")
    assert load_mask(path=str(tmp_path / "grey.png")).tolist() == [[False, False, True, True]]
    assert load_mask(path=str(tmp_path / "grey.png"), threshold=1.0, invert=True).tolist() == [[True] * 3 + [False]]
    pixels = np.array([[[255, 255, 255, 0], [255, 255, 255, 200], [255, 0, 0, 255]]], np.uint8)
    Pictures.fromarray(pixels).save(tmp_path / "a.png")
    assert load_mask(path=str(tmp_path / "a.png")).tolist() == [[False, True, False]]  # laid over black; mean
    assert load_mask(path=str(tmp_path / "a.png"), channel="alpha").tolist() == [[False, True, True]]
    with pytest.raises(ValueError, match="has no alpha"):
        load_mask(path=str(tmp_path / "grey.png"), channel="alpha")


def test_mask_of_bools(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[True, False]]))
    assert load_mask(path=str(tmp_path / "a.npy")).tolist() == [[True, False]]


def test_scale_of_each_depth(tmp_path):
    Pictures.fromarray(np.array([[128, 64]], np.uint8)).save(tmp_path / "a.png")
    assert load_scale(path=str(tmp_path / "a.png")).tolist() == [[1, 0.5]]
    assert load_scale(path=str(tmp_path / "a.png"), unit=64).tolist() == [[2, 1]]
    (tmp_path / "b.png").write_bytes(png(np.array([[[32768], [16384]]], np.uint16), 0))
    assert load_scale(path=str(tmp_path / "b.png")).tolist() == [[1, 0.5]]
    np.save(tmp_path / "a.npy", np.array([[7.5, 0.25]]))
    assert load_scale(path=str(tmp_path / "a.npy")).tolist() == [[7.5, 0.25]]
    Pictures.fromarray(np.array([[[128] * 3]], np.uint8)).save(tmp_path / "c.png")
    assert load_scale(path=str(tmp_path / "c.png")).tolist() == [[1]]


def test_scale_is_clamped_and_told(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[0.0, 9.0, 1.0, 1.0]]))
    with pytest.warns(UserWarning, match=r"50.0% of the scales"):
        assert load_scale(path=str(tmp_path / "a.npy")).tolist() == [[0.125, 8, 1, 1]]


def test_scale_in_colour_is_refused(tmp_path):
    Pictures.fromarray(noise(3, 3, 3)).save(tmp_path / "a.png")
    with pytest.raises(ValueError, match="a scale map is grey"):
        load_scale(path=str(tmp_path / "a.png"))
