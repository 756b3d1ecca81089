# SPDX-License-Identifier: GPL-3.0-or-later
"""What a table's sidecar says of it, for people; and whether a table on disk is whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..errors import TableError
from .importance import read_origin
from .table import SpectralTable, read_sidecar


def lost_share(albedo: np.ndarray) -> float:
    """Share of even light that the model does not send out again: steep sides throw it where no single bounce counts.

    Parameters
    ----------
    albedo
        ``(n_phi, n_theta)`` of a raw model with R = 1, polar angles from 0 to a right angle.

    Returns
    -------
    float
        ``1 - integral min(a, 1) cos dw / pi``; nothing is put in its place.
    """
    theta = np.linspace(0.0, 0.5 * np.pi, albedo.shape[1])
    weight = np.sin(2.0 * theta)
    weight[0] = weight[-1] = 0.0
    return float(1.0 - (np.minimum(albedo, 1.0).mean(axis=0) * weight).sum() / weight.sum())


def energy_lines(info: dict[str, Any]) -> list[str]:
    """What was done to the table's energy, a line each without a full stop; none for tables that do not say it."""
    found = info.get("energy")
    if not found:
        return []
    lines = [f"{found['model']}: {100 * found['share_cut']:.1f} % of even light is cut"]
    if "share_lost" in found:
        lines.append(f"{100 * found['share_lost']:.1f} % is lost on steep sides and not refilled")
    return lines


def lookup_lines(info: dict[str, Any]) -> list[str]:
    """The coherence window with what limits it, and the error of lookups; none for tables that do not say it."""
    lines = []
    if window := info.get("coherence"):
        lines.append(f"coherence {1e6 * window['sigma_s_m']:.4g} um ({window['limit']})")
    if error := info.get("error"):
        parts = ", ".join(f"{name} {100 * error[name]:.2g}" for name in ("slices", "radii", "angles"))
        lines.append(f"error {100 * error['reached']:.2g} % of {100 * error['asked']:.2g} % ({parts})")
    return lines


def is_table(path: str | Path) -> bool:
    """Whether a file is one of a table's two."""
    path = Path(path)
    if path.suffix.lower() not in (".exr", ".json"):
        return False
    try:
        read_sidecar(path)
    except TableError:
        return False
    return True


def table_facts(path: str | Path) -> dict[str, Any]:
    """What a table's sidecar says, ready for JSON.

    Raises
    ------
    TableError
        As `read_sidecar`.
    """
    sidecar = read_sidecar(path)
    source, layout = sidecar.get("source", {}), sidecar["layout"]
    return {
        "table": str(Path(path).with_suffix(".exr")),
        "format_version": sidecar["format_version"],
        "scan": source.get("name"),
        "size_m": source.get("size_m"),
        "texels": [layout["width"], layout["height"]],
        "terms": sidecar.get("terms"),
        "albedo_max": sidecar.get("albedo_max"),
        "energy": sidecar.get("energy"),
        "coherence": sidecar.get("coherence"),
        "error": sidecar.get("error"),
    }


def fault(path: str | Path) -> str:
    """What is wrong with a table on disk, a sentence without a full stop; empty where it is whole."""
    path = Path(path).with_suffix(".exr")
    try:
        table = SpectralTable.load(path)
    except TableError as error:
        return str(error).rstrip(".")
    directions = path.with_name(f"{path.stem}.importance.exr")
    origin = read_origin(directions)
    if directions.is_file() and (origin is None or origin[0] != table.info.get("atlas", {}).get("sha256", origin[0])):
        return f"{directions.name} belongs to another table; apply the material again"
    return ""
