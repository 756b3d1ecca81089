# SPDX-License-Identifier: GPL-3.0-or-later
"""Good files of every format that a reader knows: where the fuzz tests start from."""

import io
import struct
import zipfile
import zlib
from dataclasses import dataclass, field

import numpy as np

from tests.support import scan_files

HEIGHTS = np.linspace(0.3e-6, 0.7e-6, 30).reshape(5, 6)
SIZE = (6e-6, 10e-6)
#: What the user says of a picture.
PICTURE = {"size_m": SIZE, "height_m": 800e-9}


@dataclass(frozen=True)
class Seed:
    """Whole files, or parts and the way to join them, so that mutations reach what lies behind a checksum."""

    extension: str
    files: tuple[bytes, ...]
    reading: dict = field(default_factory=dict)
    parts: tuple[bytes, ...] = ()
    join: object = None


def _grey():
    return np.linspace(0, 65535, 30).reshape(5, 6).astype(np.uint16)


def png():
    """16-bit grey, and 8-bit grey with alpha, interlaced not."""
    from PIL import Image

    files = []
    for image in (Image.fromarray(_grey()), Image.fromarray((_grey() >> 8).astype(np.uint8)).convert("LA")):
        file = io.BytesIO()
        image.save(file, "PNG")
        files.append(file.getvalue())
    return files


def join_png(parts):
    """Header and lines of pixels as a PNG whose checksums are right."""
    head, lines = parts

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")


def picture(kind, **options):
    from PIL import Image

    file = io.BytesIO()
    Image.fromarray((_grey() >> 8).astype(np.uint8)).save(file, kind, **options)
    return file.getvalue()


def tiff():
    import tifffile

    files = []
    for pixels, options in (
        (_grey(), {}),
        (_grey().astype(np.float32) / 65535, {"compression": "zlib"}),
        (np.repeat(_grey(), 8, 0).repeat(8, 1), {"tile": (16, 16), "byteorder": ">"}),
        (_grey(), {"bigtiff": True, "photometric": "miniswhite"}),
    ):
        file = io.BytesIO()
        tifffile.imwrite(file, pixels, metadata=None, **options)
        files.append(file.getvalue())
    return files


def exr(folder):
    import OpenEXR

    files = []
    for compression, channels in (
        (OpenEXR.ZIP_COMPRESSION, {"Y": _grey().astype(np.float32)}),
        (OpenEXR.PIZ_COMPRESSION, {"RGB": np.repeat(_grey()[:, :, None] / 65535, 3, 2).astype(np.float16)}),
        (OpenEXR.NO_COMPRESSION, {"Z": _grey().astype(np.float32)}),
    ):
        with OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, channels) as file:
            file.write(str(folder / "seed.exr"))
        files.append((folder / "seed.exr").read_bytes())
    return files


def join_zip(parts):
    xml, values, valid = parts
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", xml)
        archive.writestr("bindata/data.bin", values)
        archive.writestr("bindata/valid.bin", valid)
    return file.getvalue()


def _x3p_parts():
    missing = np.zeros(HEIGHTS.shape, bool)
    missing[1, 2] = True
    with zipfile.ZipFile(io.BytesIO(scan_files.x3p(HEIGHTS, SIZE, missing))) as archive:
        xml, *rest = (archive.read(name) for name in ("main.xml", "bindata/data.bin", "bindata/valid.bin"))
    start, end = xml.index(b"<MD5"), xml.index(b"</MD5ChecksumPointData>")
    return (xml[:start] + xml[end + len(b"</MD5ChecksumPointData>") :], *rest)


def seeds(folder):
    """Name and seed of each reader."""
    result = {
        name: Seed(extension, (writer(HEIGHTS, SIZE),)) for name, (writer, extension, _) in scan_files.WRITERS.items()
    }
    result["x3p"] = Seed(".x3p", result["x3p"].files, parts=_x3p_parts(), join=join_zip)
    result["nanoscope"] = Seed(
        ".spm", (scan_files.nanoscope(HEIGHTS, SIZE), scan_files.nanoscope(HEIGHTS, SIZE, bits=32))
    )
    result["text"] = Seed(
        ".txt",
        (
            scan_files.text(HEIGHTS, SIZE),
            b"size = 10 um\nunit: nm\n1,5;2,5\n3,5;4,5\n",
            b"1 2 3\n4 5 6\n",
            b"\xef\xbb\xbf# Width: 5 um\n# Height: 5 um\n# Value units: nm\n1e-3\t2\n3\t4\n",
        ),
        {"height_m": 1e-7},
    )
    result["sdf_ascii"] = Seed(".sdf", (scan_files.sdf_ascii(HEIGHTS, SIZE),))
    grey = _grey().astype(">u2")
    lines = b"".join(b"\0" + row.tobytes() for row in grey)
    result["png"] = Seed(
        ".png", tuple(png()), PICTURE, (struct.pack(">IIBBBBB", 6, 5, 16, 0, 0, 0, 0), lines), join_png
    )
    result["jpeg"] = Seed(".jpg", (picture("JPEG"), picture("JPEG", progressive=True)), PICTURE)
    result["bmp"] = Seed(".bmp", (picture("BMP"),), PICTURE)
    result["tiff"] = Seed(".tif", tuple(tiff()), PICTURE)
    result["exr"] = Seed(".exr", tuple(exr(folder)), PICTURE)
    return result


NAMES = (*scan_files.WRITERS, "sdf_ascii", "png", "jpeg", "bmp", "tiff", "exr")
