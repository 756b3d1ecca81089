# SPDX-License-Identifier: GPL-3.0-or-later
"""The spectral table: T(u, v, w) in XYZ, as an EXR atlas and a JSON sidecar."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..constants import TABLE_FORMAT_VERSION, TABLE_FORMATS
from ..errors import ParameterError, TableError
from ..files.atomic import atomic_path
from ..files.exr import read_half_rgb, read_text, write_half_rgb
from ..light.colour import table_light
from ..light.illuminant import Illuminant, illuminant_of
from .layout import TableLayout


@dataclass(eq=False)
class SpectralTable:
    """A baked table and all that is known of its origin.

    Parameters
    ----------
    layout
        Coordinates and atlas geometry.
    atlas
        ``(height, width, 3)`` float16, XYZ texels, row 0 at the *bottom*.
    info
        The sidecar's other entries: ``parameters``, ``source``, ``colour``, ``terms``, ``albedo_max``.
    """

    layout: TableLayout
    atlas: np.ndarray
    info: dict[str, Any] = field(default_factory=dict)

    def transform(self, u: np.ndarray, v: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Look T(u, v, w) up as the shaders do: two bilinear lookups and a linear blend.

        Parameters
        ----------
        u, v, w
            Arrays that broadcast against each other; ``(u, v, w) = -(wi + wr)``.

        Returns
        -------
        ndarray
            ``(..., 3)`` float64 XYZ in 1/sr.
        """
        u, v, w = np.broadcast_arrays(*(np.asarray(x, np.float64) for x in (u, v, w)))
        layout = self.layout
        column = layout.column(np.hypot(u, v))
        row = layout.row(np.arctan2(v, u))
        position = layout.slice_coordinate(w)
        lower = np.minimum(position.astype(int), layout.n_w - 2)
        blend = (position - lower)[..., None]
        value = (1.0 - blend) * self._slice(lower, column, row) + blend * self._slice(lower + 1, column, row)
        return value * (layout.scale * layout.gain(w))[..., None]

    def _slice(self, index: np.ndarray, column: np.ndarray, row: np.ndarray) -> np.ndarray:
        x = (index % self.layout.tile_columns) * self.layout.n_r + column
        y = (index // self.layout.tile_columns) * self.layout.tile_height + 1.0 + row
        return self._bilinear(x, y)

    def _bilinear(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Atlas values at texel-centre coordinates (x, y)."""
        left = np.clip(x.astype(int), 0, self.layout.width - 2)
        below = np.clip(y.astype(int), 0, self.layout.height - 2)
        fx, fy = (x - left)[..., None], (y - below)[..., None]
        texels = self.atlas.reshape(-1, 3)
        at = below * self.layout.width + left
        low = np.take(texels, at, axis=0) * (1.0 - fx)
        low += np.take(texels, at + 1, axis=0) * fx
        at += self.layout.width
        high = np.take(texels, at, axis=0) * (1.0 - fx)
        high += np.take(texels, at + 1, axis=0) * fx
        return low * (1.0 - fy) + high * fy

    def albedo(self, directions: np.ndarray) -> np.ndarray:
        """Directional albedo a(theta, phi) with R = 1: the largest of X, Y, Z relative to white.

        Parameters
        ----------
        directions
            ``(..., 3)`` unit vectors in the local frame.
        """
        return self._albedo(directions, self.layout.albedo_y)

    def conserving_albedo(self, directions: np.ndarray) -> np.ndarray:
        """What the energy-conserving form divides by, where it passes 1: so that no wavelength's albedo does.

        Parameters
        ----------
        directions
            ``(..., 3)`` unit vectors in the local frame.
        """
        return self._albedo(directions, self.layout.conserving_y)

    def _albedo(self, directions: np.ndarray, first: int) -> np.ndarray:
        directions = np.asarray(directions, np.float64)
        layout = self.layout
        theta = np.arccos(np.clip(directions[..., 2], 0.0, 1.0))
        phi = np.arctan2(directions[..., 1], directions[..., 0])
        column = theta * ((layout.n_theta - 1) / (0.5 * np.pi))
        row = np.mod(phi * (layout.n_albedo_phi / (2.0 * np.pi)), layout.n_albedo_phi)
        return self._bilinear(column, first + 1.0 + row)[..., 0]

    @property
    def format_version(self) -> int:
        """Version of the files: that of this release, or 1 for a table that was read in that version."""
        return TABLE_FORMAT_VERSION if self.layout.guarded else 1

    @property
    def light(self) -> Illuminant:
        """The light whose white the colours are relative to: D65 where they were adapted to it, else the bake's own."""
        return table_light(self.info["colour"])

    @property
    def has_stack(self) -> bool:
        """Whether the reflectance of the surface's stuff is inside."""
        return self.info.get("stack") is not None

    @property
    def stuff(self) -> dict[str, Any]:
        """What a command says of stack (in words, with notes) and lacquer; what is not there is left out."""
        stack, lacquer = self.info.get("stack"), self.info.get("lacquer")
        said: dict[str, Any] = {} if stack is None else {"stack": stack["text"], "notes": list(stack["notes"])}
        return said if lacquer is None else {**said, "lacquer": dict(lacquer)}

    @property
    def index(self) -> float:
        """Refractive index of the lacquer over the relief; 1 for air."""
        lacquer = self.info.get("lacquer")
        return 1.0 if lacquer is None else float(lacquer["n"])

    def reflectance(self, cosine: np.ndarray) -> np.ndarray:
        """``(..., 3)`` XYZ, 1 as white: what stack and lacquer keep from below towards a view at this cosine.

        0 for a table without them.
        """
        cosine = np.asarray(cosine, np.float64)
        layout = self.layout
        if not layout.n_reflectance:
            return np.zeros((*cosine.shape, 3))
        column = np.arccos(np.clip(cosine, 0.0, 1.0)) * ((layout.n_reflectance - 1) / (0.5 * np.pi))
        return self._bilinear(column, np.full_like(column, layout.reflectance_y))

    @property
    def headroom(self) -> tuple[float, float]:
        """Largest Scale and Depth of a painted surface for which the table holds every direction."""
        return self.layout.headroom

    @property
    def albedo_max(self) -> float:
        """Largest entry of what the energy-conserving form divides by."""
        return float(self.info["albedo_max"])

    def save(self, path: str | Path) -> Path:
        """Write ``path`` (``.exr``) and its ``.json`` sidecar, each atomically.

        Both are written in full before either takes its place. The atlas carries the sidecar's text in its
        header: a process that dies between the two renames leaves an old atlas beside a new sidecar, and
        :func:`read_sidecar` then takes the header's, so a reader meets the old table or the new one,
        never a mixture.

        Returns
        -------
        Path
            The EXR's path.

        Raises
        ------
        OutputError
            If the folder cannot be written.
        """
        path = Path(path).with_suffix(".exr")
        text = self._sidecar(path.name)
        with atomic_path(path) as atlas, atomic_path(path.with_suffix(".json")) as sidecar:
            write_half_rgb(atlas, self.atlas, text)
            Path(sidecar).write_text(text, encoding="utf-8", newline="\n")
        return path

    def save_atlas(self, path: str | Path) -> Path:
        """Write the atlas alone, with its description in the header; :meth:`load_atlas` reads it.

        Raises
        ------
        OutputError
            If the folder cannot be written.
        """
        path = Path(path).with_suffix(".exr")
        with atomic_path(path) as temporary:
            write_half_rgb(temporary, self.atlas, self._sidecar(path.name))
        return path

    def _sidecar(self, file: str) -> str:
        """The sidecar's text for an atlas of that file name."""
        sidecar = {
            "format_version": self.format_version,
            "layout": self.layout.to_dict(),
            "atlas": {"file": file, "sha256": _pixels_sha256(self.atlas)},
            **self.info,
        }
        return json.dumps(sidecar, indent=1, sort_keys=True, allow_nan=False) + "\n"

    @classmethod
    def load(cls, path: str | Path, verify: bool = True) -> SpectralTable:
        """Read a table by the path of its ``.exr`` or ``.json``.

        Raises
        ------
        TableError
            If a file is missing, damaged, of another version, or the two do not belong together.
        """
        path = Path(path).with_suffix(".exr")
        return cls._load(path, read_sidecar(path), verify)

    @classmethod
    def load_atlas(cls, path: str | Path) -> SpectralTable:
        """Read a table by its atlas alone, from the description in the header.

        Raises
        ------
        TableError
            If the file is missing, damaged or of another version.
        """
        path = Path(path).with_suffix(".exr")
        return cls._load(path, _parse(read_text(path), path.name), verify=True)

    @classmethod
    def _load(cls, path: Path, sidecar: dict[str, Any], verify: bool) -> SpectralTable:
        layout = TableLayout.from_dict(sidecar["layout"])
        atlas = read_half_rgb(path, layout.width, layout.height)
        if verify and _pixels_sha256(atlas) != sidecar["atlas"].get("sha256"):
            raise TableError(f"{path.name} is damaged or has another table's sidecar; bake the scan again.")
        return cls(layout, atlas, {k: v for k, v in sidecar.items() if k not in ("format_version", "layout", "atlas")})


def read_sidecar(path: str | Path) -> dict[str, Any]:
    """The sidecar of a table (path of either file), its version checked.

    Raises
    ------
    TableError
        If a file is missing, the sidecar is no JSON or of another format version, or the atlas is no EXR.
    """
    path = Path(path).with_suffix(".json")
    atlas = path.with_suffix(".exr")
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise TableError(f"The table's sidecar {path} does not exist; bake the scan again.") from error
    except (OSError, ValueError) as error:
        raise TableError(f"The table's sidecar {path} cannot be read; bake the scan again.") from error
    sidecar = _parse(text, path.name)
    if not atlas.is_file():
        raise TableError(f"The table's atlas {atlas} does not exist; bake the scan again.")
    inside = read_text(atlas)
    # A bake that ended between its two files left the older sidecar.
    return _parse(inside, atlas.name) if inside and inside != text else sidecar


def _parse(text: str, name: str) -> dict[str, Any]:
    """A sidecar's text as a dict of this format version."""
    try:
        sidecar = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise TableError(f"The table's sidecar {name} is no JSON; bake the scan again.") from error
    version = sidecar.get("format_version") if isinstance(sidecar, dict) else None
    if version not in TABLE_FORMATS or isinstance(version, bool):
        raise TableError(
            f"{name} is a table of format version {repr(version)[:20]}, this release reads versions"
            f" {' and '.join(map(str, TABLE_FORMATS))}; bake the scan again."
        )
    if not all(isinstance(sidecar.get(part), dict) for part in ("layout", "atlas", "parameters", "source", "colour")):
        raise TableError(f"The table's sidecar {name} lacks one of its parts; bake the scan again.")
    if ("guarded" in sidecar["layout"]) != (version > 1):
        raise TableError(f"The table's sidecar {name} contradicts itself about its version; bake the scan again.")
    albedo, terms = sidecar.get("albedo_max"), sidecar.get("terms")
    if not (isinstance(albedo, int | float) and 0.0 <= albedo < math.inf and isinstance(terms, int)):
        raise TableError(f"The table's sidecar {name} holds impossible numbers; bake the scan again.")
    try:
        illuminant_of(sidecar["colour"].get("illuminant"))
    except ParameterError as error:
        raise TableError(f"The table's sidecar {name} names no known illuminant; bake the scan again.") from error
    return sidecar


def _pixels_sha256(atlas: np.ndarray) -> str:
    return hashlib.sha256(np.ascontiguousarray(atlas, "<f2").data).hexdigest()
