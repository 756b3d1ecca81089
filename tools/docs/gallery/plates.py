# SPDX-License-Identifier: GPL-3.0-or-later
"""A row of blazed plates, each turned a little further from the mirror direction of one upright tube."""

from __future__ import annotations

import math

import bpy
import numpy as np

from . import stage

#: Metres: width, height, thickness of a plate, distance from plate to plate, radius of the arc they stand on.
WIDTH, HEIGHT, THICK, STEP, ARC = 0.030, 0.072, 0.006, 0.0350, 0.26

#: Grooves' period.
PERIOD = 2.5e-6

#: Wavelength that the middle of each plate sends to the camera; 0 is the mirror.
COLOURS = (0.0, 435e-9, 470e-9, 505e-9, 540e-9, 575e-9, 605e-9, 650e-9)

#: Plates lean back by this, so that a camera above the table and a tube above the table are mirror images.
LEAN = math.radians(14.0)

#: The camera, and that part of the tube that it sees mirrored by the plates.
CAMERA, TUBE = (0.0, -1.46, 0.34), (0.40, -1.15, 0.30)


def turn(place, wavelength, lamp, eye, side=1.0):
    """Turn about z at which a plate sends the first order of a wavelength from lamp to eye (grating equation)."""
    place = np.array([*place, 0.5 * HEIGHT])
    total = sum((np.array(p) - place) / np.linalg.norm(np.array(p) - place) for p in (lamp, eye))[:2]
    bisector = math.atan2(total[1], total[0])
    return bisector + side * math.asin(wavelength / PERIOD / np.linalg.norm(total)) + math.pi / 2


def plate():
    """A slab of glass whose front (towards -y) is ruled; the slab, and the ruled face."""
    w, h, t = WIDTH / 2, HEIGHT, THICK
    front = stage.grid(
        "Ruled", np.array([[(-w, 0, 0), (w, 0, 0)], [(-w, 0, h), (w, 0, h)]], float),
        np.array([[(0, 0), (1, 0)], [(0, 1), (1, 1)]], float),
    )  # fmt: skip
    bpy.ops.mesh.primitive_cube_add(size=1.0)
    slab = bpy.context.object
    slab.scale = (WIDTH, t, h)
    slab.location = (0.0, t / 2 + 0.0001, h / 2)
    bevel = slab.modifiers.new("Bevel", "BEVEL")
    bevel.width, bevel.segments = 0.0006, 3
    return stage.link("Ruled face", front), slab


def build(out):
    """The scene."""
    scene = stage.empty_room(out / "plates.blend", (0.004, 0.005, 0.007))
    stage.table_top(3.0, stage.plain("Black glass", (0.002, 0.002, 0.002), 0.05))
    glass = stage.plain("Blank", (0.015, 0.02, 0.02), 0.1)
    faces = []
    middle = (len(COLOURS) - 1) / 2
    for index, wavelength in enumerate(COLOURS):
        angle = (index - middle) * STEP / ARC
        place = np.array([ARC * math.sin(angle), ARC * (math.cos(angle) - 1.0)])
        face, slab = plate()
        slab.data.materials.append(glass)
        slab.parent = face
        face.location = (*place, 0.0005)
        face.rotation_euler = (-LEAN, 0.0, turn(place, wavelength, TUBE, CAMERA))
        faces.append(face)
    stage.softbox("Tube", (*TUBE[:2], 0.76), (0.0, 0.0, 0.76), (0.006, 1.5), 0.35)
    stage.softbox("Sky", (0.0, 0.6, 0.7), (0.0, 0.0, 0.0), (1.2, 0.3), 1.2, (0.7, 0.85, 1.0))
    stage.camera(CAMERA, (0.0, 0.0, 0.012), 172)
    stage.diffract(faces, "blazed", fresnel="CONDUCTOR")
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Punchy"
    scene.cycles.sample_clamp_indirect = 1.0
