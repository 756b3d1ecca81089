# SPDX-License-Identifier: GPL-3.0-or-later
"""What stands at a table's path, cheap enough for every redraw of a panel."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...precompute.constants import TABLE_FORMAT_VERSION, TABLE_FORMATS
from ...precompute.errors import TableError
from ...precompute.files.stamp import file_stamp
from ...precompute.table.importance import HEIGHT, WIDTH
from ...precompute.table.layout import TableLayout
from ...precompute.table.table import read_sidecar

NONE, READY, MISSING, OLD, DAMAGED = "NONE", "READY", "MISSING", "OLD", "DAMAGED"


@dataclass(frozen=True)
class TableState:
    """State of a table.

    Parameters
    ----------
    kind
        ``NONE`` (no path), ``READY``, ``MISSING`` (a file is not there), ``OLD`` (of another format
        version) or ``DAMAGED``.
    text
        One sentence for people where it is not ready.
    layout, info
        Of a ready table: its layout and its sidecar.
    """

    kind: str
    text: str = ""
    layout: TableLayout | None = None
    info: dict[str, Any] = field(default_factory=dict)

    @property
    def texture_bytes(self) -> int:
        """Texture memory of the table and of the image that directs rays; 0 where it is not ready."""
        if self.layout is None:
            return 0
        return texture_bytes(self.layout.texel_bytes)

    @property
    def summary(self) -> str:
        """Numbers of a ready table in a line."""
        if self.layout is None:
            return ""
        return f"{self.texture_bytes / 1e6:.0f} MB of texture, {self.info.get('terms', 0)} terms"


def texture_bytes(texel_bytes: int) -> int:
    """Texture memory of a table of so many bytes, with the image that directs rays: floats, RGB padded to RGBA."""
    return texel_bytes + WIDTH * HEIGHT * 16


_seen: dict[Path, tuple[tuple, TableState]] = {}


def table_state(path: Path | None) -> TableState:
    """Look at a table; its files are read again only when they changed."""
    if path is None:
        return TableState(NONE)
    path = Path(path).with_suffix(".exr")
    stamp = (file_stamp(path), file_stamp(path.with_suffix(".json")))
    held = _seen.get(path)
    if held is None or held[0] != stamp:
        if len(_seen) > 256:
            _seen.clear()
        held = _seen[path] = (stamp, _look(path, stamp))
    return held[1]


def _look(path: Path, stamp: tuple) -> TableState:
    for there, name in zip(stamp, (path.name, path.with_suffix(".json").name), strict=True):
        if there is None:
            return TableState(MISSING, f"{name} is not in {path.parent}")
    try:
        sidecar = read_sidecar(path)
        return TableState(READY, "", TableLayout.from_dict(sidecar["layout"]), sidecar)
    except TableError as error:
        version = _version(path)
        if version is not None and version not in TABLE_FORMATS:
            text = f"{path.name} was baked by another release (format {version}, now {TABLE_FORMAT_VERSION})"
            return TableState(OLD, text)
        return TableState(DAMAGED, str(error).partition(";")[0])
    except (KeyError, TypeError, ValueError):
        return TableState(DAMAGED, f"The sidecar of {path.name} is damaged")


def _version(path: Path) -> Any:
    try:
        sidecar = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
        return sidecar.get("format_version")
    except (OSError, ValueError, AttributeError):
        return None
