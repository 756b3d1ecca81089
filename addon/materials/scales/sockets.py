# SPDX-License-Identifier: GPL-3.0-or-later
"""The sockets of the node *Snake Scales*; new ones go to the end, as those of *Diffraction* do."""

from __future__ import annotations

from math import radians

from ..node.interface import Socket

_VECTOR, _FLOAT, _INT, _COLOUR = (f"NodeSocket{kind}" for kind in ("Vector", "Float", "Int", "Color"))


def _value(
    default: object, low: float | None = None, high: float | None = None, subtype: str = ""
) -> dict[str, object]:
    more = {"min_value": low, "max_value": high, "subtype": subtype or None}
    return {"default_value": default, **{name: value for name, value in more.items() if value is not None}}


def _colour(red: float, green: float, blue: float) -> dict[str, object]:
    return {"default_value": (red, green, blue, 1.0)}


SOCKETS = (
    Socket("Vector", _VECTOR, "Coordinates; not linked: the UV map, or positions of the object as Space says",
           properties={"hide_value": True}),
    Socket("Normal", _VECTOR, "Normal or bump map under the scales; not linked: the surface's own",
           properties={"hide_value": True}),
    Socket("Space", _INT, "0: UV map, for a body whose map runs along it and once around it. 1: positions of the"
           " object, for any mesh", properties=_value(1, 0, 1)),
    Socket("Scale Size", _FLOAT, "Length of a scale in metres, one scale behind the other",
           properties=_value(0.005, 1e-5, None, "DISTANCE")),
    Socket("Scale Width", _FLOAT, "Width of a scale over its length", properties=_value(1.0, 0.1, 10.0)),
    Socket("Relief", _FLOAT, "How far scales stand up; 0 is flat", properties=_value(1.0, 0.0, 10.0)),
    Socket("Keel", _FLOAT, "Ridge on the midline of a scale, over its length", properties=_value(0.0, 0.0, 0.2)),
    Socket("Tilt", _FLOAT, "Most that a single scale leans out of the skin", properties=_value(
        radians(3.0), 0.0, radians(45.0), "ANGLE")),
    Socket("Turn", _FLOAT, "Most that the structure of a single scale is turned on it", properties=_value(
        radians(6.0), 0.0, radians(180.0), "ANGLE")),
    Socket("Variation", _FLOAT, "How much the pigment differs from scale to scale", properties=_value(
        0.25, 0.0, 2.0)),
    Socket("Seed", _INT, "Another number gives other scales", properties=_value(0, 0, 100000)),
    Socket("Ground", _COLOUR, "Pigment of the back", "Pigment", _colour(0.012, 0.0075, 0.0062)),
    Socket("Side", _COLOUR, "Pigment low on the flanks", "Pigment", _colour(0.02, 0.0135, 0.011)),
    Socket("Gap Colour", _COLOUR, "Skin between the scales", "Pigment", _colour(0.0035, 0.0025, 0.0022)),
    Socket("Belly Colour", _COLOUR, "Pigment of the smooth plates below", "Pigment", _colour(0.52, 0.47, 0.38)),
    Socket("Belly", _FLOAT, "Part of the girth that is belly; 0: scales all round, 1: belly alone", "Pigment",
           _value(0.28, 0.0, 1.0, "FACTOR")),
    Socket("Chequer", _FLOAT, "Part of the belly that is black, in squares", "Pigment",
           _value(0.0, 0.0, 1.0, "FACTOR")),
    Socket("Saddles", _FLOAT, "Blotches over the back and beside them: 0 none, 1 full", "Saddles",
           _value(0.0, 0.0, 1.0, "FACTOR")),
    Socket("Saddle Spacing", _FLOAT, "From blotch to blotch in lengths of a scale", "Saddles",
           _value(7.5, 0.5, 1000.0)),
    Socket("Saddle Colour", _COLOUR, "Pigment within", "Saddles", _colour(0.215, 0.03, 0.01)),
    Socket("Border Colour", _COLOUR, "Pigment at their edges", "Saddles", _colour(0.01, 0.006, 0.005)),
    Socket("Length", _FLOAT, "Length of the body that the UV map covers, metres", "UV Map",
           _value(1.0, 1e-4, None, "DISTANCE")),
    Socket("Girth", _FLOAT, "Girth that the UV map covers, metres; where the body tapers scales narrow with it",
           "UV Map",
           _value(0.1, 1e-5, None, "DISTANCE")),
    Socket("Along", _INT, "What runs along the body. 0: u, 1: v", "UV Map", _value(0, 0, 1)),
    Socket("Reverse", _INT, "0: the coordinate grows towards the tail, 1: towards the head", "UV Map", _value(0, 0, 1)),
    Socket("Back", _FLOAT, "The other coordinate on the spine", "UV Map", _value(0.25)),
    Socket("Tail", _VECTOR, "Direction from head to tail; z is up", "Object",
           {**_value((0.0, 1.0, 0.0)), "subtype": "DIRECTION"}),
)  # fmt: skip

PANELS = {
    "Pigment": "Colours under the structure",
    "Saddles": "Blotches",
    "UV Map": "How the map lies on the body, for Space 0",
    "Object": "How the object lies in its own space, for Space 1",
}

OUTPUTS = {
    "Base": ("NodeSocketShader", "Pigment; to Base of Diffraction"),
    "Color": ("NodeSocketColor", "Pigment, for a shader of your own"),
    "Normal": ("NodeSocketVector", "With relief and tilt of each scale"),
    "Tangent": ("NodeSocketVector", "A direction across the body: along the scan's x, its y towards the tail"),
    "Rotation": ("NodeSocketFloat", "Turn of the structure on each scale, radians"),
    "Mask": ("NodeSocketFloat", "0 between the scales, where no structure is"),
    "Height": ("NodeSocketFloat", "Relief in metres, for a Displacement node with Midlevel 0"),
}
