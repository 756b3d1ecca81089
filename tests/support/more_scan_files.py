# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scan files of the optical formats, of NT-MDT and Keysight, of numpy and of HDF5: as in `scan_files`.

Each writer takes heights in metres, bottom row first, and sizes in metres, and shares no code with the readers.
"""

import io
import struct
import tempfile
import zipfile
import zlib
from pathlib import Path

import numpy as np

NANOMETRE = 1e-9


def vk4(heights, size, bits=32):
    """A digit of 100 pm; the conditions stand behind the table of offsets, the heights behind them."""
    rows, cols = heights.shape
    counts = np.rint(heights / 1e-10).astype(f"<u{bits // 8}")
    table = [0] * 18
    table[0], table[6] = 84, 84 + 400
    conditions = [400, 2020, 1, 2, 3, 4, 5, 0, *[0] * 92]
    conditions[42:45] = [round(size[0] / cols * 1e12), round(size[1] / rows * 1e12), 100]
    image = struct.pack("<7I", cols, rows, bits, 0, counts.nbytes, 0, 0) + bytes(768) + counts[::-1].tobytes()
    head = b"VK4_" + bytes(8) + struct.pack("<18I", *table)
    return head + struct.pack("<100I", *conditions) + image


def vk6(heights, size):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("Vk4File", vk4(heights, size))
    return b"VK6" + bytes(13) + file.getvalue()


def metropro(heights, size, missing=None, inverted=0, magic=b"\x88\x1b\x03\x6f"):
    """Wavelength 500 nm, scale 0.5, obliquity 1, fine resolution; one picture of fringes first; square pixels."""
    rows, cols = heights.shape
    step = 0.5 * 500e-9 / 32768 * (-1 if inverted else 1)
    counts = np.rint(heights / step).astype(">i4")
    if missing is not None:
        counts[missing] = 2147483640
    length = 4096 if magic[3] == 0x71 else 834
    head = bytearray(length)
    head[:4] = magic
    struct.pack_into(">HI", head, 4, 3 if length > 834 else 1, length)
    head[12:32] = b"Tue Jul 30 12:34:38 "
    struct.pack_into(">5HhI", head, 48, 0, 0, 3, 2, 1, 255, 12)
    struct.pack_into(">4HI", head, 64, 0, 0, cols, rows, counts.nbytes)
    struct.pack_into(">6f", head, 164, 0.5, 500e-9, 0, 1, 0, size[0] / cols)
    struct.pack_into(">h", head, 218, 1)
    struct.pack_into(">h", head, 232, inverted)
    return bytes(head) + bytes(12) + counts[::-1].tobytes()


def plux(heights, size, missing=None):
    rows, cols = heights.shape
    values = (heights * 1e6).astype("<f4")
    if missing is not None:
        values[missing] = np.nan
    xml = (
        f"<xml><GENERAL><DATE>2020-01-02</DATE><IMAGE_SIZE_X>{cols}</IMAGE_SIZE_X><IMAGE_SIZE_Y>{rows}</IMAGE_SIZE_Y>"
        f"<FOV_X>{1e6 * size[0] / cols}</FOV_X><FOV_Y>{1e6 * size[1] / rows}</FOV_Y></GENERAL>"
        "<LAYER_0><FILENAME_Z>LAYER_0.raw</FILENAME_Z></LAYER_0>"
        "<INFO><ITEM_0><NAME>Device</NAME><VALUE>S neox</VALUE></ITEM_0></INFO></xml>"
    )
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("index.xml", xml)
        archive.writestr("LAYER_0.raw", values[::-1].tobytes())
    return file.getvalue()


def al3d(heights, size, missing=None):
    rows, cols = heights.shape
    values = np.zeros((rows, cols + cols % 2), "<f4")
    values[:, :cols] = heights
    if missing is not None:
        values[:, :cols][missing] = 1e20
    tags = {
        "Version": 1, "TagCount": 6, "Cols": cols, "Rows": rows, "PixelSizeXMeter": repr(size[0] / cols),
        "PixelSizeYMeter": repr(size[1] / rows), "InvalidPixelValue": "1.0e+20", "DepthImageOffset": 800,
    }  # fmt: skip
    head = b"AliconaImaging\0\r\n"
    for key, value in tags.items():
        head += key.encode().ljust(20, b"\0") + str(value).encode().ljust(30, b"\0") + b"\r\n"
    return head.ljust(800, b"\0") + values[::-1].tobytes()


def nms(heights, size, missing=None):
    """0.25 to 0.8 um in 65534 steps."""
    rows, cols = heights.shape
    counts = np.rint((heights * 1e6 - 0.25) / 0.55 * 65534).astype("<u2")
    if missing is not None:
        counts[missing] = 65535
    head = bytearray(3468)
    struct.pack_into("<dd", head, 16, 0.25, 0.8)
    head[1076:1092] = b"02.01.2020 12:34"
    struct.pack_into("<IIdd", head, 1368, cols, rows, 1e3 * size[0] / cols, 1e3 * size[1] / rows)
    return bytes(head) + counts[::-1].tobytes()


def mi(heights, size, bits=16):
    """Topography over a micrometre, and a deflection channel in volts before it."""
    rows, cols = heights.shape
    full = 2.0 ** (bits - 1)
    counts = np.rint(heights / 1e-6 * full).astype(f"<i{bits // 8}")
    keys = [
        ("fileType", "Image"), ("xPixels", cols), ("yPixels", rows), ("xLength", size[0]), ("yLength", size[1]),
        ("dateAcquired", "2020-01-02"), ("bufferLabel", "Deflection"), ("bufferUnit", "V"), ("bufferRange", 10),
        ("bufferLabel", "Topography"), ("bufferUnit", "um"), ("bufferRange", 1),
        ("data", "BINARY" if bits == 16 else "BINARY_32"),
    ]  # fmt: skip
    head = "".join(f"{key:<14}{value}\n" for key, value in keys)
    return head.encode() + np.zeros_like(counts).tobytes() + counts.tobytes()


def mdt(heights, size, frames=2):
    """A spectrum, which is left out, a deflection frame and a frame of heights: 0.05 nm a count."""
    rows, cols = heights.shape
    counts = np.rint(heights / 0.05e-9).astype("<i2")

    def frame(kind, body, settings):
        head = struct.pack("<IH", 22 + len(body), kind) + struct.pack(">H", 0x0105)
        return head + struct.pack("<7H", 2020, 1, 2, 3, 4, 5, settings) + body

    def scan(signal, unit, values, step):
        scales = struct.pack("<ffh", 0, 1e6 * size[0] / cols, -2) + struct.pack("<ffh", 0, 1e6 * size[1] / rows, -2)
        scales += struct.pack("<ffh", 0, step, unit)
        variables = struct.pack("<BBHH", signal, 0, cols, rows) + bytes(40)
        body = scales + variables + struct.pack("<4H", 0, cols, rows, 0) + values.tobytes() + b"title and more"
        return frame(0, body, len(scales + variables))

    parts = [frame(1, bytes(50), 10), scan(1, 2, np.zeros_like(counts), 0.1), scan(0, -1, counts, 0.05)]
    head = b"\x01\xb0\x93\xff" + struct.pack("<I4xH", sum(map(len, parts)), len(parts) - 1) + bytes(19)
    return head + b"".join(parts)


def opdx(heights, size, missing=None):
    """Heights in nanometres, sides in millimetres between the outermost pixel centres."""
    rows, cols = heights.shape
    values = (heights * 1e9).astype("<f4")
    if missing is not None:
        values[missing] = np.nan

    def name(word):
        return struct.pack("<I", len(word)) + word.encode()

    def length(count):
        return struct.pack("<BI", 4, count)

    def text(key, word):
        return name(key) + b"\x12" + length(len(word)) + word.encode()

    def quantity(key, value, unit):
        body = struct.pack("<d", value) + name("unit") + name(unit)
        return name(key) + b"\x13" + length(len(body)) + body

    def count(key, value):
        return name(key) + b"\x07" + struct.pack("<I", value)

    def folder(key, *items):
        body = b"".join(items) + name("") + b"\x7f" + b"\0\0"
        return name(key) + b"\x7d" + length(len(body)) + body

    words = name("Raw") + name("Other")
    matrix = struct.pack("<II", rows, cols) + values[::-1].tobytes()
    return b"VCA DATA\x01\x00\x00\x55" + b"".join(
        (
            folder(
                "MetaData",
                text("DataKind", "Surface Height"), text("PrimaryData2D", "Raw"), text("Date", "1/2/2020"),
                folder("2D_Channels", name("Height") + b"\x42" + name("List") + length(len(words)) + words),
            ),
            folder(
                "2D_Data",
                folder(
                    "Raw",
                    text("DataKind", "Height"), quantity("DataScale", 1.0, "nm"),
                    count("Dimension1Points", rows), count("Dimension2Points", cols),
                    quantity("Dimension1Extent", 1e3 * size[1] * (rows - 1) / rows, "mm"),
                    quantity("Dimension2Extent", 1e3 * size[0] * (cols - 1) / cols, "mm"),
                    name("Matrix") + b"\x45" + name("Matrix<float>") + length(len(matrix)) + matrix,
                ),
            ),
            name("") + b"\x7f",
        )
    )  # fmt: skip


def ardf(heights, size):
    """A phase image and one of heights in metres, each with a text; sections with their checksums."""
    rows, cols = heights.shape

    def section(name, body):
        rest = struct.pack("<I4sI", 16 + len(body), name, 0) + body
        return struct.pack("<I", zlib.crc32(rest)) + rest

    def table(name, stride, entries):
        body = b"".join(entries)
        return section(name, struct.pack("<QII", 32 + len(body), len(entries), stride)) + body

    def entry(name, *values):
        rest = struct.pack(f"<I4sI{len(values)}Q", 16 + 8 * len(values), name, 0, *values)
        return struct.pack("<I", zlib.crc32(rest)) + rest

    def image(title, unit, values):
        steps = size[0] / cols, size[1] / rows
        words = [word.encode().ljust(32, b"\0") for word in ("m", "m", title, unit)]
        lines = b"".join(section(b"IDAT", row.astype("<f4").tobytes()) for row in values)
        box = section(b"IBOX", struct.pack("<QII", 32 + len(lines), rows, 4 * cols + 16)) + lines
        return (
            table(b"IMAG", 24, [entry(b"NEXT", 0), entry(b"THMB", 0)])
            + table(b"TTOC", 32, [entry(b"TOFF", 0, 0)])
            + section(b"IDEF", struct.pack("<IIQQdd", cols, rows, 0, 0, *steps) + b"".join(words))
            + box
        )

    images = [image("PhaseTrace", "deg", np.zeros_like(heights)), image("HeightTrace", "m", heights)]
    start = 16 + 32 + 2 * 24
    contents = table(b"FTOC", 24, [entry(b"IMAG", start), entry(b"IMAG", start + len(images[0]))])
    return section(b"ARDF", b"") + contents + b"".join(images)


def omicron(heights, size, mirrored=(1, 1), lines=None, transfer="TFF_Linear1D"):
    """Up and down, forwards and backwards, each a tenth of a micrometre above the last; 0.01 nm a count."""
    rows, cols = heights.shape

    def word(text):
        return struct.pack("<I", len(text)) + text.encode("utf-16-le")

    def axis(name, count, step, both):
        head = word(name) + word("Default") + word("m") + struct.pack("<Iii", count * (1 + both), 0, 1)
        return head + struct.pack("<ddII", 0.0, step, both, 1) + word(name) + struct.pack("<I3I", 1, 0, count, 1)

    def counts(number):
        return np.rint((heights + 1e-7 * number) / 1e-11).astype("<i4") + 7

    stored = []
    for down in range(1 + mirrored[1]):
        for row in range(rows)[:: -1 if down else 1]:
            for backward in range(1 + mirrored[0]):
                stored.append(counts(2 * down + backward)[row][:: -1 if backward else 1])
    stored = np.array(stored[: lines or len(stored)])
    values = {"Factor": 1e11, "Offset": 7.0}
    if transfer != "TFF_Linear1D":
        values = {"Raw_1": 3.0, "PreOffset": 1.0, "NeutralFactor": 2e11, "PreFactor": 1.0, "Offset": 7.0}
    out = b"FLAT0100" + struct.pack("<I", 2) + axis("X", cols, size[0] / cols, mirrored[0])
    out += axis("Y", rows, size[1] / rows, mirrored[1]) + word("Z") + word(transfer) + word("m")
    out += struct.pack("<I", len(values)) + b"".join(word(k) + struct.pack("<d", v) for k, v in values.items())
    out += struct.pack("<IIQ", 1, 2, 0) + word("a comment") + struct.pack("<II", stored.size, stored.size)
    return out + stored.tobytes() + struct.pack("<I", 0)


def sm4(heights, size, upwards=False, leftwards=False):
    """A spectrum and two images, current and topography (0.01 nm a count, 0.5 um added)."""
    rows, cols = heights.shape
    counts = np.rint((heights - 0.5e-6) / 1e-11).astype("<i4")
    counts = counts[:: 1 if upwards else -1, :: -1 if leftwards else 1]
    out = bytearray(58 + 12 + 16 + 12)
    struct.pack_into("<H", out, 0, 56)
    out[2:38] = "STiMage 005.006 1\0".encode("utf-16-le")
    struct.pack_into("<5I", out, 38, 3, 1, 12, 0, 0)
    struct.pack_into("<3I", out, 58, 1, 70, 16)
    pages = []
    for kind, label, unit in ((1, "IV", "A"), (0, "Current", "A"), (0, "Topography", "m")):
        words = [label, "", "", "", "", "01/02/20", "12:34:56", "m", "m", unit, "x", "y", "", "0", "0", "", "", ""]
        text = b"".join(struct.pack("<H", len(word)) + word.encode("utf-16-le") for word in words)
        head = struct.pack("<HH9I", 180, len(words), 0, 0, 0, 0, 0, cols, rows, 0, 0)
        head += struct.pack("<4I", 0, counts.nbytes, 0, 0)
        steps = (-1 if leftwards else 1) * size[0] / cols, (1 if upwards else -1) * size[1] / rows
        head += struct.pack("<11f", *steps, 1e-11, 0, 0, 0, 0.5e-6, 0, 0, 0, 0) + struct.pack("<4I", 0, 0, 0, 1)
        at = len(out)
        strings = at + 180 + 12
        out += head + bytes(64) + struct.pack("<3I", 10, strings, len(text)) + text
        pages.append((kind, at, len(out)))
        out += counts.tobytes()
    index = len(out)
    struct.pack_into("<4I", out, 70, len(pages), 1, 0, 0)
    struct.pack_into("<3I", out, 86, 2, index, 1)
    for kind, head_at, data_at in pages:
        out += bytes(16) + struct.pack("<4I", kind, 0, 2, 6)
        out += struct.pack("<6I", 3, head_at, 180, 4, data_at, counts.nbytes)
    return bytes(out)


def npy(heights, size, order="C"):
    file = io.BytesIO()
    np.save(file, np.asarray(heights[::-1], order=order))
    return file.getvalue()


def npz(heights, size):
    file = io.BytesIO()
    np.savez_compressed(file, x=np.arange(5.0), heights=heights[::-1].astype("f4"))
    return file.getvalue()


def _hdf(fill):
    import h5py

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.h5")
        with h5py.File(path, "w") as file:
            fill(file)
        return path.read_bytes()


def datx(heights, size, missing=None):
    rows, cols = heights.shape
    values = heights[::-1] * 1e9
    if missing is not None:
        values = np.where(missing[::-1], 1.7976931348623157e308, values)

    def fill(file):
        text = file.create_dataset("MetaData", (4,), dtype=np.dtype([(key, "S40") for key in "abc"]))
        text[...] = np.array(
            [
                ("Root", "Measurement", "{m}"),
                ("{m}", "Surface", "{s}"),
                ("{s}", "Path", "/Data/Surface/x"),
                ("",) * 3,
            ],
            dtype=text.dtype,
        )
        data = file.create_dataset("Data/Surface/x", data=values)
        data.attrs["Unit"] = np.array(["NanoMeters"], dtype="S20")
        data.attrs["No Data"] = np.array([1.7976931348623157e308])
        kind = np.dtype([("Category", "S20"), ("BaseUnit", "S20"), ("Parameters", "f8", (4,))])
        for axis, step in (("X", size[0] / cols), ("Y", size[1] / rows)):
            data.attrs[f"{axis} Converter"] = np.array([("LateralCat", "Pixels", [0, step, 0, 0])], dtype=kind)
        data.attrs["Z Converter"] = np.array([("HeightCat", "NanoMeters", [0, 1, 0, 0])], dtype=kind)

    return _hdf(fill)


def nhf(heights, size, missing=None):
    """A count of -2**31 + 1 to 2**31 - 1 stands for -1 to 1 um."""
    rows, cols = heights.shape
    counts = np.rint((heights + 1e-6) / 2e-6 * (2.0**32 - 2) - (2.0**31 - 1)).astype("i4")
    if missing is not None:
        counts[missing] = -(2**31)

    def fill(file):
        file.attrs["nsf_file_version_major"], file.attrs["nsf_file_version_minor"] = 2, 0
        group = file.create_group("group_0000")
        group.attrs["group_type"], group.attrs["measurement_name"] = "image_line_based", "Image"
        segment = group.create_group("subgroup_0000")
        segment.attrs["segment_name"] = "Forward"
        segment.attrs["rect_axis_size"] = [rows, cols]
        segment.attrs["rect_axis_range"] = [size[1], size[0]]
        for number, (name, unit) in enumerate((("Deflection", "Volt (V)"), ("Topography", "Meter (m)"))):
            data = segment.create_dataset(f"dataset_{number:04}", data=counts.ravel())
            data.attrs["signal_name"] = name
            data.attrs["dataset_element_type"] = "int32"
            data.attrs["signal_calibration_unit"] = data.attrs["signal_unit"] = unit
            data.attrs["signal_id"] = data.attrs["signal_selected"] = name
            data.attrs["signal_calibration_min"], data.attrs["signal_calibration_max"] = -1e-6, 1e-6

    return _hdf(fill)


def h5_jpk(heights, size):
    rows, cols = heights.shape
    counts = np.rint((heights - 0.5e-6) / 1e-15).astype("i4")

    def fill(file):
        group = file.create_group("Measurement_000")
        grid = {"ilength": cols, "jlength": rows, "ulength": size[0], "vlength": size[1]}
        group.attrs.update({f"position-pattern.grid.{key}": value for key, value in grid.items()})
        for number, (name, unit) in enumerate((("Error Signal", "V"), ("Height", "m"))):
            channel = group.create_group(f"Channel_{number:03}")
            scaling = "net-encoder.scaling."
            channel.attrs.update({"channel.fancy-name": np.bytes_(name), "retrace": np.bytes_("false")})
            channel.attrs.update({scaling + "multiplier": 1e-15, scaling + "offset": 0.5e-6})
            channel.attrs[scaling + "unit.unit"] = np.bytes_(unit)
            channel.create_dataset(name.split()[0], data=np.stack([counts.ravel(), 2 * counts.ravel()], axis=1))

    return _hdf(fill)


#: Writer, extension, rounding of the heights (metres), and whether missing points can be written.
WRITERS = {
    "vk": (vk4, ".vk4", 0.06e-9),
    "vk6": (vk6, ".vk6", 0.06e-9),
    "metropro": (metropro, ".dat", 1e-11),
    "plux": (plux, ".plux", 1e-13),
    "al3d": (al3d, ".al3d", 1e-13),
    "nms": (nms, ".nms", 1e-11),
    "mi": (mi, ".mi", 0.02e-9),
    "mdt": (mdt, ".mdt", 0.03e-9),
    "opdx": (opdx, ".opdx", 1e-13),
    "ardf": (ardf, ".ardf", 1e-13),
    "omicron": (omicron, ".Z_flat", 0.006e-9),
    "sm4": (sm4, ".sm4", 0.006e-9),
}
HDF = {"datx": (datx, ".datx", 1e-20), "nhf": (nhf, ".nhf", 1e-15), "h5-jpk": (h5_jpk, ".h5-jpk", 1e-14)}
