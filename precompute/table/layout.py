# SPDX-License-Identifier: GPL-3.0-or-later
"""Coordinates of the spectral table and its place in the atlas.

One analytic mapping, the same in Python, OSL, GLSL and shader nodes; see
``docs/architecture.md``, "The spectral table". asinh is linear near zero, where the
specular peak needs an even step of (u, v), and logarithmic beyond, where the colour
matching functions smear every feature over a constant *ratio* of radii.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ..constants import W_MAX
from ..errors import TableError

#: Largest |(u, v)|: light and viewer on the same horizon.
R_MAX = 2.0

#: What the guard texel holds: above 1, mid-grey, negative. An image that was resized, quantised, clipped or converted
#: to another colour space shows other values there. Around it stands nothing.
GUARD = (2.0, 0.5, -0.25)
GUARD_SIDE = 5

#: How far from the guard a renderer's lookup may lie: GPUs place a bilinear lookup to 1 / 256 of a texel.
GUARD_TOLERANCE = 0.05


@dataclass(frozen=True)
class TableLayout:
    """Sizes and mapping constants of a spectral table.

    Parameters
    ----------
    n_r, n_phi, n_w
        Radii, angles and slices.
    r0
        Radius (sine units) where the radial grid turns from linear to logarithmic.
    w0
        The same for |w|; a tiny ``w0`` makes the slices logarithmic.
    w_min
        |w| of slice 0.
    power
        Texels hold ``T / (scale |w|^power)``.
    scale
        Brings the texels into the range of half floats.
    tile_columns
        Tiles side by side in the atlas.
    n_theta, n_albedo_phi
        Size of an albedo tile.
    w_max
        |w| of the last slice: 2, or 2 n under a lacquer of index n.
    n_albedo
        Albedo tiles one above the other: the first for X, Y and Z, the second, where there is one, what a renderer
        divides by so that no wavelength passes 1; what follows is for others than the surface as baked.
    n_reflectance
        Polar angles of the row that holds the reflectance of the surface's stuff; 0 has no such row.
    guarded
        1 where the atlas holds the guard texel; tables of format 1 do not.
    scale_headroom, depth_headroom
        Largest Scale and Depth of a painted surface for which the table still holds every direction: radii reach to
        twice the one, |w| to `w_max` with the other in it.
    """

    n_r: int
    n_phi: int
    n_w: int
    r0: float
    w0: float
    w_min: float
    power: float = 1.0
    scale: float = 1.0
    tile_columns: int = 1
    n_theta: int = 46
    n_albedo_phi: int = 36
    w_max: float = W_MAX
    n_albedo: int = 1
    n_reflectance: int = 0
    guarded: int = 1
    scale_headroom: float = 1.0
    depth_headroom: float = 1.0

    def __post_init__(self) -> None:
        whole = (self.n_r, self.n_phi, self.n_w, self.tile_columns, self.n_theta, self.n_albedo_phi, self.n_albedo)
        if any(not isinstance(n, int) or n < 1 for n in whole) or min(self.n_r, self.n_w, self.n_theta) < 2:
            raise TableError("The table's layout holds sizes that are not positive whole numbers; bake the scan again.")
        if any(not isinstance(n, int) or n < 0 for n in (self.n_reflectance, self.guarded)) or self.guarded > 1:
            raise TableError("The table's layout holds sizes that are not positive whole numbers; bake the scan again.")
        numbers = (self.r0, self.w0, self.w_min, self.power, self.scale, self.w_max, *self.headroom)
        if (
            not all(math.isfinite(x) for x in numbers)
            or min(self.r0, self.w0, self.w_min, self.scale, *self.headroom) <= 0
            or self.w_max <= self.w_min
        ):
            raise TableError("The table's layout holds impossible mapping constants; bake the scan again.")

    # Mapping constants, derived and stored in the sidecar for the shaders.

    @property
    def a_r(self) -> float:
        """Columns per unit of asinh(r / r0)."""
        return (self.n_r - 1) / math.asinh(R_MAX * self.scale_headroom / self.r0)

    @property
    def headroom(self) -> tuple[float, float]:
        """Largest Scale and Depth that the table holds; (1, 1) where it was baked for the surface as it is."""
        return self.scale_headroom, self.depth_headroom

    @property
    def index(self) -> float:
        """Refractive index of what lies over the relief: 1, or that of a lacquer."""
        return self.w_max / (W_MAX * self.depth_headroom)

    @property
    def holds_reflectance(self) -> bool:
        """Whether the surface's stuff (stack, lacquer) is inside: then a renderer has no R of its own."""
        return self.n_reflectance > 0

    @property
    def s_w(self) -> float:
        """asinh(w_min / w0)."""
        return math.asinh(self.w_min / self.w0)

    @property
    def a_w(self) -> float:
        """Slices per unit of asinh(|w| / w0)."""
        return (self.n_w - 1) / (math.asinh(self.w_max / self.w0) - self.s_w)

    # Atlas geometry (texels, y upwards).

    @property
    def tile_rows(self) -> int:
        """Rows of tiles."""
        return -(-self.n_w // self.tile_columns)

    @property
    def tile_height(self) -> int:
        """Texel rows of a tile: the angles and a guard row on either side."""
        return self.n_phi + 2

    @property
    def width(self) -> int:
        """Atlas width."""
        return max(self.tile_columns * self.n_r, self.n_theta, self.n_reflectance, GUARD_SIDE * self.guarded)

    @property
    def albedo_y(self) -> int:
        """First texel row of the albedo tile."""
        return self.tile_rows * self.tile_height

    @property
    def conserving_y(self) -> int:
        """First texel row of the albedo tile that renderers divide by."""
        return self.albedo_y + (self.albedo_height if self.n_albedo > 1 else 0)

    @property
    def albedo_height(self) -> int:
        """Texel rows of an albedo tile with its guard rows."""
        return self.n_albedo_phi + 2

    @property
    def reflectance_y(self) -> int:
        """Texel row of the reflectance; the rows below and above repeat it."""
        return self.albedo_y + self.n_albedo * self.albedo_height + 1

    @property
    def guard_y(self) -> int:
        """Texel row of the guard."""
        return self.reflectance_y - 1 + (3 if self.n_reflectance else 0) + GUARD_SIDE // 2

    @property
    def guard_x(self) -> int:
        """Texel column of the guard."""
        return GUARD_SIDE // 2

    @property
    def height(self) -> int:
        """Atlas height."""
        return self.guard_y - GUARD_SIDE // 2 + GUARD_SIDE * self.guarded

    @property
    def texel_bytes(self) -> int:
        """Bytes of the atlas as a renderer loads it: half floats, four channels (RGB is padded to RGBA)."""
        return self.width * self.height * 8

    # Grids.

    @property
    def radii(self) -> np.ndarray:
        """``(n_r,)`` radii sqrt(u^2 + v^2) of the columns."""
        return self.r0 * np.sinh(np.arange(self.n_r) / self.a_r)

    @property
    def angles(self) -> np.ndarray:
        """``(n_phi,)`` angles of the rows in radians."""
        return np.arange(self.n_phi) * (2.0 * np.pi / self.n_phi)

    @property
    def slices(self) -> np.ndarray:
        """``(n_w,)`` values of |w|."""
        return self.w0 * np.sinh(np.arange(self.n_w) / self.a_w + self.s_w)

    def column(self, r: np.ndarray) -> np.ndarray:
        """Column coordinate of radii ``r``, clamped to the grid."""
        return np.clip(self.a_r * np.arcsinh(np.asarray(r) / self.r0), 0.0, self.n_r - 1.0)

    def row(self, phi: np.ndarray) -> np.ndarray:
        """Row coordinate of angles ``phi`` (radians) in [0, n_phi)."""
        row = np.mod(np.asarray(phi) * (self.n_phi / (2.0 * np.pi)), self.n_phi)
        return np.where(row >= self.n_phi, 0.0, row)

    def slice_coordinate(self, w: np.ndarray) -> np.ndarray:
        """Slice coordinate of |w|, clamped to the grid.

        Seen so flatly that |w| vanishes every surface is a mirror, whose T is the same for all w. Between the first two
        slices the coordinate is therefore that of 1 / |w|, which leaves a constant T as it is.
        """
        w = np.abs(w)
        first = (1.0 - self.w_min / np.maximum(w, self.w_min)) * self.first_share
        coordinate = np.maximum(self.a_w * (np.arcsinh(w / self.w0) - self.s_w), np.minimum(first, 1.0))
        return np.minimum(coordinate, self.n_w - 1.0)

    @property
    def first_share(self) -> float:
        """What ``1 - w_min / |w|`` is multiplied by to be 1 at slice 1."""
        return 1.0 / (1.0 - self.w_min / float(self.slices[1]))

    def gain(self, w: np.ndarray) -> np.ndarray:
        """What texels are multiplied by, but for `scale`: |w|^power, below slice 0 that of slice 0."""
        return np.maximum(np.abs(w), self.w_min) ** self.power

    def tile_origin(self, index: int) -> tuple[int, int]:
        """Texel (x, y) of the lower left corner of slice ``index``, guard row included."""
        return (index % self.tile_columns) * self.n_r, (index // self.tile_columns) * self.tile_height

    def to_dict(self) -> dict[str, float | int]:
        """Everything a shader needs, for the sidecar."""
        derived = {
            name: getattr(self, name) for name in ("a_r", "a_w", "s_w", "tile_rows", "width", "height", "albedo_y")
        }
        numbers = {**asdict(self), **derived}
        if self.headroom == (1.0, 1.0):  # what is not there leaves no trace
            numbers = {name: value for name, value in numbers.items() if name not in _HEADROOM}
        if not self.guarded:  # as format 1 has it
            return {name: value for name, value in numbers.items() if name not in _SINCE_2}
        guard = dict(zip(("guard_high", "guard_middle", "guard_low"), GUARD, strict=True))
        places = {name: getattr(self, name) for name in ("conserving_y", "reflectance_y", "guard_x", "guard_y")}
        return {**numbers, **places, **guard}

    @classmethod
    def from_dict(cls, data: dict) -> TableLayout:
        """Rebuild from a sidecar; raises TableError where numbers are missing or inconsistent."""
        names = cls.__dataclass_fields__
        old: dict[str, Any] = {"w_max": W_MAX, "n_albedo": 1, "n_reflectance": 0, "guarded": 0}
        if "guarded" in data:
            old = {}
        old |= {name: 1.0 for name in _HEADROOM if name not in data}
        try:
            layout = cls(**{name: old[name] if name in old else data[name] for name in names})
        except (KeyError, TypeError) as error:
            raise TableError("The table's sidecar lacks a part of its layout; bake the scan again.") from error
        again = layout.to_dict()
        if any(again[name] != data.get(name) for name in _PLACES if name in again):
            raise TableError("The table's sidecar contradicts itself about the size of its atlas; bake the scan again.")
        return layout


#: What only tables with headroom say.
_HEADROOM = ("scale_headroom", "depth_headroom")

#: What format 1 does not know, and what a sidecar must not contradict.
_SINCE_2 = ("w_max", "n_albedo", "n_reflectance", "guarded")
_PLACES = (
    *("width", "height", "albedo_y", "tile_rows", "conserving_y", "reflectance_y"),
    *("guard_x", "guard_y", "guard_high", "guard_middle", "guard_low"),
)


def put_guard(atlas: np.ndarray, layout: TableLayout) -> None:
    """Write the guard into an atlas ``(height, width, 3)``, row 0 at the bottom; nothing where the layout has none."""
    if layout.guarded:
        low = layout.guard_y - GUARD_SIDE // 2
        atlas[low : low + GUARD_SIDE, :GUARD_SIDE] = 0.0
        atlas[layout.guard_y, layout.guard_x] = GUARD


def near_square_columns(n_r: int, n_phi: int, n_w: int) -> int:
    """Tiles side by side that keep the atlas close to a square, wasting no tile where that is possible."""
    candidates = range(1, n_w + 1)

    def cost(columns: int) -> float:
        rows = -(-n_w // columns)
        side = max(columns * n_r, rows * (n_phi + 2))
        return side * (1.0 + 0.5 * (rows * columns - n_w) / n_w)

    return min(candidates, key=cost)
