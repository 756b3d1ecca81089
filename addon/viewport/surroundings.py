# SPDX-License-Identifier: GPL-3.0-or-later
"""What surrounds the scene in a view: a plain colour, an image of the world, or Material Preview's studio light."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Euler

from ...precompute.files.stamp import file_stamp
from ..materials.twin.lamps import SUN_THRESHOLD
from .data import panorama
from .data.sky import Sky

_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Surroundings:
    """Light that does not come from lamps, and whether lamps shine.

    Parameters
    ----------
    ambient
        ``(3,)`` radiance of a plain world.
    sky
        An image all around; None where there is none.
    lamps
        Whether the scene's lamps shine in this view.
    sun_above
        Radiance above which EEVEE takes light out of the image and gives it to a sun, of which no list of lamps knows;
        0 where it does not.
    """

    ambient: tuple[float, float, float] = (0.0, 0.0, 0.0)
    sky: Sky | None = None
    lamps: bool = True
    sun_above: float = 0.0


def of_shading(scene: bpy.types.Scene, shading: bpy.types.View3DShading | None) -> Surroundings:
    """What surrounds the scene under a view's shading; None and Solid: the scene's world."""
    if shading is None or shading.type not in {"MATERIAL", "RENDERED"}:
        return of_world(scene.world)
    rendered = shading.type == "RENDERED"
    lamps = shading.use_scene_lights_render if rendered else shading.use_scene_lights
    by_world = shading.use_scene_world_render if rendered else shading.use_scene_world
    if by_world:
        world = of_world(scene.world)
        return Surroundings(world.ambient, world.sky, lamps)
    # The studio light has the threshold of the scene's world.
    above = float(getattr(scene.world, "sun_threshold", SUN_THRESHOLD))
    return Surroundings(sky=studio(shading), lamps=lamps, sun_above=above)


def studio(shading: bpy.types.View3DShading) -> Sky | None:
    """The studio light of a view."""
    light = shading.selected_studio_light
    if light is None or not light.path:
        return None
    turn = np.array(Euler((0.0, 0.0, shading.studiolight_rotate_z)).to_matrix()).ravel()
    strength = float(shading.studiolight_intensity)
    return Sky("", light.path, file_stamp(light.path) or (), tuple(turn.tolist()), (strength, strength, strength))


def of_world(world: bpy.types.World | None) -> Surroundings:
    """Colour or image of a world; one of more nodes as a panorama that has to be rendered."""
    if world is None:
        return Surroundings()
    if world.node_tree is None:
        return Surroundings(tuple(world.color))
    output = world.node_tree.get_output_node("ALL")
    links = output.inputs["Surface"].links if output is not None else ()
    if not links:
        return Surroundings()
    node = links[0].from_node
    if node.bl_idname != "ShaderNodeBackground" or node.inputs["Strength"].links:
        return _rendered(world)
    strength = float(node.inputs["Strength"].default_value)
    colour = node.inputs["Color"]
    if not colour.links:
        return Surroundings(tuple(strength * c for c in tuple(colour.default_value)[:3]))
    picture = colour.links[0].from_node
    if picture.bl_idname != "ShaderNodeTexEnvironment":
        return _rendered(world)
    if picture.image is None:
        return Surroundings((strength, 0.0, strength))  # Blender's colour for a missing image
    turn = _turn(picture.inputs["Vector"])
    if picture.projection != "EQUIRECTANGULAR" or turn is None:
        return _rendered(world)
    image = picture.image
    return Surroundings(sky=Sky(image.name_full, "", panorama.image_stamp(image), turn, (strength, strength, strength)))


def _rendered(world: bpy.types.World) -> Surroundings:
    return Surroundings(sky=Sky("", "", panorama.stamp(world), _IDENTITY, (1.0, 1.0, 1.0), world.name_full))


def _turn(socket: bpy.types.NodeSocket) -> tuple[float, ...] | None:
    """Rotation from the world's directions to those of an image; None where the vector is something else."""
    if not socket.links:
        return _IDENTITY
    node = socket.links[0].from_node
    if node.bl_idname == "ShaderNodeTexCoord":
        return _IDENTITY if socket.links[0].from_socket.name in {"Generated", "Object"} else None
    if node.bl_idname != "ShaderNodeMapping" or node.vector_type == "NORMAL":
        return None
    if any(node.inputs[name].links for name in ("Location", "Rotation", "Scale") if name in node.inputs):
        return None
    location = node.inputs["Location"].default_value if "Location" in node.inputs else (0.0, 0.0, 0.0)
    # A direction's length does not matter: the same scale along all axes does nothing.
    scale = node.inputs["Scale"].default_value
    if any(location) or len(set(scale)) != 1 or scale[0] <= 0.0:
        return None
    before = _turn(node.inputs["Vector"])
    if before is None:
        return None
    turn = np.array(Euler(node.inputs["Rotation"].default_value).to_matrix())
    if node.vector_type == "TEXTURE":
        turn = turn.T
    return tuple((turn @ np.reshape(before, (3, 3))).ravel().tolist())
