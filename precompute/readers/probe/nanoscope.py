# SPDX-License-Identifier: GPL-3.0-or-later
r"""Nanoscope files of Digital Instruments, Veeco and Bruker (.spm, .000 to .999, .di).

A text header of sections (``\*Ciao image list``) and keys (``\Samps/line: 256``), then one block
of integers for each image, bottom row first. Heights are ``raw * hard / 2^(8 bytes) * sensitivity``:
``\@2:Z scale: V [Sens. Zsens] (0.005 V/LSB) 330 V`` names the sensitivity, which stands in the
scanner or scan list as ``\@Sens. Zsens: V 34.6 nm/V``.

The slow axis: the size that the image gives for it where that differs from the fast one's, else the
scan's ``Slow Axis Size``. Where neither is there, or the image has fewer lines than the scan was set
up for, the image's ``Aspect Ratio`` says that the axis is shorter, and the numbers of lines by how much
(as Gwyddion reads it; the ratio itself is not always true).
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix
from ..common.channel import Channel, Samples
from ..common.units import metres_per

_LONGEST_HEADER = 4 << 20
_VERSION_32_BIT = 0x09200000
_FILE_LISTS = ("file list", "ec file list")
_SCANNER_LISTS = ("scanner list", "microscope list")
_SCAN_LISTS = ("ciao scan list", "afm list", "stm list", "nc afm list")
_IMAGE_LISTS = ("ciao image list", "afm image list", "stm image list", "ncafm image list", "image list")
_VALUE = re.compile(
    r"^(?P<kind>[VCS])\s*(?:\[(?P<soft>[^\]]*)\])?\s*(?:\((?P<lsb>[^()]*(?:\([^()]*\))?[^()]*)\))?(?P<hard>.*)$"
)


def read_nanoscope(path: Path) -> list[Channel]:
    """All images of a Nanoscope file."""
    sections = _sections(read_head(path, _LONGEST_HEADER))
    file_list = _merged(sections, _FILE_LISTS)
    scan = {**_merged(sections, _SCANNER_LISTS), **_merged(sections, _SCAN_LISTS)}
    version = (
        int(file_list.get("version", "0"), 16)
        if re.fullmatch("0x[0-9a-fA-F]{1,8}", file_list.get("version", ""))
        else 0
    )
    if any(keys.get("operating mode") == "Force" for _, keys in sections) or file_list.get("start context") == "FOL":
        raise ScanError("The Nanoscope file holds force curves, no map; export the height image of the scan.")
    metadata = {"instrument": _merged(sections, ("equipment list",)).get("microscope") or "Nanoscope"}
    metadata = {**metadata, "date": file_list.get("date", ""), "version": file_list.get("version", "")}
    channels: list[Channel] = []
    for name, keys in sections:
        if name in _IMAGE_LISTS:
            channels.append(_channel(path, keys, scan, version, metadata, {channel.name for channel in channels}))
    return channels


def _sections(head: bytes) -> list[tuple[str, dict[str, str]]]:
    end = head.lower().find(b"file list end")
    if head.startswith(b"?*"):
        raise ScanError("The Nanoscope file stores its data as text; export it in binary form.")
    if end < 0:
        raise ScanError("The Nanoscope header has no end; copy or export the file again.")
    sections: list[tuple[str, dict[str, str]]] = []
    for line in head[:end].decode("latin-1").splitlines():
        line = line.strip()
        if line.startswith("\\*"):
            sections.append((line[2:].lower(), {}))
        elif line.startswith("\\") and sections:
            key, _, value = line[1:].partition(": ")
            sections[-1][1][key.lower().rstrip(":")] = value.strip()
    return sections


def _merged(sections: list[tuple[str, dict[str, str]]], names: tuple[str, ...]) -> dict[str, str]:
    result: dict[str, str] = {}
    for section, keys in sections:
        if section in names:
            result.update(keys)
    return result


def _channel(
    path: Path, keys: dict[str, str], scan: dict[str, str], version: int, metadata: dict, taken: set[str]
) -> Channel:
    cols, rows = integer(keys.get("samps/line"), "Samps/line"), integer(keys.get("number of lines"), "Number of lines")
    offset, length = integer(keys.get("data offset"), "Data offset"), integer(keys.get("data length"), "Data length")
    bytes_per_pixel = integer(keys.get("bytes/pixel", "2"), "Bytes/pixel")
    if bytes_per_pixel not in (2, 4):
        raise ScanError(f"The Nanoscope file holds {bytes_per_pixel} bytes a pixel; only 2 and 4 are understood.")
    stored = 4 if version >= _VERSION_32_BIT and length >= 4 * rows * cols else bytes_per_pixel
    size_x, size_y = _sizes(keys, scan, rows, cols)
    if 0 < length < stored * rows * cols and cols > 0:  # a scan that was stopped: fewer lines than asked for
        size_y *= length // (stored * cols) / max(rows, 1)
        rows = length // (stored * cols)
    if offset + stored * rows * cols > path.stat().st_size:
        raise ScanError("The Nanoscope file ends before all of its images; copy or export it again.")
    per_count, unit = _scale(keys, scan, bytes_per_pixel)
    name = _name(keys)
    if name in taken:
        name = f"{name} ({keys.get('line direction', 'second')})"

    def load() -> Samples:
        counts = read_matrix(path, f"<i{stored}", rows, cols, offset)
        details = {"line_direction": keys.get("line direction", ""), "fast_axis": "x"}
        return Samples(
            counts, (size_x, size_y), metadata={**metadata, **details}, decode=partial(np.multiply, per_count)
        )

    return Channel(name, unit, load)


def _name(keys: dict[str, str]) -> str:
    match = _VALUE.match(keys.get("@2:image data", keys.get("@3:image data", "")))
    if match is None:
        return keys.get("image data", "").strip('" ') or "Image"
    return match["hard"].strip().strip('"') or (match["soft"] or "").strip() or "Image"


def _sizes(keys: dict[str, str], scan: dict[str, str], rows: int, cols: int) -> tuple[float, float]:
    """Side lengths in metres of an image of so many lines."""
    value = keys.get("scan size") or scan.get("scan size", "")
    lengths = _lengths(value)
    if not lengths:
        raise ScanError(f"The Nanoscope header gives the scan size '{value[:40]}', which is no length.")
    x, y = lengths[0], lengths[-1]
    lines = _whole(scan.get("lines"))
    slow = _lengths(scan.get("slow axis size", ""))
    fast = _lengths(scan.get("scan size", ""))
    if slow and slow[0] > 0:
        # The scan's own pair; the image's is square even where the scan is not.
        x, y = (fast or lengths)[0], slow[0]
        if 0 < rows < lines and _not_square(keys):
            y *= rows / lines
    elif y == x and rows > 0 and cols > 0 and _not_square(keys):
        if _not_square(scan):
            y *= rows / cols
        elif lines > 0:
            y *= rows / lines
    return x, y


def _lengths(value: str) -> list[float]:
    """The lengths of ``15 15 ~m`` or ``10000 nm`` in metres; empty where they are none."""
    pieces = value.split()
    factor = metres_per(pieces[-1]) if len(pieces) > 1 else None
    return [] if factor is None else [number(piece, "Scan Size") * factor for piece in pieces[:-1]]


def _whole(value: str | None) -> int:
    return int(value) if value is not None and re.fullmatch(r"\d{1,9}", value) else 0


def _not_square(keys: dict[str, str]) -> bool:
    """Whether ``Aspect Ratio`` is there and another than 1:1; it is written ``2:1`` or ``0.5``."""
    match = re.match(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(?::\s*(\d+(?:\.\d*)?|\.\d+))?", keys.get("aspect ratio", "")[:80])
    if match is None:
        return False
    first, second = float(match[1]), float(match[2] or 1)
    return first > 0 and second > 0 and abs(first / second - 1) > 1e-9


def _scale(keys: dict[str, str], scan: dict[str, str], bytes_per_pixel: int) -> tuple[float, str]:
    """Value of one count, and its unit."""
    entry = keys.get("@4:z scale", keys.get("@2:z scale", ""))
    match = _VALUE.match(entry)
    if match is None:
        raise ScanError("The Nanoscope header has no '@2:Z scale' (software 4.2 and older); export it as .gwy or .gsf.")
    pieces = match["hard"].split()
    hard = number(pieces[0] if pieces else None, "Z scale") / 256.0**bytes_per_pixel
    hard_unit = " ".join(pieces[1:])
    sensitivity = _VALUE.match(scan.get("@" + (match["soft"] or "").strip().lower(), ""))
    if sensitivity is not None:
        pieces = sensitivity["hard"].split()
        factor = number(pieces[0] if pieces else None, match["soft"])
        unit, slash, per = " ".join(pieces[1:]).partition("/")
        stored, sensed = _volts(hard_unit), _volts(per)
        if slash and stored is not None and sensed is not None:
            return hard * stored / sensed * factor, unit
        if slash and per.strip() == hard_unit:
            return hard * factor, unit
        if not slash:
            return hard * factor, hard_unit or "arb"
    return hard, hard_unit or "arb"


def _volts(unit: str) -> float | None:
    return {"V": 1.0, "mV": 1e-3, "uV": 1e-6, "kV": 1e3}.get(unit.strip())
