# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory of an OSL material's closures: Cycles on OptiX keeps all of a shader in 1,024 bytes, without a check.

Counted from Cycles' kernel/osl: a component takes 16 bytes and its parameters, a sum 24, a product 24, each rounded up
to 8. A lamp's lobe with its sum comes to 64, a mirror of the environment to 56, a plain pigment to about 56, a
Principled BSDF to about 300.
"""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from ..lights import slots
from ..renderers import OPTIX_BYTES
from . import material as materials

#: What each part takes.
LOBE, MIRROR, PLAIN, PRINCIPLED, MIX = 64, 56, 56, 300, 96

#: Kept free, since nothing tells when it is too much.
SPARE = 64

_PRINCIPLED = {"ShaderNodeBsdfPrincipled", "ShaderNodeBsdfHairPrincipled", "ShaderNodeBsdfMetallic"}


def needed(material: bpy.types.Material, lamps: int) -> int:
    """Bytes that a material of ours takes under a number of lamps.

    Parameters
    ----------
    material
        With a node of ours.
    lamps
        Slots of the scene's list in use (``scene["diffraction_lamps"]``).
    """
    node = materials.shader_node(material)
    return _sum(lamps, int(node.inputs["Environment"].default_value), node.id_data)


def to_come(shown: Iterable[bpy.types.Material | None], lamps: int, mirrors: int) -> int:
    """The most bytes that any of some materials will take once it is ours.

    Parameters
    ----------
    shown
        As they are; None stands for a pigment of ours.
    lamps
        Lights that the scene's list will hold.
    mirrors
        Of the environment, a sample.
    """
    return max((_sum(lamps, mirrors, each.node_tree if each is not None else None) for each in shown), default=0)


def fits_optix(material: bpy.types.Material, scene: bpy.types.Scene) -> bool:
    """Whether a material of the OSL implementation renders whole on OptiX in a scene as it is lit now."""
    return needed(material, int(scene.get(slots.COUNT, 0))) <= OPTIX_BYTES


def lamps_on_optix(material: bpy.types.Material) -> int:
    """The most lamps under which a material fits there."""
    return max(0, (OPTIX_BYTES - needed(material, 0)) // LOBE)


def _sum(lamps: int, mirrors: int, tree: bpy.types.NodeTree | None) -> int:
    below = sum(_cost(each) for each in tree.nodes) if tree is not None else 0
    return min(lamps, slots.SLOTS) * LOBE + mirrors * MIRROR + max(below, PLAIN) + SPARE


def _cost(node: bpy.types.Node) -> int:
    if not any(socket.type == "SHADER" and socket.is_linked for socket in node.outputs):
        return 0
    if node.bl_idname in _PRINCIPLED:
        return PRINCIPLED
    if node.bl_idname in {"ShaderNodeMixShader", "ShaderNodeAddShader"}:
        return MIX
    return 0 if node.bl_idname == "ShaderNodeGroup" else PLAIN
