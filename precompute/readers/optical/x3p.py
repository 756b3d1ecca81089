# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of ISO 25178-72 (.x3p): a zip archive with ``main.xml`` and a binary matrix, top row first, in metres.

Members are read by name inside the archive (nothing is unpacked to disk), their declared sizes are
checked before and their real sizes while reading, and XML with a document type (the door to
entity bombs) is refused. ``main.xml`` may lie in a folder; its links are then looked for there.

Heights are absolute (axis type A): floats are metres, and an Increment counts for integers alone, whose
unit it is (ISO 25178-72; a writer may leave one beside floats all the same).
Missing are NaN among floats, an empty ``Datum`` in lists, and what ``ValidPointsLink`` leaves out.
"""

from __future__ import annotations

import hashlib
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from ...errors import ScanError
from ..common.archive import LONGEST_XML, member, xml_root
from ..common.binary import ENDS_EARLY, integer, number
from ..common.channel import Channel, Samples
from ..common.limits import check_loaded, check_shape

_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}


def read_x3p(path: Path) -> list[Channel]:
    """The one surface of an .x3p file."""
    with zipfile.ZipFile(path) as archive:
        folder = _folder(archive)
        raw = member(archive, folder + "main.xml", LONGEST_XML, ".x3p")
    root = xml_root(raw, ".x3p")
    if _value(root, "Record1/FeatureType") not in ("SUR", ""):
        raise ScanError("The .x3p file holds a profile or a cloud of points, no surface; export the surface.")
    if _value(root, "Record1/Axes/CX/AxisType") != "I" or _value(root, "Record1/Axes/CY/AxisType") != "I":
        raise ScanError("The .x3p file's points lie on no regular grid; export it resampled.")
    cols, rows = (integer(_value(root, f"Record3/MatrixDimension/Size{axis}"), f"Size{axis}") for axis in "XY")
    check_shape(rows, cols)
    check_loaded(rows, cols)
    if integer(_value(root, "Record3/MatrixDimension/SizeZ") or 1, "SizeZ") != 1:
        raise ScanError("The .x3p file holds several layers; export one surface.")
    step_x, step_y = (number(_value(root, f"Record1/Axes/C{axis}/Increment"), "Increment") for axis in "XY")
    kind = _value(root, "Record1/Axes/CZ/DataType") or "D"
    if kind not in _TYPES:
        raise ScanError(f"The .x3p file holds '{kind[:10]}' values, which are not understood.")
    scale = number(_value(root, "Record1/Axes/CZ/Increment") or 1.0, "Increment") if kind in "IL" else 1.0
    offset = number(_value(root, "Record1/Axes/CZ/Offset") or 0.0, "Offset")
    words = [_value(root, f"Record2/Instrument/{key}") for key in ("Manufacturer", "Model")]
    metadata = {"instrument": " ".join(words).strip(), "date": _value(root, "Record2/Date")}

    def load() -> Samples:
        with zipfile.ZipFile(path) as archive:
            values = _matrix(archive, folder, root, kind, rows, cols)
            missing = np.zeros(values.shape, bool) if values.dtype.kind == "i" else ~np.isfinite(values)
            valid = _value(root, "Record3/DataLink/ValidPointsLink")
            if valid:
                missing |= ~_bits(_linked(archive, folder, valid, rows * cols), rows, cols)
        heights = np.where(missing, np.nan, values.astype(np.float64) * scale + offset)
        return Samples(heights[::-1], (cols * step_x, rows * step_y), missing[::-1], metadata=metadata)

    return [Channel("Height", "m", load)]


def _folder(archive: zipfile.ZipFile) -> str:
    """The folder of main.xml in the archive, with its slash; the outermost where there are several."""
    found = [name for name in archive.namelist() if name.casefold().split("/")[-1] == "main.xml"]
    name = min(found, key=lambda name: name.count("/"), default="main.xml")
    return name[: -len("main.xml")]


def _linked(archive: zipfile.ZipFile, folder: str, link: str, limit: int) -> bytes:
    """A member that main.xml names: beside it, or from the top of the archive."""
    inside = folder + link.strip().lstrip("./")
    there = {name.lstrip("./").casefold() for name in archive.namelist()}
    return member(archive, inside if folder and inside.lstrip("./").casefold() in there else link, limit, ".x3p")


def _matrix(
    archive: zipfile.ZipFile, folder: str, root: ElementTree.Element, kind: str, rows: int, cols: int
) -> np.ndarray:
    link = _value(root, "Record3/DataLink/PointDataLink")
    if not link:
        points = [point.text or "" for point in root.iterfind("Record3/DataList/Datum")]
        if len(points) != rows * cols:
            raise ScanError(f"The .x3p file lists {len(points)} of {rows * cols} points; export it again.")
        return np.array([number(p, "Datum") if p.strip() else np.nan for p in points]).reshape(rows, cols)
    item = np.dtype(_TYPES[kind]).itemsize
    raw = _linked(archive, folder, link, rows * cols * item)
    if len(raw) < rows * cols * item:
        raise ScanError(ENDS_EARLY)
    wanted = _value(root, "Record3/DataLink/MD5ChecksumPointData").lower()
    if wanted and wanted != hashlib.md5(raw, usedforsecurity=False).hexdigest():
        raise ScanError("The .x3p file's points do not match their checksum; copy or export it again.")
    return np.frombuffer(raw, _TYPES[kind], rows * cols).reshape(rows, cols)


def _bits(raw: bytes, rows: int, cols: int) -> np.ndarray:
    if 8 * len(raw) < rows * cols:
        raise ScanError(ENDS_EARLY)
    return (
        np.unpackbits(np.frombuffer(raw, np.uint8), count=rows * cols, bitorder="little")
        .reshape(rows, cols)
        .astype(bool)
    )


def _value(root: ElementTree.Element, path: str) -> str:
    element = root.find(path)
    return (element.text or "").strip() if element is not None else ""
