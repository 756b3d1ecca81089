# SPDX-License-Identifier: GPL-3.0-or-later
"""A sunbeam snake and a corn snake on a dark table, and the same skins on Suzanne."""

from __future__ import annotations

import math

import bpy
import numpy as np

from . import stage


def body(name, points, radius, around=72):
    """A tube along points, which the UV map covers: u along it towards the tail, v once around, the back at 1/4."""
    points = np.asarray(points, float)
    forward = np.gradient(points, axis=0)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    side = np.cross(forward, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, forward)
    turn = np.linspace(2.0 * math.pi, 0.0, around + 1)
    # A resting snake is a little flat below.
    rise = np.where(np.sin(turn) < 0.0, 0.86, 1.0) * np.sin(turn)
    ring = np.cos(turn)[None, :, None] * side[:, None] + rise[None, :, None] * up[:, None]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    uv = np.stack(np.broadcast_arrays((length / length[-1])[:, None], turn[None] / (2.0 * math.pi)), -1)
    return stage.link(name, stage.grid(name, points[:, None] + radius[:, None, None] * ring, uv, closed=True))


def winding(start, end, swing, waves, radius, phase=0.0, count=500):
    """Points of a body that winds from one place to another, resting on z = 0, and its radii: neck, trunk, tail."""
    t = np.linspace(0.0, 1.0, count)
    line = np.array(start)[None] * (1.0 - t)[:, None] + np.array(end)[None] * t[:, None]
    across = np.array([-(end[1] - start[1]), end[0] - start[0]])
    across = across / np.linalg.norm(across)
    line = line + (swing * np.sin(2.0 * math.pi * waves * t + phase))[:, None] * across[None]
    radii = radius * (0.62 + 0.38 * np.clip(t / 0.12, 0.0, 1.0)) * np.clip(1.08 - t**5, 0.1, 1.0)
    return np.concatenate([line, 0.86 * radii[:, None]], axis=1), radii


def suzanne(name, place, size, turn):
    """Blender's monkey, smooth."""
    bpy.ops.mesh.primitive_monkey_add(size=2.0 * size, location=place, rotation=(math.radians(-28.0), 0.0, turn))
    ob = bpy.context.object
    ob.name = name
    smooth = ob.modifiers.new("Smooth", "SUBSURF")
    smooth.levels = smooth.render_levels = 3
    bpy.ops.object.shade_smooth()
    return ob


def scaled(objects, species, space, scale_size=0.0):
    """The skin of a snake, on its table, by the operators an artist uses."""
    from diffraction_shader.addon.materials.scales.species import SPECIES

    snake = SPECIES[species]
    stage.diffract(objects, snake.preset, fresnel="DIELECTRIC", ior=snake.ior)
    for ob in objects:
        bpy.context.view_layer.objects.active = ob
        bpy.ops.diffraction.add_snake_scales(species=species, space=space, scale_size=scale_size)


def build(out):
    """The scene."""
    scene = stage.empty_room(out / "skins.blend", (0.05, 0.055, 0.065))
    stage.table_top(2.0, stage.plain("Slate", (0.010, 0.0095, 0.009), 0.6))
    sunbeam = body("Sunbeam snake", *winding((-0.34, -0.02), (0.36, -0.12), 0.040, 1.6, 0.0150))
    corn = body("Corn snake", *winding((-0.36, 0.15), (0.36, 0.04), 0.034, 1.7, 0.0160, 2.4))
    left, right = (
        suzanne("Left", (-0.115, 0.215, 0.058), 0.068, 0.35),
        suzanne("Right", (0.115, 0.215, 0.058), 0.068, -0.3),
    )
    scaled([sunbeam], "SUNBEAM", "UV")
    scaled([left], "SUNBEAM", "OBJECT", 0.0065)
    scaled([corn], "CORN", "UV")
    scaled([right], "CORN", "OBJECT", 0.0058)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 7.0, math.radians(0.6)
    stage.aim(stage.link("Sun", sun), (0.30, 0.42, 0.9), (0.0, 0.0, 0.0))
    stage.softbox("Window", (-0.9, 0.3, 0.8), (0.0, 0.05, 0.0), (0.5, 0.5), 7.0, (0.85, 0.92, 1.0))
    stage.camera((0.0, -0.58, 0.42), (0.0, 0.085, 0.025), 45, (0.74, 11.0))
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.4
    scene.cycles.sample_clamp_indirect = 2.0
