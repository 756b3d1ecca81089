# SPDX-License-Identifier: GPL-3.0-or-later
"""Scans in a scene: stored as .gsf, baked from the original while that is unchanged."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import bpy

from ..precompute.atomic import atomic_path
from ..precompute.gsf import write_gsf
from ..precompute.heightfield import HeightField
from ..precompute.readers import read_scan
from ..precompute.scan_info import scan_info
from . import paths


def import_scan(
    scene: bpy.types.Scene, path: Path, size_m: tuple[float, float] | None, height_m: float | None, channel: str | None
) -> HeightField:
    """Read a scan, store it as .gsf and make it the scene's.

    Raises
    ------
    DiffractionError
        Any of the readers' and of writing; the scene is then as before.
    """
    field = read_scan(path, size_m=size_m, height_m=height_m, channel=channel)
    target = paths.data_folder() / f"{path.stem}.gsf"
    unchanged = path.suffix.lower() == ".gsf" and size_m is None and height_m is None
    if not (target.exists() and target.samefile(path)):
        if unchanged:  # byte for byte, so that its hash and so the table's sidecar stay the same
            with atomic_path(target) as temporary:
                shutil.copyfile(path, temporary)
        else:
            write_gsf(field, target)
    reading = {"size_m": size_m, "height_m": height_m, "channel": channel}
    _remember(scene, field, target, path.resolve(), reading)
    return field


def store_preset(scene: bpy.types.Scene, field: HeightField, name: str) -> Path:
    """Store a generated heightfield as .gsf and make it the scene's."""
    target = paths.data_folder() / f"{name}.gsf"
    write_gsf(field, target)
    _remember(scene, read_scan(target), target, target, {})
    return target


def _remember(scene: bpy.types.Scene, field: HeightField, stored: Path, source: Path, reading: dict[str, Any]) -> None:
    info = scan_info(field)
    properties = scene.diffraction
    properties.scan_path = paths.relative(stored)
    properties.source_path = str(source)
    properties.source_sha256 = field.metadata["sha256"]
    properties.reading = json.dumps({key: value for key, value in reading.items() if value is not None})
    x, y = (size * 1e6 for size in info["size_m"])
    rows, columns = info["shape"]
    heights = (info["z_max_m"] - info["z_min_m"]) * 1e9
    missing = f", {info['missing']} missing" if info["missing"] else ""
    properties.scan_info = f"{columns} x {rows} px, {x:.4g} x {y:.4g} um, {heights:.4g} nm high{missing}"


def bake_source(scene: bpy.types.Scene) -> tuple[Path, dict[str, Any]]:
    """The file to bake and how to read it.

    The original gives the same bits as the command line does; the stored copy, which has its
    heights in 32 bits, takes its place once the original is gone or has changed.
    """
    properties = scene.diffraction
    source = Path(properties.source_path)
    if source.is_file() and _sha256(source) == properties.source_sha256:
        reading = json.loads(properties.reading or "{}")
        if "size_m" in reading:
            reading["size_m"] = tuple(reading["size_m"])
        return source, reading
    return paths.absolute(properties.scan_path), {}


def _sha256(path: Path) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
