# SPDX-License-Identifier: GPL-3.0-or-later
r"""Nanoscope files of Digital Instruments, Veeco and Bruker (.spm, .000 to .999, .di).

A text header of sections (``\*Ciao image list``) and keys (``\Samps/line: 256``), then one block
of integers for each image, bottom row first. Heights are ``raw * hard / 2^(8 bytes) * sensitivity``:
``\@2:Z scale: V [Sens. Zsens] (0.005 V/LSB) 330 V`` names the sensitivity, which stands in the
scanner or scan list as ``\@Sens. Zsens: V 34.6 nm/V``.
"""

from __future__ import annotations

import re
from pathlib import Path

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix
from ..common.channel import Channel, Samples
from ..common.units import metres_per

_LONGEST_HEADER = 4 << 20
_VERSION_32_BIT = 0x09200000
_VALUE = re.compile(
    r"^(?P<kind>[VCS])\s*(?:\[(?P<soft>[^\]]*)\])?\s*(?:\((?P<lsb>[^()]*(?:\([^()]*\))?[^()]*)\))?(?P<hard>.*)$"
)


def read_nanoscope(path: Path) -> list[Channel]:
    """All images of a Nanoscope file."""
    sections = _sections(read_head(path, _LONGEST_HEADER))
    file_list = _merged(sections, "file list")
    scan = {**_merged(sections, "scanner list"), **_merged(sections, "ciao scan list")}
    version = (
        int(file_list.get("version", "0"), 16)
        if re.fullmatch("0x[0-9a-fA-F]{1,8}", file_list.get("version", ""))
        else 0
    )
    metadata = {"instrument": _merged(sections, "equipment list").get("microscope") or "Nanoscope"}
    metadata = {**metadata, "date": file_list.get("date", ""), "version": file_list.get("version", "")}
    channels: list[Channel] = []
    for name, keys in sections:
        if name.endswith("image list"):
            channels.append(_channel(path, keys, scan, version, metadata, {channel.name for channel in channels}))
    return channels


def _sections(head: bytes) -> list[tuple[str, dict[str, str]]]:
    end = head.lower().find(b"\\*file list end")
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


def _merged(sections: list[tuple[str, dict[str, str]]], name: str) -> dict[str, str]:
    result: dict[str, str] = {}
    for section, keys in sections:
        if section == name:
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
    size_x, size_y = _sizes(keys.get("scan size", ""), scan)
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
        values = read_matrix(path, f"<i{stored}", rows, cols, offset) * per_count
        details = {"line_direction": keys.get("line direction", ""), "fast_axis": "x"}
        return Samples(values, (size_x, size_y), metadata={**metadata, **details})

    return Channel(name, unit, load)


def _name(keys: dict[str, str]) -> str:
    match = _VALUE.match(keys.get("@2:image data", keys.get("@3:image data", "")))
    if match is None:
        return keys.get("image data", "").strip('" ') or "Image"
    return match["hard"].strip().strip('"') or (match["soft"] or "").strip() or "Image"


def _sizes(value: str, scan: dict[str, str]) -> tuple[float, float]:
    """Side lengths in metres from ``15 15 ~m`` or ``10000 nm``."""
    pieces = value.split()
    factor = metres_per(pieces[-1]) if len(pieces) > 1 else None
    if factor is None:
        raise ScanError(f"The Nanoscope header gives the scan size '{value[:40]}', which is no length.")
    x = number(pieces[0], "Scan Size") * factor
    y = number(pieces[1], "Scan Size") * factor if len(pieces) > 2 else x
    slow = scan.get("slow axis size", "").split()
    if len(slow) == 2 and (slow_factor := metres_per(slow[1])) is not None:
        y = number(slow[0], "Slow Axis Size") * slow_factor
    return x, y


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
