# SPDX-License-Identifier: GPL-3.0-or-later
"""Render small scenes on every device that Blender has here, and compare each pixel with the processor's.

`gpu_check.py [--size N] [--samples N] [--only PART ...] [--eevee | --no-eevee] [--out FILE]` with Blender as a module,
or in a Blender that has the extension's libraries: `blender -b --factory-startup -P tools/gpu_check.py -- [...]`

Cycles: OSL and Nodes under lamps of all types, under a picture of the sky and under the most lamps that a scene's list
or OptiX's memory of closures holds, on each interface (CUDA, OptiX, HIP, oneAPI, Metal) with all its devices, against
the processor with the same seed. GPU module: the viewport's diffraction
under a sun and under the picture against Cycles, a bake's table against the processor's, and EEVEE (by default where
the GPU is hardware: a software renderer needs a minute or two to compile it).

What is quick comes first (GPU module, EEVEE, Cycles; there Nodes on each interface, then OSL): the first picture of
an interface compiles its kernels, minutes on some, and what it waits for is said on stderr before.

Prints a table: error of the pixels (median, 99th percentile; difference over the reference, with a floor of a hundredth
of its brightest), ratio of the means, and what was allowed. Exit code 0: all that ran agrees; 1: something does not;
2: wrong arguments. What this machine lacks is named and is no fault.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

#: Interfaces of Cycles to devices other than the processor; those that run OSL.
INTERFACES = ("CUDA", "OPTIX", "HIP", "ONEAPI", "METAL")
WITH_OSL = {"CPU", "OPTIX"}

#: Parts of the check in their order.
PARTS = ("viewport", "bake", "eevee", "cycles")

#: Where the sun of every scene stands.
SUN = (0.3, -0.4, 0.8)


@dataclass
class Row:
    """One comparison: errors are parts of one."""

    device: str
    what: str
    median: float
    percentile_99: float
    mean: float
    allowed_99: float
    allowed_mean: float

    @property
    def agrees(self) -> bool:
        """Whether both bounds hold; no number is no agreement."""
        return self.percentile_99 <= self.allowed_99 and abs(self.mean - 1.0) <= self.allowed_mean

    def text(self) -> str:
        """A line of the table."""
        verdict = "ok" if self.agrees else "DIFFERS"
        return (
            f"{self.device:<22.22} {self.what:<34} {100 * self.median:8.3f} % {100 * self.percentile_99:8.2f} %"
            f" {self.mean:9.4f}   {100 * self.allowed_99:.0f} %, {100 * self.allowed_mean:.1f} %  {verdict}"
        )


def compare(
    device: str, what: str, found: np.ndarray, reference: np.ndarray, allowed_99: float, allowed_mean: float,
    where: np.ndarray | None = None,
) -> Row:  # fmt: skip
    """Two pictures (rows, cols, 3).

    Parameters
    ----------
    allowed_99, allowed_mean
        Of the 99th percentile of the errors, and of the ratio of the means from 1.
    where
        Pixels that count; None takes those that shine.
    """
    most = float(reference.max())
    lit = reference.max(-1) > 0.01 * most if where is None else where
    if not lit.any() or not np.isfinite(found).all():
        return Row(device, what, float("nan"), float("nan"), float("nan"), allowed_99, allowed_mean)
    size = np.maximum(np.abs(reference).max(-1), 0.01 * most)
    error = (np.abs(found - reference).max(-1) / size)[lit]
    ratio = float(found[lit].mean() / reference[lit].mean())
    return Row(device, what, *np.percentile(error, (50, 99)).tolist(), ratio, allowed_99, allowed_mean)


def lamps() -> None:
    """One lamp of each kind about the sphere."""
    from tests.support.blender import scenes
    from tests.support.blender.lamps import add_lamp

    scenes.add_sun(SUN, strength=2.0)
    add_lamp("POINT", (2.0, 1.0, 2.0), energy=120.0, name="point", shadow_soft_size=0.1)
    add_lamp("SPOT", (-2.0, 0.5, 2.5), energy=300.0, name="spot", spot_size=1.0)
    add_lamp("AREA", (0.5, 2.0, 2.0), energy=80.0, name="area", shape="RECTANGLE", size=0.6, size_y=1.5)


def crowd(count: int) -> None:
    """Many small lamps of many colours on a turn of a spiral above the sphere."""
    from tests.support.blender.lamps import add_lamp

    for index in range(count):
        turn, up = 2.4 * index, 0.5 + 2.0 * index / count
        colour = 0.5 + 0.5 * np.cos(turn + np.array([0.0, 2.1, 4.2]))
        lamp = add_lamp("POINT", (2.0 * np.cos(turn), 2.0 * np.sin(turn), up), energy=60.0, shadow_soft_size=0.05)
        lamp.data.color = colour.tolist()


def sun() -> None:
    """A sun alone."""
    from tests.support.blender import scenes

    scenes.add_sun(SUN, strength=2.0)


def sky() -> None:
    """A picture of a sky all around."""
    from tests.support.blender.worlds import picture_world

    y, x = np.mgrid[0:64, 0:128]
    lon, lat = x / 128 * 2 * np.pi, (y / 64 - 0.5) * np.pi
    picture_world(np.stack([0.4 + 0.3 * np.sin(lon), 0.3 + 0.2 * np.sin(lat), 0.4 - 0.3 * np.cos(lon)], -1))


class Check:
    """The comparisons on one machine.

    Parameters
    ----------
    size, samples
        Of the pictures.
    folder
        For tables.
    """

    def __init__(self, size: int, samples: int, folder: Path) -> None:
        from tests.support.blender import tables

        self.size, self.samples, self.folder = size, samples, folder
        self.table = folder / "lobes.exr"
        tables.make_table(self.table, tables.gentle, albedo=lambda theta, phi: 0.6 / np.cos(0.99 * theta))

    def crowd(self) -> None:
        """As many lamps as both implementations hold on every device: OptiX does not check its memory of closures."""
        from diffraction_shader.addon.lights import slots
        from diffraction_shader.addon.materials import closures
        from diffraction_shader.addon.renderers import OPTIX_BYTES

        crowd(min(slots.SLOTS, (OPTIX_BYTES - closures.to_come([None], 0, 0)) // closures.LOBE))

    def scene(self, light: Callable[[], None], implementation: str, environment: int) -> None:
        """An empty file with a sphere of our material under some light, for Cycles on the processor."""
        import bpy

        from tests.support.blender import extension, materials, scenes

        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        scene = bpy.context.scene
        scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
        scene.cycles.shading_system = implementation == "OSL"
        scene.cycles.seed = 7
        scene.cycles.sample_clamp_indirect = 0.0
        scene.render.film_transparent = True
        ob = scenes.add_sphere(segments=64, rings=32)
        scenes.add_camera((0.2, 0.1, 1.0))
        light()
        extension.load()
        materials.diffracting(
            ob, self.table, implementation=implementation, pigment=(0.02, 0.02, 0.03, 1.0), environment=environment
        )
        bpy.context.view_layer.update()
        bpy.context.view_layer.update()

    def cycles(self) -> Iterator[Row | str]:
        """The material on every device of Cycles."""
        import bpy

        from tests.support.blender import scenes

        preferences = bpy.context.preferences.addons["cycles"].preferences
        devices = {}
        for kind in INTERFACES:
            found = device_names(preferences, kind)
            if found:
                devices[kind] = found
            else:
                yield f"Cycles: no device of {kind}"
        for light, name, environment, noise in (
            (lamps, "lamps", 0, 0.05), (sky, "environment", 1, 0.25), (self.crowd, "crowd", 0, 0.05)
        ):  # fmt: skip
            reference = {}
            for implementation in ("NODES", "OSL"):
                if implementation == "OSL" and not _has_osl():
                    yield "Cycles: this Blender was built without OSL"
                    continue
                self.scene(light, implementation, environment)
                reference[implementation] = scenes.render(self.size, self.samples)
                for kind, names in devices.items():
                    if implementation == "OSL" and kind not in WITH_OSL:
                        continue
                    use_device(preferences, kind)
                    print(f"{implementation}, {name}, on {kind} ...", file=sys.stderr, flush=True)
                    bpy.context.scene.cycles.device = "GPU"
                    found = scenes.render(self.size, self.samples)
                    bpy.context.scene.cycles.device = "CPU"
                    what = f"{implementation} {name} against processor"
                    yield compare(f"{kind} {names}", what, found, reference[implementation], noise, 0.01)
            # Other random numbers: the means, and blocks of pixels; a single pixel of the rim is a crowd's whole noise.
            if len(reference) == 2 and name != "crowd":
                blocks = [_blocks(reference[each], self.size // 8) for each in ("NODES", "OSL")]
                yield compare("processor", f"NODES {name} against OSL", *blocks, 2.0 * noise + 0.05, 0.02)

    def viewport(self) -> Iterator[Row | str]:
        """The viewport's diffraction on the GPU that Blender draws with, against Cycles on the processor."""
        from diffraction_shader.addon.viewport import handlers

        from tests.support.blender import drawing, scenes

        device = _drawing_device()
        if not device:
            yield "GPU module: Blender has no GPU context here"
            return
        implementation = "OSL" if _has_osl() else "NODES"
        for light, name, environment, allowed in ((sun, "sun", 0, (0.05, 0.01)), (sky, "environment", 1, (0.2, 0.02))):
            self.scene(light, implementation, environment)
            reference = scenes.render(self.size, 1 if light is sun else 16 * self.samples, centred=True)
            handlers.renderer.clear()
            drawn = drawing.alone(handlers.renderer, self.size, surface="REPLACE", points=16)
            yield compare(device, f"viewport, {name}, against Cycles", drawn, reference, *allowed, _inside(self.size))
        handlers.renderer.clear()

    def eevee(self) -> Iterator[Row | str]:
        """The Nodes material in EEVEE against Cycles, under a sun and under the picture."""
        import bpy
        from diffraction_shader.addon.versions import EEVEE

        from tests.support.blender import scenes

        device = _drawing_device()
        if not device:
            return
        for light, name, allowed in ((sun, "sun", (0.06, 0.01)), (sky, "environment", (0.5, 0.05))):
            self.scene(light, "NODES", 0 if light is sun else 1)
            scene = bpy.context.scene
            reference = scenes.render(self.size, 1 if light is sun else 16 * self.samples, centred=True)
            scene.render.engine = EEVEE
            scene.eevee.taa_render_samples = 1 if light is sun else 4 * self.samples
            scene.eevee.use_shadows, scene.eevee.light_threshold = False, 1e-5
            found = scenes.render(self.size, self.samples, centred=True)
            yield compare(device, f"EEVEE, {name}, against Cycles", found, reference, *allowed, _inside(self.size))

    def bake(self) -> Iterator[Row | str]:
        """A table whose transforms the GPU computed, against one of the processor."""
        from diffraction_shader.addon.tables.gpu.transforms import GpuTransforms
        from diffraction_shader.addon.versions import computes
        from diffraction_shader.precompute.bake import bake
        from diffraction_shader.precompute.parameters import BakeParameters
        from diffraction_shader.precompute.presets import make_preset

        device = _drawing_device()
        if not device or not computes():
            yield "GPU bake: not in this Blender" if device else "GPU bake: no GPU context"
            return
        patch, parameters = make_preset("stam_bumps", 8e-6, 96), BakeParameters(detail=0.5)
        plain = bake(patch, parameters)
        transforms = GpuTransforms(lambda function: function(), race=False)
        by_gpu = bake(patch, parameters, transforms=transforms)
        if transforms.device == "processor":
            yield "GPU bake: the GPU gave its work back to the processor"
            return
        tables = [np.asarray(each.atlas, np.float64) for each in (by_gpu, plain)]
        yield compare(device, "bake against processor", *tables, 0.01, 0.001, np.ones(plain.atlas.shape[:2], bool))


def _has_osl() -> bool:
    from diffraction_shader.addon.renderers import has_osl

    return has_osl()


def device_names(preferences, kind: str) -> str:
    """Names of an interface's devices, empty where it has none."""
    try:
        found = preferences.get_devices_for_type(kind)
    except (ValueError, TypeError):
        return ""
    return ", ".join(device.name for device in found or () if device.type == kind)


def use_device(preferences, kind: str) -> None:
    """Let Cycles' device GPU be all devices of an interface."""
    preferences.compute_device_type = kind
    for device in preferences.get_devices_for_type(kind):
        device.use = device.type == kind


def _drawing_device() -> str:
    """Name of the GPU that Blender draws with, empty where it has none."""
    import gpu
    from diffraction_shader.addon.gpu_context import NoGpu, ensure_gpu

    try:
        ensure_gpu()
    except NoGpu:
        return ""
    return str(gpu.platform.renderer_get())


def _is_hardware() -> bool:
    from diffraction_shader.addon.tables.gpu import device

    found = device.renderer()
    return found is not None and found[1]


def _blocks(picture: np.ndarray, side: int) -> np.ndarray:
    """Means of blocks of side x side pixels."""
    count = picture.shape[0] // side
    cut = picture[: count * side, : count * side]
    return cut.reshape(count, side, count, side, 3).mean(axis=(1, 3))


def _inside(size: int) -> np.ndarray:
    """Pixels of the sphere well inside its rim, where a pixel sees one place."""
    y, x = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    return np.hypot(x, y) < 0.85 * size / 2.2


def machine() -> str:
    """What this runs on, one line."""
    import platform

    import bpy

    return f"Blender {bpy.app.version_string}, {platform.system()}, {os.cpu_count()} processors"


def main(words: list[str]) -> int:
    """Run and print; the exit code."""
    parser = argparse.ArgumentParser(prog="gpu_check.py", description=__doc__.split("\n")[0])
    parser.add_argument("--size", type=int, default=48, help="pixels a side, a multiple of 8")
    parser.add_argument("--samples", type=int, default=16, help="samples of Cycles")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS, help="parts to run; all by default")
    parser.add_argument("--eevee", action=argparse.BooleanOptionalAction, help="EEVEE too; default: on hardware")
    parser.add_argument("--out", type=Path, help="JSON with the numbers")
    chosen = parser.parse_args(words)
    if chosen.size < 16 or chosen.size % 8 or chosen.samples < 1:
        parser.error("--size is a multiple of 8 from 16 on, --samples at least 1")

    from tests.support.blender import extension

    package = extension.load()
    package.register()
    rows: list[Row] = []
    missing: list[str] = []
    print(f"{machine()}\n\n{'device':<22} {'what':<34} {'median':>10} {'99 %':>10} {'mean':>9}   allowed")
    try:
        with tempfile.TemporaryDirectory() as folder:
            check = Check(chosen.size, chosen.samples, Path(folder))
            for name in [each for each in PARTS if each in chosen.only]:
                if name == "eevee" and not (chosen.eevee or (chosen.eevee is None and _is_hardware())):
                    missing.append("EEVEE: left out on a software renderer; --eevee tries it")
                else:
                    _run(getattr(check, name), rows, missing)
    finally:
        package.unregister()
    print("".join(f"\n{line}" for line in missing))
    if chosen.out is not None:
        chosen.out.parent.mkdir(parents=True, exist_ok=True)
        found = [asdict(row) | {"agrees": row.agrees} for row in rows]
        chosen.out.write_text(json.dumps({"machine": machine(), "rows": found, "missing": missing}, indent=1) + "\n")
    bad = [row for row in rows if not row.agrees]
    print(f"\n{len(rows)} comparisons, {len(bad)} differ." if rows else "\nNothing could be compared.")
    return 1 if bad or not rows else 0


def _run(part: Callable[[], Iterator[Row | str]], rows: list[Row], missing: list[str]) -> None:
    for found in part():
        if isinstance(found, str):
            missing.append(found)
        else:
            rows.append(found)
            print(found.text(), flush=True)


if __name__ == "__main__":
    given = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    if Path(sys.argv[0]).name != Path(__file__).name and "--" not in sys.argv:
        given = []
    code = main(given)
    sys.stdout.flush()
    os._exit(code)  # Blender's own end can fail in a driver after all is done
