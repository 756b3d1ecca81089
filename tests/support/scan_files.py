# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scan files of every instrument format, written from the formats' descriptions.

Each writer takes heights in metres with the *bottom* row first and sizes in metres, and shares no
code with the readers. They are the seeds of the fuzz tests too.
"""

import hashlib
import io
import struct
import zipfile

import numpy as np


def gsf(heights, size):
    rows, cols = heights.shape
    head = (
        f"Gwyddion Simple Field 1.0\nXRes = {cols}\nYRes = {rows}\nXReal = {size[0]}\nYReal = {size[1]}\nZUnits = m\n"
    )
    head = head.encode() + b"\0" * (4 - len(head) % 4)
    return head + heights[::-1].astype("<f4").tobytes()


def gwy(heights, size):
    def item(key, code, payload):
        return key.encode() + b"\0" + code + payload

    def obj(name, body):
        return name.encode() + b"\0" + struct.pack("<I", len(body)) + body

    rows, cols = heights.shape
    unit = obj("GwySIUnit", item("unitstr", b"s", b"m\0"))
    values = heights[::-1].astype("<f8").tobytes()
    field = (
        item("xres", b"i", struct.pack("<i", cols))
        + item("yres", b"i", struct.pack("<i", rows))
        + item("xreal", b"d", struct.pack("<d", size[0]))
        + item("yreal", b"d", struct.pack("<d", size[1]))
        + item("si_unit_xy", b"o", unit)
        + item("si_unit_z", b"o", unit)
        + item("data", b"D", struct.pack("<I", heights.size) + values)
    )
    title = item("/0/data/title", b"s", b"Topography\0")
    return b"GWYP" + obj("GwyContainer", item("/0/data", b"o", obj("GwyDataField", field)) + title)


def text(heights, size):
    lines = [f"# Width: {size[0] * 1e6} um", f"# Height: {size[1] * 1e6} um", "# Value units: nm"]
    return "\n".join([*lines, *(" ".join(f"{1e9 * h:.6f}" for h in row) for row in heights[::-1])]).encode()


def nanoscope(heights, size, bits=16, extra_lines=""):
    """Sensitivity 20 nm/V, full range 440 V; an error channel in millivolts comes first."""
    rows, cols = heights.shape
    step = 440.0 / 2**bits * 20e-9
    counts = np.rint(heights / step).astype(f"<i{bits // 8}")
    image = (
        "\\*Ciao image list\r\n\\Data offset: {offset}\r\n\\Data length: {length}\r\n\\Bytes/pixel: {bytes}\r\n"
        "\\Samps/line: {cols}\r\n\\Number of lines: {rows}\r\n\\Scan Size: {x} {y} ~m\r\n\\Line Direction: Trace\r\n"
        '\\@2:Image Data: S [{key}] "{name}"\r\n\\@2:Z scale: V [Sens. {sens}] (0.0067 V/LSB) 440.0 {unit}\r\n'
    )
    start, block = 8192, counts.nbytes
    common = {"length": block, "bytes": bits // 8, "cols": cols, "rows": rows, "x": size[0] * 1e6, "y": size[1] * 1e6}
    head = (
        "\\*File list\r\n\\Version: 0x05310001\r\n\\Date: 12:34:38 PM Tue Jul 30 2019\r\n\\*Scanner list\r\n"
        "\\@Sens. Zscan: V 20.00000 nm/V\r\n\\*Ciao scan list\r\n\\@Sens. Amplitude: V 1.000000 \r\n"
        + extra_lines
        + image.format(
            offset=start, key="AmplitudeError", name="Amplitude Error", sens="Amplitude", unit="mV", **common
        )
        + image.format(offset=start + block, key="Height", name="Height", sens="Zscan", unit="V", **common)
        + "\\*File list end\r\n\x1a"
    )
    return head.encode("latin-1").ljust(start, b"\0") + np.zeros_like(counts).tobytes() + counts.tobytes()


def nanosurf(heights, size):
    """A deflection channel, then heights as signed 32-bit counts over 4 um that begin at -1 um."""
    rows, cols = heights.shape
    counts = np.rint((heights - 1e-6) / (4e-6 / 2**32)).astype("<i4")
    channel = (
        "[DataSet-0:{i}]\r\nPoints={cols}\r\nLines={rows}\r\nFrame=Scan forward\r\nSaveMode=Binary\r\nSaveBits=32\r\n"
        "SaveSign=Signed\r\nSaveOrder=Intel\r\nDim0Range={x}\r\nDim0Unit=m\r\nDim1Range={y}\r\nDim1Unit=m\r\n"
        "Dim2Min={low}\r\nDim2Range={span}\r\nDim2Unit={unit}\r\nDim2Name={name}\r\n"
    )
    common = {"cols": cols, "rows": rows, "x": size[0], "y": size[1]}
    head = (
        "[DataSet]\r\nVersion=2\r\nGroupCount=1\r\nGr0-Count=2\r\nGr0-Ch0=DataSet-0:0\r\nGr0-Ch1=DataSet-0:1\r\n"
        + channel.format(i=0, low=-1, span=2, unit="V", name="Deflection", **common)
        + channel.format(i=1, low=-1e-6, span=4e-6, unit="m", name="Z-Axis", **common)
    )
    return head.encode("latin-1") + b"\r\n#!" + np.zeros_like(counts).tobytes() + counts.tobytes()


def park(heights, size):
    """Gain 1 um, scale 0.001, offset 0.25: a count is a nanometre, a quarter micrometre is added."""
    import tifffile

    rows, cols = heights.shape
    counts = np.rint((heights - 0.25e-6) / 1e-9).astype("<i2")

    def wide(word, length):
        return word.encode("utf-16-le").ljust(2 * length, b"\0")

    header = struct.pack("<I", 0) + wide("Z Height", 32) + wide("Tapping", 8) + struct.pack("<dII", 0, 0, 0)
    header += struct.pack("<II", cols, rows) + struct.pack("<dIdIII", 0, 0, 0, 1, 1, 0)
    header += struct.pack("<dddddd", size[0] * 1e6, size[1] * 1e6, 0, 0, 1, 0) + wide("V", 8)
    header += struct.pack("<ddddd", 0, 0, 1.0, 0.001, 0.25) + wide("um", 8) + struct.pack("<iiiIII", 0, 0, 0, 0, 0, 1)
    file = io.BytesIO()
    tags = [
        (50432, "I", 1, 0x0E031301, True),
        (50433, "I", 1, 0x1000001, True),
        (50434, "B", counts.nbytes, counts.tobytes(), True),
        (50435, "B", len(header), header, True),
    ]
    tifffile.imwrite(file, np.zeros((8, 8, 3), np.uint8), photometric="rgb", extratags=tags, metadata=None)
    return file.getvalue()


def jpk(heights, size, reflect=0):
    """A thumbnail with the grid, then one page of counts of a nanometre above 0.5 um."""
    import tifffile

    counts = np.rint((heights - 0.5e-6) / 1e-9).astype("<i2")
    stored = counts[::-1] if reflect else counts
    file = io.BytesIO()
    with tifffile.TiffWriter(file) as writer:
        grid = [
            (0x8000, "s", 0, "2.0", True),
            (0x8003, "s", 0, "2019-07-30 12:34:38 +0200", True),
            (0x8042, "d", 1, size[0], True),
            (0x8043, "d", 1, size[1], True),
            (0x8045, "I", 1, reflect, True),
        ]
        writer.write(np.zeros((4, 4, 3), np.uint8), photometric="rgb", extratags=grid, metadata=None)
        slots = [
            (0x8051, "I", 1, 0, True),
            (0x8052, "s", 0, "Height", True),
            (0x8080, "I", 1, 2, True),
            (0x8081, "s", 0, "calibrated", True),
            (0x8090, "s", 0, "raw", True),
            (0x80A2, "s", 0, "V", True),
            (0x80A3, "s", 0, "NullScaling", True),
            (0x80C0, "s", 0, "calibrated", True),
            (0x80D2, "s", 0, "m", True),
            (0x80D3, "s", 0, "LinearScaling", True),
            (0x80D4, "d", 1, 1e-9, True),
            (0x80D5, "d", 1, 0.5e-6, True),
        ]
        writer.write(stored, photometric="minisblack", extratags=slots, metadata=None)
    return file.getvalue()


def wsxm(heights, size):
    rows, cols = heights.shape
    keys = (
        f"[Control]\r\n    X Amplitude: {size[0] * 1e9} nm\r\n    Y Amplitude: {size[1] * 1e6} um\r\n[General Info]\r\n"
        f"    Image Data Type: double\r\n    Number of columns: {cols}\r\n    Number of rows: {rows}\r\n"
        "    Z Amplitude: 1000 nm\r\n[Header end]\r\n"
    )
    head = f"WSxM file copyright UAM\r\nSxM Image file\r\nImage header size: {len(keys) + 68}\r\n{keys}"
    return head.encode("latin-1") + (heights * 1e9)[:, ::-1].astype("<f8").tobytes()


def sur(heights, size, missing=None):
    """Counts of 0.1 nm in 32 bits; the header's own units are millimetres and micrometres."""
    rows, cols = heights.shape
    counts = np.rint(heights / 1e-10).astype("<i4")
    low = int(counts.min())
    if missing is not None:
        counts[missing] = low - 2

    def word(value, length=16):
        return value.encode("latin-1").ljust(length)

    head = b"DIGITAL SURF" + struct.pack("<4H", 0, 1, 1, 2) + word("object", 30) + word("instrument", 30)
    head += struct.pack("<5H", 0, 0, 0, 0 if missing is None else 1, 1) + bytes(8) + struct.pack("<H", 32)
    head += struct.pack("<4i", low, int(counts.max()), cols, rows) + struct.pack("<I", rows * cols)
    head += struct.pack("<3f", size[0] * 1e3 / cols, size[1] * 1e3 / rows, 1e-4)
    head += word("X") + word("Y") + word("Z") + word("mm") + word("mm") + word("µm") + word("mm") + word("mm")
    head += (
        word("µm")
        + struct.pack("<3f", 1, 1, 1)
        + struct.pack("<3H", 0, 0, 0)
        + bytes(12)
        + struct.pack("<7H", *[1] * 7)
    )
    head += struct.pack("<f", 0) + bytes(10) + struct.pack("<HH", 5, 0) + bytes(128) + struct.pack("<3f", 0, 0, 0)
    head = head.ljust(512, b"\0")
    return head + b"notes" + counts[::-1].tobytes()


def sdf_binary(heights, size):
    rows, cols = heights.shape
    head = b"bISO-1.0" + b"maker".ljust(10) + b"010120200000" * 2 + struct.pack("<HH", cols, rows)
    head += struct.pack("<ddddBBB", size[0] / cols, size[1] / rows, 1e-9, 0, 0, 7, 0)
    return head + (heights[::-1] / 1e-9).astype("<f8").tobytes()


def sdf_ascii(heights, size, missing=None):
    rows, cols = heights.shape
    head = (
        f"aISO-1.0\nManufacID = maker\nNumPoints = {cols}\nNumProfiles = {rows}\nXscale = {size[0] / cols}\n"
        f"Yscale = {size[1] / rows}\nZscale = 1e-9\nZresolution = -1\nCompression = 0\nDataType = 7\nCheckType = 0\n*\n"
    )
    words = [f"{h / 1e-9:.6f}" for h in heights[::-1].ravel()]
    if missing is not None:
        words = ["BAD" if bad else w for w, bad in zip(words, missing[::-1].ravel(), strict=True)]
    return (head + "\n".join(words) + "\n*\n").encode()


def opd(heights, size, missing=None):
    """Wavelength 500 nm, Mult 2, pixels twice as high as wide are told by Aspect."""
    rows, cols = heights.shape
    values = (heights.T / (500e-9 / 2)).astype("<f4")
    if missing is not None:
        values[missing.T] = 1e38
    array = struct.pack("<HHH", cols, rows, 4) + values.tobytes()
    aspect = (size[1] / rows) / (size[0] / cols)
    blocks = [
        (b"Wavelength", 7, struct.pack("<f", 500.0)),
        (b"Mult", 6, struct.pack("<h", 2)),
        (b"Aspect", 7, struct.pack("<f", aspect)),
        (b"Pixel_size", 7, struct.pack("<f", 1e3 * size[0] / cols)),
        (b"Title", 5, b"a title"),
        (b"RAW_DATA", 3, array),
    ]
    directory = struct.pack("<16shlH", b"Directory", 1, 24 * (len(blocks) + 1), 0)
    for name, kind, payload in blocks:
        directory += struct.pack("<16shlH", name, kind, len(payload), 0)
    return b"\1\0" + directory + b"".join(payload for _, _, payload in blocks)


def plu(heights, size, missing=None):
    rows, cols = heights.shape
    values = (heights * 1e6).astype("<f4")
    if missing is not None:
        values[missing] = 1000001.0
    head = b"Tue Jul 30 12:34:38 2019".ljust(128, b"\0") + struct.pack("<I", 0) + bytes(256)
    head += struct.pack("<III", rows, cols, 1)
    head += struct.pack("<7f", 1, size[0] * 1e6 / cols, size[1] * 1e6 / rows, 0, 0, 1, 0)
    head += struct.pack("<5I", 3, 0, 0, 1, 0) + bytes(40) + struct.pack("<5B3BI", 0, 1, 0, 0, 0, 0, 0, 0, 1)
    return head + struct.pack("<II", rows, cols) + values[::-1].tobytes() + struct.pack("<ff", 0, 1)


def nanonis(heights, size, downwards=False, missing=None):
    """Current and height, each forward and backward."""
    rows, cols = heights.shape
    values = heights.copy()
    if missing is not None:
        values[missing] = np.nan
    values = (values[::-1] if downwards else values).astype(">f4")
    head = (
        f":NANONIS_VERSION:\n2\n:SCANIT_TYPE:\n              FLOAT            MSBFIRST\n:REC_DATE:\n 30.07.2019\n"
        f":SCAN_PIXELS:\n       {cols}       {rows}\n:SCAN_RANGE:\n   {size[0]:E}   {size[1]:E}\n"
        f":SCAN_DIR:\n{'down' if downwards else 'up'}\n:DATA_INFO:\n"
        "\tChannel\tName\tUnit\tDirection\tCalibration\tOffset\n"
        "\t0\tCurrent\tA\tboth\t1.0E-9\t0.0E+0\n\t14\tZ\tm\tboth\t1.0E-9\t0.0E+0\n\n:SCANIT_END:\n\n\n"
    )
    zeros = np.zeros_like(values).tobytes()
    return (
        head.encode() + b"\x1a\x04" + zeros + zeros + values.tobytes() + (values[:, ::-1] * 2).astype(">f4").tobytes()
    )


def igor(heights, size, order="<"):
    """A wave of two layers, phase and height, with a note of Asylum's."""
    rows, cols = heights.shape
    values = np.stack([np.zeros_like(heights), heights]).astype(order + "f8").tobytes()
    note = b"Date: 2019-10-24\rTime: 12:14:13 PM\rScanAngle: 0\rMicroscopeModel: Cypher\rScanSize: 1\r"
    labels = b"".join(name.ljust(32, b"\0") for name in (b"", b"PhaseRetrace", b"HeightRetrace"))
    head = struct.pack(
        order + "hhiiii4i4iiii", 5, 0, 320 + len(values), 0, len(note), 0, 0, 0, 0, 0, 0, 0, len(labels), 0, 0, 0, 0
    )
    wave = struct.pack(order + "IIIihh6sh32sii", 0, 0, 0, 2 * rows * cols, 4, 0, b"", 1, b"scan", 0, 0)
    wave += struct.pack(order + "4i4d4d", cols, rows, 2, 0, size[0] / cols, size[1] / rows, 1, 1, 0, 0, 0, 0)
    wave += b"m\0\0\0" + b"m\0\0\0" * 2 + bytes(8)
    return head + wave.ljust(320, b"\0") + values + note + labels


X3P_XML = """<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1><Revision>ISO5436 - 2000</Revision>
<FeatureType>SUR</FeatureType><Axes><CX><AxisType>I</AxisType><Increment>{dx}</Increment></CX>
<CY><AxisType>I</AxisType><Increment>{dy}</Increment></CY><CZ><AxisType>A</AxisType><DataType>{kind}</DataType>
{scale}</CZ></Axes></Record1><Record2><Date>2019-10-24T12:14:13</Date><Instrument><Manufacturer>maker</Manufacturer>
<Model>one</Model></Instrument></Record2><Record3><MatrixDimension><SizeX>{cols}</SizeX><SizeY>{rows}</SizeY>
<SizeZ>1</SizeZ></MatrixDimension><DataLink><PointDataLink>bindata/data.bin</PointDataLink>
<MD5ChecksumPointData>{md5}</MD5ChecksumPointData>{valid}</DataLink></Record3></p:ISO5436_2>"""


def x3p(heights, size, missing=None, kind="D", xml=X3P_XML):
    rows, cols = heights.shape
    values = heights[::-1].astype("<f8") if kind == "D" else np.rint(heights[::-1] / 1e-10 - 5).astype("<i4")
    raw, file = values.tobytes(), io.BytesIO()
    valid = "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>" if missing is not None else ""
    scale = "" if kind == "D" else "<Increment>1e-10</Increment><Offset>5e-10</Offset>"
    main = xml.format(
        dx=size[0] / cols,
        dy=size[1] / rows,
        kind=kind,
        scale=scale,
        cols=cols,
        rows=rows,
        valid=valid,
        md5=hashlib.md5(raw).hexdigest().upper(),
    )
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", main)
        archive.writestr("bindata/data.bin", raw)
        if missing is not None:
            archive.writestr("bindata/valid.bin", np.packbits(~missing[::-1].ravel(), bitorder="little").tobytes())
    return file.getvalue()


#: Writer, extension and rounding of the heights (metres) of each format.
WRITERS = {
    "gsf": (gsf, ".gsf", 1e-14),
    "gwy": (gwy, ".gwy", 1e-20),
    "text": (text, ".txt", 1e-14),
    "nanoscope": (nanoscope, ".spm", 0.07e-9),
    "igor": (igor, ".ibw", 1e-20),
    "x3p": (x3p, ".x3p", 1e-20),
    "nanosurf": (nanosurf, ".nid", 1e-15),
    "park": (park, ".tiff", 0.51e-9),
    "jpk": (jpk, ".jpk", 0.51e-9),
    "wsxm": (wsxm, ".stp", 1e-20),
    "nanonis": (nanonis, ".sxm", 1e-13),
    "sur": (sur, ".sur", 0.06e-9),
    "sdf": (sdf_binary, ".sdf", 1e-20),
    "opd": (opd, ".opd", 1e-13),
    "plu": (plu, ".plu", 1e-13),
}
