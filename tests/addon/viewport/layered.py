# SPDX-License-Identifier: GPL-3.0-or-later
"""What `test_stuff.py` runs in a process of its own: tables that hold a film or a lacquer, as numpy evaluates them."""

import numpy as np
import pytest

from precompute.bake import bake
from precompute.evaluate.surface import brdf
from precompute.light.colour import xyz_to_rgb_matrix
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.stack import parse_stack
from tests.support.blender import drawing, materials, scenes
from tests.support.blender import viewport_scene as scene
from tests.support.blender.worlds import picture_world
from tests.support.compare import assert_images_agree
from tests.truth import radiance

SIZE, SUN = 64, np.array((0.5, 0.3, 2.0)) / np.linalg.norm((0.5, 0.3, 2.0))


def ggx_cos(wi, wr, alpha):
    """GGX lobe times cos_i by Walter et al. (2007), eq. 33, with Smith's correlated masking (Heitz, 2014)."""
    h = wi + wr
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    tan2 = 1.0 / h[..., 2] ** 2 - 1.0
    d = 1.0 / (np.pi * alpha**2 * h[..., 2] ** 4 * (1.0 + tan2 / alpha**2) ** 2)
    lambdas = [0.5 * (np.sqrt(1.0 + alpha**2 * (1.0 / w[..., 2] ** 2 - 1.0)) - 1.0) for w in (wi, wr)]
    return d / (1.0 + lambdas[0] + lambdas[1]) / (4.0 * wr[..., 2])


@pytest.mark.parametrize(("substrate", "lacquer"), [("au", None), ("au", 1.5), (None, 1.5)])
def test_sphere_is_that_of_numpy(renderer, tmp_path, substrate, lacquer):
    from diffraction_shader.addon.materials import material

    stack = parse_stack(substrate, ["2.35:250"] if substrate else [])
    table = bake(make_preset("stam_bumps", 8e-6, 96), BakeParameters(stack=stack, lacquer=lacquer, detail=0.5))
    path = table.save(tmp_path / "table.exr")
    sphere = scenes.add_sphere(segments=256, rings=128)
    scene.add_lamp("SUN", (0.5, 0.3, 2), power=2.0, angle=0.0)
    scenes.add_camera()
    shaded = scene.give_material(sphere, path)
    rough = 0.6
    material.shader_node(shaded).inputs["LacquerRoughness"].default_value = rough
    image = drawing.alone(renderer, SIZE)
    hit, _, t, b, n = scenes.sphere_frames(sphere, SIZE)
    _, direction = scenes.camera_rays(SIZE)
    wr = radiance.local(np.broadcast_to(-direction, n.shape), t, b, n)
    wi = radiance.local(np.broadcast_to(SUN, n.shape), t, b, n)
    value = 2.0 * brdf(table, wi, wr, energy_conserving=True) * np.maximum(wi[..., 2:], 0.0)
    shown = radiance.gamut_step(value, xyz_to_rgb_matrix())
    if lacquer:  # the mirror of its outer face, of the reflectance at the view's angle
        c = np.clip(wr[..., 2], 1e-3, 1.0)
        inside = np.sqrt(1.0 - (1.0 - c**2) / lacquer**2)
        s, p = (c - lacquer * inside) / (c + lacquer * inside), (lacquer * c - inside) / (lacquer * c + inside)
        with np.errstate(all="ignore"):
            shown = shown + (2.0 * 0.5 * (s**2 + p**2) * ggx_cos(wi, wr, rough**2))[..., None]
    truth = np.where(hit[..., None], shown, 0.0)
    where = hit & (wi[..., 2] > 0.1) & (wr[..., 2] > 0.15) & (truth.sum(-1) > 1e-3 * truth.max())
    assert_images_agree(image, truth, 0.02, where=where, name=f"viewport stuff {substrate} {lacquer}")


def test_a_studio_sun_is_mirrored_once(renderer, tmp_path):
    """EEVEE shows it in a lacquer's outer face: what is added to materials made of nodes is the diffraction alone."""
    import bpy
    from diffraction_shader.addon.viewport import surroundings

    table = bake(make_preset("stam_bumps", 8e-6, 96), BakeParameters(lacquer=1.5, detail=0.5))
    path = table.save(tmp_path / "table.exr")
    sphere = scenes.add_sphere(segments=64, rings=32)
    scenes.add_camera((0.4, -1.0, 0.5))
    made = materials.diffracting(sphere, path, "NODES")
    pixels = np.full((64, 128, 3), 0.1, np.float32)
    pixels[44:46, 88:90] = 5000.0
    picture_world(pixels)
    around = surroundings.Surroundings(
        sky=surroundings.of_world(bpy.context.scene.world).sky, lamps=False, sun_above=10.0
    )
    drawn = {}
    for roughness in (0.4, 0.8):
        made.node_tree.nodes["Diffraction"].inputs["LacquerRoughness"].default_value = roughness
        bpy.context.view_layer.update()
        renderer.clear()
        drawn[roughness] = drawing.alone(renderer, 32, around=around), drawing.alone(renderer, 32)
    assert drawn[0.4][0].max() > 0.01
    assert drawn[0.4][0] == pytest.approx(drawn[0.8][0])
    assert np.abs(drawn[0.4][1] - drawn[0.8][1]).max() > 0.1  # where the viewport shows the mirror itself
