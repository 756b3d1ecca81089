# SPDX-License-Identifier: GPL-3.0-or-later
"""From a scan to a picture, as a user would do it: `demo.py [--scan FILE [--size-um S] [--height-nm H]] [--out DIR]`.

Builds the extension for this platform, installs it into an empty Blender, and there imports the scan (by default the
preset snake), bakes it, applies the material to the sample scene and renders. Writes `snake.png` and `brdf_map.png`.
"""

import argparse
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # a script: its folder alone is on the path


from tools.build.build_extension import build
from tools.build.check_manifest import main as check_manifest
from tools.build.fetch_wheels import ROOT, chosen_platforms, chosen_pythons

MODULE = "bl_ext.user_default.diffraction_shader"


@contextmanager
def step(sentence):
    """Say what is being done and how long it took."""
    print(f"{sentence} ...", flush=True)
    start = time.perf_counter()
    yield
    print(f"    {time.perf_counter() - start:.1f} s", flush=True)


def precompute(*arguments):
    """Run the command line of `precompute`; stop where it fails, it has said why."""
    done = subprocess.run([sys.executable, "-m", "precompute", *map(str, arguments)], cwd=ROOT, check=False)
    if done.returncode:
        sys.exit(done.returncode)


def empty_blender(user):
    """Blender as a module whose user folder is `user`: an empty one, so that nothing of this machine plays a part."""
    os.environ["BLENDER_USER_RESOURCES"] = str(user)
    import bpy

    return bpy


def install(bpy, path):
    """Install and enable the extension's zip. FINISHED proves nothing, so look for it."""
    bpy.ops.extensions.package_install_files(
        filepath=str(path), repo="user_default", enable_on_install=True, overwrite=True
    )
    if MODULE not in bpy.context.preferences.addons or not hasattr(bpy.types, "DIFFRACTION_OT_bake"):
        sys.exit(f"The extension {path} was not enabled in Blender {bpy.app.version_string}.")


def sample_scene():
    """The module that builds the sample scene; it is no part of the extension."""
    spec = importlib.util.spec_from_file_location("build_scene", ROOT / "sample_blend" / "build_scene.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # its dataclasses look themselves up
    spec.loader.exec_module(module)
    return module


def operate(operator, **properties):
    """Call an operator; what it reports as an error ends the demo in one sentence."""
    try:
        outcome = operator(**properties)
    except RuntimeError as error:
        sys.exit(str(error).removeprefix("Error: ").strip())
    if outcome != {"FINISHED"}:
        sys.exit(f"{operator.idname_py()} ended with {outcome}.")


def render(bpy, path, samples):
    """Render the scene with Cycles and OSL on the CPU to a PNG."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    if samples:
        scene.cycles.samples = samples
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def run(arguments, out, user):
    """All steps; `user` is an empty folder.

    Returns
    -------
    list of pathlib.Path
        The pictures.
    """
    out.mkdir(parents=True, exist_ok=True)
    with step("Building the extension"):
        if check_manifest():
            sys.exit(1)
        (path,) = build(chosen_platforms("current"), chosen_pythons("current"))
        print(f"    {path.relative_to(ROOT)}, {path.stat().st_size / 1e6:.1f} MB")
    scan = arguments.scan
    if scan is None:
        scan = out / "snake.gsf"
        with step("Making the preset scan"):
            precompute("preset", "snake", "--out", scan)
    with step("Installing the extension into an empty Blender"):
        bpy = empty_blender(user)
        install(bpy, path)

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
    sample_scene().build_scene()  # selects the body
    bpy.ops.wm.save_as_mainfile(filepath=str(out / "snake.blend"))  # scan and table are kept beside it
    with step(f"Importing {scan.name}"):
        given = {}
        if arguments.size_um:
            given["size_um"] = (arguments.size_um * 2)[:2]
        if arguments.height_nm:
            given["height_nm"] = arguments.height_nm
        operate(bpy.ops.diffraction.import_scan, filepath=str(scan.resolve()), **given)
    with step("Baking"):
        operate(bpy.ops.diffraction.bake)
    operate(bpy.ops.diffraction.apply_material, fresnel="DIELECTRIC")
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_mainfile()
    pictures = [out / "snake.png", out / "brdf_map.png"]
    with step("Rendering"):
        render(bpy, pictures[0], arguments.samples)
    with step("Drawing the BRDF map"):
        table = bpy.path.abspath(bpy.context.scene.diffraction.table_path)
        precompute("map", table, "--theta-i", 30, "--phi-i", 90, "--out", pictures[1])
    return pictures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan", type=Path, help="a scan of your own in place of the preset")
    parser.add_argument("--size-um", type=float, nargs="+", help="side (or both) of a scan that carries no units")
    parser.add_argument("--height-nm", type=float, help="height range of a scan that carries no units")
    parser.add_argument("--out", type=Path, default=ROOT / "out")
    parser.add_argument("--samples", type=int, help="samples a pixel; by default the sample scene's")
    arguments = parser.parse_args()
    start = time.perf_counter()
    user = Path(tempfile.mkdtemp(prefix="diffraction_demo_"))
    try:
        pictures = run(arguments, arguments.out.resolve(), user)
    finally:
        shutil.rmtree(user, ignore_errors=True)
    print(f"Done in {time.perf_counter() - start:.0f} s. The pictures are")
    for path in pictures:
        print(f"    {path}")


if __name__ == "__main__":
    main()
