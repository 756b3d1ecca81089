# SPDX-License-Identifier: GPL-3.0-or-later
"""How a table was made, kept with the scene and with each material, so that it can be made again.

A scan lies beside the tables made from it. A recipe therefore names it without a folder: wherever the
material's table belongs, there the scan is looked for.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import bpy

from ...precompute.errors import ScanError
from . import bake_settings

#: Custom property of the materials' groups that holds the recipe of their table.
KEY = "diffraction_recipe"


def make(state: Any) -> str:
    """The recipe of the table that the scene's scan and settings give, as JSON."""
    return json.dumps(
        {
            "scan": Path(state.scan_path.replace("//", "")).name,
            "source": state.source_path,
            "sha256": state.source_sha256,
            "reading": state.reading or "{}",
            "info": state.scan_info,
            "settings": bake_settings.remember(state),
        },
        sort_keys=True,
    )


def of(owner: bpy.types.ID) -> dict[str, Any]:
    """The recipe of the table of a group or a material; empty where it has none."""
    try:
        return dict(json.loads(owner.get(KEY, "{}")))
    except ValueError:
        return {}


def scan_of(recipe: dict[str, Any], folder: Path) -> tuple[Path, dict[str, Any]]:
    """The file to bake and how to read it.

    The original gives the same bits as the command line does; the stored copy, which has its
    heights in 32 bits, takes its place once the original is gone or has changed.

    Raises
    ------
    ScanError
        If neither is there.
    """
    source = Path(recipe.get("source", ""))
    if source.is_file() and file_sha256(source) == recipe.get("sha256"):
        reading = json.loads(recipe.get("reading") or "{}")
        if "size_m" in reading:
            reading["size_m"] = tuple(reading["size_m"])
        # Sizes and heights were asked about when the scan was imported.
        reading["trust_units"] = True
        return source, reading
    name = recipe.get("scan", "")
    stored = folder / name
    if not name or not stored.is_file():
        raise ScanError(
            f"The scan {name or 'of this table'} is neither in {folder} nor at its origin; import it again."
        )
    return stored, {"trust_units": True}


def file_sha256(path: Path) -> str:
    """Of a file's bytes."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
