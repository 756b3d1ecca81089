# SPDX-License-Identifier: GPL-3.0-or-later
"""The uniform blocks of ``sources``, as rows of four numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....precompute.table.layout import TableLayout
from ...materials.osl import LAMP_KINDS, LAMPS_MAX
from .sources import DEPTH_SLACK, KEPT

#: Side of the cube that holds the view transform; its axes are even in log(1 + gain x) up to the value white, both at
#: an exposure of 0.
DISPLAY_SIDE = 64
DISPLAY_GAIN = 32.0
DISPLAY_WHITE = 32.0

#: Side of the square that holds a table's albedos.
ALBEDO_SIDE = 512

#: How steeply a surface may rise within DEPTH_SLACK: one seen edge-on would reach in front of what hides it. A slope of
#: 16 is 86 degrees.
DEPTH_STEEPEST = 16.0

#: By how much smaller a part of the sphere a direction looks up than it stands for, in the mean of several drawings and
#: in a single one. What lies below a surface's horizon, or beside an order, would else be blurred into its light: with
#: 1 the means under Blender's HDRIs were 3 % low. What is smaller still passes between the directions.
SKY_OVERLAP, SKY_SHARPEST_OF_ONE = 0.75, 2.0


@dataclass
class Frame:
    """What all surfaces of a drawing share.

    Parameters
    ----------
    view, projection
        ``(4, 4)``, as mathematicians write them (rows first).
    lamps
        ``(n, 6, 4)`` rows of the lamps, see `lamp_rows`.
    points
        Points that stand for a wide lamp.
    display
        Whether colours go through the view transform.
    exposure
        Of the view transform, in stops.
    ambient
        ``(3,)`` radiance of the world, for the pigment.
    clip
        At most six planes (a, b, c, d) in world space; what lies behind one of them is not drawn.
    sky
        ``(4, 4)`` rows of an image of the surroundings, see `Sky`; None has none.
    moved
        Two parts of one by which the directions into an image of the surroundings are moved.
    together
        Drawings that make a mean, each of which looks in other directions.
    border
        Left, bottom, right and top in pixels, outside of which nothing is drawn.
    width
        Of the viewport in pixels, for a depth that was sampled elsewhere in them.
    """

    view: np.ndarray
    projection: np.ndarray
    lamps: np.ndarray
    points: int = 4
    display: bool = False
    exposure: float = 0.0
    ambient: tuple[float, float, float] = (0.0, 0.0, 0.0)
    clip: tuple[tuple[float, float, float, float], ...] = ()
    border: tuple[float, float, float, float] | None = None
    sky: np.ndarray | None = None
    moved: tuple[float, float] = (0.0, 0.0)
    together: int = 1
    width: int = 1

    def rows(self) -> np.ndarray:
        """``(23 + 6 LAMPS_MAX, 4)``."""
        rows = np.zeros((23 + 6 * LAMPS_MAX, 4), np.float32)
        view, projection = np.asarray(self.view, float), np.asarray(self.projection, float)
        rows[0:4], rows[4:8] = view.T, projection.T
        to_world = np.linalg.inv(view)
        perspective = projection[3, 3] == 0.0
        if perspective:
            rows[8] = *to_world[:3, 3], 1.0
        else:
            rows[8] = *(to_world[:3, 2] / np.linalg.norm(to_world[:3, 2])), 0.0
        rows[9] = len(self.lamps), self.points, *self.moved
        side = DISPLAY_SIDE
        gain = DISPLAY_GAIN * 2.0**self.exposure
        rows[10] = gain, 1.0 / np.log2(DISPLAY_WHITE * DISPLAY_GAIN + 1.0), (side - 1) / side, 0.5 / side
        rows[11] = *self.ambient, self._most_slack()
        rows[12:18] = 0.0, 0.0, 0.0, 1.0  # hides nothing
        for row, plane in zip(rows[12:18], self.clip, strict=False):
            row[:] = plane
        if self.sky is not None:
            rows[19:23] = self.sky
            rows[22, 2] = max(SKY_OVERLAP * self.together, SKY_SHARPEST_OF_ONE)
        rows[18] = self.border if self.border is not None else 0.0
        if len(self.lamps):
            rows[23 : 23 + 6 * len(self.lamps)] = np.reshape(self.lamps, (-1, 4))
        return rows

    def _most_slack(self) -> float:
        """Depth times the homogeneous w that a surface of DEPTH_STEEPEST rises in DEPTH_SLACK pixels."""
        p = np.asarray(self.projection, float)
        # d depth / d z = (p22 p33 - p32 p23) / 2 w^2, and a pixel is 2 w / (p00 width) wide.
        rise = abs(p[2, 2] * p[3, 3] - p[2, 3] * p[3, 2]) / (abs(p[0, 0]) * max(self.width, 1))
        return float(DEPTH_SLACK * DEPTH_STEEPEST * rise)

    def flags(self) -> set[str]:
        """What of ``sources.FLAGS`` these lamps and this display need."""
        flags = {f"LAMPS_{len(self.lamps)}"} | ({"DISPLAY"} if self.display else set())
        if self.clip or self.border is not None:
            flags.add("BOUNDED")
        kinds = {name: number for name, number in LAMP_KINDS.items() if number}
        for row in np.reshape(self.lamps, (-1, 6, 4)):
            kind = next(name for name, number in kinds.items() if number == int(row[0, 3]))
            flags.add({"SUN": "SUNS", "BALL": "BALLS"}.get(kind, "AREAS"))
            if kind == "BALL" and row[1, 3] > 0.5:
                flags.add("SPOTS")
            wide = row[4, 3] > 0.0 if kind in {"SUN", "BALL"} else True
            if wide and self.points > 1:
                flags.add("WIDE")
        return flags


@dataclass
class Surface:
    """What decides the look of a material.

    Parameters
    ----------
    to_rgb
        ``(3, 3)`` matrix from XYZ to the working space.
    fresnel
        ``NONE``, ``DIELECTRIC``, ``SCHLICK`` or ``CONDUCTOR``.
    ior, conductor_n, conductor_k
        Refractive indices.
    conserve_energy
        Divide f by the albedo where that passes 1.
    rotation
        Radians.
    angle_image
        Whether an image adds to the rotation.
    scale, depth
        Period and depth over the table's.
    mask
        Part of the surface that has the structure; of `masks.Mask` the constant.
    painted
        Whether an image says scale, depth, mask and what is added to the rotation.
    environment
        Whether light of a plain world is diffracted.
    brightness
        Factor on the diffracted light.
    pigment
        Albedo of the surface underneath; None adds the diffraction to what is already drawn.
    lacquer_roughness
        Of the outer face of a table's lacquer.
    mask_factor, mask_image, mask_alpha
        Factor of an image, whether there is one, and whether its alpha counts, see `masks.Mask`.
    cutout
        Whether the surface ends where the mask falls below a half.
    kept
        ``(KEPT, 3)`` RGB that the table's stuff keeps from the pigment, for even steps of the angle; None: by Fresnel.
    """

    to_rgb: np.ndarray
    fresnel: str = "DIELECTRIC"
    ior: float = 1.5
    conductor_n: tuple[float, float, float] = (1.35, 0.95, 0.61)
    conductor_k: tuple[float, float, float] = (7.47, 6.54, 5.47)
    conserve_energy: bool = True
    rotation: float = 0.0
    angle_image: bool = False
    scale: float = 1.0
    depth: float = 1.0
    mask: float = 1.0
    painted: bool = False
    environment: bool = True
    brightness: float = 1.0
    pigment: tuple[float, float, float] | None = None
    kept: np.ndarray | None = None
    lacquer_roughness: float = 0.05
    mask_factor: float = 0.0
    mask_image: bool = False
    mask_alpha: bool = False
    cutout: bool = False
    layout: TableLayout = field(kw_only=True)

    def rows(self) -> np.ndarray:
        """``(12 + KEPT, 4)``."""
        layout = self.layout
        rows = np.zeros((12 + KEPT, 4), np.float32)
        rows[0] = layout.a_r, 1.0 / layout.r0, layout.n_r - 1, layout.n_phi
        rows[1] = layout.a_w, 1.0 / layout.w0, layout.s_w, layout.n_w - 1
        rows[2] = layout.scale, layout.power, *layout.headroom
        rows[3] = 1.0 / layout.n_r, 1.0 / layout.tile_height, 0.5 * (ALBEDO_SIDE - 1) / ALBEDO_SIDE, self.scale
        rows[4:7, :3] = self.to_rgb
        rows[7] = self.depth, self.ior, self.mask_factor, self.brightness
        rows[8], rows[9] = (*self.conductor_n, layout.w_min), (*self.conductor_k, layout.first_share)
        rows[10] = np.cos(self.rotation), np.sin(self.rotation), self.mask, self.rotation
        rows[11, 3] = float(self.mask_alpha)
        if self.pigment is not None:
            rows[11, :3] = self.pigment
        if self.kept is not None:
            rows[12:, :3] = self.kept
        rows[12, 3] = layout.index
        rows[13, 3] = max(self.lacquer_roughness, 0.1) ** 2  # narrower lobes than that slip between the pixels
        return rows

    def flags(self, ambient: bool) -> set[str]:
        """What of ``sources.FLAGS`` this material needs; `ambient`: in a plain world that shines."""
        inside = self.layout.holds_reflectance
        flags = {self.fresnel} if self.fresnel != "NONE" and not inside else set()
        chosen = {
            "CONSERVE": self.conserve_energy,
            "INSIDE": inside,
            "LACQUER": self.layout.index > 1.0,
            "LINEAR_IN_W": self.layout.power == 1.0,
            "TURNED": self.angle_image and not self.painted,
            "PAINTED": self.painted,
            "SCALED": self.painted or (self.scale, self.depth) != (1.0, 1.0),
            "AMBIENT": ambient and self.environment,
            "REPLACE": self.pigment is not None,
            "MASKED": self.mask_image and not self.painted,
            "CUTOUT": self.cutout and self.pigment is not None,
        }
        return flags | {name for name, wanted in chosen.items() if wanted}


def uniform(rows: np.ndarray) -> Any:
    """A uniform buffer with these rows."""
    import gpu

    return gpu.types.GPUUniformBuf(buffer(rows))


def buffer(values: np.ndarray) -> Any:
    """Numbers as the gpu module takes them."""
    import gpu

    flat = np.ascontiguousarray(values, np.float32).ravel()
    return gpu.types.Buffer("FLOAT", flat.size, flat)
