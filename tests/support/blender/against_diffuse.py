# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene twice: with f = 1 / pi in our material, and with Blender's diffuse one of albedo 1."""

from tests.support.blender import materials, scenes, tables


def both(plane, monkeypatch, tmp_path, samples, size=16):
    """Our picture with f = 1 / pi, and the diffuse one."""
    materials.lambertian(monkeypatch)
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE")
    ours = scenes.render(size, samples)
    materials.white_diffuse(plane)
    return ours, scenes.render(size, samples)
