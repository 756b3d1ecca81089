# SPDX-License-Identifier: GPL-3.0-or-later
"""The snake under an environment picture alone: a studio of softboxes, no lamp."""

from __future__ import annotations

import bpy

from . import snake_sun, stage, studio


def build(out):
    """The scene."""
    stage.empty_room(out / "snake_studio.blend")
    bodies = snake_sun.sample_scene().build_scene()
    scene = bpy.context.scene
    for ob in [ob for ob in scene.objects if ob.type == "LIGHT"]:
        bpy.data.objects.remove(ob)
    picture = bpy.data.images.load(str(studio.save(out / "studio.exr")))
    tree = scene.world.node_tree
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image = picture
    tree.links.new(environment.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = 3.0
    stage.diffract(bodies, "snake", environment=1)
    scene.cycles.sample_clamp_indirect = 6.0
    scene.view_settings.exposure = 0.25
    stage.aim(scene.camera, (-0.75, -1.85, 1.35), (-0.05, -0.065, 0.08))
    # Mirrors that are drawn at random make noise of the passes that would guide the denoiser.
    scene.cycles.denoising_input_passes = "RGB"
    lens = scene.camera.data
    lens.lens, lens.clip_start = 60, 0.01
    lens.dof.use_dof, lens.dof.focus_distance, lens.dof.aperture_fstop = True, 1.75, 4.0
