# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport draws tables that hold a film or a lacquer as numpy evaluates them."""

import numpy as np
import pytest

from precompute.bake import bake
from precompute.evaluate.surface import brdf
from precompute.light.colour import xyz_to_rgb_matrix
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.stack import parse_stack
from tests.support.blender import drawing, scenes
from tests.support.blender import viewport_scene as scene
from tests.support.compare import assert_images_agree
from tests.truth import radiance

SIZE, SUN = 64, np.array((0.5, 0.3, 2.0)) / np.linalg.norm((0.5, 0.3, 2.0))


@pytest.mark.parametrize(("substrate", "lacquer"), [("au", None), ("au", 1.5), (None, 1.5)])
def test_sphere_is_that_of_numpy(renderer, tmp_path, substrate, lacquer):
    stack = parse_stack(substrate, ["2.35:250"] if substrate else [])
    table = bake(make_preset("stam_bumps", 8e-6, 96), BakeParameters(stack=stack, lacquer=lacquer, detail=0.5))
    path = table.save(tmp_path / "table.exr")
    sphere = scenes.add_sphere(segments=256, rings=128)
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera()
    scene.give_material(sphere, path)
    image = drawing.alone(renderer, SIZE)
    hit, _, t, b, n = scenes.sphere_frames(sphere, SIZE)
    _, direction = scenes.camera_rays(SIZE)
    wr = radiance.local(np.broadcast_to(-direction, n.shape), t, b, n)
    wi = radiance.local(np.broadcast_to(SUN, n.shape), t, b, n)
    value = 2.0 * brdf(table, wi, wr, energy_conserving=True) * np.maximum(wi[..., 2:], 0.0)
    truth = np.where(hit[..., None], radiance.gamut_step(value, xyz_to_rgb_matrix()), 0.0)
    where = hit & (wi[..., 2] > 0.1) & (wr[..., 2] > 0.15) & (truth.sum(-1) > 1e-3 * truth.max())
    assert_images_agree(image, truth, 0.02, where=where, name=f"viewport stuff {substrate} {lacquer}")
