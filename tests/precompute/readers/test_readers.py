# SPDX-License-Identifier: GPL-3.0-or-later
"""Every basic format gives the right heights, size, unit, channel and orientation.

The files are written by independent libraries (gsffile, gwyfile, Pillow, tifffile, OpenEXR) or by hand.
"""

import hashlib
import struct

import numpy as np
import pytest

from precompute.readers import channel_names, read_scan
from precompute.scan.gsf import write_gsf
from precompute.scan.heightfield import HeightField

#: Top row first, as all these files store it: the tallest pixel is at the top right.
TOP_FIRST = np.array([[1.0, 2.0, 9.0], [3.0, 4.0, 5.0]]) * 1e-9
BOTTOM_FIRST = np.array([[3.0, 4.0, 5.0], [1.0, 2.0, 9.0]]) * 1e-9


@pytest.fixture
def chip(scan_dir):
    for name in ("chip_80um.gsf", "chip_80um.gwy"):
        if not (scan_dir / name).is_file():
            pytest.skip(f"{name} is not in {scan_dir}")
    return scan_dir


def test_gsf_from_another_library(tmp_path):
    import gsffile

    path = tmp_path / "scan.gsf"
    gsffile.write_gsf(path, TOP_FIRST.astype(np.float32), {"XReal": 3e-6, "YReal": 4e-6, "ZUnits": "m", "Title": "Top"})
    field = read_scan(path)
    np.testing.assert_array_equal(field.heights, BOTTOM_FIRST.astype(np.float32).astype(float))
    assert (field.dx, field.dy) == pytest.approx((1e-6, 2e-6))
    assert field.metadata["channel"] == "Top"
    assert field.metadata["format"] == "gsf"
    assert field.metadata["name"] == "scan.gsf"
    assert field.metadata["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()


def test_gsf_in_nanometres_and_micrometres(tmp_path):
    header = "Gwyddion Simple Field 1.0\nXRes = 3\nYRes = 2\nXReal = 3\nYReal = 4\nXYUnits = µm\nZUnits = nm\n".encode()
    header += b"\0" * (4 - len(header) % 4)
    (tmp_path / "scan.gsf").write_bytes(header + (TOP_FIRST * 1e9).astype("<f4").tobytes())
    field = read_scan(tmp_path / "scan.gsf")
    np.testing.assert_allclose(field.heights, BOTTOM_FIRST, rtol=1e-12)
    assert field.size_m == pytest.approx((3e-6, 4e-6))


def test_gsf_nan_is_a_missing_point(tmp_path):
    import gsffile

    values = TOP_FIRST.astype(np.float32).copy()
    values[0, 2] = np.nan
    gsffile.write_gsf(tmp_path / "scan.gsf", values, {"XReal": 3e-6, "YReal": 4e-6, "ZUnits": "m"})
    field = read_scan(tmp_path / "scan.gsf")
    assert np.argwhere(field.missing).tolist() == [[1, 2]]


def test_gsf_round_trip_keeps_everything(tmp_path):
    rng = np.random.default_rng(3)
    heights = rng.normal(0, 1e-7, (7, 5))
    missing = rng.random((7, 5)) < 0.2
    heights[missing] = np.nan
    steps = ({"step": "level", "method": "poly2"}, {"step": "fill", "count": 3})
    field = HeightField(heights, 1.1e-8, 2.3e-8, missing, {"channel": "ZSensor", "format": "x3p"}, steps)
    again = read_scan(write_gsf(field, tmp_path / "größe µ.gsf"))
    np.testing.assert_array_equal(again.heights, heights.astype(np.float32).astype(float))
    np.testing.assert_array_equal(again.missing, missing)
    assert (again.dx, again.dy) == pytest.approx((field.dx, field.dy), rel=1e-15)
    assert again.processing == steps
    assert again.metadata["channel"] == "ZSensor"
    assert again.metadata["SourceFormat"] == "x3p"


def test_written_gsf_is_read_by_another_library(tmp_path):
    import gsffile

    field = HeightField(BOTTOM_FIRST, 1e-6, 2e-6)
    values, metadata = gsffile.read_gsf(write_gsf(field, tmp_path / "scan.gsf"))
    np.testing.assert_array_equal(values, TOP_FIRST.astype(np.float32))
    assert (metadata["XReal"], metadata["YReal"], metadata["ZUnits"]) == (3e-6, 4e-6, "m")


def _gwy(path, **fields):
    import gwyfile.objects as gwy

    container = gwy.GwyContainer()
    for key, value in fields.items():
        container["/" + key.replace("__", "/")] = value
    container.tofile(str(path))


def _gwy_field(values, unit="m"):
    import gwyfile.objects as gwy

    return gwy.GwyDataField(np.asarray(values, float), 3e-6, 4e-6, si_unit_xy="m", si_unit_z=unit)


def test_gwy_chooses_the_height_channel_and_keeps_the_mask(tmp_path):
    _gwy(
        tmp_path / "scan.gwy",
        **{
            "0__data": _gwy_field(TOP_FIRST * 1e9, "deg"),
            "0__data__title": "Phase",
            "1__data": _gwy_field(TOP_FIRST),
            "1__data__title": "Topography",
            "1__mask": _gwy_field([[0, 0, 1.0], [0, 0, 0]]),
        },
    )
    field = read_scan(tmp_path / "scan.gwy")
    assert field.metadata["channel"] == "Topography"
    assert field.metadata["channels"] == ["Phase [deg]", "Topography [m]"] == channel_names(tmp_path / "scan.gwy")
    assert field.size_m == pytest.approx((3e-6, 4e-6))
    assert np.argwhere(field.missing).tolist() == [[1, 2]]
    np.testing.assert_array_equal(field.heights[~field.missing], BOTTOM_FIRST[~field.missing])


def test_a_channel_can_be_named(tmp_path):
    _gwy(
        tmp_path / "scan.gwy",
        **{
            "0__data": _gwy_field(TOP_FIRST),
            "0__data__title": "Height trace",
            "1__data": _gwy_field(2 * TOP_FIRST),
            "1__data__title": "Height retrace",
        },
    )
    assert read_scan(tmp_path / "scan.gwy").metadata["channel"] == "Height trace"
    for name in ("Height retrace", "height RETRACE", "1"):
        np.testing.assert_array_equal(read_scan(tmp_path / "scan.gwy", channel=name).heights, 2 * BOTTOM_FIRST)


def test_the_two_chip_files_agree(chip):
    gsf, gwy = read_scan(chip / "chip_80um.gsf"), read_scan(chip / "chip_80um.gwy")
    np.testing.assert_array_equal(gsf.heights.astype(np.float32), gwy.heights.astype(np.float32))
    assert gsf.size_m == pytest.approx((80e-6, 80e-6)) == gwy.size_m
    assert gsf.shape == (300, 300)


GWYDDION = "# Channel: My Channel\n# Width: 12.5 µm\n# Height: 5000 nm\n# Value units: nm\n"
WSXM = "WSxM file\nWSxM ASCII Matrix file\nX Amplitude: 12.5 um\nY Amplitude: 5 um\nZ Amplitude: 9 nm\n\n"
PAIRS = "h=2 w=3\npixel size=2.5e-6 m\ndata unit=nm\n"


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
@pytest.mark.parametrize(
    ("header", "size"), [(GWYDDION, (12.5e-6, 5e-6)), (WSXM, (12.5e-6, 5e-6)), (PAIRS, (7.5e-6, 5e-6))]
)
def test_text_headers(tmp_path, header, size, encoding):
    path = tmp_path / "scan.txt"
    path.write_bytes((header + "1 2 9\n3 4 5\n").encode(encoding))
    field = read_scan(path)
    np.testing.assert_allclose(field.heights, BOTTOM_FIRST, rtol=1e-12)
    assert field.size_m == pytest.approx(size)


@pytest.mark.parametrize(
    "body",
    ["1 2 9\n3 4 5", "1\t2\t9\r\n3\t4\t5\r\n", "1,2,9\n3,4,5\n", "1;2;9\n\n3;4;5\n", "1,0\t2,0\t9,0\n3,0\t4,0\t5,0"],
)
def test_text_separators(tmp_path, body):
    (tmp_path / "scan.csv").write_text(GWYDDION + body, encoding="utf-8")
    np.testing.assert_allclose(read_scan(tmp_path / "scan.csv").heights, BOTTOM_FIRST, rtol=1e-12)


def test_text_without_units_takes_the_users(tmp_path):
    (tmp_path / "scan.txt").write_text("1 2 9\n3 4 5\n")
    field = read_scan(tmp_path / "scan.txt", size_m=(3e-6, 2e-6), height_m=16e-9)
    assert np.ptp(field.heights) == pytest.approx(16e-9)
    assert (field.heights[0, 1] - field.heights[0, 0]) == pytest.approx(2e-9)
    assert field.processing[-1]["step"] == "set height"


def test_the_users_size_takes_the_place_of_the_files(tmp_path):
    (tmp_path / "scan.txt").write_text(GWYDDION + "1 2 9\n3 4 5\n", encoding="utf-8")
    field = read_scan(tmp_path / "scan.txt", size_m=(6e-6, 8e-6))
    assert field.size_m == pytest.approx((6e-6, 8e-6))
    assert field.processing[0]["before_m"] == pytest.approx([12.5e-6, 5e-6])


GREY8 = np.array([[0, 51, 255], [102, 153, 204]], np.uint8)


def _check_grey(path, rtol=1e-12):
    field = read_scan(path, size_m=(3e-6, 4e-6), height_m=1e-6)
    np.testing.assert_allclose(field.heights, [[0.4e-6, 0.6e-6, 0.8e-6], [0, 0.2e-6, 1e-6]], rtol=rtol, atol=1e-15)
    assert field.size_m == pytest.approx((3e-6, 4e-6))
    return field


@pytest.mark.parametrize("extension", ["png", "tif", "bmp"])
@pytest.mark.parametrize("mode", ["L", "RGB"])
def test_8_bit_images(tmp_path, extension, mode):
    from PIL import Image

    Image.fromarray(GREY8).convert(mode).save(tmp_path / f"scan.{extension}")
    _check_grey(tmp_path / f"scan.{extension}")


def test_16_bit_png(tmp_path):
    from PIL import Image

    Image.fromarray(GREY8.astype(np.uint16) * 257).save(tmp_path / "scan.png")
    assert struct.unpack(">B", (tmp_path / "scan.png").read_bytes()[24:25]) == (16,)
    _check_grey(tmp_path / "scan.png")


@pytest.mark.parametrize("photometric", ["minisblack", "miniswhite"])
def test_16_bit_tiff(tmp_path, photometric):
    import tifffile

    values = GREY8.astype(np.uint16) * 257
    if photometric == "miniswhite":
        values = 65535 - values
    tifffile.imwrite(tmp_path / "scan.tif", values, photometric=photometric)
    _check_grey(tmp_path / "scan.tif")


@pytest.mark.parametrize("compression", ["tiff_lzw", "tiff_adobe_deflate", "packbits"])
def test_compressed_tiff(tmp_path, compression):
    from PIL import Image

    Image.fromarray(GREY8.astype(np.uint16) * 257).save(tmp_path / "scan.tif", compression=compression)
    _check_grey(tmp_path / "scan.tif")


def test_float_tiff(tmp_path):
    import tifffile

    tifffile.imwrite(tmp_path / "scan.tif", (GREY8 / 255).astype(np.float32))
    _check_grey(tmp_path / "scan.tif", rtol=1e-6)


@pytest.mark.parametrize("channels", [["Y"], ["R", "G", "B"], ["Z", "A"]])
def test_exr(tmp_path, channels):
    import OpenEXR

    values = (GREY8 / 255).astype(np.float32)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {name: values.copy() for name in channels}) as file:
        file.write(str(tmp_path / "scan.exr"))
    _check_grey(tmp_path / "scan.exr", rtol=1e-6)


def test_the_name_does_not_decide_where_the_content_tells(tmp_path):
    import gsffile

    gsffile.write_gsf(
        tmp_path / "scan.gsf", TOP_FIRST.astype(np.float32), {"XReal": 3e-6, "YReal": 4e-6, "ZUnits": "m"}
    )
    (tmp_path / "scan.gsf").rename(tmp_path / "scan.0007")
    assert read_scan(tmp_path / "scan.0007").metadata["format"] == "gsf"
