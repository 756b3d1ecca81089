# SPDX-License-Identifier: GPL-3.0-or-later
"""Every panel in a real layout in every state of the work, and every grey button's reason."""

import re
import time
from pathlib import Path

import bpy
import pytest

from tests.support.blender import extension, scenes, tables
from tests.support.blender.panels import all_panels, everything, plane_with_material, preset, shown, words

STAGES = ["Scan", "Levelling", "Bake", "Material", "Viewport", "Evaluate"]


@pytest.fixture
def project(blender, tmp_path):
    """A saved, empty .blend."""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    return tmp_path


def stand_in_table(folder):
    """A table as if it had been baked of the scene's scan with the panel's settings; no bake."""
    from diffraction_shader.addon.tables import recipe

    state = bpy.context.scene.diffraction
    tables.make_table(folder / "diffraction" / "sinusoid.exr", tables.lobes)
    state.table_path = "//diffraction/sinusoid.exr"
    state.table_recipe = recipe.make(state)
    return state


def refusal(operator, **options):
    """Why a button is grey."""
    assert not operator.poll()
    with pytest.raises(RuntimeError) as caught:
        operator(**options)
    return str(caught.value)


def test_stages_stand_in_the_order_of_the_work(project):
    stages = [cls for cls in all_panels() if getattr(cls, "bl_parent_id", "") == "DIFFRACTION_PT_main"]
    labels = [cls.bl_label for cls in sorted(stages, key=lambda cls: cls.bl_order)]
    assert [label for label in labels if label in STAGES] == STAGES
    assert len({cls.bl_order for cls in stages if cls.bl_label in STAGES}) == len(STAGES)


def test_without_a_scan(project):
    everything()
    assert "Import a scan" in words(shown("scan"))
    assert "About" not in words(shown("bake"))
    assert "Import a scan or use a preset" in refusal(bpy.ops.diffraction.bake)
    assert "Import a scan or use a preset" in refusal(bpy.ops.diffraction.preview_levelling)
    assert "Bake a table first" in refusal(bpy.ops.diffraction.brdf_map)
    assert "Bake a table first" in refusal(bpy.ops.diffraction.apply_material)
    assert "No material" in refusal(bpy.ops.diffraction.rebake)
    assert "No table is missing" in refusal(bpy.ops.diffraction.find_files, directory="//")
    assert "active material has no table" in refusal(bpy.ops.diffraction.use_material_scan)
    assert "No scan is stored" in refusal(bpy.ops.diffraction.use_stored_scan)
    assert "no other channel" in refusal(bpy.ops.diffraction.choose_channel)
    assert shown("active") is None and shown("files") is None


def grey_without_a_reason():
    """Operators of ours whose button is grey and does not say why."""
    found = []
    for name in dir(bpy.ops.diffraction):
        operator = getattr(bpy.ops.diffraction, name)
        if not operator.poll():
            with pytest.raises(RuntimeError) as caught:
                operator()
            if "context is incorrect" in str(caught.value):
                found.append(name)
    return found


def test_every_grey_button_says_why(project):
    """In an empty file, with a scan, while something runs, with a table, with a material whose table is gone."""
    from diffraction_shader.addon.jobs import progress

    assert "bake" in dir(bpy.ops.diffraction)
    assert grey_without_a_reason() == []
    preset()
    assert grey_without_a_reason() == []
    progress.show("Baking", 0.5)
    try:
        assert grey_without_a_reason() == []
    finally:
        progress.clear()
    stand_in_table(project)
    assert grey_without_a_reason() == []
    plane_with_material()
    assert grey_without_a_reason() == []
    (project / "diffraction" / "sinusoid.exr").unlink()
    assert grey_without_a_reason() == []


def test_collecting_needs_a_saved_file(blender):
    assert "Save the .blend first" in refusal(bpy.ops.diffraction.collect_files)


def test_with_a_scan(project):
    state = preset()
    text = words(shown("scan"))
    assert "sinusoid.gsf" in text and "128 x 128 px" in text and "10 x 10 um" in text
    assert "Estimating" in words(shown("bake"))
    deadline = time.monotonic() + 120.0
    while "Estimating" in words(shown("bake")) and time.monotonic() < deadline:
        time.sleep(0.05)
    text = words(shown("bake"))
    for pattern in (
        r"About \d+ (s|min), \d+ terms",
        r"\d+ MB of memory",
        r"\d+ MB on disk",
        r"\d+ MB of texture to render",
    ):
        assert re.search(pattern, text), text
    state.limit_mb = 1
    from diffraction_shader.addon.tables import estimates

    assert "limit" in estimates.estimate(bpy.context.scene, wait=True).error
    assert "more than the limit" in words(shown("bake"))
    assert bpy.ops.diffraction.bake.poll() and bpy.ops.diffraction.preview_levelling.poll()
    everything()


def test_with_the_stored_scan_missing(project):
    """A preset has no other origin: panel and button say that it is gone."""
    state = preset()
    Path(bpy.path.abspath(state.scan_path)).unlink()
    assert "The stored scan is missing" in words(shown("scan"))
    from diffraction_shader.addon.tables import estimates

    assert "import it again" in estimates.estimate(bpy.context.scene, wait=True).error
    assert "import it again" in words(shown("bake"))
    with pytest.raises(RuntimeError, match="is gone"):
        bpy.ops.diffraction.bake()
    everything()


@pytest.mark.parametrize("ensemble", ["average", "single", "periodic"])
def test_every_ensemble_has_an_estimate(project, ensemble):
    from diffraction_shader.addon.tables import estimates

    state = preset()
    state.ensemble, state.detail = ensemble, 0.25
    found = estimates.estimate(bpy.context.scene, wait=True)
    assert found.error == "" and found.cost.seconds > 0.0 and found.cost.memory_bytes > found.cost.texel_bytes
    everything()


def test_units_are_in_the_labels(project):
    preset()
    text = everything()
    for label in ("Coherence (um)", "Keep (%)", "Limit (MB)", "Period (um)", "Amplitude (nm)", "Size (um)"):
        assert label in text, label


def test_every_preset_has_its_parameters_in_the_panel(project):
    from diffraction_shader.addon import preset_properties
    from diffraction_shader.precompute.presets import PRESETS

    state = bpy.context.scene.diffraction
    for name, structure in PRESETS.items():
        state.preset = name
        text = shown("preset")
        for parameter in structure.parameters:
            assert preset_properties.label(parameter) in text
        assert structure.source.split()[0] in words(text)


def test_parameters_of_a_preset_arrive(project):
    from precompute.presets import make_preset
    from precompute.readers import read_scan

    assert bpy.ops.diffraction.make_preset(preset="blazed", size_um=10, period_um=1.25) == {"FINISHED"}
    stored = read_scan(bpy.path.abspath(bpy.context.scene.diffraction.scan_path))
    expected = make_preset("blazed", 10e-6, period_um=1.25)
    assert stored.heights == pytest.approx(expected.heights, abs=1e-13)


def test_while_baking(project):
    from diffraction_shader.addon.jobs import progress

    preset()
    progress.show("Baking: transforms", 0.42, "diffraction.bake")
    try:
        # In the place of its own button, so that nothing jumps.
        assert "Baking: transforms, Esc stops" in shown("bake") and '"draw_string": "Bake"' not in shown("bake")
        for name in ("main", "levelling", "scan"):
            assert "Esc stops" not in shown(name)
        for operator in ("bake", "preview_levelling", "make_preset", "import_scan", "use_stored_scan", "reflectance"):
            assert "Esc stops it" in refusal(getattr(bpy.ops.diffraction, operator))
        everything()
    finally:
        progress.clear()
    assert bpy.ops.diffraction.bake.poll()


def test_baked_then_stale_then_baked_again(project):
    state = preset()
    assert bpy.ops.diffraction.bake(detail=0.25, clip_percent=99.5) == {"FINISHED"}
    assert (state.detail, state.clip_percent) == (0.25, 99.5)  # the panel shows what was baked
    text = words(shown("bake"))
    assert "sinusoid.exr" in text and "MB of texture" in text and "Changed since" not in text
    state.sigma_s_um, state.level = 0.9, "plane"
    assert "Changed since the bake: Levelling, Coherence (um)." in words(shown("bake"))
    assert bpy.ops.diffraction.bake() == {"FINISHED"}  # takes what the panel holds
    assert "Changed since" not in words(shown("bake"))
    preset(amplitude_nm=40)
    assert "Changed since the bake: Scan." in words(shown("bake"))
    everything()


def test_row_alignment_on_a_grating_along_the_lines_warns_in_the_panel(project):
    """The grating's period runs along y once turned, so that each scan line along x is one of its lines."""
    preset()
    state = bpy.context.scene.diffraction
    path = bpy.path.abspath(state.scan_path)
    assert bpy.ops.diffraction.import_scan(filepath=path, turn="1") == {"FINISHED"}
    from diffraction_shader.addon.tables import estimates

    state.align_rows = "y"
    assert estimates.estimate(bpy.context.scene, wait=True).warnings == ()
    state.align_rows = "x"
    (warning,) = estimates.estimate(bpy.context.scene, wait=True).warnings
    assert "removed a period of 2 um" in warning
    assert "removed a period of 2 um" in words(shown("levelling"))
    assert bpy.ops.diffraction.preview_levelling() == {"FINISHED"}  # told as a warning there too


def test_crop_smooth_and_tile_reach_the_core(project):
    from diffraction_shader.addon.tables import bake_settings

    state = preset()
    state.use_crop, state.crop_um = True, (1.0, 6.0, 2.0, 7.5)
    state.smooth_nm, state.tile, state.clip_percent = 25.0, "blend", 99.9
    chosen = bake_settings.parameters(state)
    assert chosen.crop_m == pytest.approx((1e-6, 6e-6, 2e-6, 7.5e-6), rel=1e-12)
    assert (chosen.smooth_m, chosen.tile, chosen.clip_percent) == (pytest.approx(25e-9), "blend", 99.9)
    assert "Left (um)" in shown("levelling") and '"Top"' in shown("levelling")
    state.crop_um = (6.0, 1.0, 2.0, 7.0)
    assert "A crop from 6 to 1 um in x" in words(shown("bake"))
    with pytest.raises(RuntimeError, match="left < right"):
        bpy.ops.diffraction.bake()


def test_another_scan_of_the_same_name_does_not_take_the_place_of_a_baked_one(project):
    state = preset(amplitude_nm=40)
    (project / "diffraction" / "sinusoid.exr").write_bytes(b"a table")
    before = (project / "diffraction" / "sinusoid.gsf").read_bytes()
    preset(amplitude_nm=60)
    assert state.scan_path == "//diffraction/sinusoid_1.gsf"
    preset(amplitude_nm=70)  # not baked: replaced
    assert state.scan_path == "//diffraction/sinusoid_1.gsf"
    preset(amplitude_nm=40)  # the same as the first
    assert state.scan_path == "//diffraction/sinusoid.gsf"
    assert (project / "diffraction" / "sinusoid.gsf").read_bytes() == before


def test_missing_old_and_damaged_tables(project):
    from diffraction_shader.addon.materials.node import group

    preset()
    stand_in_table(project)
    plane = plane_with_material()
    atlas, sidecar = (project / "diffraction" / f"sinusoid.{suffix}" for suffix in ("exr", "json"))
    everything()
    assert re.search(r"sinusoid.exr: \d+ MB, 1 material", words(shown("files")))
    assert "diffraction.rebake" not in shown("files")
    good = sidecar.read_text()

    sidecar.write_text(good.replace('"format_version": 2', '"format_version": 7'))
    assert "another release (format 7, now 2)" in words(shown("bake"))
    assert "another release" in words(shown("active"))
    assert "another release" in refusal(bpy.ops.diffraction.brdf_map)
    sidecar.write_text("{")
    assert "no JSON" in words(shown("bake"))
    sidecar.write_text(good)
    assert "another release" not in words(shown("bake"))
    atlas.unlink()
    for name in ("bake", "active"):
        assert "sinusoid.exr is not in" in words(shown(name))
    assert "diffraction.rebake" in shown("active") and "diffraction.find_files" in shown("files")
    everything()
    assert bpy.ops.diffraction.rebake.poll() and bpy.ops.diffraction.find_files.poll()

    elsewhere = project / "backup" / "2024"
    tables.make_table(elsewhere / "sinusoid.exr", tables.lobes)
    assert bpy.ops.diffraction.find_files(directory=str(project / "backup")) == {"FINISHED"}
    assert group.owner(plane.active_material)["diffraction_table"] == "//backup/2024/sinusoid.exr"
    assert "diffraction.collect_files" in shown("files")
    assert bpy.ops.diffraction.collect_files() == {"FINISHED"}
    assert group.owner(plane.active_material)["diffraction_table"] == "//diffraction/sinusoid.exr"
    assert atlas.is_file()


def test_material_panel_follows_the_choice(project):
    from diffraction_shader.addon.versions import EEVEE

    preset()
    state = stand_in_table(project)
    assert "Select an object" in refusal(bpy.ops.diffraction.apply_material)
    plane_with_material()
    assert '"IOR"' in shown("material")
    state.fresnel = "CONDUCTOR"
    assert '"IOR"' not in shown("material")
    for orientation in ("UV", "ATTRIBUTE", "RADIAL", "TEXTURE"):
        state.orientation = orientation
        everything()
    state.implementation = "NODES"
    bpy.context.scene.render.engine = EEVEE
    assert "four lamps" in words(shown("material"))
    bpy.context.scene.render.engine = "CYCLES"
    assert "four lamps" not in words(shown("material"))
    text = words(shown("active"))
    assert "MB of texture" in text


def test_several_scans_and_materials(project):
    """Each material keeps its table, scan and settings; the panel goes back to those of the active one."""
    from diffraction_shader.addon.materials import travel

    state = bpy.context.scene.diffraction
    planes = []
    for name, level in (("sinusoid", "plane"), ("blazed", "none")):
        bpy.ops.diffraction.make_preset(preset=name, size_um=8)
        assert bpy.ops.diffraction.bake(detail=0.2, level=level) == {"FINISHED"}
        for ob in bpy.context.scene.objects:
            ob.select_set(False)
        planes.append(plane_with_material())
    stems = [travel.recipe_of(p.active_material)["scan"] for p in planes]
    assert stems == ["sinusoid.gsf", "blazed.gsf"]
    bpy.context.view_layer.objects.active = planes[0]
    assert bpy.ops.diffraction.use_material_scan() == {"FINISHED"}
    assert (state.scan_path, state.level) == ("//diffraction/sinusoid.gsf", "plane")
    assert state.table_path == "//diffraction/sinusoid.exr"
    assert "Changed since" not in words(shown("bake"))
    before = (project / "diffraction" / "blazed.exr").read_bytes()
    state.level = "poly2"
    assert bpy.ops.diffraction.bake() == {"FINISHED"}
    recipes = [travel.recipe_of(p.active_material)["settings"]["level"] for p in planes]
    assert recipes == ["poly2", "none"]
    assert (project / "diffraction" / "blazed.exr").read_bytes() == before


def test_stored_scans_can_be_taken_up_again(project):
    state = preset()
    bpy.ops.diffraction.make_preset(preset="blazed", size_um=10)
    assert state.scan_path == "//diffraction/blazed.gsf"
    assert bpy.ops.diffraction.use_stored_scan(name="sinusoid") == {"FINISHED"}
    assert state.scan_path == "//diffraction/sinusoid.gsf"
    with pytest.raises(RuntimeError, match="no stored scan 'nothing'"):
        bpy.ops.diffraction.use_stored_scan(name="nothing")


def test_scale_warnings(project):
    from diffraction_shader.addon.materials import scale

    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 1000
    cube = scenes.add_plane()  # 2 units
    bpy.context.view_layer.update()
    side = max(cube.dimensions)
    assert scale.warnings(scene, cube, "average", 6.5e-6, 65e-6) == []
    scene.unit_settings.scale_length = 1e-6 / side  # the plane is 1 um long
    (text,) = scale.warnings(scene, cube, "average", 6.5e-6, 65e-6)
    assert "1 um" in text and "13 um" in text
    scene.unit_settings.scale_length = 50e-6 / side
    (text,) = scale.warnings(scene, cube, "average", 1e-6, 65e-6)
    assert "smaller than the scanned patch" in text
    scene.unit_settings.scale_length = 0.1 / side  # a pixel covers 100 um, the window 32.5 um
    assert scale.warnings(scene, cube, "single", 5e-6, 65e-6)[0].count("Average") == 1
    assert scale.warnings(scene, cube, "single", 16.25e-6, 65e-6) == []
    assert scale.warnings(scene, None, "single", 5e-6, 65e-6) == []


def test_orientation_of_an_import(project, tmp_path):
    """Flips and quarter turns are the core's."""
    import numpy as np

    from precompute.readers import read_scan
    from precompute.scan.gsf import write_gsf
    from precompute.scan.heightfield import HeightField
    from precompute.scan.orientation import flip_x, rotate90

    heights = np.random.default_rng(3).normal(0.0, 1e-8, (6, 8))
    path = write_gsf(HeightField(heights, 1e-7, 1e-7), tmp_path / "one.gsf")
    state = bpy.context.scene.diffraction
    assert bpy.ops.diffraction.import_scan(filepath=str(path), flip_x=True, turn="1") == {"FINISHED"}
    stored = read_scan(bpy.path.abspath(state.scan_path))
    expected = rotate90(flip_x(read_scan(path)), 1)
    assert stored.heights == pytest.approx(expected.heights, abs=1e-14)
    assert [step["step"] for step in stored.processing] == ["flip x", "rotate"]
    assert bpy.ops.diffraction.bake.poll()


def test_other_channels_are_offered(project, tmp_path):
    import numpy as np
    from gwyfile.objects import GwyContainer, GwyDataField

    from precompute.readers import read_scan

    heights = np.random.default_rng(4).normal(0.0, 1e-8, (2, 12, 12))
    container = GwyContainer()
    for index, title in enumerate(("Height", "Second height")):
        container[f"/{index}/data/title"] = title
        container[f"/{index}/data"] = GwyDataField(heights[index], 1e-6, 1e-6, si_unit_xy="m", si_unit_z="m")
    container.tofile(str(tmp_path / "two.gwy"))
    state = bpy.context.scene.diffraction
    assert bpy.ops.diffraction.import_scan(filepath=str(tmp_path / "two.gwy")) == {"FINISHED"}
    assert "Other Channels" in shown("scan")
    for index in (1, 0):
        assert bpy.ops.diffraction.choose_channel(channel=str(index)) == {"FINISHED"}
        stored = read_scan(bpy.path.abspath(state.scan_path)).heights
        assert stored == pytest.approx(heights[index][::-1], abs=1e-14)
    (tmp_path / "two.gwy").unlink()
    assert "is gone" in refusal(bpy.ops.diffraction.choose_channel)
    everything()


def test_level_preview_and_map_become_images(project):
    preset()
    assert bpy.ops.diffraction.preview_levelling() == {"FINISHED"}
    image = bpy.data.images["Diffraction Levelling"]
    assert tuple(image.size) == (1280, 960) and image.packed_file is not None
    assert tuple(image.preview.image_size) == (320, 320) and max(image.preview.image_pixels_float[:64]) > 0.05
    everything()
    stand_in_table(project)
    assert bpy.ops.diffraction.brdf_map(theta=0.4, size=64, linear=True) == {"FINISHED"}
    import numpy as np

    from precompute.evaluate.directions import disc_directions, from_angles
    from precompute.evaluate.surface import brdf
    from precompute.light.colour import xyz_to_rgb
    from precompute.table.table import SpectralTable

    image = bpy.data.images["BRDF sinusoid"]
    pixels = np.array(image.pixels[:]).reshape(64, 64, 4)[..., :3]
    directions, inside = disc_directions(64)
    table = SpectralTable.load(project / "diffraction" / "sinusoid.exr")
    truth = xyz_to_rgb(brdf(table, from_angles(np.float32(0.4), 0.0), directions[inside]))
    assert pixels[inside] == pytest.approx(truth, rel=1e-3, abs=1e-4)
    assert np.all(pixels[~inside] == 0.0)
    assert bpy.ops.diffraction.brdf_map(size=32) == {"FINISHED"}
    assert not bpy.data.images["BRDF sinusoid"].is_float


def test_reflectance_finds_the_period(project):
    """A sine of 1.25 um; the first order leaves where the grating equation says."""
    assert "Import a scan or use a preset" in refusal(bpy.ops.diffraction.reflectance)
    assert bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=25, period_um=1.25) == {"FINISHED"}
    assert bpy.ops.diffraction.reflectance(theta=0.1) == {"FINISHED"}
    state = bpy.context.scene.diffraction
    found = float(re.search(r"colours ([0-9.]+) nm", state.plot_result).group(1))
    assert found == pytest.approx(1250.0, rel=0.01)
    assert bpy.data.images["Diffraction Reflectance"].packed_file is not None
    assert "Period by the colours" in words(shown("reflectance"))
    with pytest.raises(RuntimeError, match="does not leave"):
        bpy.ops.diffraction.reflectance(theta=1.4, order=-4)
    bpy.ops.diffraction.make_preset(preset="flat")
    with pytest.raises(RuntimeError, match="no dominant period"):
        bpy.ops.diffraction.reflectance()


def test_kept_settings_come_back(project):
    state = preset()
    state.level, state.sigma_s_um = "plane", 3.5
    assert bpy.ops.diffraction.bake_preset_add(name="mine") == {"FINISHED"}
    state.preset, state.presets.blazed.period_um = "blazed", 1.75
    assert bpy.ops.diffraction.structure_preset_add(name="ruled") == {"FINISHED"}
    state.level, state.sigma_s_um = "none", 0.0
    state.preset, state.presets.blazed.period_um = "cd", 2.5
    for menu, folder, name in (("bake", "bake", "mine"), ("structure", "structure", "ruled")):
        roots = bpy.utils.preset_paths(f"diffraction/{folder}")
        (path,) = [entry for root in roots for entry in Path(root).glob(f"{name}.py")]
        bpy.ops.script.execute_preset(filepath=str(path), menu_idname=f"DIFFRACTION_MT_{menu}_presets")
    assert (state.level, state.sigma_s_um) == ("plane", 3.5)
    assert state.preset == "blazed" and state.presets.blazed.period_um == 1.75


class Window:
    """What a modal operator needs of Blender, without a window."""

    def __init__(self):
        self.texts, self.timers = [], 0
        self.workspace = self
        self.window_manager = self
        self.windows = []
        self.window = None
        self.scene = bpy.context.scene

    def status_text_set(self, text):
        self.texts.append(text)

    def event_timer_add(self, seconds, window):
        self.timers += 1
        return "timer"

    def event_timer_remove(self, timer):
        self.timers -= 1

    def modal_handler_add(self, operator):
        pass


class Event:
    def __init__(self, kind, value="PRESS"):
        self.type, self.value = kind, value


def modal(work, events):
    """Run a threaded operator by hand: what it returned and told."""
    from diffraction_shader.addon.jobs.job import Job
    from diffraction_shader.addon.jobs.threaded import Threaded

    class Operator(Threaded):
        title = "Testing"
        told = []

        def jobs(self, context):
            return [Job(work)]

        def finished(self, context, results):
            return f"made {results}"

        def report(self, level, text):
            self.told.append((level, text))

    window, operator = Window(), Operator()
    assert operator.invoke(window, None) == {"RUNNING_MODAL"}
    result = {"RUNNING_MODAL"}
    deadline = time.monotonic() + 60.0
    while "RUNNING_MODAL" in result and time.monotonic() < deadline:
        time.sleep(0.01)
        result = operator.modal(window, events.pop(0) if events else Event("TIMER"))
    return result, operator.told, window


def test_a_threaded_operator_tells_its_progress_and_cleans_up(project):
    from diffraction_shader.addon.jobs import progress

    def work(report):
        report("first", 0.25)
        time.sleep(0.1)
        return 7

    result, told, window = modal(work, [Event("TIMER")])
    assert result == {"FINISHED"}
    assert told == [({"INFO"}, "made [7]")]
    assert window.timers == 0 and progress.running() is None
    assert window.texts[-1] is None and callable(window.texts[0])


def test_esc_stops_a_threaded_operator(project):
    from diffraction_shader.addon.jobs import progress

    def work(report):
        for _ in range(6000):
            report("on", 0.5)
            time.sleep(0.01)

    result, told, window = modal(work, [Event("TIMER"), Event("ESC")])
    assert result == {"CANCELLED"}
    assert told == [({"WARNING"}, "Testing was stopped; nothing was written")]
    assert window.timers == 0 and progress.running() is None


def test_disabling_the_extension_stops_a_threaded_operator(project, monkeypatch):
    """Blender frees the operator without a word; the next one would find a computation that never ends."""
    from types import SimpleNamespace

    from diffraction_shader.addon import operators
    from diffraction_shader.addon.jobs import job, progress, threaded
    from diffraction_shader.precompute.errors import Cancelled

    operators.unregister()  # nothing is at work

    def work(report):
        for _ in range(6000):
            report("on", 0.5)
            time.sleep(0.01)

    class Operator(threaded.Threaded):
        def jobs(self, context):
            self.last = job.Job(work)
            return [self.last]

    window, operator = Window(), Operator()
    operator.invoke(window, None)
    monkeypatch.setattr(threaded, "bpy", SimpleNamespace(context=window))
    operators.unregister()
    assert window.timers == 0 and progress.running() is None and window.texts[-1] is None
    with pytest.raises(Cancelled):
        operator.last.result()


def given(cls, **values):
    """Stands in for an operator that a panel's button calls."""
    values["properties"] = type("Given", (), {"is_property_set": lambda self, name, ghost=True: name in values})()
    return type("Operator", (), {**values, "jobs": cls.jobs, "finished": cls.finished})()


def test_reading_a_scan_and_making_a_structure_can_be_stopped(project, tmp_path):
    """They run away from Blender; Esc leaves no file and the scene as it was."""
    from diffraction_shader.addon.operators import import_scan, make_preset
    from diffraction_shader.precompute.errors import Cancelled
    from diffraction_shader.precompute.presets import make_preset as heights
    from diffraction_shader.precompute.scan.gsf import write_gsf

    state, stored = bpy.context.scene.diffraction, project / "diffraction"
    source = write_gsf(heights("blazed", 8e-6, 64), tmp_path / "own.gsf")
    reading = given(
        import_scan.DIFFRACTION_OT_import_scan,
        size_um=(0.0, 0.0), height_nm=0.0, flip_x=True, flip_y=False, turn="0", channel="", filepath=str(source),
        trust_units=False,
    )  # fmt: skip
    making = given(
        make_preset.DIFFRACTION_OT_make_preset, preset="sinusoid", size_um=8.0, pixels=64, period_um=1.5, look=False
    )
    for operator, name in ((reading, "own"), (making, "sinusoid")):
        (job,) = operator.jobs(bpy.context)
        job.cancel()
        assert job.stage == "stopping"  # what panel and status bar say until the next step
        job.start()
        with pytest.raises(Cancelled):
            job.result()
        assert not stored.is_dir() or list(stored.glob(f"{name}*")) == []
        before = state.scan_path
        (job,) = operator.jobs(bpy.context)
        job.start()
        result = job.result()
        assert job.fraction > 0.5 and state.scan_path == before  # a thread does not touch the scene
        assert name in operator.finished(bpy.context, [result]).lower()
        assert state.scan_path == f"//diffraction/{name}.gsf"


def test_an_error_in_the_thread_becomes_one_sentence(project):
    extension.load()
    from diffraction_shader.precompute.errors import ScanError

    def work(report):
        raise ScanError("The scan is no scan; choose another.")

    result, told, window = modal(work, [])
    assert result == {"CANCELLED"}
    assert told == [({"ERROR"}, "The scan is no scan; choose another.")]
    assert window.timers == 0


def table_bytes(project):
    from precompute.table.table import read_sidecar

    layout = read_sidecar(project / "diffraction" / "sinusoid.exr")["layout"]
    return layout["width"] * layout["height"] * 8


def test_the_estimate_of_the_table_is_the_table(project):
    """Texture size exactly as planned, files within a tenth; an error asks for no more than is said."""
    from diffraction_shader.addon.tables import estimates

    state = preset()
    state.detail, state.error_percent = 0.25, 1.0
    found = estimates.estimate(bpy.context.scene, wait=True)
    assert bpy.ops.diffraction.bake() == {"FINISHED"}
    assert table_bytes(project) <= found.cost.refined_bytes
    state.error_percent = 100.0
    found = estimates.estimate(bpy.context.scene, wait=True)
    assert bpy.ops.diffraction.bake() == {"FINISHED"}
    from precompute.table.table import read_sidecar

    path = project / "diffraction" / "sinusoid.exr"
    assert found.cost.texel_bytes == table_bytes(project)
    assert found.cost.nodes == read_sidecar(path)["terms"]
    assert found.cost.disk_bytes == pytest.approx(path.stat().st_size, rel=0.1)
