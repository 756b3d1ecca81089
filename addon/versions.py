# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between the Blenders that the extension runs in: 4.5 LTS and 5.2 LTS."""

from __future__ import annotations

from typing import Any

import bpy

#: Name of EEVEE among the render engines.
EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"


def limits() -> list[str]:
    """What this Blender cannot do, one sentence without a full stop each; none where all works."""
    if bpy.app.version >= (5, 2):
        return []
    return [
        f"Blender {bpy.app.version_string} has no choice of working space: colours are made for Linear Rec.709",
        "An OSL material applied in another version of Blender must be applied again here, and the other way round",
        "Bakes run on the processor: compute shaders of this version give wrong transforms",
        "Nodes and OSL differ by some per cent on a few pixels here: take OSL where it matters",
    ]


def tells_mirrored_uv() -> bool:
    """Whether Cycles hands the attribute `tangent_sign` to materials, which 4.5 reads as zero."""
    return bpy.app.version >= (5, 2)


def texture_t_is_down() -> bool:
    """Whether `texture()` of OSL counts t from an image's top, as 4.5 does, and not from its bottom."""
    return bpy.app.version < (5, 2)


def computes() -> bool:
    """Whether compute shaders can be relied on: those of a bake come out wrong in 4.5, where nothing says why."""
    return bpy.app.version >= (5, 2)


def draws_into_layers() -> bool:
    """Whether a framebuffer can be told one layer of an array texture: 4.5 mistakes the word for the texture."""
    return bpy.app.version >= (5, 0)


def give_nodes(block: bpy.types.Material | bpy.types.World) -> bpy.types.NodeTree:
    """The shader nodes of a material or world, which has none by itself before 5.0; its plain colour stays."""
    if bpy.app.version < (5, 0) and not block.use_nodes:
        fresh = block.node_tree is None
        block.use_nodes = True
        shader = block.node_tree.nodes.get("Principled BSDF")
        if fresh and shader is not None:
            shader.inputs["Base Color"].default_value = block.diffuse_color
    return block.node_tree


def smooth_lookups(texture: Any) -> None:
    """Linear lookups that repeat the border, which textures of 4.5 have by themselves and cannot be told."""
    if hasattr(texture, "filter_mode"):
        texture.filter_mode(True)
        texture.extend_mode("EXTEND")


def start_gpu() -> None:
    """A GPU context in background mode, where this Blender makes none by itself.

    Raises
    ------
    Exception
        Of Blender's, if there is none to be had.
    """
    import gpu

    if hasattr(gpu, "init"):
        gpu.init()
        return
    try:
        gpu.platform.renderer_get()
    except SystemError:
        _render_once()


def _render_once() -> None:
    """Render 8 x 8 pixels with an engine that wants a context: what else opens one before 5.2 is a window."""

    class DIFFRACTION_context(bpy.types.RenderEngine):
        bl_idname = "DIFFRACTION_CONTEXT"
        bl_label = "Diffraction GPU Context"
        bl_use_gpu_context = True

        def render(self, depsgraph: bpy.types.Depsgraph) -> None:
            pass

    bpy.utils.register_class(DIFFRACTION_context)
    scene = bpy.data.scenes.new("diffraction context")
    lens = bpy.data.cameras.new("diffraction context")
    camera = bpy.data.objects.new("diffraction context", lens)
    try:
        scene.collection.objects.link(camera)
        scene.camera = camera
        scene.render.engine = DIFFRACTION_context.bl_idname
        scene.render.resolution_x = scene.render.resolution_y = 8
        bpy.ops.render.render(scene=scene.name)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(lens)
        bpy.utils.unregister_class(DIFFRACTION_context)
