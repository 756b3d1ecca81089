# SPDX-License-Identifier: GPL-3.0-or-later
"""Instrument formats: size, unit, channel, orientation and missing points.

Self-made files of each format pin everything; the real scans are compared with numbers that
SurfaceTopography 1.27 gives for them (transposed, first row at the bottom).
"""

import hashlib

import numpy as np
import pytest

from precompute.errors import ScanError
from precompute.readers import channel_names, read_scan
from tests.support import scan_files

#: Heights without any symmetry, so that every flip and transposition shows; bottom row first.
HEIGHTS = np.linspace(0.3e-6, 0.7e-6, 30).reshape(5, 6) + 20e-9 * np.sin(np.arange(30.0) ** 2).reshape(5, 6)
SIZE = (6e-6, 10e-6)
MISSING = np.zeros((5, 6), bool)
MISSING[0, 4] = MISSING[3, 1] = True


def write(tmp_path, name, data):
    (tmp_path / name).write_bytes(data)
    return tmp_path / name


@pytest.mark.parametrize("name", scan_files.WRITERS)
def test_heights_size_and_orientation(tmp_path, name):
    writer, extension, rounding = scan_files.WRITERS[name]
    field = read_scan(write(tmp_path, "scan" + extension, writer(HEIGHTS, SIZE)))
    np.testing.assert_allclose(field.heights, HEIGHTS, atol=rounding)
    assert field.size_m == pytest.approx(SIZE, rel=1e-6)
    assert field.metadata["format"] == name
    assert not field.missing.any()


@pytest.mark.parametrize("name", ["sur", "opd", "plu", "nanonis", "x3p", "sdf_ascii"])
def test_missing_points_are_marked(tmp_path, name):
    writer = getattr(scan_files, name)
    field = read_scan(
        write(tmp_path, f"scan.{name.split('_')[0].replace('nanonis', 'sxm')}", writer(HEIGHTS, SIZE, missing=MISSING))
    )
    np.testing.assert_array_equal(field.missing, MISSING)
    np.testing.assert_allclose(field.valid, HEIGHTS[~MISSING], atol=0.06e-9)


def test_variants(tmp_path):
    for data, extension in (
        (scan_files.nanoscope(HEIGHTS, SIZE, bits=32), ".001"),
        (scan_files.igor(HEIGHTS, SIZE, order=">"), ".ibw"),
        (scan_files.x3p(HEIGHTS, SIZE, kind="L"), ".x3p"),
        (scan_files.sdf_ascii(HEIGHTS, SIZE), ".sdf"),
        (scan_files.jpk(HEIGHTS, SIZE, reflect=1), ".jpk"),
        (scan_files.nanonis(HEIGHTS, SIZE, downwards=True), ".sxm"),
    ):
        field = read_scan(write(tmp_path, "scan" + extension, data))
        np.testing.assert_allclose(field.heights, HEIGHTS, atol=0.51e-9)
        assert field.size_m == pytest.approx(SIZE, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "offered", "chosen"),
    [
        ("nanoscope", ["Amplitude Error [mV]", "Height [nm]"], "Height"),
        ("nanosurf", ["Deflection (Scan forward) [V]", "Z-Axis (Scan forward) [m]"], "Z-Axis (Scan forward)"),
        ("igor", ["PhaseRetrace [deg]", "HeightRetrace [m]"], "HeightRetrace"),
        (
            "nanonis",
            ["Current (forward) [A]", "Current (backward) [A]", "Z (forward) [m]", "Z (backward) [m]"],
            "Z (forward)",
        ),
    ],
)
def test_the_height_channel_is_chosen_and_the_others_offered(tmp_path, name, offered, chosen):
    writer, extension, _ = scan_files.WRITERS[name]
    path = write(tmp_path, "scan" + extension, writer(HEIGHTS, SIZE))
    assert channel_names(path) == offered
    assert read_scan(path).metadata["channel"] == chosen
    with pytest.raises(ScanError, match="not a height"):
        read_scan(path, channel=offered[0])


def test_backward_channels_are_turned_round(tmp_path):
    path = write(tmp_path, "scan.sxm", scan_files.nanonis(HEIGHTS, SIZE))
    np.testing.assert_allclose(read_scan(path, channel="Z (backward)").heights, 2 * HEIGHTS, rtol=1e-6)


def test_a_stopped_nanoscope_scan_keeps_its_pixel_size(tmp_path):
    data = scan_files.nanoscope(HEIGHTS, SIZE).replace(b"Number of lines: 5", b"Number of lines: 8")
    field = read_scan(write(tmp_path, "scan.spm", data))
    np.testing.assert_allclose(field.heights, HEIGHTS, atol=0.07e-9)
    assert field.size_m == pytest.approx((6e-6, 10e-6 * 5 / 8))


def test_provenance_is_kept(tmp_path):
    data = scan_files.igor(HEIGHTS, SIZE)
    field = read_scan(write(tmp_path, "scan.ibw", data))
    assert field.metadata["sha256"] == hashlib.sha256(data).hexdigest()
    assert field.metadata["instrument"] == "Asylum Research Cypher"
    assert field.metadata["date"] == "2019-10-24 12:14:13 PM"


#: File: shape, size in um, range in nm, missing points, channel, and in nm how much higher than the bottom left
#: corner (the mean of 20 rows and 30 columns) the top left and the bottom right corner are.
REAL = {
    "asylum.ibw": ((256, 256), (20.0784313725, 20.0784313725), 373.390406594, 0, "HeightTrace", (-21.3183, -263.258)),
    "hexagonal_bumps_15um.002": ((256, 256), (15.0, 15.0), 704.791960520, 0, "Height", (-19.7553, 313.440)),
    "nanoscope.di": ((256, 256), (10.0, 10.0), 1210.13061632, 0, "Height Sensor", (491.211, -586.333)),
    "nanosurf.nid": ((256, 256), (20.0, 20.0), 1370.13441999, 0, "Z-AxisSensor (Scan forward)", (396.692, -833.945)),
    "park_1um.tiff": ((512, 512), (1.0, 1.0), 36.6903658823, 0, "Z Height", (1.16768, 0.424165)),
    "wsxm.stp": ((256, 256), (0.6, 0.6), 13.7008070332, 0, "Topography", (0.456925, 5.78670)),
    "areal.x3p": ((650, 650), (82.9767313943, 204.478373793), 554.3362, 0, "Height", (-88.7730, -48.5649)),
    "missing_points.sur": ((484, 563), (1961.4921233, 1686.2561060), 1476.00001725, 117, "Z", (21.8387, -1.13513)),
}


@pytest.mark.parametrize("name", REAL)
def test_real_scans(scan_dir, name):
    if not (scan_dir / name).is_file():
        pytest.skip(f"{name} is not in {scan_dir}")
    shape, size_um, range_nm, missing, channel, corners_nm = REAL[name]
    field = read_scan(scan_dir / name)
    assert field.shape == shape
    assert field.size_m == pytest.approx((size_um[0] * 1e-6, size_um[1] * 1e-6), rel=1e-8)
    assert np.ptp(field.valid) == pytest.approx(range_nm * 1e-9, rel=1e-6)
    assert int(field.missing.sum()) == missing
    assert field.metadata["channel"] == channel
    origin = np.nanmean(field.heights[:20, :30])
    corners = np.nanmean(field.heights[-20:, :30]) - origin, np.nanmean(field.heights[:20, -30:]) - origin
    assert corners == pytest.approx(tuple(c * 1e-9 for c in corners_nm), rel=1e-4)


def test_the_bumps_have_the_lattice_of_the_array(scan_dir):
    """Lattice planes 0.521 to 0.529 um apart, six of them around."""
    path = scan_dir / "hexagonal_bumps_15um.002"
    if not path.is_file():
        pytest.skip(f"{path.name} is not in {scan_dir}")
    field = read_scan(path)
    heights = field.heights - field.heights.mean()
    power = np.abs(np.fft.fft2(heights * np.outer(np.hanning(256), np.hanning(256)))) ** 2
    fx, fy = np.fft.fftfreq(256, field.dx)[None, :], np.fft.fftfreq(256, field.dy)[:, None]
    power[np.hypot(fx, fy) < 1 / 1e-6] = 0
    row, col = np.unravel_index(np.argmax(power), power.shape)
    assert 1 / np.hypot(fx[0, col], fy[row, 0]) == pytest.approx(0.525e-6, rel=0.02)


def test_every_file_of_the_folder_opens_or_is_refused_in_a_sentence(scan_dir):
    refused = []
    for path in sorted(path for path in scan_dir.iterdir() if path.is_file()):
        options = {"size_m": (65e-6, 65e-6), "height_m": 818.69e-9} if path.suffix == ".png" else {}
        try:
            assert read_scan(path, **options).size_m[0] > 0
        except ScanError as error:
            refused.append((path.name, str(error)))
    # The text export's heights are metres: a synthetic ramp that no instrument measures.
    always = {"corrupted.di", "matrix.txt", "gwyddion_export.txt"}
    assert always <= {name for name, _ in refused} <= always | {"SOURCES.md"}
    assert all(sentence.endswith(".") and "\n" not in sentence for _, sentence in refused)
