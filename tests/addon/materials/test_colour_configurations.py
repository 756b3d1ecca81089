# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour configurations that name their spaces otherwise: the same light in each, or one sentence."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender.extension import ROOT

#: Configurations that OpenColorIO has built in, and the working space that each means.
CONFIGURATIONS = {
    "ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1": "ACEScg",
    "ocio://cg-config-v2.1.0_aces-v1.3_ocio-v2.3": "ACEScg",
    "ocio://studio-config-v2.1.0_aces-v1.3_ocio-v2.3": "ACEScg",
    "ocio://default": "ACEScg",
}

PROGRAM = """
import json, sys, os
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
version = f"python{sys.version_info.major}.{sys.version_info.minor}"
packages = os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages")
sys.path.append(packages)  # oslquery, and OpenColorIO's module where told to
if BLIND:
    sys.modules["PyOpenColorIO"] = None
from tests.support.blender import extension, materials, scenes, tables
extension.load().register()
import numpy as np
from pathlib import Path
from diffraction_shader.addon import colour_spaces, pictures
from diffraction_shader.addon.viewport.data import display
folder = Path(sys.argv[1])
bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
bpy.context.scene.render.engine = "CYCLES"
bpy.context.scene.cycles.shading_system = True
tables.make_table(folder / "t.exr", tables.lobes)
sphere = scenes.add_sphere(segments=48, rings=24)
scenes.add_sun((0.3, 0.1, 0.9))
scenes.add_camera()
materials.diffracting(sphere, folder / "t.exr", implementation=sys.argv[2], fresnel="NONE", environment=0)
picture = np.full((2, 2, 3), 0.5)
shown = pictures.show(bpy.context, "grey", picture)
linear = pictures.show(bpy.context, "linear", picture, linear=True)
images = {image.name: image.colorspace_settings.is_data for image in bpy.data.images if image.name.startswith("t")}
rendered = scenes.render(24)
mean = np.asarray(rendered)[..., :3].mean((0, 1)).tolist()
print("FOUND " + json.dumps([colour_spaces.working_space(), images, mean]))
"""


def render(folder, implementation, configuration=None, blind=False):
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    environment.pop("OCIO", None)
    if configuration:
        environment["OCIO"] = configuration
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.replace("BLIND", str(blind)), str(folder), implementation],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    found = [line for line in done.stdout.splitlines() if line.startswith("FOUND ")]
    assert found, done.stdout + done.stderr
    space, images, rgb = json.loads(found[0][6:])
    assert images and all(images.values()), images
    return space, np.linalg.solve(xyz_to_rgb_matrix(space), rgb)


@pytest.mark.parametrize(
    ("implementation", "configuration", "blind"),
    [
        ("OSL", "ocio://cg-config-v2.1.0_aces-v1.3_ocio-v2.3", False),
        ("NODES", "ocio://cg-config-v2.1.0_aces-v1.3_ocio-v2.3", True),
        pytest.param("OSL", "ocio://cg-config-v1.0.0_aces-v1.3_ocio-v2.1", False, marks=pytest.mark.slow),
        pytest.param("OSL", "ocio://studio-config-v2.1.0_aces-v1.3_ocio-v2.3", True, marks=pytest.mark.slow),
        pytest.param("NODES", "ocio://default", False, marks=pytest.mark.slow),
        pytest.param("OSL", "ocio://default", True, marks=pytest.mark.slow),
    ],
)
def test_the_same_light_in_every_configuration(bpy_module, tmp_path, implementation, configuration, blind):
    """XYZ of a sphere's picture as in Blender's own configuration, with and without OpenColorIO's module.

    The gamut step acts in the working space, so that colours beyond Rec.709 differ a little.
    """
    if bpy_module.app.version < (5, 2):
        pytest.skip("Blender 4.5 has no working space but its own")
    (tmp_path / "own").mkdir()
    (tmp_path / "other").mkdir()
    space, own = render(tmp_path / "own", implementation)
    assert space == "Linear Rec.709"
    space, other = render(tmp_path / "other", implementation, configuration, blind)
    assert space == CONFIGURATIONS[configuration]
    np.testing.assert_allclose(other, own, rtol=0.01)
