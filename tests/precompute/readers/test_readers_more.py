# SPDX-License-Identifier: GPL-3.0-or-later
"""Optical formats, NT-MDT, Keysight, numpy and HDF5: size, unit, channel, orientation, missing points, refusals."""

import io

import numpy as np
import pytest

from precompute.errors import ScanError
from precompute.readers import read_scan
from tests.support import more_scan_files, odd_scans, scan_files

#: Heights without any symmetry; bottom row first.
HEIGHTS = np.linspace(0.3e-6, 0.7e-6, 30).reshape(5, 6) + 20e-9 * np.sin(np.arange(30.0) ** 2).reshape(5, 6)
SIZE = (6e-6, 10e-6)
SQUARE = (12e-6, 10e-6)  # MetroPro knows square pixels only
MISSING = np.zeros((5, 6), bool)
MISSING[0, 4] = MISSING[3, 1] = True
ALL = {**more_scan_files.WRITERS, **more_scan_files.HDF}


@pytest.fixture
def read(tmp_path):
    def call(name, data, **options):
        path = tmp_path / name
        path.write_bytes(data)
        return read_scan(path, **options)

    return call


def written(name, **options):
    if name in more_scan_files.HDF:
        pytest.importorskip("h5py", reason="h5py is not installed: HDF5 formats are refused with its name")
    writer, extension, rounding = ALL[name]
    size = SQUARE if name == "metropro" else SIZE
    return f"scan{extension}", writer(HEIGHTS, size, **options), rounding, size


@pytest.mark.parametrize("name", ALL)
def test_heights_size_and_orientation(read, name):
    file, data, rounding, size = written(name)
    field = read(file, data)
    np.testing.assert_allclose(field.heights, HEIGHTS, atol=rounding)
    assert field.size_m == pytest.approx(size, rel=1e-6)
    assert field.metadata["format"] == name.replace("vk6", "vk")
    assert not field.missing.any()


@pytest.mark.parametrize("name", ["metropro", "plux", "al3d", "nms", "opdx", "datx", "nhf"])
def test_missing_points_are_marked(read, name):
    file, data, rounding, _ = written(name, missing=MISSING)
    field = read(file, data)
    np.testing.assert_array_equal(field.missing, MISSING)
    np.testing.assert_allclose(field.valid, HEIGHTS[~MISSING], atol=rounding)


def test_variants(read):
    for name, data in (
        ("a.vk4", more_scan_files.vk4(HEIGHTS, SIZE, bits=16)),
        ("a.dat", more_scan_files.metropro(HEIGHTS, SQUARE, inverted=1)),
        ("a.dat", more_scan_files.metropro(HEIGHTS, SQUARE, magic=b"\x88\x1b\x03\x71")),
        ("a.sm4", more_scan_files.sm4(HEIGHTS, SIZE, upwards=True)),
        ("a.sm4", more_scan_files.sm4(HEIGHTS, SIZE, leftwards=True)),
        ("a.Z_flat", more_scan_files.omicron(HEIGHTS, SIZE, (0, 0), transfer="TFF_MultiLinear1D")),
        ("a.mi", more_scan_files.mi(HEIGHTS, SIZE, bits=32)),
    ):
        np.testing.assert_allclose(read(name, data).heights, HEIGHTS, atol=0.06e-9)


JPK_CHANNELS = [
    *(f"Error Signal (trace) frame {frame} [V]" for frame in (1, 2)),
    *(f"Height (trace) frame {frame} [m]" for frame in (1, 2)),
]


@pytest.mark.parametrize(
    ("name", "offered"),
    [
        ("mi", ["Deflection [V]", "Topography [um]"]),
        ("mdt", ["DFL [V]", "Height [nm]"]),
        ("ardf", ["PhaseTrace [deg]", "HeightTrace [m]"]),
        ("sm4", ["Current (forward) [A]", "Topography (forward) [m]"]),
        ("nhf", ["Deflection (Forward) [V]", "Topography (Forward) [m]"]),
        ("h5-jpk", JPK_CHANNELS),
    ],
)
def test_channels(read, name, offered):
    file, data, *_ = written(name)
    assert read(file, data).metadata["channels"] == offered


def test_omicron_scans_both_ways_and_stopped(read):
    data = more_scan_files.omicron(HEIGHTS, SIZE)
    for number, name in enumerate(("up, forward", "up, backward", "down, forward", "down, backward")):
        field = read("a.Z_flat", data, channel=f"Z ({name})")
        np.testing.assert_allclose(field.heights, HEIGHTS + 1e-7 * number, atol=0.006e-9)
    stopped = read("a.Z_flat", more_scan_files.omicron(HEIGHTS, SIZE, (1, 0), lines=6))
    assert stopped.shape == (5, 6) and stopped.missing[3:].all() and not stopped.missing[:3].any()
    np.testing.assert_allclose(stopped.valid, HEIGHTS[:3].ravel(), atol=0.006e-9)


@pytest.mark.parametrize("order", ["C", "F"])
def test_npy(read, order):
    field = read("scan.npy", more_scan_files.npy(HEIGHTS, SIZE, order), size_m=SIZE, height_m=float(np.ptp(HEIGHTS)))
    np.testing.assert_allclose(field.heights, HEIGHTS, atol=1e-20)


@pytest.mark.parametrize("dtype", ["u2", ">i4", "<f2", "?"])
def test_npy_of_other_numbers(read, dtype):
    values, file = (np.arange(30).reshape(5, 6) % 7).astype(dtype), io.BytesIO()
    np.save(file, values)
    field = read("scan.npy", file.getvalue(), size_m=SIZE, height_m=float(np.ptp(values.astype(float))))
    np.testing.assert_allclose(field.heights, values[::-1].astype(float), atol=1e-12)


def test_npy_nan_and_planes(read):
    values = np.stack([HEIGHTS[::-1], 2 * HEIGHTS[::-1]])
    values[0, 1, 2] = np.nan
    for order in "CF":
        file = io.BytesIO()
        np.save(file, np.asarray(values, order=order))
        first = read("scan.npy", file.getvalue(), size_m=SIZE, height_m=1e-6)
        assert first.metadata["channels"] == ["Plane 1", "Plane 2"] and np.argwhere(first.missing).tolist() == [[3, 2]]
        second = read("scan.npy", file.getvalue(), size_m=SIZE, height_m=2 * float(np.ptp(HEIGHTS)), channel="Plane 2")
        np.testing.assert_allclose(second.heights, 2 * HEIGHTS, atol=1e-20)


def test_npz(read):
    field = read(
        "scan.npz", more_scan_files.npz(HEIGHTS, SIZE), size_m=SIZE, height_m=float(np.ptp(np.float32(HEIGHTS)))
    )
    np.testing.assert_allclose(field.heights, np.float32(HEIGHTS), rtol=1e-12)
    assert field.metadata["channel"] == "heights"


@pytest.mark.parametrize("save", [np.save, np.savez])
def test_pickled_arrays_are_not_opened(read, save):
    file = io.BytesIO()
    save(file, np.array([[{"a": 1}, 2], [3, 4]], dtype=object), allow_pickle=True)
    name = "scan.npy" if save is np.save else "scan.npz"
    with pytest.raises(ScanError, match=r"pickled objects|no two-dimensional array"):
        read(name, file.getvalue(), size_m=SIZE, height_m=1e-6)


def test_a_declared_array_is_refused_before_allocation(read):
    data = more_scan_files.npy(HEIGHTS, SIZE).replace(b"(5, 6), }  ", b"(500, 6), }", 1)
    with pytest.raises(ScanError, match=r"ends early|pixels"):
        read("scan.npy", data, size_m=SIZE, height_m=1e-6)


def test_without_h5py_the_refusal_names_it(read, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ScanError, match=r"needs the Python package 'h5py'.*\.gsf"):
        read("scan.nhf", b"\x89HDF\r\n\x1a\n" + bytes(100))


def test_a_sensor_in_volts_is_passed_over(read):
    """The file calls both channels metres; the sensor's span a metre."""
    names = (b"ZSensorTrace", b"HeightTrace")
    data = scan_files.igor(HEIGHTS, SIZE).replace(b"PhaseRetrace".ljust(32, b"\0"), names[0].ljust(32, b"\0"))
    data = data.replace(b"HeightRetrace".ljust(32, b"\0"), names[1].ljust(32, b"\0"))
    volts = np.linspace(0, 1, HEIGHTS.size).astype("<f8").tobytes()
    data = data[:384] + volts + data[384 + len(volts) :]
    field = read("scan.ibw", data)
    np.testing.assert_allclose(field.heights, HEIGHTS)
    assert any("ZSensorTrace was passed over: the heights span 1 m" in note for note in field.metadata["notes"])
    with pytest.raises(ScanError, match="span 1 m"):
        read("scan.ibw", data, channel="ZSensorTrace")


#: Formats whose rows are taken from the file, so that a part of a scan of any size can be read.
MAPPED = [
    ("gsf", scan_files.gsf), ("gwy", scan_files.gwy), ("spm", scan_files.nanoscope), ("nid", scan_files.nanosurf),
    ("stp", scan_files.wsxm), ("sxm", scan_files.nanonis), ("sur", scan_files.sur), ("sdf", scan_files.sdf_binary),
    ("opd", scan_files.opd), ("plu", scan_files.plu), ("ibw", scan_files.igor), ("vk4", more_scan_files.vk4),
    ("nms", more_scan_files.nms), ("mi", more_scan_files.mi), ("mdt", more_scan_files.mdt),
    ("sm4", more_scan_files.sm4),
    ("ardf", more_scan_files.ardf), ("opdx", more_scan_files.opdx), ("al3d", more_scan_files.al3d),
]  # fmt: skip


@pytest.mark.parametrize(("extension", "writer"), MAPPED)
def test_a_part_of_a_scan_too_large_to_read_whole(tmp_path, monkeypatch, extension, writer):
    import precompute.readers as readers
    from precompute.errors import SizeLimitError
    from precompute.readers.common import limits

    y, x = np.mgrid[0:40, 0:50]
    heights = 0.3e-6 + 1e-9 * ((7 * x + 13 * y) % 97) + 1e-9 * x
    path = tmp_path / f"scan.{extension}"
    path.write_bytes(writer(heights, (5e-6, 8e-6)))
    whole = read_scan(path)
    monkeypatch.setattr(limits, "LIMIT_PIXELS", 1000)
    monkeypatch.setattr(readers, "LIMIT_FILE_BYTES", path.stat().st_size - 1)
    with pytest.raises(SizeLimitError, match="--crop-um"):
        read_scan(path)
    part = read_scan(path, crop_m=(1e-6, 3e-6, 2e-6, 4e-6))
    np.testing.assert_array_equal(part.heights, whole.heights[10:20, 10:30])
    assert (part.dx, part.dy) == (whole.dx, whole.dy)
    assert part.processing[-1] == {"step": "crop", "cols": [10, 30], "rows": [10, 20]}
    with pytest.raises(SizeLimitError):
        read_scan(path, crop_m=(0, 5e-6, 0, 8e-6))


def test_a_part_of_a_picture(tmp_path, monkeypatch):
    import tifffile

    from precompute.readers.common import limits

    values = np.arange(40 * 50, dtype="u2").reshape(40, 50)
    tifffile.imwrite(tmp_path / "scan.tif", values)
    np.save(tmp_path / "scan.npy", values)
    monkeypatch.setattr(limits, "LIMIT_PIXELS", 1000)
    options = {"size_m": (5e-6, 4e-6), "crop_m": (1e-6, 3e-6, 2e-6, 3e-6)}
    field = read_scan(tmp_path / "scan.tif", height_m=65535e-9, **options)
    np.testing.assert_allclose(field.heights, values[::-1][20:30, 10:30] * 1e-9, rtol=1e-9)
    assert read_scan(tmp_path / "scan.npy", height_m=1e-6, **options).shape == (10, 20)
    tifffile.imwrite(tmp_path / "packed.tif", values, compression="zlib")
    from precompute.errors import SizeLimitError

    with pytest.raises(SizeLimitError, match="only be read whole"):
        read_scan(tmp_path / "packed.tif", height_m=1e-6, **options)


def test_the_command_line_bakes_a_part_of_a_scan_too_large(tmp_path, monkeypatch, capsys):
    import json

    from precompute.cli import main
    from precompute.readers.common import limits

    x = np.mgrid[0:60, 0:60][1]
    (tmp_path / "scan.gsf").write_bytes(scan_files.gsf(30e-9 * np.sin(x * 0.5), (4.8e-6, 4.8e-6)))
    crop = ["--crop-um", "0.8", "4", "0.8", "4"]
    common = ["--sigma-s-um", "0.4", "--detail", "0.3", "--json"]
    assert main(["bake", str(tmp_path / "scan.gsf"), "--out", str(tmp_path / "a"), *crop, *common]) == 0
    monkeypatch.setattr(limits, "LIMIT_PIXELS", 2000)
    assert main(["bake", str(tmp_path / "scan.gsf"), "--out", str(tmp_path / "c"), *common]) == 2
    assert main(["bake", str(tmp_path / "scan.gsf"), "--out", str(tmp_path / "b"), *crop, *common]) == 0
    assert (tmp_path / "a" / "scan.exr").stat().st_size == (tmp_path / "b" / "scan.exr").stat().st_size
    from precompute.table.table import SpectralTable

    a, b = (SpectralTable.load(tmp_path / name / "scan.exr") for name in "ab")
    np.testing.assert_array_equal(a.atlas, b.atlas)
    assert a.info["parameters"] == b.info["parameters"]
    capsys.readouterr()
    assert main(["info", str(tmp_path / "scan.gsf"), *crop, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["shape"] == [40, 40]


def test_notes_are_said_on_standard_error_and_in_json(tmp_path, capsys):
    import json

    from precompute.cli import main

    (tmp_path / "scan.x3p").write_bytes(scan_files.x3p(HEIGHTS, SIZE, MISSING))
    (tmp_path / "scan.spm").write_bytes(scan_files.nanoscope(HEIGHTS, SIZE))
    for name, words in (("scan.x3p", "2 missing points"), ("scan.spm", "channel Height was chosen of 2")):
        assert main(["info", str(tmp_path / name), "--json"]) == 0
        out, err = capsys.readouterr()
        assert words in " ".join(json.loads(out)["notes"]) and words in err
    x = np.mgrid[0:40, 0:40][1]
    surface = 30e-9 * np.sin(x * 0.5)
    gap = np.zeros(surface.shape, bool)
    gap[3:5, 6] = True
    (tmp_path / "wave.x3p").write_bytes(scan_files.x3p(surface, (3.2e-6, 3.2e-6), gap))
    arguments = ["bake", str(tmp_path / "wave.x3p"), "--out", str(tmp_path), "--sigma-s-um", "0.3", "--detail", "0.3"]
    assert main([*arguments, "--json"]) == 0
    out, err = capsys.readouterr()
    assert "2 missing points" in " ".join(json.loads(out)["notes"]) and "filled" in err


def test_info_into_a_pipe_that_closes(tmp_path):
    import subprocess
    import sys

    (tmp_path / "scan.spm").write_bytes(odd_scans.bruker(64, 64, ["Scan Size: 1 1 ~m", "Lines: 64"], []))
    program = f"{sys.executable} -m precompute info {tmp_path / 'scan.spm'} | true"
    done = subprocess.run(["bash", "-c", program], capture_output=True, text=True, check=False)
    assert done.stderr == ""
