# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure the viewport: milliseconds a frame by the table and by the thesis's own method, on the same GPU context.

`bench_viewport.py [--scan FILE --size-um X Y --height-nm H] [--size PIXELS] [--directions N] [--no-scene] [--no-cost]`

A full-screen triangle shades every pixel with one light: by the table, by a shader of one fetch, and by FLSS with 79
wavelengths, the Taylor terms that the heights need, and a window of 3 x 3 bins, as it stood at commit f889080. Both are
held against the reference evaluator at random pixels. Then the sample scene, and what a mesh that deforms and 300
objects add to a redraw, beside a floor (viewport_cost.py). On a software renderer all times are of the processor, all
threads together: other work on the machine hardly changes them. The result is merged into out/bench.json under
"viewport".
"""

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import viewport_cost
import viewport_flss

ROOT = Path(__file__).resolve().parents[2]
XENOPELTIS = "xenopeltis_65um_818.69nm.png"

#: One fetch of the table a pixel, and all blocks in use.
ONE_FETCH = """
void main()
{
    out_colour = textureLod(df_table, vec3(0.5 * place + 0.5, 3.0), 0.0) + 1e-30 * df_light * df_surface.value.x;
}
"""

#: Part of the disc of view directions that the frame shows: its corners stay above the horizon.
INSCRIBED = 0.7


def extension():
    """The checkout as the package `diffraction_shader`, registered."""
    import importlib.util

    spec = importlib.util.spec_from_file_location(
        "diffraction_shader", ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
    )
    module = sys.modules["diffraction_shader"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.register()


def find_scan(arguments, folder):
    """The scan's path and how to read it."""
    if arguments.scan:
        reading = {}
        if arguments.size_um:
            reading["size_m"] = tuple(1e-6 * x for x in arguments.size_um)
        if arguments.height_nm:
            reading["height_m"] = 1e-9 * arguments.height_nm
        return Path(arguments.scan).resolve(), reading
    scans = Path(os.environ.get("DIFFRACTION_SCAN_DIR", ROOT.parent / "shared" / "data"))
    if (scans / XENOPELTIS).is_file():
        return scans / XENOPELTIS, {"size_m": (65e-6, 65e-6), "height_m": 818.69e-9}
    from diffraction_shader.precompute.presets import make_preset
    from diffraction_shader.precompute.scan.gsf import write_gsf

    path = folder / "snake.gsf"
    write_gsf(make_preset("snake"), path)
    return path, {}


def clock():
    """Seconds: of the processor where a software renderer draws, else of the wall."""
    import gpu

    return time.process_time() if "llvmpipe" in gpu.platform.renderer_get() else time.perf_counter()


class FullScreen:
    """A triangle over the whole frame, shaded by one of the methods."""

    def __init__(self, table, albedo, series, look, size):
        import gpu
        from diffraction_shader.addon.viewport.data import blocks, sources

        self.size = size
        self.target = gpu.types.GPUOffScreen(size, size, format="RGBA32F")
        no_lamps = np.zeros((0, 6, 4))
        self.frame = blocks.uniform(blocks.Frame(np.eye(4), np.eye(4), no_lamps).rows())
        recorded = viewport_flss.surface_rows(table.layout, look.to_rgb, look.conserve_energy)
        self.surfaces = {"FLSS": blocks.uniform(recorded)}
        self.surfaces["TABLE"] = self.surfaces["ONE_FETCH"] = blocks.uniform(look.rows())
        samplers = {"df_table": table.slices, "df_albedo": table.albedo}
        self.samplers = {
            "TABLE": samplers,
            "ONE_FETCH": {"df_table": table.slices},
            "FLSS": {**samplers, "df_albedo": albedo, "df_terms": series.terms},
        }
        self.series = series.uniform
        flags = frozenset(look.flags(ambient=False) & {"CONSERVE", "LINEAR_IN_W"})
        self.shaders = {
            "TABLE": sources.map_of_directions("TABLE", flags),
            "ONE_FETCH": sources.map_of_directions("TABLE", flags - {"CONSERVE"}, ONE_FETCH),
            "FLSS": viewport_flss.map_shader(),
        }
        self.batches = {}

    def draw(self, method, light, show_transform=False, times=1):
        """Draw and wait; returns pixels (size, size, 4) and seconds a frame."""
        import gpu
        from diffraction_shader.addon.viewport import offscreen
        from gpu_extras.batch import batch_for_shader

        shader = self.shaders[method]
        corners = {"pos": [(-1, -1), (3, -1), (-1, 3)]}
        batch = self.batches.setdefault(method, batch_for_shader(shader, "TRIS", corners))
        with self.target.bind():
            shader.bind()
            shader.uniform_block("df_frame", self.frame)
            shader.uniform_block("df_surface", self.surfaces[method])
            for name, texture in self.samplers[method].items():
                shader.uniform_sampler(name, texture)
            shader.uniform_float("df_light", (*light, float(show_transform)))
            shader.uniform_float("df_reach", INSCRIBED)
            if method == "FLSS":
                shader.uniform_block("df_series", self.series)
            gpu.state.blend_set("NONE")
            offscreen.read(self.target)  # all that was asked for before is done
            start = clock()
            for _ in range(times):
                batch.draw(shader)
            pixels = offscreen.read(self.target)
            seconds = (clock() - start) / times
        return pixels, seconds


def relative_errors(pixels, light, places, patch, sigma_s_m, ensemble):
    """Relative errors of Y at pixels (row, column) of a frame that shows T, against the reference evaluator."""
    from diffraction_shader.precompute.evaluate.direct import direct_xyz
    from diffraction_shader.precompute.evaluate.surface import geometry_factor

    size = pixels.shape[0]
    errors = []
    for row, column in places:
        x, y = INSCRIBED * (2 * (np.array([column, row]) + 0.5) / size - 1)
        wr = np.array([x, y, np.sqrt(1 - x * x - y * y)])
        reference = direct_xyz(patch, sigma_s_m, ensemble, np.array(light), wr)[1]
        value = geometry_factor(np.array(light), wr) * pixels[row, column, 1]
        errors.append(abs(value / reference - 1))
    return errors


def scene_milliseconds(table_path, size):
    """Milliseconds a frame of the sample scene for both methods."""
    import bpy
    from diffraction_shader.addon.materials import material
    from diffraction_shader.addon.viewport import handlers, looks, offscreen
    from mathutils import Matrix

    sys.path.insert(0, str(ROOT / "sample_blend"))
    import build_scene

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bodies = build_scene.build_scene(detail=0.1)
    for body in bodies:
        material.apply(body.active_material, str(table_path), material.Settings())
    import gpu

    scene = bpy.context.scene
    depsgraph = bpy.context.evaluated_depsgraph_get()
    view = np.array(scene.camera.matrix_world.normalized().inverted())
    projection = np.array(scene.camera.calc_matrix_camera(depsgraph, x=size, y=size))
    target = gpu.types.GPUOffScreen(size, size, format="RGBA32F")
    # As in an open view, the scene's depth is there before: what it hides is not shaded.
    with offscreen.view_3d() as override, bpy.context.temp_override(**override):
        override["space_data"].shading.type = "SOLID"
        override["space_data"].overlay.show_overlays = False
        layer, space, region = bpy.context.view_layer, override["space_data"], override["region"]
        target.draw_view3d(scene, layer, space, region, Matrix(view), Matrix(projection))

    def by_table():
        handlers.renderer.draw(depsgraph, view, projection, looks.View(points=1), False, lambda ob: True)
        if handlers.renderer.message:
            sys.exit(handlers.renderer.message)

    result = {}
    with target.bind():
        by_table()
        by_flss = recorded_scene(handlers.renderer, depsgraph, view, projection)
        for name, draw, times, rounds in (("TABLE", by_table, 5, 5), ("FLSS", by_flss, 1, 1)):
            draw()
            seconds = []
            for _ in range(rounds):
                offscreen.read(target)
                start = clock()
                for _ in range(times):
                    draw()
                offscreen.read(target)
                seconds.append((clock() - start) / times)
            result[name] = 1e3 * float(np.median(seconds))
    return result


def recorded_scene(renderer, depsgraph, view, projection):
    """A function that draws what the renderer has in its list by the recorded FLSS."""
    import gpu
    from diffraction_shader.addon.viewport import looks
    from diffraction_shader.addon.viewport.data import blocks
    from diffraction_shader.precompute.light.colour import xyz_to_rgb_matrix
    from diffraction_shader.precompute.table.table import SpectralTable

    listing = renderer._listing(depsgraph, lambda ob: True, 0, False)
    shader = viewport_flss.surface_shader()
    frame = blocks.uniform(viewport_flss.frame_rows(view, projection, listing.lamps))
    held = {}
    for item in listing.items:
        path = looks.table_path(item.material)
        if path not in held:
            table = renderer.tables.get(path)
            rows = viewport_flss.surface_rows(
                table.layout, xyz_to_rgb_matrix(), table.info["albedo_max"] > 1.0, fresnel=1.0
            )
            albedo = viewport_flss.albedo_texture(SpectralTable.load(path))
            held[path] = blocks.uniform(rows), table, albedo, renderer.series.get(path, table.info)

    def draw():
        gpu.state.blend_set("ADDITIVE")
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.state.depth_mask_set(False)
        shader.bind()
        shader.uniform_block("df_frame", frame)
        shader.uniform_sampler("df_display", renderer.display.any())
        for item in listing.items:
            rows, table, albedo, series = held[looks.table_path(item.material)]
            shader.uniform_block("df_surface", rows)
            shader.uniform_block("df_series", series.uniform)
            for name, texture in (("df_table", table.slices), ("df_albedo", albedo), ("df_angle", albedo),
                                  ("df_terms", series.terms)):  # fmt: skip
                shader.uniform_sampler(name, texture)
            shader.uniform_float("df_model", item.matrix)
            item.batch.draw(shader)
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")

    return draw


def merge(path, viewport):
    """Put the numbers beside those of other benchmarks."""
    from diffraction_shader.precompute.files.atomic import atomic_path

    known = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    known["viewport"] = viewport
    with atomic_path(path) as temporary:
        Path(temporary).write_text(json.dumps(known, indent=1, sort_keys=True) + "\n", encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan")
    parser.add_argument("--size-um", nargs=2, type=float)
    parser.add_argument("--height-nm", type=float)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--directions", type=int, default=6)
    parser.add_argument("--no-scene", action="store_true")
    parser.add_argument("--no-cost", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        numbers = measure(arguments, Path(folder))
    merge(ROOT / "out" / "bench.json", numbers)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash at exit once it has drawn


def measure(arguments, folder):
    """Bake, draw, compare; prints as it goes and returns the numbers."""
    extension()
    import gpu
    from diffraction_shader.addon.viewport import offscreen
    from diffraction_shader.addon.viewport.data import blocks, series, textures
    from diffraction_shader.precompute.bake.baking import bake_file
    from diffraction_shader.precompute.light.colour import xyz_to_rgb_matrix
    from diffraction_shader.precompute.parameters import BakeParameters
    from diffraction_shader.precompute.readers import read_scan
    from diffraction_shader.precompute.scan.preparation import prepare

    offscreen.ensure_gpu()
    scan, reading = find_scan(arguments, folder)
    parameters = BakeParameters(level="poly2", clip_percent=99.9, series="taylor")
    report = bake_file(scan, folder, parameters, **reading)
    patch = prepare(read_scan(scan, **reading), parameters)
    table = textures.upload(textures.texels(report.table))
    terms = series.SeriesTextures().get(report.path, report.table.info)
    look = blocks.Surface(
        layout=table.layout, to_rgb=xyz_to_rgb_matrix(), conserve_energy=report.table.albedo_max > 1.0
    )
    albedo = viewport_flss.albedo_texture(report.table)
    screen = FullScreen(table, albedo, terms, look, arguments.size)
    light = tuple(np.array([0.3, 0.2, 1.0]) / np.linalg.norm([0.3, 0.2, 1.0]))
    layout = table.layout
    print(f"{scan.name} on {gpu.platform.renderer_get()}, {arguments.size} x {arguments.size} pixels")
    print(f"  table {layout.n_r} x {layout.n_phi} x {layout.n_w}, FLSS {report.table.info['terms']} terms")

    rounds = {"TABLE": [], "ONE_FETCH": []}
    for _ in range(6):
        for method, seconds in rounds.items():
            seconds.append(screen.draw(method, light, times=10)[1])
    table_ms, fetch_ms = (1e3 * float(np.median(seconds[1:])) for seconds in rounds.values())
    flss_ms = 1e3 * screen.draw("FLSS", light)[1]
    numbers = {
        "size": arguments.size,
        "renderer": gpu.platform.renderer_get(),
        "terms": report.table.info["terms"],
        "table_ms": table_ms,
        "one_fetch_ms": fetch_ms,
        "flss_ms": flss_ms,
        "table_over_one_fetch": table_ms / fetch_ms,
        "flss_over_table": flss_ms / table_ms,
    }
    print(
        f"  full screen: table {table_ms:.2f} ms, FLSS {flss_ms:.0f} ms a frame: {flss_ms / table_ms:.0f} times faster"
    )
    print(
        f"  the same triangle with one fetch a pixel: {fetch_ms:.2f} ms;"
        f" the table takes {table_ms / fetch_ms:.2f} times that"
    )
    if arguments.directions:
        random = np.random.default_rng(1)
        places = random.integers(0, arguments.size, (arguments.directions, 2))
        sigma = parameters.sigma_s_m or report.table.info["parameters"]["sigma_s_m"]
        for method, name, ensemble, width in (
            ("TABLE", "table", "average", sigma),
            ("FLSS", "flss", "single", series.SIGMA_S_M),
        ):
            pixels, _ = screen.draw(method, light, show_transform=True)
            errors = relative_errors(pixels, light, places, patch, width, ensemble)
            numbers[f"{name}_error_median"] = float(np.median(errors))
            numbers[f"{name}_error_max"] = float(np.max(errors))
            print(
                f"  {name}: error of Y against the reference ({ensemble}) at {len(errors)} pixels:"
                f" median {np.median(errors):.2%}, largest {np.max(errors):.2%}"
            )
    if not arguments.no_scene:
        scene = scene_milliseconds(report.path, arguments.size)
        numbers["scene_table_ms"], numbers["scene_flss_ms"] = scene["TABLE"], scene["FLSS"]
        print(
            f"  snake scene: table {scene['TABLE']:.1f} ms, FLSS {scene['FLSS']:.0f} ms a frame:"
            f" {scene['FLSS'] / scene['TABLE']:.0f} times faster"
        )
    if not arguments.no_cost:
        numbers.update(viewport_cost.measure(report.path, clock))
    return numbers


if __name__ == "__main__":
    main()
