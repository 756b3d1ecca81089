# SPDX-License-Identifier: GPL-3.0-or-later
"""Never black, never silent: what Automatic chooses, and what a Blender without OSL says."""

import bpy
import pytest

from tests.support.blender import scenes

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def plane(blender, tmp_path):
    """A selected plane in a saved file whose scene has a table."""
    return scenes.plane_with_table(tmp_path)


@pytest.fixture
def renderers(monkeypatch):
    """The module that chooses."""
    from diffraction_shader.addon import renderers

    return renderers


def implementation(ob):
    from diffraction_shader.addon.materials import material

    return "OSL" if material.needs_osl(ob.active_material) else "NODES"


@pytest.mark.parametrize(
    ("engine", "osl", "device", "in_window", "in_background"),
    [
        ("CYCLES", True, "", "OSL", "OSL"),
        ("CYCLES", True, "CUDA", "NODES", "OSL"),
        ("CYCLES", False, "", "NODES", "NODES"),
        ("EEVEE", True, "", "NODES", "OSL"),
        ("EEVEE", False, "", "NODES", "NODES"),
        ("BLENDER_WORKBENCH", True, "", "NODES", "OSL"),
    ],
)
def test_automatic_takes_what_renders(renderers, monkeypatch, engine, osl, device, in_window, in_background):
    scene = bpy.context.scene
    scene.render.engine = renderers.EEVEE if engine == "EEVEE" else engine
    monkeypatch.setattr(renderers, "has_osl", lambda: osl)
    monkeypatch.setattr(renderers, "device_without_osl", lambda scene: device)
    kind, why = renderers.choose(scene, background=False)
    assert kind == in_window and why
    assert renderers.choose(scene, background=True)[0] == in_background
    assert renderers.choose(scene)[0] == in_background  # the tests have no window


def test_a_gpu_without_osl_is_known(renderers):
    scene, preferences = bpy.context.scene, bpy.context.preferences.addons["cycles"].preferences
    assert renderers.has_osl()
    assert renderers.device_without_osl(scene) == ""
    scene.cycles.device = "GPU"
    assert renderers.device_without_osl(scene) == ""  # no device is chosen: Cycles takes the processor
    for kind in ("CUDA", "OPTIX"):
        try:
            preferences.compute_device_type = kind
        except TypeError:
            continue  # not in this build
        assert renderers.device_without_osl(scene) == ("" if kind == "OPTIX" else kind)
    preferences.compute_device_type = "NONE"


def test_automatic_takes_nodes_where_optix_has_no_room(plane, capfd, renderers, monkeypatch):
    """A device of which only its name is known here: 14 lamps fit OptiX over a plain pigment, 15 do not."""
    from diffraction_shader.addon.materials import closures
    from diffraction_shader.addon.watch import misfits

    scene = bpy.context.scene
    monkeypatch.setattr(renderers, "_gpu", lambda scene: "OPTIX")
    for number in range(13):
        scenes.add_sun((0.1 * number - 0.7, 0.3, 1.0))
    assert bpy.ops.diffraction.apply_material(environment=0) == {"FINISHED"}
    assert implementation(plane) == "OSL" and misfits.misfits(scene) == []
    assert closures.lamps_on_optix(plane.active_material) == 14
    scenes.add_sun((0.7, 0.9, 1.0))
    bpy.context.view_layer.update()
    assert misfits.misfits(scene) == [plane.active_material]
    assert "OptiX has no room" in misfits.why(scene)
    assert bpy.ops.diffraction.fit_renderer() == {"FINISHED"}
    assert implementation(plane) == "NODES" and misfits.misfits(scene) == []
    plane.data.materials.clear()
    assert bpy.ops.diffraction.apply_material(environment=0) == {"FINISHED"}
    assert implementation(plane) == "NODES"
    assert "set up with Nodes, because with this scene's lamps it takes 1,080 bytes" in capfd.readouterr().out
    monkeypatch.setattr(renderers, "_gpu", lambda scene: "")
    assert bpy.ops.diffraction.apply_material(environment=0) == {"FINISHED"}
    assert implementation(plane) == "OSL"


def test_automatic_is_the_default_and_told(plane, capfd, renderers, monkeypatch):
    state = bpy.context.scene.diffraction
    assert state.implementation == "AUTO"
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    assert implementation(plane) == "OSL"
    monkeypatch.setattr(renderers, "has_osl", lambda: False)
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    assert implementation(plane) == "NODES"
    assert "with Nodes, because this Blender was built without Open Shading Language" in capfd.readouterr().out


def test_stored_choices_keep_their_meaning(plane):
    """Files keep numbers: 0 was OSL in 0.1.0 and 1 Nodes."""
    state = bpy.context.scene.diffraction
    items = {item.identifier: item.value for item in state.bl_rna.properties["implementation"].enum_items}
    assert items == {"OSL": 0, "NODES": 1, "AUTO": 2}


def test_without_osl_one_sentence_and_nothing_left(plane, renderers, monkeypatch):
    monkeypatch.setattr(renderers, "has_osl", lambda: False)
    before = [len(getattr(bpy.data, kind)) for kind in ("materials", "texts", "images", "node_groups")]
    for _ in range(2):
        with pytest.raises(RuntimeError, match="built without Open Shading Language") as caught:
            bpy.ops.diffraction.apply_material(implementation="OSL")
        assert "Traceback" not in str(caught.value)
    assert [len(getattr(bpy.data, kind)) for kind in ("materials", "texts", "images", "node_groups")] == before


def test_what_fails_half_way_leaves_nothing(plane, monkeypatch):
    from diffraction_shader.addon.materials import material
    from diffraction_shader.precompute.errors import TableError

    real = material.apply

    def fail(*arguments):
        real(*arguments)
        raise TableError("The disk is full; make room.")

    monkeypatch.setattr(material, "apply", fail)
    before = [len(getattr(bpy.data, kind)) for kind in ("materials", "texts", "images", "node_groups")]
    with pytest.raises(RuntimeError, match="disk is full"):
        bpy.ops.diffraction.apply_material()
    assert [len(getattr(bpy.data, kind)) for kind in ("materials", "texts", "images", "node_groups")] == before
    assert plane.active_material is None


def test_a_shared_material_is_said_and_can_be_kept_apart(plane, capfd):
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    other = scenes.add_plane()
    other.data.materials.append(plane.active_material)
    bpy.context.view_layer.update()
    capfd.readouterr()
    assert bpy.ops.diffraction.apply_material(ior=1.4) == {"FINISHED"}
    assert f"{other.name} shares" in capfd.readouterr().out
    assert other.active_material == plane.active_material
    assert bpy.ops.diffraction.apply_material(ior=1.3, own_copy=True) == {"FINISHED"}
    assert "shares" not in capfd.readouterr().out
    assert other.active_material != plane.active_material
    ior = [ob.active_material.node_tree.nodes["Diffraction"].inputs["IOR"].default_value for ob in (plane, other)]
    assert ior == pytest.approx([1.3, 1.4])


def test_untouched_grey_gives_way_to_a_dark_ground_on_request(plane):
    """Colours drown in the grey that Blender starts with; whatever somebody has touched stays."""
    from tests.support.blender import extension

    grey = bpy.data.materials.new("Material")
    extension.give_nodes(grey)
    plane.data.materials.append(grey)
    bpy.context.view_layer.update()

    def pigment():
        return plane.active_material.node_tree.nodes["Diffraction"].inputs["Base"].links[0].from_node.bl_idname

    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}  # a script that says nothing keeps what is there
    assert pigment() == "ShaderNodeBsdfPrincipled"
    plane.active_material = grey
    assert bpy.ops.diffraction.apply_material(dark_ground=True) == {"FINISHED"}
    assert pigment() == "ShaderNodeBsdfDiffuse"
    grey.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
    plane.active_material = grey
    assert bpy.ops.diffraction.apply_material(dark_ground=True) == {"FINISHED"}
    assert pigment() == "ShaderNodeBsdfPrincipled"


def test_the_start_up_files_material_is_untouched(blender):
    from diffraction_shader.addon.operators.apply_material import untouched

    bpy.ops.wm.read_factory_settings()
    assert untouched(bpy.data.materials["Material"])
    bpy.ops.wm.read_factory_settings(use_empty=True)
