# SPDX-License-Identifier: GPL-3.0-or-later
"""Good files of every format that a reader knows: where the fuzz tests start from."""

import io
import struct
import zipfile
import zlib
from dataclasses import dataclass, field
from importlib.util import find_spec

import numpy as np

from tests.support import more_scan_files, odd_scans, scan_files

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


_TEXTS = (
    b"size = 10 um\nunit: nm\n1,5;2,5\n3,5;4,5\n",
    b"1 2 3\n4 5 6\n",
    b"\xef\xbb\xbf# Width: 5 um\n# Height: 5 um\n# Value units: nm\n1e-3\t2\n3\t4\n",
    "# Kanal: a\n# Breite: 5,0 µm\n# Höhe: 5,0 µm\n# Einheiten: nm\n1,5\t2,5\nNaN\t4,5\n".encode("utf-16"),
    b"# File Format = ASCII\n# x-pixels = 2\n# y-pixels = 2\n# x-length = 5\n# y-length = 5\n# Bit2nm = 2\n1 2\n3 4\n",
    b'# Width: 5 um\n# Height: 5 um\n# Value units: nm\n1.5,,2\n,3,\n4,5,"6"\n',
    b"x [um],y [um],z [nm]\n0,0,1\n1,0,2\n0,1,3\n1,1,4\n",
    b"Wyko ASCII Data File Format\t0\t0\t1\nX Size\t2\nY Size\t2\nWavelength\t7\t4\t500\nMult\t7\t4\t2\n"
    b"Pixel_size\t7\t4\t0.0005\nRAW_DATA\t3\t16\t\n1\tBad\n3\t4\n",
)
_LISTS = (
    b"ncols 4\nnrows 2\ncellsize 0.5\nNODATA_value -9999\n1 2 3 4\n5 6 -9999 8\n",
    b",0,1,2,3\n0,1.5,2.5,3.5,9\n1,4.5,5.5,6.5,2\n2,8,1,3,4\n",
    b"0 0 1\n1 0 2\n0 1 3\n1 1 4\n",
)


def seeds(folder):
    """Name and seed of each reader."""
    result = {
        name: Seed(extension, (writer(HEIGHTS, SIZE),)) for name, (writer, extension, _) in scan_files.WRITERS.items()
    }
    result["x3p"] = Seed(".x3p", result["x3p"].files, parts=_x3p_parts(), join=join_zip)
    result["nanoscope"] = Seed(
        ".spm", (scan_files.nanoscope(HEIGHTS, SIZE), scan_files.nanoscope(HEIGHTS, SIZE, bits=32))
    )
    result["text"] = Seed(".txt", (scan_files.text(HEIGHTS, SIZE), *_TEXTS), {"height_m": 1e-7})
    result["lists"] = Seed(".csv", _LISTS, PICTURE)
    for name, (writer, extension, _) in more_scan_files.WRITERS.items():
        result[name] = Seed(extension, (writer(HEIGHTS, SIZE),))
    if HAS_HDF:
        for name, (writer, extension, _) in more_scan_files.HDF.items():
            result[name] = Seed(extension, (writer(HEIGHTS, SIZE),))
    result["npy"] = Seed(".npy", tuple(more_scan_files.npy(HEIGHTS, SIZE, order) for order in "CF"), PICTURE)
    result["npz"] = Seed(".npz", (more_scan_files.npz(HEIGHTS, SIZE),), PICTURE)
    packed = (
        odd_scans.sur(b"um", packed=streams, missing=True, objects=layers) for streams, layers in ((1, 1), (3, 2))
    )
    result["sur"] = Seed(".sur", (*result["sur"].files, *packed))
    bcr = odd_scans.sdf(b"bBCR-1.0", 5, "<i2", 2**15 - 1)
    result["sdf"] = Seed(".sdf", (*result["sdf"].files, bcr, odd_scans.sdf(b"bISO-2.0", 3, "<f4", np.nan)))
    colour = np.repeat(_grey()[..., None], 4, axis=2)
    result["png16"] = Seed(
        ".png",
        (odd_scans.png(colour, (4, 3, 2, 1)),),
        PICTURE,
        (
            struct.pack(">IIBBBBB", 6, 5, 16, 6, 0, 0, 0),
            b"".join(b"\4" + row.astype(">u2").tobytes() for row in colour),
        ),
        join_png,
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


HAS_HDF = find_spec("h5py") is not None
#: Where h5py is not installed its formats are refused before a byte is read.
NAMES = (
    *scan_files.WRITERS,
    *more_scan_files.WRITERS,
    *(more_scan_files.HDF if HAS_HDF else ()),
    *("sdf_ascii", "lists", "npy", "npz", "png", "png16", "jpeg", "bmp", "tiff", "exr"),
)
