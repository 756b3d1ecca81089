# SPDX-License-Identifier: GPL-3.0-or-later
"""Variants of the formats that are easily read wrongly: the right numbers or one sentence, nothing in between."""

import io
import struct
import zlib

import numpy as np
import pytest

from precompute.errors import ScanError
from precompute.readers import channel_names, read_scan
from tests.support import odd_scans
from tests.support.odd_scans import NM, rows_of

SIZES = {"size_m": (2e-6, 1.5e-6), "height_m": 385e-9}
BOTTOM_FIRST = NM[::-1] * 1e-9


@pytest.fixture
def read(tmp_path):
    """Write a file and read it."""

    def call(name, data, **options):
        path = tmp_path / name
        path.write_bytes(data.encode() if isinstance(data, str) else data)
        return read_scan(path, **options)

    return call


@pytest.fixture
def refused(read):
    """Write a file whose reading must end in one sentence; gives it."""

    def call(name, data, **options):
        with pytest.raises(ScanError) as caught:
            read(name, data, **options)
        sentence = str(caught.value)
        assert sentence.endswith(".") and "\n" not in sentence and len(sentence) < 400
        return sentence

    return call


def same(field, missing=(), size_um=None, heights=BOTTOM_FIRST):
    """Heights, points without one (row from the bottom, column) and size."""
    np.testing.assert_array_equal(np.argwhere(field.missing).tolist(), [list(point) for point in missing] or [])
    np.testing.assert_allclose(field.heights[~field.missing], heights[~field.missing], atol=1e-15)
    if size_um is not None:
        assert field.size_m == pytest.approx([side * 1e-6 for side in size_um])


# --- Bruker: the slow axis -------------------------------------------------------------------------------------------

SQUARE = ["Scan Size: 10000 nm", "Lines: 64", "Aspect Ratio: 1:1"]


def scan_list(size, lines, aspect):
    return [f"Scan Size: {size}", f"Lines: {lines}", f"Aspect Ratio: {aspect}"]


def image_list(aspect, size="10 10 ~m"):
    return [f"Aspect Ratio: {aspect}", f"Scan Size: {size}"]


@pytest.mark.parametrize(
    ("cols", "rows", "scan", "image", "size_um"),
    [
        (64, 64, SQUARE, image_list("1:1"), (10, 10)),
        (64, 32, scan_list("10000 nm", 32, "2:1"), image_list("2:1"), (10, 5)),
        (64, 16, scan_list("8000 nm", 16, "4:1"), image_list("4:1", "8 8 ~m"), (8, 2)),
        (32, 64, scan_list("8000 nm", 64, "1:2"), image_list("1:2", "8 8 ~m"), (8, 16)),
        (64, 40, SQUARE, image_list("0.6"), (10, 10 * 40 / 64)),
        (64, 40, SQUARE, image_list("1.6:1", "10000 nm"), (10, 10 * 40 / 64)),
        (64, 24, [*SQUARE, "Slow Axis Size: 10000 nm"], image_list("2.67:1"), (10, 10 * 24 / 64)),
        (64, 64, [*SQUARE, "Slow Axis Size: 2500 nm"], image_list("4:1"), (10, 2.5)),
        (64, 32, scan_list("10 5 ~m", 32, "2:1"), image_list("2:1", "10 5 ~m"), (10, 5)),
        (64, 32, scan_list("10 ~m", 32, "2:1"), ["Aspect Ratio: 2:1"], (10, 5)),
    ],
)
def test_bruker_scans_that_are_not_square(read, cols, rows, scan, image, size_um):
    field = read("scan.spm", odd_scans.bruker(cols, rows, scan, image))
    assert field.shape == (rows, cols)
    assert field.size_m == pytest.approx([side * 1e-6 for side in size_um])


def test_bruker_of_the_electrochemical_software(read):
    data = odd_scans.bruker(64, 64, SQUARE, ["Scan Size: 10 10 ~m"], first="*EC File list")
    assert read("scan.spm", data).metadata["format"] == "nanoscope"


def test_bruker_force_curves_are_no_map(refused):
    data = odd_scans.bruker(64, 2, [*SQUARE, "Operating Mode: Force"], ["Scan Size: 10 10 ~m"])
    assert "force curves" in refused("scan.spm", data)


# --- Marks of missing points -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("magic", "kind", "dtype", "bad"),
    [
        (b"bISO-1.0", 7, "<f8", np.finfo("f8").min),
        (b"bISO-1.0", 7, "<f8", np.nan),
        (b"bISO-1.0", 3, "<f4", np.finfo("f4").min),
        (b"bISO-1.0", 4, "<i1", -128),
        (b"bISO-1.0", 5, "<i2", -(2**15)),
        (b"bISO-2.0", 6, "<i4", -(2**31)),
        (b"bISO-2.0", 4, "<i1", -128),
        (b"bBCR-1.0", 5, "<i2", 2**15 - 1),
        (b"bBCR-1.0", 1, "<u2", 2**16 - 1),
        (b"bBCR-1.0", 0, "<u1", 255),
        (b"BBCR-1.0", 7, "<f8", 1.7e308),
    ],
)
def test_sdf_marks(read, magic, kind, dtype, bad):
    same(read("scan.sdf", odd_scans.sdf(magic, kind, dtype, bad)), [(1, 1)], (4, 3))


@pytest.mark.parametrize(
    ("magic", "kind", "bad"),
    [("aISO-1.0", 7, "BAD"), ("aISO-2.0", 5, "-32768"), ("aBCR-1.0", "INTEGER", "32767")],
)
def test_sdf_marks_in_text(read, magic, kind, bad):
    values = [str(int(v)) for v in NM.ravel()]
    values[5] = bad
    comment = "; a comment * with a star" if "BCR" in magic else ""
    text = (
        f"{magic}\nManufacID = maker\nNumPoints = 4\nNumProfiles = 3\nXscale = 1e-6\nYscale = 1e-6\nZscale = 1e-9\n"
        f"DataType = {kind} {comment}\nCompression = 0\n*\n{' '.join(values)}\n*\nOperator = a * b\n*\n"
    )
    same(read("scan.sdf", text), [(1, 1)], (4, 3))


def test_esri_grid(read):
    text = "NCOLS 4\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 0.5\nNODATA_value -9999\n" + rows_of(NM, " ")
    same(read("grid.asc", text.replace("100.0", "-9999"), **SIZES), [(1, 1)])


@pytest.mark.parametrize("nodata", ["-9999", "-3.4028234663852886e+38", "nan", "0.75"])
def test_tiff_no_data_tag(read, nodata):
    import tifffile

    values, file = (NM / 400).astype("f4"), io.BytesIO()
    values[1, 1] = np.float32(nodata)
    tifffile.imwrite(file, values, extratags=[(42113, "s", 0, nodata, True)])
    field = read("scan.tif", file.getvalue(), size_m=(2e-6, 1.5e-6), height_m=400e-9)
    same(field, [(1, 1)], heights=np.float32(NM[::-1] / 400) * 400e-9)


def test_exr_nan(read, tmp_path):
    import OpenEXR

    values = (NM / 400).astype("f4")
    values[0, 3] = np.nan
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"Y": values}) as file:
        file.write(str(tmp_path / "a.exr"))
    field = read("scan.exr", (tmp_path / "a.exr").read_bytes(), **SIZES)
    assert np.argwhere(field.missing).tolist() == [[2, 3]]


@pytest.mark.parametrize("mark", ["NaN", "nan", "Bad", "--", "N/A", "1.#QNAN"])
def test_words_for_missing_points(read, mark):
    text = "# Width: 2 um\n# Height: 1.5 um\n# Value units: nm\n" + rows_of(NM).replace("100.0", mark)
    same(read("scan.txt", text), [(1, 1)], (2, 1.5))


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_empty_cells_keep_their_place(read, separator):
    cells = [[str(v) for v in row] for row in NM]
    cells[0][1] = cells[1][0] = cells[2][3] = ""
    text = "".join(separator.join(row) + "\n" for row in cells)
    field = read("scan.csv", text, size_m=(2e-6, 1.5e-6), height_m=325e-9)
    same(field, [(0, 3), (1, 0), (2, 1)])


# --- X3P -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["F", "D"])
def test_x3p_increment_beside_floats_says_nothing(read, kind):
    values = (NM * 1e-9).astype({"F": "<f4", "D": "<f8"}[kind])
    field = read("scan.x3p", odd_scans.x3p(kind, values, "<Increment>1e-06</Increment>"))
    same(field, size_um=(4, 3), heights=values[::-1].astype(float))


@pytest.mark.parametrize("kind", ["I", "L"])
def test_x3p_increment_of_integers_is_their_unit(read, kind):
    values = NM.astype({"I": "<i2", "L": "<i4"}[kind])
    same(read("scan.x3p", odd_scans.x3p(kind, values, "<Increment>1e-9</Increment>")), size_um=(4, 3))


def test_x3p_in_a_folder(read):
    same(read("scan.x3p", odd_scans.x3p("D", (NM * 1e-9).astype("<f8"), folder="a/b/")), size_um=(4, 3))


@pytest.mark.parametrize(("kind", "axis", "unit"), [("I", "<Increment>1e-9</Increment>", 1), ("D", "", 1e-9)])
def test_x3p_lists_with_empty_points(read, kind, axis, unit):
    datums = [f"{v * unit:.12g}" for v in NM.ravel()]
    datums[5] = ""
    same(read("scan.x3p", odd_scans.x3p(kind, axis=axis, datums=datums)), [(1, 1)], (4, 3))


# --- Tables that are no map ------------------------------------------------------------------------------------------

POINTS = [(x * 0.5, y * 0.5, NM[2 - y, x]) for y in range(3) for x in range(4)]


@pytest.mark.parametrize("order", ["rows", "columns", "any"])
@pytest.mark.parametrize("separator", [" ", "\t", ",", ";"])
def test_points_on_a_grid(read, order, separator):
    mixed = [POINTS[i] for i in np.random.default_rng(1).permutation(12)]
    points = {"rows": POINTS, "columns": sorted(POINTS), "any": mixed}[order]
    field = read("scan.txt", rows_of(points, separator), **SIZES)
    same(field)
    assert any("grid" in note for note in field.metadata["notes"])


def test_points_of_a_noisy_stage(read):
    """Positions as measured: a few thousandths of a step beside the grid, one line of points missing."""
    noise = np.random.default_rng(3).normal(0, 1e-3, (20, 30, 2))
    points = [
        (0.1 * x + 0.1 * noise[y, x, 0], 0.2 * y + 0.2 * noise[y, x, 1], 7 * x + y)
        for y in range(20) for x in range(30) if x != 9
    ]  # fmt: skip
    field = read("scan.xyz", rows_of(points, " ").encode(), size_m=(3e-6, 4e-6), height_m=222e-9)
    assert field.shape == (20, 30) and field.missing[:, 9].all() and field.missing.sum() == 20
    y, x = np.mgrid[0:20, 0:30]
    np.testing.assert_allclose(field.heights[~field.missing], (7 * x + y)[~field.missing] * 1e-9, atol=1e-15)


def test_points_with_units_and_a_gap(read):
    text = "z [nm],x [um],y [um]\n" + rows_of([(z, x, y) for x, y, z in POINTS if z != 100], ",")
    same(read("scan.xyz", text), [(1, 1)], (2, 1.5))


@pytest.mark.parametrize(
    "text",
    [
        "x,z\n" + "".join(f"{i * 0.1:.1f},{i % 5}\n" for i in range(9)),
        "".join(f"{i} {i % 7}\n" for i in range(30)),
        "wavelength,red,green,blue\n" + "".join(f"{380 + 5 * i},{i % 3},{i % 5},{i % 7}\n" for i in range(40)),
        "Z piezo [nm]\tDeflection [nm]\tForce [nN]\n" + "".join(f"{i}\t{i * i}\t{3 * i * i}\n" for i in range(40)),
        "".join(f"{x} {y} {x + y}\n" for x, y in np.random.default_rng(0).random((40, 2))),
        "0 1 2 3 4 5 6 7 8 9\n5 3 2 6 4 8 6 1 2 3\n",
        "".join(f"{400 + i} {i % 3} {i % 5} {i % 7} {i % 11}\n" for i in range(40)),
    ],
)
def test_lists_are_no_map(refused, text):
    assert "no map" in refused("table.csv", text, **SIZES)


@pytest.mark.parametrize(
    "text",
    [
        "0,1,2,3\n" + rows_of(NM, ","),
        "y,0,1,2,3\n" + "".join(f"{50 * i},{rows_of([row], ',')}" for i, row in enumerate(NM)),
        ",0,1,2,3\n" + "".join(f"{i},{rows_of([row], ',')}" for i, row in enumerate(NM)),
        "\t0.0\t0.5\t1.0\t1.5\n" + "".join(f"{0.5 * i}\t{rows_of([row])}" for i, row in enumerate(NM)),
        "".join(f"{i} {rows_of([row], ' ')}" for i, row in enumerate(NM)),
    ],
)
def test_rows_and_columns_of_coordinates_are_no_heights(read, text):
    field = read("scan.csv", text, **SIZES)
    same(field)
    assert any("coordinates" in note for note in field.metadata["notes"])


@pytest.mark.parametrize("make", [lambda x, y: 4 * y + x, lambda x, y: x, lambda x, y: y, lambda x, y: 10 * x + 3 * y])
def test_ramps_are_heights(read, make):
    y, x = np.mgrid[0:12, 0:10]
    field = read("ramp.txt", rows_of(make(x, y), " "), size_m=(1e-6, 1e-6), height_m=1e-7)
    assert field.shape == (12, 10)


def test_wyko_text(read):
    columns = rows_of(NM[::-1].T).replace("100.0", "Bad")
    head = "Wyko ASCII Data File Format 0\t{}\t1\nX Size\t4\nY Size\t3\nBlock Name\tType\tLength\tValue\n"
    keys = "Wavelength\t7\t4\t500\nMult\t7\t4\t4\nAspect\t7\t4\t2\nPixel_size\t7\t4\t0.0005\nRAW_DATA\t3\t48\t\n"
    same(read("scan.asc", head.format(1) + keys + columns), [(1, 1)], (2, 3))
    same(read("scan.asc", head.format(0) + keys + columns), [(1, 1)], (2, 3), heights=125 * BOTTOM_FIRST)


# --- Pictures --------------------------------------------------------------------------------------------------------

FINE = np.random.default_rng(2).permutation(65536)[: 20 * 30].reshape(20, 30).astype("u2")


@pytest.mark.parametrize("count", [1, 2, 3, 4])
@pytest.mark.parametrize("filters", [(0,), (1,), (2,), (3,), (4,), (4, 0, 3, 1, 2)])
def test_16_bits_stay_16_bits(read, count, filters):
    samples = np.repeat(FINE[..., None], count, axis=2)
    if count in (2, 4):
        samples[..., -1] = 65535
    field = read("scan.png", odd_scans.png(samples, filters), size_m=(3e-6, 2e-6), height_m=65535e-9)
    np.testing.assert_allclose(field.heights, FINE[::-1] * 1e-9, rtol=1e-12)


def test_transparent_points_are_missing(read):
    samples = np.dstack([FINE, np.full_like(FINE, 65535)])
    samples[3, 4, 1] = 0
    field = read("scan.png", odd_scans.png(samples), size_m=(3e-6, 2e-6), height_m=1e-6)
    assert np.argwhere(field.missing).tolist() == [[16, 4]]


def test_a_coloured_picture_of_16_bits_is_refused(refused):
    samples = np.dstack([FINE, FINE[::-1], FINE])
    assert "coloured" in refused("scan.png", odd_scans.png(samples), size_m=(3e-6, 2e-6), height_m=1e-6)


def test_pages_are_channels(read, tmp_path):
    import tifffile

    file = io.BytesIO()
    tifffile.imwrite(file, np.stack([FINE // 2, FINE]), photometric="minisblack")
    options = {"size_m": (3e-6, 2e-6), "height_m": 65535e-9}
    first = read("scan.tif", file.getvalue(), **options)
    np.testing.assert_allclose(first.heights, FINE[::-1] // 2 * 1e-9, rtol=1e-12)
    assert first.metadata["notes"] == ["channel Page 1 was chosen of 2"]
    np.testing.assert_allclose(
        read("scan.tif", file.getvalue(), channel="Page 2", **options).heights, FINE[::-1] * 1e-9
    )
    assert channel_names(tmp_path / "scan.tif") == ["Page 1", "Page 2"]


def test_tiff_in_colour_of_16_bits(read):
    import tifffile

    for options in ({}, {"planarconfig": "separate"}):
        file, planes = io.BytesIO(), np.dstack([FINE] * 3)
        tifffile.imwrite(file, planes if not options else np.moveaxis(planes, -1, 0), photometric="rgb", **options)
        field = read("scan.tif", file.getvalue(), size_m=(3e-6, 2e-6), height_m=65535e-9)
        np.testing.assert_allclose(field.heights, FINE[::-1] * 1e-9, rtol=1e-9)


# --- Units that are not there ----------------------------------------------------------------------------------------


def test_a_wave_without_units_asks_for_its_size(read, refused):
    assert "4 m x 3 m" in refused("scan.ibw", odd_scans.igor_without_units(1.0))
    assert read("scan.ibw", odd_scans.igor_without_units(1.0), size_m=(4e-6, 3e-6)).size_m == pytest.approx(
        (4e-6, 3e-6)
    )
    assert read("scan.ibw", odd_scans.igor_without_units(1.0), trust_units=True).size_m == pytest.approx((4, 3))
    field = read("scan.ibw", odd_scans.igor_without_units(1e-6))
    assert field.size_m == pytest.approx((4e-6, 3e-6)) and "metres" in field.metadata["notes"][0]


def gsf(size, unit="m", factor=1e-9):
    head = f"Gwyddion Simple Field 1.0\nXRes = 4\nYRes = 3\nXReal = {size}\nYReal = {size}\nZUnits = {unit}\n".encode()
    return head + b"\0" * (4 - len(head) % 4) + (NM * factor).astype("<f4").tobytes()


def test_sides_and_heights_that_no_microscope_scans(read, refused):
    assert "4 m x 4 m" in refused("scan.gsf", gsf(4))
    assert "11 mm x 11 mm" in refused("scan.gsf", gsf(0.011))
    assert read("scan.gsf", gsf(0.009)).size_m == pytest.approx((0.009, 0.009))
    assert "385 m" in refused("scan.gsf", gsf(4e-6, factor=1))
    assert "--height-nm" in refused("scan.gsf", gsf(4e-6, factor=1))
    assert np.ptp(read("scan.gsf", gsf(4e-6, factor=1), height_m=1e-6).heights) == pytest.approx(1e-6)
    assert np.ptp(read("scan.gsf", gsf(4e-6, factor=1), trust_units=True).heights) == pytest.approx(385)
    assert "--height-nm" in refused("scan.gsf", gsf(4, factor=1), size_m=(1e-6, 1e-6))
    refused("huge.txt", "# Width: 2 um\n# Height: 2 um\n# Value units: m\n1e200 2\n3 4\n", trust_units=True)


def test_what_the_project_stored_is_not_asked_about_again(tmp_path, read):
    from precompute.scan.gsf import write_gsf

    field = read("scan.gsf", gsf(4), trust_units=True)
    assert read_scan(write_gsf(field, tmp_path / "stored.gsf")).size_m == pytest.approx((4, 4))


# --- Refused, and should open ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit", ["µm".encode(), "µm".encode("latin-1"), b"\xe6m", b"um"])
def test_digital_surf_units(read, unit):
    same(read("scan.sur", odd_scans.sur(unit)), size_um=(2, 1.5), heights=np.float32(1e-3) * NM[::-1] * 1e-6)


@pytest.mark.parametrize("streams", [1, 3])
@pytest.mark.parametrize("name", ["scan.sur", "scan.pro"])
def test_digital_surf_compressed(read, streams, name):
    field = read(name, odd_scans.sur(b"um", packed=streams, missing=True))
    same(field, [(2, 2)], (2, 1.5), heights=np.float32(1e-3) * NM[::-1] * 1e-6)


@pytest.mark.parametrize("packed", [0, 1])
def test_digital_surf_layers(read, packed):
    data = odd_scans.sur(b"um", packed=packed, objects=3)
    assert read("scan.sur", data).metadata["channels"] == [f"Z layer {i} [um]" for i in range(3)]
    third = read("scan.sur", data, channel="Z layer 2")
    np.testing.assert_allclose(third.heights, BOTTOM_FIRST + 2e-6, rtol=1e-6)


EXPORTS = {
    "German": ("Kanal", "Breite", "Höhe", "Einheiten"),
    "French": ("Canal ", "Largeur ", "Hauteur ", "Unités "),
    "Czech": ("Kanál", "Šířka", "Výška", "Jednotky hodnot"),
    "Spanish": ("Canal", "Anchura", "Altura", "Unidades de valor"),
    "English": ("Channel", "Width", "Height", "Value units"),
}


@pytest.mark.parametrize("language", EXPORTS)
@pytest.mark.parametrize("comma", [False, True])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le"])
def test_gwyddion_exports_in_languages(read, language, comma, encoding):
    keys = EXPORTS[language]
    text = f"# {keys[0]}: Topo\n# {keys[1]}: 2.000 µm\n# {keys[2]}: 1.500 µm\n# {keys[3]}: nm\n" + rows_of(NM)
    field = read("scan.txt", (text.replace(".", ",") if comma else text).encode(encoding))
    same(field, size_um=(2, 1.5))
    assert field.metadata["channel"] == "Topo"


def test_spip_text(read):
    text = (
        "# File Format = ASCII\n# x-pixels = 4\n# y-pixels = 3\n# x-length = 2000\n# y-length = 1500\n# z-unit = nm\n"
    )
    same(read("scan.asc", text + "# Start of Data:\n" + rows_of(NM)), size_um=(2, 1.5))
    wrapped = "\n".join(str(v) for v in NM.ravel())  # a number a line: the counts say how many make a row
    assert read("scan.asc", text.replace("nm", "um") + rows_of(NM)).heights.max() == pytest.approx(385e-6)
    same(read("scan.asc", text + wrapped.replace("\n", " \n")), size_um=(2, 1.5))


@pytest.mark.parametrize("quote", ['"', "'"])
def test_quoted_numbers(read, quote):
    same(read("scan.csv", rows_of(NM, ",", lambda v: f"{quote}{v}{quote}"), **SIZES))


def test_quoted_decimal_commas(read):
    same(read("scan.csv", rows_of(NM, ",", lambda v: f'"{v}"'.replace(".", ",")), **SIZES))


def test_exports_of_several_channels(read):
    head = "# Channel: {}\n# Width: 2 um\n# Height: 1.5 um\n# Value units: {}\n"
    text = head.format("Phase", "deg") + rows_of(NM) + "\n" + head.format("Topo", "nm") + rows_of(NM)
    field = read("scan.txt", text)
    same(field, size_um=(2, 1.5))
    assert field.metadata["channels"] == ["Phase [deg]", "Topo [nm]"]


def test_floats_with_predictor_3_name_what_is_missing(refused):
    """A TIFF of one strip, deflated, whose bytes were predicted (Adobe's technical note 3)."""
    from importlib.util import find_spec

    if find_spec("imagecodecs") is not None:
        pytest.skip("imagecodecs is installed, so such a file is read")
    strip = zlib.compress(bytes(4 * 12))
    entries = [(256, 4), (257, 3), (258, 32), (259, 8), (262, 1), (273, 8), (277, 1), (278, 3)]
    entries += [(279, len(strip)), (317, 3), (339, 3)]
    table = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", tag, 4, 1, value) for tag, value in entries)
    data = struct.pack("<2sHI", b"II", 42, 8 + len(strip)) + strip + table + struct.pack("<I", 0)
    assert "imagecodecs" in refused("scan.tif", data, **SIZES)
