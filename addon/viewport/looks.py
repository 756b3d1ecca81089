# SPDX-License-Identifier: GPL-3.0-or-later
"""What a material of ours looks like: its sockets as the numbers of the viewport's shader."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...precompute.constants import LEAST_SCALE
from ...precompute.evaluate.surface import coherence_area, relative_colour_factor
from ...precompute.light.colour import table_light, xyz_to_rgb_matrix
from ...precompute.table.layout import TableLayout
from ..colour_spaces import working_space
from ..materials import material
from ..materials import pigment as pigments
from ..materials.node import paint_nodes
from ..materials.osl import FRESNEL
from .data import masks, orientation
from .data.blocks import Surface


@dataclass(frozen=True)
class View:
    """What the user chose for the drawing.

    Parameters
    ----------
    method
        ``TABLE`` or ``FLSS``.
    brightness
        Factor on the diffracted light.
    normalisation
        ``ABSOLUTE`` or ``RELATIVE`` (the specular peak of a flat patch at normal incidence has luminance 1).
    surface
        ``ADD`` to what is drawn, or ``REPLACE`` it by pigment and diffraction.
    points
        Points that stand for a wide lamp.
    lights
        ``SCENE``, or ``STUDIO`` for lamps that stay with the viewer.
    """

    method: str = "TABLE"
    brightness: float = 1.0
    normalisation: str = "ABSOLUTE"
    surface: str = "ADD"
    points: int = 4
    lights: str = "SCENE"


def surface(shaded: bpy.types.Material, layout: TableLayout, info: dict, view: View) -> Surface:
    """The look of a material; sockets with links count with the values that they have without.

    Parameters
    ----------
    layout, info
        Of its table.
    """
    node = material.shader_node(shaded)
    value = _Sockets(node)
    illuminant = table_light(info["colour"])
    modes = {number: name for name, number in FRESNEL.items()}
    mask = masks.of(shaded)
    look = Surface(
        layout=layout,
        to_rgb=xyz_to_rgb_matrix(working_space(), illuminant),
        fresnel=modes.get(int(value("Fresnel", 3)), "DIELECTRIC"),
        ior=float(value("IOR", 1.5)),
        conductor_n=tuple(value("ConductorN", (1.35, 0.95, 0.61)))[:3],
        conductor_k=tuple(value("ConductorK", (7.47, 6.54, 5.47)))[:3],
        conserve_energy=bool(value("ConserveEnergy", 1)) and info["albedo_max"] > 1.0,
        rotation=float(value("Rotation", 0.0)),
        scale=_least(value("Scale", 1.0)),
        depth=_least(value("Depth", 1.0)),
        mask=mask.constant,
        mask_factor=mask.factor,
        mask_image=mask.image is not None,
        mask_alpha=mask.alpha,
        environment=bool(value("Environment", 0)),
        brightness=float(value("Brightness", 1.0)) * view.brightness,
        lacquer_roughness=float(value("LacquerRoughness", 0.05)),
    )
    if layout.holds_reflectance:
        look.kept = np.clip(np.array(info["reflectance_xyz"], float) @ look.to_rgb.T, 0.0, 1.0)
    base = node.inputs.get("Base") if node is not None else None
    if (look.mask_image or look.mask < 1.0) and base is not None:
        look.cutout = pigments.sees_through(base)
    if (look.scale, look.depth) != (1.0, 1.0) or paint_nodes.image(shaded) is not None:
        look.conserve_energy = bool(value("ConserveEnergy", 1))  # its albedo may pass 1 where the table's does not
    turned = orientation.angle_image(shaded)
    if turned is not None:
        look.angle_image, look.rotation = True, turned[1]
    if paint_nodes.image(shaded) is not None:
        look.painted, look.rotation = True, paint_nodes.turn(shaded)
    if view.normalisation == "RELATIVE":
        look.brightness *= relative_gain(info, look)
    if view.surface == "REPLACE":
        look.pigment = pigment(node)
    return look


def _least(value: Any) -> float:
    """A scale or depth as renderers take it."""
    return float(value) if float(value) >= LEAST_SCALE else LEAST_SCALE


def relative_gain(info: dict, look: Surface) -> float:
    """What f cos is multiplied by to give the relative BRDF of the thesis, R / R0 included."""
    parameters, source = info["parameters"], info["source"]
    rows, cols = source["shape"]
    size_x, size_y = source["size_m"]
    area = coherence_area((rows, cols), size_x / cols, size_y / rows, parameters["sigma_s_m"], parameters["ensemble"])
    normal = np.array([0.0, 0.0, 1.0])
    gain = float(relative_colour_factor(normal, normal, area, info["colour"]["illuminant"]))
    if look.fresnel in {"DIELECTRIC", "SCHLICK"} and not look.layout.holds_reflectance:
        gain /= max(((look.ior - 1.0) / (look.ior + 1.0)) ** 2, 1e-6)
    return gain


def pigment(node: bpy.types.Node | None) -> tuple[float, float, float]:
    """Colour of the diffuse shader underneath, as far as the nodes tell it without being evaluated."""
    base = node.inputs.get("Base") if node is not None else None
    return (pigments.colour_of(base) if base is not None else None) or (0.0, 0.0, 0.0)


class _Sockets:
    """Values of a node's sockets, or of its defaults where it lacks one."""

    def __init__(self, node: bpy.types.Node | None) -> None:
        self._node = node

    def __call__(self, name: str, default: Any) -> Any:
        socket = self._node.inputs.get(name) if self._node is not None else None
        return default if socket is None or not hasattr(socket, "default_value") else socket.default_value


def table_path(shaded: bpy.types.Material) -> Path:
    """Absolute path of a material's table."""
    return material.table_path(shaded).with_suffix(".exr")
