# SPDX-License-Identifier: GPL-3.0-or-later
"""A compact disc before a DVD on a dark table, under one small lamp and a strip light."""

from __future__ import annotations

import math

from . import stage

#: Metres: hole, clear hub, data, rim, thickness.
HOLE, HUB, DATA, RIM, THICK = 0.0075, 0.0222, 0.0585, 0.0600, 0.0012

#: Where the lamp stands: of the large picture, and of the three that show the colours move.
LAMP = (0.22, -0.34, 0.62)
LAMPS = ((0.42, -0.30, 0.50), LAMP, (-0.02, -0.42, 0.55))


def disc(name):
    """A disc in its parts, all children of the data's ring, which is returned: it alone diffracts."""
    data = stage.link(f"{name} data", stage.lathe("Data", [(DATA, THICK), (HUB, THICK)]))
    plastic = stage.plain("Edge", (0.06, 0.065, 0.07), 0.2)
    clear = stage.plain("Polycarbonate", (0.05, 0.055, 0.06), 0.08)
    clear.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.6
    edge, ridge, band = 0.0002, 0.0003, HUB - 0.0012
    rim = [(HUB, 0.0), (RIM - edge, 0.0), (RIM, edge), (RIM, THICK - edge), (RIM - edge, THICK), (DATA, THICK)]
    hub = [
        (band, THICK), (0.0179, THICK), (0.0176, THICK + ridge), (0.0171, THICK + ridge), (0.0168, THICK),
        (HOLE + edge, THICK), (HOLE, THICK - edge), (HOLE, THICK * 0.4),
    ]  # fmt: skip
    for part, profile, material in (
        ("rim", rim, plastic),
        ("hub", hub, clear),
        ("band", [(HUB, THICK), (band, THICK)], stage.plain("Mirror band", (0.75, 0.76, 0.78), 0.08, 1.0)),
        ("back", [(HUB, THICK * 0.5), (RIM - edge, THICK * 0.5)], stage.plain("Print", (0.02, 0.02, 0.022), 0.4)),
    ):
        mesh = stage.lathe(part, profile)
        mesh.materials.append(material)
        stage.link(f"{name} {part}", mesh).parent = data
    return data


def build(out, lamp=LAMP, alone=False):
    """The scene: a compact disc before a DVD, or alone."""
    scene = stage.empty_room(out / "disc.blend", (0.010, 0.012, 0.016))
    slate = stage.plain("Slate", (0.003, 0.003, 0.0035), 0.32)
    slate.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0.12
    stage.table_top(2.0, slate)
    places = (
        ("CD", "cd", (-0.028, -0.032, 0.0265), (12.0, 10.0)),
        ("DVD", "dvd", (0.052, 0.018, 0.020), (9.0, -11.0)),
    )
    stage.bulb("Lamp", lamp, 16.0, 0.004)
    stage.softbox("Strip", (0.1, 1.0, 0.40), (0.0, 0.0, 0.0), (1.4, 0.10), 5.0, (0.8, 0.9, 1.0))
    stage.camera((0.0, -0.33, 0.25), (0.006, -0.001, 0.01), 66)
    if alone:
        places = places[:1]
        stage.aim(scene.camera, (0.0, -0.33, 0.25), (-0.028, -0.034, 0.022))
        scene.camera.data.lens = 96
    for name, preset, place, tilt in places:
        data = disc(name)
        data.location = place
        data.rotation_euler = [math.radians(angle) for angle in (*tilt, 0.0)]
        stage.diffract([data], preset, fresnel="CONDUCTOR", orientation="RADIAL")
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.5
    scene.cycles.sample_clamp_indirect = 1.0
