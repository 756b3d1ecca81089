# SPDX-License-Identifier: GPL-3.0-or-later
"""A compact disc on a dark table under one small lamp."""

from __future__ import annotations

import math

from . import stage

#: Metres: hole, clear hub, data, rim, thickness.
HOLE, HUB, DATA, RIM, THICK = 0.0075, 0.0222, 0.0585, 0.0600, 0.0012

#: Where the lamp stands: of the large picture, and of the three that show the colours move.
LAMP = (0.22, -0.34, 0.62)
LAMPS = ((0.42, -0.30, 0.50), LAMP, (-0.02, -0.42, 0.55))


def disc(name="Disc"):
    """The parts of a disc as a list: the data's ring first, which diffracts."""
    data = stage.link(f"{name} data", stage.lathe("Data", [(DATA, THICK), (HUB, THICK)]))
    metal = stage.plain("Mirror band", (0.75, 0.76, 0.78), 0.08, 1.0)
    edge_of = stage.plain("Edge", (0.06, 0.065, 0.07), 0.2)
    clear = stage.plain("Polycarbonate", (0.05, 0.055, 0.06), 0.08)
    clear.node_tree.nodes["Principled BSDF"].inputs["Alpha"].default_value = 0.6
    back = stage.plain("Print", (0.02, 0.02, 0.022), 0.4)
    edge = 0.0002
    rim = [(DATA, THICK), (RIM - edge, THICK), (RIM, THICK - edge), (RIM, edge), (RIM - edge, 0.0), (HUB, 0.0)]
    hub = [
        (HOLE, THICK * 0.4), (HOLE, THICK - edge), (HOLE + edge, THICK), (0.0168, THICK),
        (0.0171, THICK + 0.0003), (0.0176, THICK + 0.0003), (0.0179, THICK), (HUB - 0.0012, THICK),
    ]  # fmt: skip
    parts = [data]
    for part, profile, material in (
        ("rim", rim[::-1], edge_of), ("hub", hub[::-1], clear), ("band", [(HUB, THICK), (HUB - 0.0012, THICK)], metal),
        ("back", [(HUB, THICK * 0.5), (RIM - edge, THICK * 0.5)], back),
    ):  # fmt: skip
        mesh = stage.lathe(part, profile)
        mesh.materials.append(material)
        parts.append(stage.link(f"{name} {part}", mesh))
    for part in parts[1:]:
        part.parent = data
    return parts


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
        parts = disc(name)
        parts[0].location = place
        parts[0].rotation_euler = [math.radians(a) for a in (*tilt, 0.0)]
        stage.diffract(parts[:1], preset, fresnel="CONDUCTOR", orientation="RADIAL")
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.5
    scene.cycles.sample_clamp_indirect = 1.0
