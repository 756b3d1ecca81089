# SPDX-License-Identifier: GPL-3.0-or-later
"""Scans in a scene: stored as .gsf beside the tables made from them."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ...precompute.errors import ScanError
from ...precompute.files.atomic import atomic_path
from ...precompute.readers import read_scan
from ...precompute.scan import orientation
from ...precompute.scan.gsf import write_gsf
from ...precompute.scan.heightfield import HeightField
from ...precompute.scan.info import scan_info
from .. import paths
from ..jobs.job import Progress
from . import recipe

#: In the header of every .gsf that is written here, hardly in others.
_MARK = b"\nProcessing = "


@dataclass(frozen=True)
class Placement:
    """How a scan is turned before it is stored: mirrored first, then turned anticlockwise by quarters."""

    flip_x: bool = False
    flip_y: bool = False
    quarter_turns: int = 0

    @property
    def changes(self) -> bool:
        """Whether it does anything."""
        return self.flip_x or self.flip_y or self.quarter_turns % 4 != 0

    def apply(self, field: HeightField) -> HeightField:
        """The field, placed."""
        if self.flip_x:
            field = orientation.flip_x(field)
        if self.flip_y:
            field = orientation.flip_y(field)
        return orientation.rotate90(field, self.quarter_turns)


@dataclass(frozen=True)
class Stored:
    """A scan that was read, with what a scene is told of it.

    Parameters
    ----------
    path
        The stored .gsf.
    source, reading, sha256
        What to bake: a file, how to read it, and its hash.
    info
        One line for the panel.
    imported
        The user's own file and how it was read, to read it again otherwise; empty where there is none.
    channels
        Names of its channels.
    """

    path: Path
    source: Path
    reading: dict[str, Any]
    sha256: str
    info: str
    imported: dict[str, Any]
    channels: list[str]


def import_scan(
    folder: Path,
    path: Path,
    size_m: tuple[float, float] | None,
    height_m: float | None,
    channel: str | None,
    placement: Placement = Placement(),
    progress: Progress = lambda stage, fraction: None,
    trusted: bool = False,
) -> Stored:
    """Read a scan and store it as .gsf; touches nothing of Blender, so that a thread may do it.

    ``trusted`` takes sizes and heights from the file that are refused otherwise (`read_scan`'s ``trust_units``).

    Raises
    ------
    DiffractionError
        Any of the readers' and of writing; nothing is written then.
    """
    progress("read", 0.0)
    field = read_scan(path, size_m=size_m, height_m=height_m, channel=channel, trust_units=trusted)
    progress("turn", 0.6)
    field = placement.apply(field)
    as_it_is = path.suffix.lower() == ".gsf" and size_m is None and height_m is None and not placement.changes
    progress("store", 0.7)
    target = _store(folder, path.stem, field, path if as_it_is else None)
    reading = {"size_m": size_m, "height_m": height_m, "channel": channel}
    reading = {key: value for key, value in reading.items() if value is not None}
    if trusted:
        reading["trust_units"] = True
    imported = {"path": str(path.resolve()), **reading}
    channels = field.metadata.get("channels", [])
    if placement.changes:  # the original lies otherwise
        return Stored(target, target, {}, recipe.file_sha256(target), _info(field), imported, channels)
    return Stored(target, path.resolve(), reading, field.metadata["sha256"], _info(field), imported, channels)


def store_preset(
    folder: Path, name: str, make: Callable[[], HeightField], progress: Progress = lambda stage, fraction: None
) -> Stored:
    """Store a generated heightfield as .gsf; touches nothing of Blender."""
    progress("make", 0.0)
    field = make()
    progress("store", 0.8)
    return stored(_store(folder, name, field, None))


def stored(path: Path) -> Stored:
    """A scan that was stored before.

    Raises
    ------
    DiffractionError
        If it cannot be read.
    """
    field = read_scan(path, trust_units=True)  # it was asked about when it was imported
    return Stored(path, path, {}, field.metadata["sha256"], _info(field), {}, [])


def adopt(scene: bpy.types.Scene, scan: Stored) -> None:
    """Make a stored scan the scene's."""
    properties = scene.diffraction
    properties.scan_path = paths.relative(scan.path)
    properties.source_path = str(scan.source)
    properties.source_sha256 = scan.sha256
    properties.reading = json.dumps(scan.reading)
    properties.scan_info = scan.info
    properties.imported = json.dumps(scan.imported) if scan.imported else ""
    properties.channels = json.dumps(scan.channels) if scan.channels else ""
    properties.table_name = ""


def stored_scans() -> list[Path]:
    """Scans in the folder of this file."""
    folder = paths.data_folder()
    return sorted(folder.glob("*.gsf")) if folder.is_dir() else []


def bring_here(scene: bpy.types.Scene) -> None:
    """Copy the scene's stored scan to where its table will be, if it lies elsewhere (the .blend was saved in between).

    Raises
    ------
    ScanError
        If the stored scan is gone.
    """
    properties = scene.diffraction
    stored = paths.absolute(properties.scan_path)
    folder = paths.data_folder()
    if not stored.is_file():
        source = Path(properties.source_path)
        if source.is_file() and recipe.file_sha256(source) == properties.source_sha256:
            return
        raise ScanError(f"The stored scan {stored} is gone and so is its origin; import it again.")
    if stored.parent != folder:
        target = _free(folder, stored.stem, stored.read_bytes())
        _copy(stored, target)
        if Path(properties.source_path) == stored:
            properties.source_path = str(target)
        properties.scan_path = paths.relative(target)


def _store(folder: Path, stem: str, field: HeightField, as_it_is: Path | None) -> Path:
    """Write a field (or copy a .gsf byte for byte, so that its hash and its table's sidecar stay) under a free name."""
    with atomic_path(folder / f"{stem}.new.gsf") as temporary:
        if as_it_is is None:
            write_gsf(field, temporary)
        else:
            shutil.copyfile(as_it_is, temporary)
        content = temporary.read_bytes()
    made = folder / f"{stem}.new.gsf"
    try:
        target = _free(folder, stem, content)
        _copy(made, target)
    finally:
        made.unlink(missing_ok=True)
    return target


def _copy(source: Path, target: Path) -> None:
    if not target.is_file() or not target.samefile(source):
        with atomic_path(target) as temporary:
            shutil.copyfile(source, temporary)


def _free(folder: Path, stem: str, content: bytes) -> Path:
    """Where to store a scan: over a file of the same bytes, or over one of ours without a table, else a new number."""
    number = 0
    while True:
        target = folder / (f"{stem}.gsf" if not number else f"{stem}_{number}.gsf")
        if not target.exists():
            return target
        there = target.read_bytes()
        if there == content or (not target.with_suffix(".exr").exists() and _MARK in there[:4096]):
            return target
        number += 1


def _info(field: HeightField) -> str:
    info = scan_info(field)
    x, y = (size * 1e6 for size in info["size_m"])
    rows, columns = info["shape"]
    heights = (info["z_max_m"] - info["z_min_m"]) * 1e9
    missing = f", {info['missing']} missing" if info["missing"] else ""
    # A line of the panel each.
    notes = "".join(f", {note.replace(', ', '; ')}" for note in field.metadata.get("notes", ()))
    return f"{columns} x {rows} px, {x:.4g} x {y:.4g} um, {heights:.4g} nm high{missing}{notes}"


def bake_source(scene: bpy.types.Scene) -> tuple[Path, dict[str, Any]]:
    """The file to bake and how to read it, see `recipe.scan_of`."""
    made = json.loads(recipe.make(scene.diffraction))
    return recipe.scan_of(made, paths.absolute(scene.diffraction.scan_path).parent)
