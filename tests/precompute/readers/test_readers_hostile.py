# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged and malicious files: a scan or one sentence, within bounded time and memory."""

import io
import os
import struct
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from precompute.errors import DiffractionError
from precompute.readers import read_scan
from tests.support import scan_files
from tests.support.peak_memory import PeakMemory

HEIGHTS = np.linspace(0.3e-6, 0.7e-6, 30).reshape(5, 6)
SIZE = (6e-6, 10e-6)


def outcome(path, **options):
    """``read`` or the sentence of the refusal."""
    try:
        field = read_scan(path, **options)
    except DiffractionError as error:
        return str(error)
    assert np.isfinite(field.valid).all()
    return "read"


def image(kind):
    """A small picture of a format."""
    values, file = np.random.default_rng(0).random((9, 7)).astype(np.float32), io.BytesIO()
    if kind == ".exr":
        import OpenEXR

        with tempfile.TemporaryDirectory() as folder:
            header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
            with OpenEXR.File(header, {"Y": values}) as exr:
                exr.write(os.path.join(folder, "a.exr"))
            return Path(folder, "a.exr").read_bytes()
    if kind == ".tif":
        import tifffile

        tifffile.imwrite(file, (values * 65535).astype(np.uint16), compression="zlib")
    else:
        from PIL import Image

        Image.fromarray((values * 255).astype(np.uint8)).save(file, {".jpg": "jpeg"}.get(kind, kind[1:]))
    return file.getvalue()


def mutated(good, rng):
    data = bytearray(good)
    kind = rng.integers(0, 4)
    if kind == 0:
        return bytes(data[: rng.integers(1, len(data))])
    if kind == 1:  # extreme values where counts and sizes stand
        position = int(rng.integers(0, max(1, len(data) - 4)))
        extreme = rng.choice([0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**16 - 1])
        data[position : position + 4] = struct.pack("<I", int(extreme))
        return bytes(data)
    if kind == 2:  # digits in text headers
        digits = [i for i, byte in enumerate(data[:3000]) if 48 <= byte <= 57]
        for position in rng.choice(digits, min(3, len(digits))) if digits else []:
            data[position] = int(rng.choice(list(b"0123456789-.eE")))
        return bytes(data)
    for position in rng.integers(0, len(data), rng.integers(1, 8)):
        data[position] = rng.integers(0, 256)
    return bytes(data)


@pytest.mark.parametrize("name", scan_files.WRITERS)
@pytest.mark.parametrize("count", [60, pytest.param(10000, marks=pytest.mark.thorough)])
def test_mutated_files(tmp_path, name, count):
    writer, extension, _ = scan_files.WRITERS[name]
    good, path, rng = writer(HEIGHTS, SIZE), tmp_path / f"scan{extension}", np.random.default_rng(1)
    outcomes, slowest = set(), 0.0
    for _ in range(count):
        path.write_bytes(mutated(good, rng))
        start = time.perf_counter()
        outcomes.add(outcome(path))
        slowest = max(slowest, time.perf_counter() - start)
    assert outcomes - {"read"}
    assert not any("\n" in sentence for sentence in outcomes)
    assert slowest < 5.0  # a hang, not a speed


@pytest.mark.parametrize("extension", [".png", ".tif", ".exr", ".jpg", ".bmp"])
@pytest.mark.parametrize("count", [60, pytest.param(10000, marks=pytest.mark.thorough)])
def test_mutated_images(tmp_path, extension, count):
    good, path, rng = image(extension), tmp_path / f"scan{extension}", np.random.default_rng(2)
    outcomes, slowest = set(), 0.0
    with PeakMemory() as memory:
        for _ in range(count):
            path.write_bytes(mutated(good, rng))
            start = time.perf_counter()
            outcomes.add(outcome(path, size_m=SIZE, height_m=1e-6))
            slowest = max(slowest, time.perf_counter() - start)
    assert outcomes - {"read"}
    assert not any("\n" in sentence for sentence in outcomes)
    assert slowest < 5.0
    assert memory.grown < 1 << 30


@pytest.mark.parametrize(("tag", "value"), [(277, 55041), (279, 2**32 - 1), (278, 2**31), (257, 2**30)])
def test_tiff_counts_are_refused_before_allocation(tmp_path, tag, value):
    """Samples a pixel, bytes of a strip, rows of a strip, rows: all far beyond the file."""
    data = bytearray(image(".tif"))
    (directory,) = struct.unpack_from("<I", data, 4)
    for at in range(directory + 2, directory + 2 + 12 * struct.unpack_from("<H", data, directory)[0], 12):
        if struct.unpack_from("<H", data, at)[0] == tag:
            struct.pack_into("<HI", data, at + 2, 4, 1)
            struct.pack_into("<I", data, at + 8, value)
    path = tmp_path / "scan.tif"
    path.write_bytes(bytes(data))
    with PeakMemory() as memory:
        outcome(path, size_m=SIZE, height_m=1e-6)
    assert memory.grown < 100 << 20


def test_libraries_keep_their_remarks_to_themselves(tmp_path, capfd):
    data = bytearray(image(".tif"))
    rng = np.random.default_rng(5)
    for _ in range(100):
        (tmp_path / "scan.tif").write_bytes(mutated(bytes(data), rng))
        outcome(tmp_path / "scan.tif", size_m=SIZE, height_m=1e-6)
    assert capfd.readouterr() == ("", "")


def huge(name):
    """A file that declares a gigantic image."""
    good = scan_files.WRITERS[name][0](HEIGHTS, SIZE)
    return {
        "nanoscope": lambda: good.replace(b"Samps/line: 6", b"Samps/line: 600000000"),
        "nanosurf": lambda: good.replace(b"Points=6", b"Points=600000000"),
        "wsxm": lambda: good.replace(b"columns: 6", b"columns: 600000000"),
        "nanonis": lambda: good.replace(b"       6       5", b"       6000000 5000000"),
        "igor": lambda: good.replace(struct.pack("<ii", 6, 5), struct.pack("<ii", 2**31 - 1, 2**31 - 1), 1),
        "sdf": lambda: good.replace(struct.pack("<HH", 6, 5), struct.pack("<HH", 65535, 65535), 1),
        "plu": lambda: good[:500] + struct.pack("<II", 2**31, 2**31) + good[508:],
        "gwy": lambda: good.replace(struct.pack("<i", 6), struct.pack("<i", 2**31 - 1), 1),
    }[name]()


@pytest.mark.parametrize("name", ["nanoscope", "nanosurf", "wsxm", "nanonis", "igor", "sdf", "plu", "gwy"])
def test_declared_sizes_are_refused_before_allocation(tmp_path, name):
    path = tmp_path / f"scan{scan_files.WRITERS[name][1]}"
    path.write_bytes(huge(name))
    with PeakMemory() as memory:
        assert outcome(path) != "read"
    assert memory.grown < 100 << 20


def archive(members):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name, data in members.items():
            zipped.writestr(name, data)
    return file.getvalue()


def test_entity_bombs_are_refused(tmp_path):
    entities = "".join(f'<!ENTITY e{i} "{f"&e{i - 1};" * 10}">' for i in range(1, 12))
    bomb = f'<?xml version="1.0"?><!DOCTYPE b [<!ENTITY e0 "ha">{entities}]><b>&e11;</b>'
    (tmp_path / "scan.x3p").write_bytes(archive({"main.xml": bomb}))
    assert "entities" in outcome(tmp_path / "scan.x3p")


def test_external_entities_are_refused(tmp_path):
    xml = '<!DOCTYPE b [<!ENTITY e SYSTEM "file:///etc/passwd">]>' + scan_files.X3P_XML
    (tmp_path / "scan.x3p").write_bytes(scan_files.x3p(HEIGHTS, SIZE, xml=xml))
    assert "entities" in outcome(tmp_path / "scan.x3p")


def test_zip_bombs_are_refused(tmp_path):
    bomb = archive({"main.xml": b" " * (64 << 20)})
    assert len(bomb) < 1 << 20
    (tmp_path / "scan.x3p").write_bytes(bomb)
    assert "more than fit" in outcome(tmp_path / "scan.x3p")


def test_a_lying_zip_directory_unpacks_no_more_than_fits(tmp_path):
    """The directory says 100 bytes for a member of 64 MB: nothing beyond the bound is unpacked."""
    bomb = bytearray(archive({"main.xml": b" " * (64 << 20)}))
    size = struct.pack("<I", 64 << 20)
    while (at := bomb.find(size)) >= 0:
        bomb[at : at + 4] = struct.pack("<I", 100)
    (tmp_path / "scan.x3p").write_bytes(bytes(bomb))
    with PeakMemory() as memory:
        assert outcome(tmp_path / "scan.x3p") != "read"
    assert memory.grown < 40 << 20


def test_paths_inside_an_archive_cannot_leave_it(tmp_path):
    secret = tmp_path / "secret.bin"
    secret.write_bytes(HEIGHTS[::-1].astype("<f8").tobytes())
    (tmp_path / "inside").mkdir()
    xml = scan_files.X3P_XML.replace("bindata/data.bin", "../secret.bin")
    (tmp_path / "inside" / "scan.x3p").write_bytes(scan_files.x3p(HEIGHTS, SIZE, xml=xml))
    assert "lacks '../secret.bin'" in outcome(tmp_path / "inside" / "scan.x3p")


def test_changed_points_do_not_match_their_checksum(tmp_path):
    good = scan_files.x3p(HEIGHTS, SIZE)
    with zipfile.ZipFile(io.BytesIO(good)) as zipped:
        xml = zipped.read("main.xml")
    other = archive({"main.xml": xml, "bindata/data.bin": bytes(8 * HEIGHTS.size)})
    (tmp_path / "scan.x3p").write_bytes(other)
    assert "checksum" in outcome(tmp_path / "scan.x3p")


def test_a_zip_that_is_no_scan(tmp_path):
    (tmp_path / "scan.zip").write_bytes(archive({"a.txt": "b"}))
    assert "format is not known" in outcome(tmp_path / "scan.zip")


def test_a_scan_that_changes_while_it_is_read_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "scan.gsf"
    path.write_bytes(scan_files.gsf(HEIGHTS, SIZE))
    import precompute.readers as readers

    original = readers.find_format

    def slow(found):
        result = original(found)
        path.write_bytes(scan_files.gsf(2 * HEIGHTS, SIZE) + b"more")
        return result

    monkeypatch.setattr(readers, "find_format", slow)
    assert "changed while it was read" in outcome(path)
