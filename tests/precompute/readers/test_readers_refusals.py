# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad input ends in one clear sentence, never in a traceback of a library or a silent wrong scan."""

import numpy as np
import pytest

from precompute.errors import DiffractionError, ScanError, SizeLimitError
from precompute.readers import read_scan

GSF = "Gwyddion Simple Field 1.0\nXRes = {cols}\nYRes = {rows}\nXReal = {x}\nYReal = {y}\n{units}"


def gsf(path, values=None, cols=3, rows=2, x="3e-6", y="2e-6", units="ZUnits = m\n"):
    header = GSF.format(cols=cols, rows=rows, x=x, y=y, units=units).encode()
    header += b"\0" * (4 - len(header) % 4)
    values = np.arange(6.0).reshape(2, 3) if values is None else np.asarray(values)
    path.write_bytes(header + values.astype("<f4").tobytes())
    return path


def refused(path, words, kind=ScanError, **options):
    with pytest.raises(kind) as caught:
        read_scan(path, **options)
    sentence = str(caught.value)
    assert words in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence
    assert len(sentence) < 500


def test_missing_file(tmp_path):
    refused(tmp_path / "none.gsf", "There is no file")


def test_folder(tmp_path):
    refused(tmp_path, "is a folder")


def test_name_with_a_zero_byte(tmp_path):
    refused(str(tmp_path / "a\0b"), "a")


def test_empty_file(tmp_path):
    (tmp_path / "empty.gsf").write_bytes(b"")
    refused(tmp_path / "empty.gsf", "is empty")


@pytest.mark.parametrize("name", ["scan.blend", "scan", "scan.mnt", "scan.pkl"])
def test_unknown_format(tmp_path, name):
    (tmp_path / name).write_bytes(b"something else")
    refused(tmp_path / name, "format is not known; supported are")
    refused(tmp_path / name, "open the file in Gwyddion and export it as .gsf")


@pytest.mark.parametrize("name", ["scan.gsf", "scan.png", "scan.exr", "scan.gwy", "scan.tif"])
def test_content_that_is_not_what_the_name_says(tmp_path, name):
    (tmp_path / name).write_bytes(b"not at all")
    refused(tmp_path / name, "the content does not")


def test_one_pixel(tmp_path):
    refused(gsf(tmp_path / "s.gsf", [[1.0]], cols=1, rows=1), "1 x 1 pixels")
    (tmp_path / "s.txt").write_text("5\n")
    refused(tmp_path / "s.txt", "1 x 1 pixels", size_m=(1e-6, 1e-6), height_m=1e-9)


def test_one_column_of_numbers_is_no_matrix(tmp_path):
    (tmp_path / "s.txt").write_text("\n".join(str(i) for i in range(16)))
    refused(tmp_path / "s.txt", "16 x 1 pixels", size_m=(1e-6, 1e-6), height_m=1e-9)


def test_infinite_heights(tmp_path):
    refused(gsf(tmp_path / "s.gsf", [[0, 1, np.inf], [0, 1, 2]]), "infinite")


def test_nothing_but_missing_points(tmp_path):
    refused(gsf(tmp_path / "s.gsf", np.full((2, 3), np.nan)), "no valid height")


@pytest.mark.parametrize("value", ["inf", "-inf"])
def test_text_with_inf(tmp_path, value):
    (tmp_path / "s.txt").write_text(f"# Width: 1 um\n# Height: 1 um\n# Value units: nm\n1 2\n3 {value}\n")
    refused(tmp_path / "s.txt", "inf in row 2, column 2")


def test_heights_without_units(tmp_path):
    refused(gsf(tmp_path / "s.gsf", units=""), "carry no unit; give the height range")
    (tmp_path / "s.txt").write_text("1 2\n3 4\n")
    refused(tmp_path / "s.txt", "carry no unit; give the height range", size_m=(1e-6, 1e-6))


def test_heights_in_another_unit(tmp_path):
    refused(gsf(tmp_path / "s.gsf", units="ZUnits = V\nTitle = Friction\n"), "Friction [V]")
    refused(gsf(tmp_path / "s.gsf", units="ZUnits = V\nTitle = Friction\n"), "not a height", channel="Friction")


def test_no_size(tmp_path):
    (tmp_path / "s.txt").write_text("# Value units: nm\n1 2\n3 4\n")
    refused(tmp_path / "s.txt", "carries no size")


@pytest.mark.parametrize("x", ["0", "-3e-6", "nan", "inf"])
def test_file_with_a_size_that_makes_no_sense(tmp_path, x):
    refused(gsf(tmp_path / "s.gsf", x=x), "The file gives the size")


@pytest.mark.parametrize("size", [(0.0, 1e-6), (1e-6, -1e-6), (np.nan, 1e-6), (np.inf, 1e-6)])
def test_user_size_that_makes_no_sense(tmp_path, size):
    refused(gsf(tmp_path / "s.gsf"), "two positive side lengths", size_m=size)


@pytest.mark.parametrize("height", [0.0, -1e-9, np.nan, np.inf])
def test_user_height_that_makes_no_sense(tmp_path, height):
    refused(gsf(tmp_path / "s.gsf"), "positive height", height_m=height)


@pytest.mark.parametrize("options", [{}, {"size_m": (1e-6, 1e-6)}, {"height_m": 1e-6}])
def test_an_image_needs_size_and_height(tmp_path, options):
    from PIL import Image

    Image.fromarray(np.zeros((4, 4), np.uint8)).save(tmp_path / "s.png")
    refused(tmp_path / "s.png", "--size-um 65 65 --height-nm 800", **options)


def test_a_coloured_image_tells_no_heights(tmp_path):
    from PIL import Image

    Image.fromarray(np.array([[[255, 0, 0], [0, 255, 0]]] * 2, np.uint8)).save(tmp_path / "s.png")
    refused(tmp_path / "s.png", "coloured", size_m=(1e-6, 1e-6), height_m=1e-6)


def test_unknown_channel_lists_what_there_is(tmp_path):
    refused(gsf(tmp_path / "s.gsf", units="ZUnits = m\nTitle = Topo\n"), "choose one of: Topo [m]", channel="Phase")


def test_angles_in_text(scan_dir):
    refused(scan_dir / "matrix.txt", "[rad]")


def test_text_that_is_not_rectangular(tmp_path):
    (tmp_path / "s.txt").write_text("# Width: 1 um\n# Height: 1 um\n# Value units: nm\n1 2 3\n3 4\n")
    refused(tmp_path / "s.txt", "not rectangular")


def test_text_without_numbers(tmp_path):
    (tmp_path / "s.txt").write_text("A letter to my mother.\n")
    refused(tmp_path / "s.txt", "no matrix of numbers")


def test_truncated_gsf(tmp_path):
    path = gsf(tmp_path / "s.gsf")
    path.write_bytes(path.read_bytes()[:-3])
    refused(path, "ends early")


@pytest.mark.parametrize(("cols", "rows"), [(10**9, 10**9), (2**31, 2), (-3, 2), (0, 0)])
def test_declared_sizes_are_checked_before_allocation(tmp_path, cols, rows):
    refused(gsf(tmp_path / "s.gsf", cols=cols, rows=rows), "pixels", (ScanError, SizeLimitError))


def test_huge_declared_png(tmp_path):
    import struct
    import zlib

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", 10**6, 10**6, 16, 0, 0, 0, 0)
    (tmp_path / "s.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b""))
    refused(tmp_path / "s.png", "s.png", DiffractionError, size_m=(1e-6, 1e-6), height_m=1e-6)


@pytest.mark.parametrize("kind", ["gsf", "gwy", "png", "tif", "exr", "txt"])
def test_truncated_and_damaged_files_never_escape(tmp_path, kind):
    """Cut at many lengths and with flipped bytes: a scan or one sentence, nothing else."""
    import gsffile
    import gwyfile.objects as gwy
    import OpenEXR
    import tifffile
    from PIL import Image

    rng = np.random.default_rng(11)
    path, values = tmp_path / f"good.{kind}", rng.random((6, 5)).astype(np.float32)
    if kind == "gsf":
        gsffile.write_gsf(path, values, {"XReal": 3e-6, "YReal": 4e-6, "ZUnits": "m"})
    elif kind == "gwy":
        container = gwy.GwyContainer()
        container["/0/data"] = gwy.GwyDataField(values.astype(float), 1e-6, 1e-6, si_unit_xy="m", si_unit_z="m")
        container.tofile(str(path))
    elif kind == "png":
        Image.fromarray((values * 255).astype(np.uint8)).save(path)
    elif kind == "tif":
        tifffile.imwrite(path, values)
    elif kind == "exr":
        with OpenEXR.File(
            {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"Y": values}
        ) as file:
            file.write(str(path))
    else:
        rows = "\n".join(" ".join(f"{v:.3f}" for v in row) for row in values)
        path.write_text("# Width: 1 um\n# Height: 1 um\n# Value units: nm\n" + rows)
    good = path.read_bytes()
    bad = tmp_path / f"bad.{kind}"
    outcomes = set()
    for trial in range(120):
        data = bytearray(good)
        if trial % 2:
            data = data[: rng.integers(1, len(data))]
        else:
            for position in rng.integers(0, len(data), rng.integers(1, 6)):
                data[position] = rng.integers(0, 256)
        bad.write_bytes(bytes(data))
        try:
            field = read_scan(bad, size_m=(1e-6, 1e-6), height_m=1e-6)
            assert np.isfinite(field.valid).all()
            outcomes.add("read")
        except DiffractionError as error:
            outcomes.add(str(error))
    assert outcomes - {"read"}
    assert not any("\n" in outcome for outcome in outcomes)
