# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that hold the surface's stuff: films and lacquer, in OSL, nodes and numpy alike."""

import numpy as np
import pytest

from precompute.bake import bake
from precompute.evaluate.surface import brdf
from precompute.light.colour import spectral_weights, xyz_to_rgb_matrix
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.stack import fresnel_exact, parse_stack
from tests.support.blender import materials, scenes
from tests.truth import radiance

FILM = parse_stack("au", ["2.35:250"])


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Three tables of one small relief: a film, a film under lacquer, lacquer alone."""
    folder = tmp_path_factory.mktemp("tables")
    relief = make_preset("stam_bumps", 8e-6, 96)
    made = {}
    for name, stuff in {"film": (FILM, None), "both": (FILM, "1.5"), "lacquer": (None, 1.5)}.items():
        table = bake(relief, BakeParameters(stack=stuff[0], lacquer=stuff[1], detail=0.5))
        made[name] = table, table.save(folder / f"{name}.exr")
    return made


def unit(*vector):
    return np.array(vector) / np.linalg.norm(vector)


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
@pytest.mark.parametrize("name", ["film", "both", "lacquer"])
def test_lamp_light_is_that_of_numpy(blender, saved, implementation, name):
    table, path = saved[name]
    plane, sun, view = scenes.add_plane(), unit(-0.3, -0.2, 0.9), unit(0.25, 0.35, 1.0)
    scenes.add_sun(sun)
    scenes.add_camera(view, extent=0.2)
    made = materials.diffracting(plane, path, implementation=implementation, environment=0)
    node = made.node_tree.nodes["Diffraction"]
    assert all(node.inputs[each].hide for each in ("Fresnel", "IOR", "ConductorN", "ConductorK"))
    assert node.inputs["LacquerRoughness"].hide == (name == "film")
    # A mirror as sharp as the face leaves the sun aside.
    node.inputs["LacquerRoughness"].default_value = 0.0
    image = scenes.render(4).mean((0, 1))
    f_cos = brdf(table, sun, view, energy_conserving=True) * sun[2]
    truth = radiance.gamut_step(f_cos, xyz_to_rgb_matrix())
    assert image == pytest.approx(truth, rel=0.01, abs=1e-4)


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_pigment_gets_what_the_stack_leaves(blender, saved, implementation):
    """A white sky and no lamp: the pigment sends back 1 - R(view), the lacquer's face R of its own."""
    for name in ("film", "lacquer"):
        table, path = saved[name]
        plane, view = scenes.add_plane(half=5.0), unit(0.6, 0.0, 1.0)
        scenes.add_camera(view, extent=0.2)
        made = materials.diffracting(plane, path, implementation, (1, 1, 1, 1), environment=0)
        made.node_tree.nodes["Diffraction"].inputs["LacquerRoughness"].default_value = 0.0
        world = blender.context.scene.world or blender.data.worlds.new("white")
        blender.context.scene.world = world
        from diffraction_shader.addon.versions import give_nodes

        give_nodes(world)
        world.node_tree.nodes["Background"].inputs[0].default_value = (1, 1, 1, 1)
        image = scenes.render(4, samples=16).mean((0, 1))
        kept = np.clip(xyz_to_rgb_matrix() @ table.reflectance(view[2]), 0, 1)
        if implementation == "NODES":
            kept = np.full(3, kept.mean())
        mirror = fresnel_exact(1.5, view[2]) if name == "lacquer" else 0.0
        assert image == pytest.approx(1.0 - kept + mirror, rel=0.02)
        blender.data.objects.remove(plane)


def test_row_of_the_table_is_what_the_formulas_say(saved):
    lam, weights = spectral_weights()
    table, _ = saved["both"]
    cosine = np.array([1.0, 0.7])
    inside = np.sqrt(1 - (1 - cosine**2) / 1.5**2)
    from precompute.stack import material_of

    r = FILM.reflectance(lam, inside, material_of(1.5)).T @ weights
    outer = fresnel_exact(1.5, cosine)[:, None]
    white = weights.sum(0)
    assert table.reflectance(cosine) == pytest.approx(white - (1 - outer) * (white - r), abs=3e-3)
