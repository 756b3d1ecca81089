# SPDX-License-Identifier: GPL-3.0-or-later
"""Where to look for the environment: densities over (u, v) that follow a spectral table.

For light from everywhere a renderer draws (u, v) from a density q and weights the sample by
f / q, since du dv = cos(theta_i) d omega. The closer q follows f, the less noise; any q that is
positive where f is gives the right mean. The densities are stored as inverse distributions in
equal steps of probability, so that drawing costs two lookups and the density itself comes from
the two edges of the step that was drawn:

    slice    s = floor(cos_r * n_slices)                      (a density for each range of view angles)
    radius   texel (k, s) of the radius rows, k = floor(xi_1 * n_r):  r between its two edges, uniform in r^2
    angle    texel (j, s * n_r + k) of the angle rows, j = floor(xi_2 * n_phi): turn between its two edges
    q(u, v) = 1 / (n_r * pi (r_1^2 - r_0^2)) * 1 / (n_phi (turn_1 - turn_0))
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .atomic import atomic_path
from .exr import write_image
from .table import SpectralTable

#: Ranges of cos_r, steps of the radius and of the angle.
N_SLICES, N_R, N_PHI = 8, 128, 128

#: Share of the mean over all slices in each slice's density: f follows w, which depends on the direction drawn too.
_SHARED = 0.1

#: Shares of X, Y and Z in a density: mostly luminance; that alone would leave the blue orders to chance.
_XYZ_SHARES = np.float32((0.25, 0.55, 0.2))

#: Azimuths of the viewer over which a density is averaged.
_AZIMUTHS = 24

#: Share of an even density, for regions that hold no light at all.
_EVEN = 0.02


@dataclass(frozen=True, eq=False)
class Importance:
    """Inverse distributions of a table.

    Parameters
    ----------
    radius
        ``(n_slices, n_r, 2)`` lower and upper edge of each step of sqrt(u^2 + v^2).
    turn
        ``(n_slices, n_r, n_phi, 2)`` edges of each step of atan2(v, u) / 2 pi in [0, 1].
    """

    radius: np.ndarray
    turn: np.ndarray

    def draw(self, cos_r: np.ndarray, xi_1: np.ndarray, xi_2: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Draw (u, v), as the shader does.

        Parameters
        ----------
        cos_r
            Cosines of the view angle.
        xi_1, xi_2
            Random numbers in [0, 1).

        Returns
        -------
        u, v, q : ndarray
            The point and its density (per unit of u and v).
        """
        n_slices, n_r, n_phi = self.turn.shape[:3]
        s = np.minimum((np.asarray(cos_r) * n_slices).astype(int), n_slices - 1)
        k, j = (xi_1 * n_r).astype(int), (xi_2 * n_phi).astype(int)
        r_0, r_1 = np.moveaxis(self.radius[s, k].astype(float), -1, 0)
        t_0, t_1 = np.moveaxis(self.turn[s, k, j].astype(float), -1, 0)
        r = np.sqrt(r_0**2 + (xi_1 * n_r - k) * (r_1**2 - r_0**2))
        phi = 2 * np.pi * (t_0 + (xi_2 * n_phi - j) * (t_1 - t_0))
        with np.errstate(divide="ignore"):
            q = 1.0 / (n_r * np.pi * (r_1**2 - r_0**2) * n_phi * (t_1 - t_0))
        return r * np.cos(phi), r * np.sin(phi), q

    def image(self) -> np.ndarray:
        """``(n_slices * (n_r + 1), max(n_r, n_phi), 3)`` float32, row 0 at the bottom.

        Radius rows first, then the angle rows; red and green hold the two edges.
        """
        n_slices, n_r, n_phi = self.turn.shape[:3]
        image = np.zeros((n_slices * (n_r + 1), max(n_r, n_phi), 3), np.float32)
        image[:n_slices, :n_r, :2] = self.radius
        image[n_slices:, :n_phi, :2] = self.turn.reshape(n_slices * n_r, n_phi, 2)
        return image


def importance(table: SpectralTable, n_slices: int = N_SLICES, n_r: int = N_R, n_phi: int = N_PHI) -> Importance:
    """Inverse distributions that follow the BRDF of a table, averaged over the viewer's azimuth.

    Parameters
    ----------
    table
        The spectral table.
    n_slices, n_r, n_phi
        Ranges of the view angle's cosine, steps of radius and angle.
    """
    layout = table.layout
    density = _densities(table, (np.arange(n_slices) + 0.5) / n_slices)
    edges = _ring_edges(layout.radii)
    area = np.pi * np.diff(edges**2) / layout.n_phi
    density /= (density * area).sum(axis=(1, 2), keepdims=True)
    density = (1.0 - _SHARED) * density + _SHARED * density.mean(axis=0)
    radius = np.empty((n_slices, n_r, 2), np.float32)
    turn = np.empty((n_slices, n_r, n_phi, 2), np.float32)
    for s in range(n_slices):
        # Nothing lies beyond: light on the horizon opposite to the flattest view of the range.
        reach = 1.0 + np.sqrt(1.0 - (s / n_slices) ** 2)
        radius[s], turn[s] = _invert(density[s] * area, edges, reach, n_r, n_phi)
    return Importance(radius, turn)


def _densities(table: SpectralTable, cos_r: np.ndarray) -> np.ndarray:
    """``(views, n_phi, n_r)`` mean of f over the viewer's azimuth, at the texels' radii and angles.

    A view angle and a radius leave the azimuth open, on which cos(theta_i), w and whether the light
    stands above the surface at all depend: their mean is one row of weights over the table's slices.
    """
    layout = table.layout
    azimuth = (np.arange(_AZIMUTHS) + 0.5) * (np.pi / _AZIMUTHS)
    cos_r, sin_r = cos_r[:, None, None], np.sqrt(1.0 - cos_r**2)[:, None, None]
    r, turn = layout.radii[None, :, None], azimuth[None, None, :]
    cos_i2 = 1.0 - (r**2 + sin_r**2 + 2.0 * r * sin_r * np.cos(turn))
    above = cos_i2 > 0.0
    cos_i = np.sqrt(np.maximum(cos_i2, 1e-4))
    w = cos_i + cos_r
    # 1 + wi.wr = (|wi + wr|^2) / 2, with wi + wr = -(u, v, w).
    factor = np.where(above, ((r**2 + w**2) / 2.0) ** 2 / (cos_i * cos_r * w**2), 0.0)
    column = np.arccos(cos_i) * ((layout.n_theta - 1) / (0.5 * np.pi))
    rows = table.atlas[layout.albedo_y + 1 : layout.albedo_y + 1 + layout.n_albedo_phi, : layout.n_theta, 0]
    factor /= np.maximum(np.interp(column, np.arange(layout.n_theta), rows.astype(float).mean(axis=0)), 1.0)

    position = layout.slice_coordinate(w)
    lower = np.minimum(position.astype(int), layout.n_w - 2)
    blend = position - lower
    gain = factor * layout.scale * w**layout.power / _AZIMUTHS
    weights = np.zeros((cos_r.shape[0], layout.n_r, layout.n_w))
    views, columns = np.arange(cos_r.shape[0])[:, None, None], np.arange(layout.n_r)[None, :, None]
    np.add.at(weights, (views, columns, lower), gain * (1.0 - blend))
    np.add.at(weights, (views, columns, lower + 1), gain * blend)

    total = np.zeros((cos_r.shape[0], layout.n_phi, layout.n_r))
    for index in range(layout.n_w):
        x, y = layout.tile_origin(index)
        tile = table.atlas[y + 1 : y + 1 + layout.n_phi, x : x + layout.n_r]
        total += weights[:, None, :, index] * np.maximum(tile.astype(np.float32) @ _XYZ_SHARES, 0.0)
    return total + 1e-30


def _ring_edges(radii: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], 0.5 * (radii[1:] + radii[:-1]), radii[-1:]])


def _invert(mass: np.ndarray, edges: np.ndarray, reach: float, n_r: int, n_phi: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges of equal steps of probability in radius, and in angle within each of those steps."""
    # Cumulative mass within each radius, for each angle; between the edges it grows like r^2.
    cumulative = np.concatenate([np.zeros((mass.shape[0], 1)), np.cumsum(mass, axis=1)], axis=1)
    squared = edges**2
    total = cumulative.sum(axis=0)
    end = np.interp(reach**2, squared, total)
    total = (1.0 - _EVEN) * np.minimum(total / end, 1.0) + _EVEN * np.minimum(squared / reach**2, 1.0)
    inside = np.append(squared[squared < reach**2], reach**2)
    r_squared = np.interp(np.linspace(0.0, 1.0, n_r + 1), np.interp(inside, squared, total), inside)
    r_squared[0], r_squared[-1] = 0.0, reach**2
    radius = np.sqrt(r_squared).astype(np.float32)

    places = np.clip(np.searchsorted(squared, r_squared, side="right") - 1, 0, len(squared) - 2)
    blend = (r_squared - squared[places]) / (squared[places + 1] - squared[places])
    at_edges = cumulative[:, places] * (1.0 - blend) + cumulative[:, places + 1] * blend
    steps = np.maximum(np.diff(at_edges, axis=1).T, 0.0)  # (n_r, angles)
    steps = steps / np.maximum(steps.sum(axis=1, keepdims=True), 1e-300)
    steps = (1.0 - _EVEN) * steps + _EVEN / steps.shape[1]
    # A texel's angle is the middle of its sector: the sector of angle 0 begins half a step before it.
    count = steps.shape[1]
    sectors = (np.arange(count + 1) - 0.5) / count
    turn = np.empty((n_r, n_phi + 1))
    targets = np.linspace(0.0, 1.0, n_phi + 1)
    for k in range(n_r):
        cdf = np.concatenate([[0.0], np.cumsum(steps[k])])
        turn[k] = np.interp(targets * cdf[-1], cdf, sectors)
    turn = turn.astype(np.float32)
    return np.stack([radius[:-1], radius[1:]], -1), np.stack([turn[:, :-1], turn[:, 1:]], -1)


def save_importance(image: np.ndarray, path: str | os.PathLike[str], atlas_sha256: str) -> None:
    """Write the image of `Importance.image` as a 32-bit EXR that names the atlas it was made from.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    import OpenEXR

    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "atlasSha256": atlas_sha256,
    }
    with atomic_path(path) as temporary:
        write_image(temporary, header, {"RGB": np.ascontiguousarray(image[::-1], np.float32)})


def made_from(path: str | os.PathLike[str]) -> str | None:
    """Hash of the atlas that an importance image was made from; None where there is no such image."""
    import OpenEXR

    if not Path(path).is_file():
        return None
    try:
        with OpenEXR.File(os.fspath(path)) as file:
            return file.header().get("atlasSha256")
    except Exception:  # whatever is wrong with it, it is made anew
        return None
