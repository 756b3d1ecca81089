# SPDX-License-Identifier: GPL-3.0-or-later
"""Small files of the variants that readers get wrong: each function gives the bytes, written from the descriptions.

Heights are counted in nanometres, top row first, unless a function says otherwise.
"""

import io
import struct
import zipfile
import zlib
from itertools import pairwise

import numpy as np

#: Rows from the top; nothing is symmetric, and no two heights are equal.
NM = np.array([[0.0, 10, 25, 45], [70, 100, 135, 175], [220, 270, 325, 385]])


def bruker(cols, rows, scan, image, first="*File list", counts=None):
    """One height image of 32 bits: 100 nm/V, a count is 100 * 24.576 / 2**32 nm."""
    counts = np.arange(rows * cols).reshape(rows, cols) if counts is None else counts
    raw = np.ascontiguousarray(counts, "<i4").tobytes()
    lines = [
        first, "Version: 0x09400103", "*Ciao scan list", "@Sens. Zs: V 100.0 nm/V", *scan, "*Ciao image list",
        "Data offset: 8192", f"Data length: {len(raw)}", "Bytes/pixel: 4", f"Samps/line: {cols}",
        f"Number of lines: {rows}", *image, '@2:Image Data: S [ZSensor] "Height Sensor"',
        "@2:Z scale: V [Sens. Zs] (0.006 V/LSB) 24.576 V", "*File list end",
    ]  # fmt: skip
    return ("".join(f"\\{line}\r\n" for line in lines)).encode("latin-1").ljust(8192, b"\0") + raw


def sdf(magic, kind, dtype, bad, scale=1e-9):
    """4 x 3 points, a micrometre apart; the point in the middle of the left marked as bad."""
    counts = np.rint(NM / 5) * 5 if np.dtype(dtype).kind == "f" else np.rint(NM / 5)
    values = (counts * (1e-9 / scale if np.dtype(dtype).kind == "f" else 1)).astype(dtype)
    values[1, 1] = bad
    head = magic + b"maker".ljust(10) + b"010120240000" * 2
    head += struct.pack("<II" if magic.endswith(b"2.0") else "<HH", 4, 3)
    step = scale if np.dtype(dtype).kind == "f" else 5e-9
    return head + struct.pack("<4d3B", 1e-6, 1e-6, step, -1, 0, kind, 0) + values.tobytes()


def x3p(kind, values=None, axis="", folder="", datums=None):
    """Axes a micrometre apart; ``axis`` goes into CZ, ``datums`` makes a list in the XML."""
    grid = "".join(f"<C{c}><AxisType>I</AxisType><Increment>1e-6</Increment></C{c}>" for c in "XY")
    body = "<DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink>"
    if datums is not None:
        body = "<DataList>" + "".join(f"<Datum>{d}</Datum>" if d else "<Datum/>" for d in datums) + "</DataList>"
    xml = (
        '<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1><FeatureType>SUR</FeatureType><Axes>'
        f"{grid}<CZ><AxisType>A</AxisType><DataType>{kind}</DataType>{axis}</CZ></Axes></Record1><Record3>"
        f"<MatrixDimension><SizeX>4</SizeX><SizeY>3</SizeY><SizeZ>1</SizeZ></MatrixDimension>{body}</Record3>"
        "</p:ISO5436_2>"
    )
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr(folder + "main.xml", xml)
        if values is not None:
            archive.writestr(folder + "bindata/data.bin", values.tobytes())
    return file.getvalue()


def sur(unit, packed=0, missing=False, objects=1):
    """Counts of a nanometre; ``packed`` zlib streams, 0 for none; ``objects`` layers, each 1000 nm above the last."""
    out = b""
    for layer in range(objects):
        counts = NM.astype("<i4") + 1000 * layer
        low = int(counts.min())
        if missing:
            counts[0, 2] = low - 2
        body = counts.tobytes()
        if packed:
            cuts = np.linspace(0, counts.size, packed + 1).astype(int)
            raws = [counts.ravel()[a:b].tobytes() for a, b in pairwise(cuts)]
            zips = [zlib.compress(raw) for raw in raws]
            lengths = b"".join(struct.pack("<II", len(r), len(z)) for r, z in zip(raws, zips, strict=True))
            body = struct.pack("<I", packed) + lengths + b"".join(zips)
        head = struct.pack(
            "<12s4H30s30s5H8sH4iI3f16s16s16s16s16s16s", b"DSCOMPRESSED" if packed else b"DIGITAL SURF", 0, objects, 1,
            2 if objects == 1 else 5, b"object", b"", 0, 0, 0, int(missing), 1, b"", 32, low, int(counts.max()), 4, 3,
            12, 0.5, 0.5, 1e-3, b"X", b"Y", b"Z", unit, unit, unit,
        )  # fmt: skip
        head = bytearray(head.ljust(512, b"\0"))
        struct.pack_into("<I", head, 324, len(body) if packed else 0)
        out += bytes(head) + body
    return out


def igor_without_units(step):
    """A wave of version 5 whose dimensions have no unit; heights say metres."""
    head = struct.pack("<hhiiii11i", 5, 0, 368, 0, 0, 0, *[0] * 11)
    wave = bytearray(320)
    struct.pack_into("<h", wave, 16, 2)
    struct.pack_into("<4i", wave, 68, 4, 3, 0, 0)
    struct.pack_into("<4d", wave, 84, step, step, 1, 1)
    wave[148:149] = b"m"
    return head + bytes(wave) + (NM.ravel() * 1e-9).astype("<f4").tobytes()


def png(samples, filters=(0,)):
    """A PNG of 16 bits of ``(rows, cols, samples)``, row by row with these filters in turn."""
    rows, cols, count = samples.shape
    lines = samples.astype(">u2").tobytes()
    width, size = 2 * cols * count, 2 * count
    above, out = bytes(width), b""
    for row in range(rows):
        line, kind = lines[row * width : (row + 1) * width], filters[row % len(filters)]
        coded = bytearray()
        for at in range(width):
            left = line[at - size] if at >= size else 0
            corner = above[at - size] if at >= size else 0
            up = above[at]
            guess = min((left, up, corner), key=lambda value: abs(left + up - corner - value))
            coded.append((line[at] - (0, left, up, (left + up) // 2, guess)[kind]) & 255)
        out += bytes([kind]) + bytes(coded)
        above = line

    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    head = struct.pack(">IIBBBBB", cols, rows, 16, {1: 0, 2: 4, 3: 2, 4: 6}[count], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(out)) + chunk(b"IEND", b"")


def rows_of(values, separator="\t", number=str):
    """A matrix as text."""
    return "".join(separator.join(number(v) for v in row) + "\n" for row in values)
