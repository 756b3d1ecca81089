# SPDX-License-Identifier: GPL-3.0-or-later
"""A cabinet of stacks: butterfly, beetle, anodised ring, gold leaf, copper, an oily plate; their looks do the rest."""

from __future__ import annotations

import math

import bpy
import numpy as np

from . import stage

#: Degrees from the body's right hand: outline of a forewing and of a hindwing, and how far they reach (metres).
_FORE = ((-8, 0.030), (5, 0.047), (18, 0.054), (32, 0.064), (41, 0.066), (50, 0.058), (62, 0.036), (74, 0.018))
_HIND = ((-82, 0.030), (-66, 0.041), (-48, 0.047), (-30, 0.047), (-14, 0.042), (2, 0.033), (16, 0.022))


def wing(name, outline, side, lift):
    """A fan about the body's joint, bent upwards; the attribute *edge* is 1 inside and 0 on the dark margin."""
    angles, reach = np.array(outline, float).T
    angle = np.linspace(angles[0], angles[-1], 97)
    rim = np.interp(angle, angles, reach) * (1.0 + 0.012 * np.cos(np.linspace(0.0, 9.0 * 2.0 * np.pi, 97)))
    part = np.linspace(0.03, 1.0, 49)
    radius, turn = part[:, None] * rim, np.radians(angle)[None, :] + 0.0 * part[:, None]
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    z = lift * x + 2.2 * x**2 + 0.0006 * np.sin(9.0 * turn) * part[:, None]
    points = np.stack([side * (x + 0.002), y, z + 0.004], -1)
    # The ridges of the scales run from the body outwards: the scan's y. Its x, the table's tangent, runs across them.
    uv = np.stack([points[..., 1], -side * points[..., 0]], -1)
    flip = slice(None, None, -side)  # faces look up
    mesh = stage.grid(name, points[:, flip], uv[:, flip])
    edge = mesh.attributes.new("edge", "FLOAT", "POINT")
    inside = np.clip((0.86 - part) / 0.10, 0.0, 1.0)[:, None] * np.ones(97)
    veins = np.clip(np.abs(np.sin(7.5 * np.pi * (angle - angle[0]) / np.ptp(angle))) * 14.0, 0.0, 1.0)[None, :]
    edge.data.foreach_set("value", (inside * veins)[:, flip].astype(np.float32).ravel())
    return stage.link(name, mesh)


def butterfly(place, turn):
    """Four wings and a body; the wings."""
    dark = stage.plain("Fur", (0.010, 0.008, 0.007), 0.8)
    wings = [
        wing(f"{kind} {side:+}", outline, side, lift)
        for side in (1, -1)
        for kind, outline, lift in (("Hindwing", _HIND, 0.20), ("Forewing", _FORE, 0.26))
    ]
    body = stage.link("Body", stage.lathe("Body", _egg(0.0026, 0.030, 24), 48))
    body.rotation_euler = (math.pi / 2, 0.0, 0.0)
    body.location = (0.0, 0.012, 0.005)
    body.data.materials.append(dark)
    _together([*wings, body], place, turn)
    return wings


def _egg(radius, length, steps):
    """Profile of a closed egg about z, from the top down to the bottom."""
    along = np.linspace(0.0, np.pi, steps)
    swell = radius * np.sin(along) * (1.0 - 0.25 * np.cos(along))
    return np.stack([np.maximum(swell, 1e-6), 0.5 * length * np.cos(along)], -1)[::-1]


def beetle(place, turn):
    """Two wing cases with a seam, a collar and a head; all of them shine."""
    length, width, height = 0.034, 0.0072, 0.0062
    along = np.linspace(-1.0, 1.0, 121)
    swell = (1.0 - np.abs(along) ** 2.6) ** 0.5 * (1.0 - 0.22 * along)
    parts = []
    for side in (1, -1):
        turned = np.linspace(math.radians(1.2), math.radians(88.0), 61)
        x = side * width * swell[:, None] * np.sin(turned)
        z = height * swell[:, None] * np.cos(turned) ** 0.9 * (1.0 + 0.012 * np.cos(30.0 * turned))
        y = 0.5 * length * along[:, None] + 0.0 * x
        points = np.stack([x, y, z], -1)
        if side < 0:
            points = points[:, ::-1]
        parts.append(stage.link("Wing case", stage.grid("Wing case", points, points[..., :2].copy())))
    for name, y, size in (("Collar", -0.0195, (0.0066, 0.0050, 0.0052)), ("Head", -0.0243, (0.0042, 0.0030, 0.0036))):
        ball = stage.link(name, stage.lathe(name, _egg(1.0, 2.0, 48), 96))
        ball.scale, ball.location = size, (0.0, y, 0.0006)
        parts.append(ball)
    _together(parts, place, turn)
    return parts


def _together(parts, place, turn):
    """Parent to an empty that stands somewhere."""
    middle = bpy.data.objects.new("Middle", None)
    bpy.context.scene.collection.objects.link(middle)
    middle.location, middle.rotation_euler = place, turn
    for part in parts:
        part.parent = middle


def leaf(place, turn):
    """A leaf of foil that was crumpled once."""
    rng = np.random.default_rng(5)
    side = np.linspace(-0.021, 0.021, 161)
    x, y = np.meshgrid(side, side)
    z = np.zeros_like(x)
    for _ in range(26):  # creases: a kink along a line each
        angle, offset, depth = rng.uniform(0, np.pi), rng.uniform(-0.018, 0.018), rng.normal(0, 0.13)
        z += depth * np.abs(np.cos(angle) * x + np.sin(angle) * y - offset) * 0.35
    z -= z.min()
    points = np.stack([x, y, 0.0006 + 0.8 * z], -1)
    sheet = stage.link("Leaf", stage.grid("Leaf", points, points[..., :2].copy()))
    _together([sheet], place, turn)
    return sheet


def plate(name, size, place, turn):
    """A flat plate, its grooves along its y."""
    w, h = size
    points = np.array([[(-w, -h, 0), (w, -h, 0)], [(-w, h, 0), (w, h, 0)]], float)
    ob = stage.link(name, stage.grid(name, points, points[..., :2].copy()))
    ob.location, ob.rotation_euler = place, turn
    return ob


def ring(place, turn):
    """A band with a rounded outside; its ripple runs along the circumference."""
    across = np.linspace(-1.0, 1.0, 41)
    outside = np.stack([0.0120 + 0.0011 * (1.0 - across**2), 0.0042 * across], -1)
    inside = np.stack([np.full(9, 0.0112), np.linspace(0.0042, -0.0042, 9)], -1)
    ob = stage.link("Ring", stage.lathe("Ring", np.concatenate([outside, inside]), 256))
    ob.location, ob.rotation_euler = place, turn
    return ob


def looks(objects, preset, **surface):
    """The look of a preset, as *Use Preset* sets it."""
    stage.diffract(objects, preset, structure={"look": True}, **surface)


def build(out):
    """The scene."""
    scene = stage.empty_room(out / "stuff.blend", (0.035, 0.038, 0.043))
    stage.table_top(2.0, stage.plain("Slate", (0.006, 0.006, 0.007), 0.35))
    wings = butterfly((-0.034, 0.024, 0.006), (math.radians(16.0), math.radians(0.0), math.radians(14.0)))
    cases = beetle((0.044, -0.032, 0.0), (0.0, 0.0, math.radians(-58.0)))
    band = ring((0.004, -0.040, 0.0118), (math.radians(90.0), 0.0, math.radians(64.0)))
    gold = leaf((-0.070, -0.036, 0.0), (0.0, 0.0, math.radians(20.0)))
    # Tilted out of the window's mirror image: what is seen are its orders.
    copper = plate("Copper", (0.015, 0.020), (0.060, 0.022, 0.007), (0.0, math.radians(-18.0), math.radians(66.0)))
    oil = plate("Oily", (0.022, 0.015), (-0.028, -0.062, 0.0008), (0.0, 0.0, math.radians(8.0)))
    looks(wings, "morpho")
    tree = wings[0].active_material.node_tree
    mask = tree.nodes.new("ShaderNodeAttribute")
    mask.attribute_name = "edge"
    tree.links.new(mask.outputs["Fac"], tree.nodes["Diffraction"].inputs["Mask"])
    looks(cases, "jewel_beetle")
    looks([band], "titanium_ripple")
    looks([gold], "gold_foil")
    looks([copper], "copper_plate")
    looks([oil], "oily_plate")
    stage.softbox("Window", (-0.30, 0.25, 0.42), (0.0, 0.0, 0.0), (0.30, 0.16), 1.1, (0.92, 0.96, 1.0))
    stage.softbox("Card", (0.42, 0.05, 0.20), (0.02, 0.0, 0.0), (0.10, 0.26), 0.5, (1.0, 0.93, 0.86))
    stage.softbox("Strip", (0.09, 0.30, 0.17), (0.03, 0.0, 0.0), (0.20, 0.035), 0.35)
    stage.bulb("Bulb", (0.10, 0.30, 0.34), 0.9, 0.008)
    stage.camera((0.01, -0.245, 0.185), (-0.004, 0.002, 0.006), 45)
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.5
    scene.cycles.sample_clamp_indirect = 1.0
