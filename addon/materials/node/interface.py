# SPDX-License-Identifier: GPL-3.0-or-later
"""The sockets of the node *Diffraction*, the same for every implementation, in one order for good.

Blender knows a socket by an identifier that it counts up as sockets are made, and keys of an animation by the number
of the socket. All groups are therefore made from the one list below, in its order, whatever they hold: a node keeps its
values, links, keys and drivers as it goes from one group to another. New sockets go to the end of `SOCKETS`; where they
are shown is up to their panel.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import bpy

_SHADER, _VECTOR, _FLOAT, _INT = (f"NodeSocket{kind}" for kind in ("Shader", "Vector", "Float", "Int"))


@dataclass(frozen=True)
class Socket:
    """An input of the node.

    Parameters
    ----------
    name, kind
        As shown, and its type.
    text
        Tooltip.
    panel
        Where it is folded away; empty: always seen.
    properties
        Of the interface's item: default, limits, subtype.
    """

    name: str
    kind: str
    text: str
    panel: str = ""
    properties: dict[str, object] = field(default_factory=dict)


def _value(default: object, low: float | None = None, high: float | None = None, **more: object) -> dict[str, object]:
    limits = {"min_value": low, "max_value": high}
    return {"default_value": default, **{name: v for name, v in limits.items() if v is not None}, **more}


_LINKED: dict[str, object] = {"hide_value": True}

SOCKETS = (
    Socket("Base", _SHADER, "The surface without its structure: pigment, weighted by what is not reflected"),
    Socket("Normal", _VECTOR, "Normal or bump map; not linked: the surface's own", properties=_LINKED),
    Socket(
        "Tangent", _VECTOR, "Along the scan's x, a normal map's (1, 0.5, 0.5) or a direction; not linked: u of the"
        " UV map", properties=_LINKED,
    ),
    Socket("Rotation", _FLOAT, "Turn of the scan about the normal", properties=_value(0.0, subtype="ANGLE")),
    Socket("Brightness", _FLOAT, "Factor on the diffracted light", properties=_value(1.0, 0.0)),
    Socket("Fresnel", _INT, "How much is reflected. 0: all, 1: as a dielectric of the index IOR by Schlick's"
           " approximation, 2: as a conductor, 3: as a dielectric, exactly", properties=_value(3, 0, 3)),
    Socket("IOR", _FLOAT, "Index of refraction of a dielectric", properties=_value(1.5, 1.0, 10.0)),
    Socket("Environment", _INT, "Random mirrors a sample that look at world, glowing things and light that bounces."
           " 0: lamps only", properties=_value(1, 0, 8)),
    Socket("ConductorN", _VECTOR, "Refractive index of a conductor for red, green and blue", "Conductor",
           _value((1.35, 0.95, 0.61))),
    Socket("ConductorK", _VECTOR, "Extinction coefficient of a conductor for red, green and blue", "Conductor",
           _value((7.47, 6.54, 5.47))),
    Socket("ConserveEnergy", _INT, "1: divide by the albedo where it passes 1. 0: the raw model", "Limits",
           _value(1, 0, 1)),
    Socket("DiffuseLimit", _FLOAT, "Most of f cos that diffuse bounces see, 1/sr: above it fireflies begin", "Limits",
           _value(1.0, 0.0)),
    Socket("Cone", _FLOAT, "Half-angle of the lobe aimed at a small lamp", "Limits",
           _value(0.1, 0.005, 0.5 * math.pi, subtype="ANGLE")),
    Socket("Bitangent", _VECTOR, "Along the scan's y, as a normal map gives (0.5, 1, 0.5): tells mirrored UV maps",
           "Frame", _LINKED),
    Socket("Handedness", _FLOAT, "-1 where the UV map is mirrored, 0 unknown", "Frame", _value(0.0, -1.0, 1.0)),
    Socket("TangentIsDirection", _INT, "1: the tangent is a direction, 0: it comes from a Normal Map node", "Frame",
           _value(0, 0, 1)),
    Socket("LacquerRoughness", _FLOAT, "Roughness of the outer face of a table's lacquer: 0 is a mirror", "Lacquer",
           _value(0.05, 0.0, 1.0, subtype="FACTOR")),
    Socket("Mask", _FLOAT, "Where the structure is: 0 shows the pigment alone, 1 diffracts; Apply takes the pigment's"
           " alpha", properties=_value(1.0, 0.0, 1.0, subtype="FACTOR")),
    Socket("Scale", _FLOAT, "Period of the structure over that of the table, its coherence window with it; above 1 the"
           " table ends before the horizon unless it was baked with headroom", properties=_value(1.0, 0.01, 8.0)),
    Socket("Depth", _FLOAT, "Depth of the structure over that of the table; above 1 the table ends unless it was baked"
           " with headroom", properties=_value(1.0, 0.01, 8.0)),
)  # fmt: skip

PANELS = {
    "Conductor": "n and k of a metal, for Fresnel 2",
    "Limits": "Energy, fireflies and the width of lobes",
    "Lacquer": "The clear layer of a table that was baked under one",
    "Frame": "How directions of the scan are told, where the tangent comes from a node",
}

_LIMITS = ("min_value", "max_value")

#: The node's output, and what EEVEE reads of it in less time (`eevee_output`).
OUTPUT, EEVEE = "BSDF", "EEVEE"


def make(
    tree: bpy.types.NodeTree,
    sockets: tuple[Socket, ...] = SOCKETS,
    panels: Mapping[str, str] = PANELS,
    outputs: Mapping[str, tuple[str, str]] = MappingProxyType({OUTPUT: (_SHADER, "Pigment and diffracted light")}),
    more: Mapping[str, tuple[str, str]] = MappingProxyType(
        {EEVEE: (_SHADER, "The same for EEVEE alone, which needs minutes to make a shader of BSDF")}
    ),
) -> None:
    """Give a group sockets; those that it has stay, with the limits of today.

    Parameters
    ----------
    tree
        A shader node group.
    sockets
        Its inputs; those of *Diffraction*.
    panels
        Name: text.
    outputs
        Name: (socket type, text).
    more
        Outputs that came after the inputs.
    """
    items = tree.interface
    there = {(item.item_type, getattr(item, "in_out", ""), item.name): item for item in items.items_tree}
    for name, (kind, text) in outputs.items():
        if ("SOCKET", "OUTPUT", name) not in there:
            items.new_socket(name, in_out="OUTPUT", socket_type=kind, description=text)
    folded: dict[str, Any] = {}
    for name, text in panels.items():
        folded[name] = there.get(("PANEL", "", name)) or items.new_panel(name, description=text, default_closed=True)
    for socket in sockets:
        known = there.get(("SOCKET", "INPUT", socket.name))
        item: Any = known or items.new_socket(
            socket.name, in_out="INPUT", socket_type=socket.kind, description=socket.text,
            parent=folded.get(socket.panel),
        )  # fmt: skip
        for key in _LIMITS if known else ("subtype", *_LIMITS, "default_value", "hide_value"):
            if key in socket.properties and getattr(item, key) != socket.properties[key]:
                setattr(item, key, socket.properties[key])
    for name, (kind, text) in more.items():
        if ("SOCKET", "OUTPUT", name) not in there:
            items.new_socket(name, in_out="OUTPUT", socket_type=kind, description=text)
