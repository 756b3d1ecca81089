# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference method in GLSL against the same method in numpy, on a small patch."""

import numpy as np
import pytest

SIGMA = 1.5e-6
STEP = 95e-9


def three_by_three(heights, u, v, w, wavelength):
    """T by the nine bins of the patch's DFT next to (u, v) / lambda, the window's transform between them.

    The phase is summed sample by sample and not from a series; sample i lies at i times the step, the window's middle
    half a side from the first.
    """
    count = len(heights)
    side = count * STEP
    x = np.arange(count) * STEP
    p = np.exp(2j * np.pi * w * heights / wavelength)
    f0 = np.array([u, v]) / wavelength
    nearest = np.floor(f0 * side + 0.5)
    amplitude = 0.0
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            f = np.add(nearest, (i, j)) / side
            spectrum = np.exp(2j * np.pi * f[1] * x) @ p @ np.exp(2j * np.pi * f[0] * x)
            away = f0 - f
            middle = np.exp(1j * np.pi * away.sum() * side)
            window = 2 * np.pi * SIGMA**2 * np.exp(-2 * (np.pi * SIGMA) ** 2 * (away @ away)) * middle
            amplitude = amplitude + spectrum * window / count**2
    g = np.exp(-(((np.arange(count) - (count - 1) / 2) * STEP) ** 2) / (2 * SIGMA**2))
    area = (STEP * (g @ g)) ** 2
    return abs(amplitude) ** 2 / (area * wavelength**2)


@pytest.mark.parametrize("series", ["taylor", "chebyshev"])
def test_flss(renderer, tmp_path, series):
    """T in XYZ at pixels of the full-screen frame."""
    import gpu
    from diffraction_shader.addon.viewport import offscreen
    from diffraction_shader.addon.viewport.data import blocks, sources, textures
    from diffraction_shader.addon.viewport.data import series as on_gpu
    from diffraction_shader.precompute.bake.baking import bake_file
    from diffraction_shader.precompute.light.colour import spectral_weights
    from diffraction_shader.precompute.parameters import BakeParameters
    from diffraction_shader.precompute.scan.gsf import write_gsf
    from diffraction_shader.precompute.scan.heightfield import HeightField
    from gpu_extras.batch import batch_for_shader

    random = np.random.default_rng(3)
    x = np.arange(64) * STEP
    heights = 6e-8 * np.sin(2 * np.pi * x / 1.1e-6)[None, :] + 4e-8 * np.sin(2 * np.pi * x / 0.9e-6)[:, None]
    heights = (heights + 5e-9 * random.standard_normal((64, 64))).astype(np.float32).astype(float)
    write_gsf(HeightField(heights, STEP, STEP), tmp_path / "patch.gsf")
    parameters = BakeParameters(sigma_s_m=SIGMA, ensemble="single", series=series, detail=0.25)
    report = bake_file(tmp_path / "patch.gsf", tmp_path, parameters)
    table = textures.upload(textures.texels(report.table))
    terms = on_gpu.SeriesTextures().get(report.path, report.table.info)

    size, light = 24, np.array([0.2, -0.1, 0.0])
    light[2] = np.sqrt(1 - light @ light)
    shader = sources.map_of_directions("FLSS")
    target = gpu.types.GPUOffScreen(size, size, format="RGBA32F")
    look = blocks.Surface(layout=table.layout, to_rgb=np.eye(3))
    frame = blocks.uniform(blocks.Frame(np.eye(4), np.eye(4), np.zeros((0, 6, 4))).rows())
    look = blocks.uniform(look.rows())
    batch = batch_for_shader(shader, "TRIS", {"pos": [(-1, -1), (3, -1), (-1, 3)]})
    with target.bind():
        shader.bind()
        for name, block in (("df_frame", frame), ("df_surface", look), ("df_series", terms.uniform)):
            shader.uniform_block(name, block)
        for name, texture in (("df_table", table.slices), ("df_albedo", table.albedo), ("df_terms", terms.terms)):
            shader.uniform_sampler(name, texture)
        shader.uniform_float("df_light", (*light, 1.0))
        shader.uniform_float("df_reach", 0.7)
        batch.draw(shader)
        image = offscreen.read(target)
    target.free()

    wavelengths, weights = spectral_weights(on_gpu.WAVELENGTHS_M)
    drawn, expected = [], []
    for row, column in random.integers(0, size, (12, 2)):
        a, b = 0.7 * (2 * (np.array([column, row]) + 0.5) / size - 1)
        u, v, w = -(light + np.array([a, b, np.sqrt(1 - a * a - b * b)]))
        values = [three_by_three(heights, u, v, w, wavelength) for wavelength in wavelengths]
        drawn.append(image[row, column, :3])
        expected.append(np.array(values) @ weights)
    drawn, expected = np.array(drawn), np.array(expected)
    error = np.abs(drawn - expected).max(-1) / expected.max(-1)
    assert error.max() < 0.01
