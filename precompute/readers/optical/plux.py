# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensofar's archives (.plux): a zip of ``index.xml`` and layers of float32 micrometres, top row first, NaN missing.

``GENERAL/IMAGE_SIZE_X`` and ``_Y`` give the pixels, ``GENERAL/FOV_X`` and ``_Y`` their side in micrometres,
``LAYER_n/FILENAME_Z`` the heights of a layer.
"""

from __future__ import annotations

import zipfile
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.archive import LONGEST_XML, member, xml_root
from ..common.binary import ENDS_EARLY, integer, number
from ..common.channel import Channel, Samples
from ..common.limits import check_loaded, check_shape

_MOST_LAYERS = 256


def read_plux(path: Path) -> list[Channel]:
    """The layers of a .plux file."""
    with zipfile.ZipFile(path) as archive:
        root = xml_root(member(archive, "index.xml", LONGEST_XML, ".plux"), ".plux")

    def value(key: str) -> str:
        return (root.findtext(key) or "").strip()

    cols, rows = (integer(value(f"GENERAL/IMAGE_SIZE_{axis}"), f"IMAGE_SIZE_{axis}") for axis in "XY")
    check_shape(rows, cols)
    check_loaded(rows, cols)
    step_x, step_y = (number(value(f"GENERAL/FOV_{axis}"), f"FOV_{axis}") * 1e-6 for axis in "XY")
    size_m = cols * step_x, rows * step_y
    items = {item.findtext("NAME", "").strip(): item.findtext("VALUE", "").strip() for item in root.findall("INFO/*")}
    metadata = {"instrument": f"Sensofar {items.get('Device', '')}".strip(), "date": value("GENERAL/DATE")}
    files = [value(f"LAYER_{layer}/FILENAME_Z") for layer in range(_MOST_LAYERS)]
    files = [name for name in files if name] or ["LAYER_0.raw"]
    return [
        Channel(
            "Height" if len(files) == 1 else f"Height layer {layer}",
            "um",
            partial(_load, path, name, rows, cols, size_m, metadata),
        )
        for layer, name in enumerate(files)
    ]


def _load(path: Path, name: str, rows: int, cols: int, size_m: tuple[float, float], metadata: dict) -> Samples:
    with zipfile.ZipFile(path) as archive:
        raw = member(archive, name, 4 * rows * cols, ".plux")
    if len(raw) < 4 * rows * cols:
        raise ScanError(ENDS_EARLY)
    values = np.frombuffer(raw, "<f4", rows * cols).reshape(rows, cols)[::-1]
    return Samples(values, size_m, metadata=metadata, decode=np.asarray)
