# SPDX-License-Identifier: GPL-3.0-or-later
"""One table as that of a stretched, deepened, turned surface.

A surface stretched by s along x and y, its coherence window with it, and by q in height has

    T'(u, v, w) = s^2 T(s u, s v, q w)

exactly: substitute x -> s x in ``P = integral g exp(i k w q h(x / s)) exp(i k (u x + v y))`` and divide by the
window's area, which grows by s^2.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from ..constants import LEAST_REFLECTANCE, LEAST_SCALE
from ..errors import ParameterError
from ..table.albedo import albedo_map
from ..table.scaled_albedo import look_up, scaled_albedos
from ..table.table import SpectralTable
from .surface import geometry_factor, lacquer_factor, lacquer_uvw


@lru_cache(maxsize=4)
def _tiles_of(table: SpectralTable) -> np.ndarray:
    return scaled_albedos(table)


def at_least(value: np.ndarray | float) -> np.ndarray:
    """A Scale or Depth as renderers take it: what is negative, zero or no number counts as 0.01."""
    value = np.asarray(value, float)
    return np.where(value >= LEAST_SCALE, value, LEAST_SCALE)  # NaN compares false


def scaled_transform(
    table: SpectralTable,
    u: np.ndarray,
    v: np.ndarray,
    w: np.ndarray,
    scale: np.ndarray | float = 1.0,
    depth: np.ndarray | float = 1.0,
    rotation: np.ndarray | float = 0.0,
) -> np.ndarray:
    """T'(u, v, w), pixel by pixel.

    Parameters
    ----------
    table
        Of the surface as baked.
    u, v, w
        As for `SpectralTable.transform`; all arguments broadcast.
    scale, depth
        Period and depth over those baked. Where ``scale r`` or ``depth |w|`` leaves the table it is clamped to its rim.
    rotation
        Radians by which the structure is turned from the tangent towards the bitangent.

    Returns
    -------
    ndarray
        ``(..., 3)`` XYZ in 1/sr.
    """
    s, q = at_least(scale), at_least(depth)
    cosine, sine = np.cos(rotation), np.sin(rotation)
    along, across = cosine * u + sine * v, cosine * np.asarray(v) - sine * u
    value = table.transform(s * along, s * across, q * w)
    if table.has_stack and table.index == 1.0:
        # |(u, v, w)| = 2 cos(half-angle), where the stack's R is taken: that of the true directions counts.
        square, w2 = np.asarray(u) ** 2 + np.asarray(v) ** 2, np.asarray(w) ** 2
        own, taken = (np.minimum(0.5 * np.sqrt(each), 1.0) for each in (square + w2, s**2 * square + q**2 * w2))
        value = value * table.reflectance(own) / np.maximum(table.reflectance(taken), LEAST_REFLECTANCE)
    return np.broadcast_to(s**2, value.shape[:-1])[..., None] * value


class ScaledTable:
    """A table under one scale, depth and rotation, for everything that takes a table.

    Parameters
    ----------
    table
        As baked.
    scale, depth, rotation
        As for `scaled_transform`, numbers.
    """

    def __init__(self, table: SpectralTable, scale: float = 1.0, depth: float = 1.0, rotation: float = 0.0) -> None:
        for name, value in (("scale", scale), ("depth", depth)):
            if not (np.isfinite(value) and value > 0):
                raise ParameterError(f"A {name} of {value:g} makes no sense; give a positive number such as 0.5.")
        self.has_stack, self.index = table.has_stack, table.index
        self.table, self.scale, self.depth, self.rotation = table, float(scale), float(depth), float(rotation)
        self.info = table.info

    @property
    def beyond(self) -> bool:
        """Whether directions exist for which the table ends and its rim is taken."""
        above = any(value > most for value, most in zip((self.scale, self.depth), self.table.headroom, strict=True))
        # Under a lacquer light runs steeply, and a table without headroom holds no smaller |w|.
        return above or (self.depth < 1.0 and self.table.layout.w_min > 0.5)

    @property
    def approximate(self) -> bool:
        """Whether the reflectance of a stack in the table is known approximately only.

        ``|(u, v, w)| = 2 cos(half-angle)``, and the table has it at (s u, s v, q w): the ratio of X, Y and Z at both
        angles corrects it, which is not what it is at each wavelength. Under a lacquer it is not corrected.
        """
        return self.has_stack and (self.scale, self.depth) != (1.0, 1.0)

    def transform(self, u: np.ndarray, v: np.ndarray, w: np.ndarray) -> np.ndarray:
        """`scaled_transform` with these numbers."""
        return scaled_transform(self.table, u, v, w, self.scale, self.depth, self.rotation)

    @cached_property
    def _albedos(self) -> np.ndarray:
        layout = self.table.layout
        r, w, phi = np.meshgrid(layout.radii, layout.slices, layout.angles, indexing="ij")
        value = scaled_transform(self.table, r * np.cos(phi), r * np.sin(phi), -w, self.scale, self.depth)
        texels = np.moveaxis(value / (w**layout.power)[..., None], -1, 2)
        white = np.asarray(self.table.info["colour"]["white_xyz"], float)
        return albedo_map(texels.astype(np.float32), layout, white)

    @property
    def _tiles(self) -> np.ndarray:
        return _tiles_of(self.table)

    def conserving_albedo(self, directions: np.ndarray) -> np.ndarray:
        """What renderers divide by where it passes 1, see `precompute.table.scaled_albedo`."""
        directions = np.asarray(directions, float)
        cosine, sine = np.cos(self.rotation), np.sin(self.rotation)
        x, y = directions[..., 0], directions[..., 1]
        own = np.stack([cosine * x + sine * y, cosine * y - sine * x, directions[..., 2]], -1)
        if (self.scale, self.depth) == (1.0, 1.0):
            return self.table.conserving_albedo(own)
        most_s, most_q = self.table.headroom
        shape = own.shape[:-1]
        return look_up(self._tiles, own, np.full(shape, self.scale / most_s), np.full(shape, self.depth / most_q))

    def albedo(self, directions: np.ndarray) -> np.ndarray:
        """Directional albedo with R = 1, by the quadrature that bakes do."""
        directions = np.asarray(directions, float)
        rows, columns = self._albedos.shape
        theta = np.arccos(np.clip(directions[..., 2], 0.0, 1.0))
        phi = np.arctan2(directions[..., 1], directions[..., 0]) - self.rotation
        x, y = theta * ((columns - 1) / (0.5 * np.pi)), np.mod(phi * (rows / (2.0 * np.pi)), rows)
        left, below = np.minimum(x.astype(int), columns - 2), y.astype(int) % rows
        fx, fy, above = x - left, y - np.floor(y), (below + 1) % rows
        a = self._albedos
        low, high = (a[row, left] * (1.0 - fx) + a[row, left + 1] * fx for row in (below, above))
        return low * (1.0 - fy) + high * fy


def painted_brdf(
    table: SpectralTable,
    wi: np.ndarray,
    wr: np.ndarray,
    scale: np.ndarray,
    depth: np.ndarray,
    rotation: np.ndarray,
    mask: np.ndarray,
) -> np.ndarray:
    """The raw absolute BRDF (R = 1) of each pixel of a painted surface.

    Parameters
    ----------
    wi, wr
        ``(3,)`` or ``(rows, cols, 3)`` unit vectors in the surface's frame.
    scale, depth, rotation, mask
        ``(rows, cols)``, see `precompute.paint.Paint`.

    Returns
    -------
    ndarray
        ``(rows, cols, 3)`` XYZ in 1/sr.
    """
    wi, wr = np.asarray(wi, float), np.asarray(wr, float)
    u, v, w = lacquer_uvw(wi, wr, table.index)
    factor = (lacquer_factor(wi, wr, table.index) if table.index > 1.0 else geometry_factor(wi, wr)) * mask
    return factor[..., None] * scaled_transform(table, u, v, w, scale, depth, rotation)
