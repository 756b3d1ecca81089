# SPDX-License-Identifier: GPL-3.0-or-later
"""A crumpled sheet of holographic foil, whose facets each send another order to the camera."""

from __future__ import annotations

import bpy
import numpy as np

from . import stage

#: Metres: sides of the sheet, height of its folds, distance between them.
SIDES, HEIGHT, FOLD = (0.34, 0.22), 0.016, 0.008


def crumpled(seed=7):
    """A sheet of flat triangles between random points, folded along random straight creases; u runs along x."""
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(seed)
    columns, rows = (round(side / FOLD) for side in SIDES)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, columns) * SIDES[0], np.linspace(-0.5, 0.5, rows) * SIDES[1])
    inner = (np.abs(x) < 0.499 * SIDES[0]) & (np.abs(y) < 0.499 * SIDES[1])
    plane = np.stack([x, y], -1) + inner[..., None] * rng.uniform(-0.42, 0.42, (*x.shape, 2)) * FOLD
    plane = plane.reshape(-1, 2)
    height = np.zeros(len(plane))
    for scale in (0.11, 0.06, 0.032, 0.018):  # triangle waves in random directions: straight creases
        for _ in range(3):
            angle, phase = rng.uniform(0.0, 2.0 * np.pi, 2)
            wave = (plane @ (np.cos(angle), np.sin(angle))) / scale + phase
            height += scale * 0.10 * np.abs(np.mod(wave, 2.0) - 1.0)
    mesh = bpy.data.meshes.new("Foil")
    faces = Delaunay(plane).simplices
    corners = plane[faces]
    edge, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    upside_down = edge[:, 0] * other[:, 1] - edge[:, 1] * other[:, 0] < 0.0
    faces[upside_down] = faces[upside_down][:, ::-1]
    mesh.from_pydata(np.column_stack([plane, height]).tolist(), [], faces.tolist())
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", plane[faces.ravel()].astype(np.float32).ravel())
    return mesh


def build(out):
    """The scene."""
    scene = stage.empty_room(out / "foil.blend", (0.01, 0.011, 0.013))
    stage.table_top(2.0, stage.plain("Slate", (0.004, 0.004, 0.005), 0.3), -0.002)
    sheet = stage.link("Foil", crumpled())
    for index, (place, size) in enumerate(
        (((0.35, -0.25, 0.50), (0.01, 0.4)), ((-0.40, -0.10, 0.45), (0.01, 0.4)), ((0.05, 0.5, 0.5), (0.5, 0.01)))
    ):
        stage.softbox(f"Strip {index}", place, (0.0, 0.0, 0.0), size, 0.9)
    stage.camera((0.0, -0.30, 0.34), (0.0, -0.004, 0.0), 66, blur=(0.44, 8.0))
    stage.diffract([sheet], "foil", bake={"sigma_s_um": 3.0}, fresnel="CONDUCTOR")
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Punchy"
    scene.cycles.sample_clamp_indirect = 1.0
