# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group *Snake Scales*: sheets of scales laid onto a surface, leaning and turned one by one, and painted.

On a UV map one sheet runs along the body and closes round it. On a mesh without such a map three sheets are seen along
the axes of the object, and where two meet the scale that stands higher, with a bonus for the sheet that faces the
surface, covers the other: the seam follows the edges of scales.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Any

import bpy

from .. import batch
from ..node import interface
from ..node_graph import Graph, Socket, Value
from . import lattice, pattern, sockets

#: Name of the group, and the property that tells ours from a user's own of this name, with its version.
NAME, KEY, VERSION = "Snake Scales", "diffraction_scales", 1

#: How much a scale's height counts where two sheets meet, against the cosine of the sheet.
INTERLOCK = 2.0

#: What a way upwards counts along the body of a mesh without a UV map, against one backwards.
UPWARDS = 0.8

#: Relief of the plates of the belly over that of the scales of the back.
SMOOTH = 0.6


@dataclass
class Sheet:
    """What one place shows: sockets of the scale there, and the directions along x and y."""

    cell: Socket
    centre: Socket
    slope: Socket
    shape: Socket
    place: Socket
    along: Socket
    across: Socket

    FIELDS = ("cell", "centre", "slope", "shape", "place", "along", "across")


def is_scales(tree: bpy.types.NodeTree | None) -> bool:
    """Whether a node group is this one."""
    return tree is not None and KEY in tree


def build() -> bpy.types.NodeTree:
    """The group of the file: made where there is none, anew where another version made it."""
    tree = next((t for t in bpy.data.node_groups if is_scales(t) and t.library is None), None)
    if tree is None:
        tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    elif tree[KEY] == VERSION:
        return tree
    interface.make(tree, sockets.SOCKETS, sockets.PANELS, sockets.OUTPUTS, {})
    tree.nodes.clear()
    batch.make(lambda: _fill(Graph(tree)))
    tree[KEY] = VERSION
    return tree


def _fill(g: Graph) -> None:
    given: Any = g.add("NodeGroupInput").outputs
    space = given["Space"]
    geometry: Any = g.add("ShaderNodeNewGeometry").outputs
    linked = g.math("GREATER_THAN", g.scalar("LENGTH", given["Normal"]), 0.0)
    normal = g.vector("NORMALIZE", g.mix(linked, geometry["Normal"], given["Normal"]))

    rows, on_uv, around = _uv_sheet(g, given, normal)
    on_object, up, step = _object_sheets(g, given, normal)
    chosen = _choose(g, space, on_uv, on_object, rows)

    # From the spine, 0, to the middle of the belly, 1/2: at this place, and in the middle of its scale.
    away = g.mix(
        space,
        g.join(around, _from_back(g, given, g.quotient(_y(g, chosen.centre), rows)), 0.0),
        g.join(up, up, 0.0),
    )
    here, middle, _ = g.split(away)
    plates, belly, chosen = _belly(g, given, chosen, here, middle)

    noise: Any = g.add("ShaderNodeTexWhiteNoise", noise_dimensions="3D")
    g.put(noise.inputs["Vector"], g.vector("ADD", chosen.cell, g.join(0.0, 0.0, g.product(given["Seed"], 8.0))))
    lean_x, lean_y, turn = g.split(g.vector("SUBTRACT", noise.outputs["Color"], (0.5, 0.5, 0.5)))
    tangent_of_tilt = g.product(g.math("TANGENT", given["Tilt"]), 2.0)
    relief = g.product(given["Relief"], g.fused(belly, SMOOTH - 1.0, 1.0))
    slope_x, slope_y, _ = g.split(chosen.slope)
    # Slopes along y count half widths.
    slope_y = g.quotient(g.product(slope_y, 2.0), given["Scale Width"])
    bent = normal
    for direction, slope, lean in ((chosen.along, slope_x, lean_x), (chosen.across, slope_y, lean_y)):
        whole = g.fused(relief, slope, g.product(lean, tangent_of_tilt))
        bent = g.vector("SUBTRACT", bent, g.scaled(direction, whole))
    bent = g.vector("NORMALIZE", bent)

    height, root, across = g.split(chosen.shape)
    x, x_middle = g.split(chosen.place)[0], g.split(chosen.centre)[0]
    # Sheets along other axes count from elsewhere: blotches follow one number all over a mesh.
    step = g.choose(space, x, step)
    at = pattern.Place(
        step, g.sum(step, g.difference(x_middle, x)), here, middle, root, across, belly, plates, chosen.cell
    )
    colour = pattern.colour(g, given, at, noise.outputs["Value"])
    base: Any = g.add("ShaderNodeBsdfDiffuse")
    g.put(base.inputs["Color"], colour)
    g.put(base.inputs["Normal"], bent)

    out = g.add("NodeGroupOutput").inputs
    g.put(out["Base"], base.outputs["BSDF"])
    g.put(out["Color"], colour)
    g.put(out["Normal"], bent)
    g.put(out["Tangent"], g.scaled(chosen.across, -1.0))
    g.put(out["Rotation"], g.product(turn, g.product(given["Turn"], 2.0)))
    g.put(out["Mask"], pattern.smooth(g, root, 0.03, 0.09))
    g.put(out["Height"], g.product(g.product(height, relief), given["Scale Size"]))


def _y(g: Graph, vector: Socket) -> Socket:
    return g.split(vector)[1]


def _from_back(g: Graph, given: Any, around: Value) -> Socket:
    """|distance from the spine| in girths, 0 to 1/2."""
    turned = g.math("FRACT", g.sum(g.difference(around, given["Back"]), 0.5))
    return g.math("ABSOLUTE", g.difference(turned, 0.5))


def _uv_sheet(g: Graph, given: Any, normal: Socket) -> tuple[Socket, Sheet, Socket]:
    """Number of half rows, the sheet's coordinates and directions, distance from the spine."""
    texture: Any = g.add("ShaderNodeTexCoord").outputs
    u, v, _ = g.split(g.mix(_is_linked(g, given["Vector"]), texture["UV"], given["Vector"]))
    along_v = given["Along"]
    along, around = g.choose(along_v, u, v), g.choose(along_v, v, u)
    sign = g.fused(given["Reverse"], -2.0, 1.0)
    width = g.product(given["Scale Width"], given["Scale Size"])
    # An even number of half widths: the sheet closes round the body.
    rows = g.product(g.math("MAXIMUM", g.math("ROUND", g.quotient(given["Girth"], width)), 1.0), 2.0)
    x = g.product(sign, g.quotient(g.product(along, given["Length"]), given["Scale Size"]))
    y = g.product(around, rows)
    tangent: Any = g.add("ShaderNodeTangent", direction_type="UV_MAP").outputs["Tangent"]
    second: Any = g.add("ShaderNodeNormalMap", space="TANGENT")
    second.inputs["Color"].default_value = (0.5, 1.0, 0.5, 1.0)
    crossed = g.vector("CROSS_PRODUCT", normal, tangent)
    hand = g.math("SIGN", g.scalar("DOT_PRODUCT", crossed, second.outputs["Normal"]))
    to_v = g.scaled(crossed, hand)
    forward = g.scaled(g.mix(along_v, tangent, to_v), sign)
    sideways = g.mix(along_v, to_v, tangent)
    place = g.join(x, y, 0.0)
    return rows, Sheet(place, place, place, place, place, forward, sideways), _from_back(g, given, around)


def _object_sheets(g: Graph, given: Any, normal: Socket) -> tuple[list[tuple[Socket, Sheet]], Socket, Socket]:
    """Three sheets with the cosine of each to the surface, the distance from the spine as the normal tells it, and the
    way along the body in lengths of scales: backwards, and up."""
    texture: Any = g.add("ShaderNodeTexCoord").outputs
    position = g.mix(_is_linked(g, given["Vector"]), texture["Object"], given["Vector"])
    # Positions of the object in metres: an object's scale counts.
    axes = [_turned(g, axis, "VECTOR") for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
    position = g.vector("MULTIPLY", position, g.join(*(g.scalar("LENGTH", axis) for axis in axes)))
    # Where linked coordinates are not those of the object, the object's axes still tell directions.
    tail = g.vector("NORMALIZE", given["Tail"])
    side = g.vector("NORMALIZE", g.vector("CROSS_PRODUCT", (0.0, 0.0, 1.0), tail))
    up = g.vector("CROSS_PRODUCT", tail, side)
    local: Any = g.add("ShaderNodeVectorTransform", vector_type="NORMAL", convert_from="WORLD", convert_to="OBJECT")
    g.put(local.inputs["Vector"], normal)
    cosines = [g.scalar("DOT_PRODUCT", local.outputs[0], axis) for axis in (up, side, tail)]
    places = {axis: g.scalar("DOT_PRODUCT", position, axis) for axis in (tail, side, up)}
    length = given["Scale Size"]
    half = g.product(g.product(given["Scale Width"], length), 0.5)
    world = {axis: g.vector("NORMALIZE", _turned(g, axis, "VECTOR")) for axis in (tail, side, up)}
    sheets = []
    for cosine, x, y in zip(cosines, (tail, tail, up), (side, up, side), strict=True):
        place = g.join(g.quotient(places[x], length), g.quotient(places[y], half), 0.0)
        directions = [_in_surface(g, world[axis], normal) for axis in (x, y)]
        sheets.append((g.math("ABSOLUTE", cosine), Sheet(place, place, place, place, place, *directions)))
    away = g.product(g.math("ARCCOSINE", g.clamp(cosines[0], -1.0, 1.0)), 0.5 / pi)
    step = g.quotient(g.fused(places[up], UPWARDS, places[tail]), length)
    return sheets, away, step


def _turned(g: Graph, vector: Value, kind: str) -> Socket:
    """A vector of the object in the world."""
    node: Any = g.add("ShaderNodeVectorTransform", vector_type=kind, convert_from="OBJECT", convert_to="WORLD")
    g.put(node.inputs["Vector"], vector)
    return node.outputs[0]


def _in_surface(g: Graph, direction: Socket, normal: Socket) -> Socket:
    """The part of a direction along the surface, of length 1."""
    part = g.vector("SUBTRACT", direction, g.scaled(normal, g.scalar("DOT_PRODUCT", direction, normal)))
    return g.vector("NORMALIZE", part)


def _is_linked(g: Graph, vector: Socket) -> Socket:
    """1 where a socket has coordinates; one that is not linked is 0."""
    return g.math("GREATER_THAN", g.scalar("LENGTH", vector), 0.0)


def _choose(
    g: Graph, space: Socket, on_uv: Sheet, on_object: list[tuple[Socket, Sheet]], rows: Socket
) -> Sheet:  # fmt: skip
    """The sheet that covers the others here; the first stands for that of the UV map, too."""
    tree = lattice.build()
    best: Any = None
    score: Any = None
    for number, (cosine, flat) in enumerate(on_object):
        place, along, across = flat.place, flat.along, flat.across
        closed: Value = 0.0
        if number == 0:
            place, along, across = (
                g.mix(space, getattr(on_uv, name), getattr(flat, name)) for name in ("place", "along", "across")
            )
            closed = g.product(g.difference(1.0, space), rows)
        x, y, _ = g.split(place)
        made: Any = g.group(tree, X=x, Y=y, Rows=closed, Keel=_keel(g)).outputs
        cell = g.vector("ADD", made["Cell"], (0.0, 0.0, float(number)))
        sheet = Sheet(cell, made["Centre"], made["Slope"], made["Shape"], place, along, across)
        height = g.split(made["Shape"])[0]
        value = g.fused(height, INTERLOCK, cosine)
        if best is None:
            best, score = sheet, g.sum(value, g.product(g.difference(1.0, space), 10.0))
            continue
        wins = g.math("GREATER_THAN", value, score)
        best = Sheet(*(g.mix(wins, getattr(best, name), getattr(sheet, name)) for name in Sheet.FIELDS))
        score = g.math("MAXIMUM", value, score)
    return best


def _keel(g: Graph) -> Socket:
    given: Any = next(node for node in g.tree.nodes if node.bl_idname == "NodeGroupInput").outputs
    return given["Keel"]


def _belly(
    g: Graph, given: Any, back: Sheet, here: Socket, middle: Socket
) -> tuple[Socket, Socket, Sheet]:  # fmt: skip
    """Where plates are, how much belly there is, and the sheet with the plates in it.

    On a UV map the belly has plates, one behind the other, whose border runs along the scales of the back. On a mesh
    without one the scales go on, smoother and in the belly's colour.
    """
    border = g.difference(0.5, g.product(given["Belly"], 0.5))
    on_uv = g.difference(1.0, given["Space"])
    plates = g.product(on_uv, g.math("GREATER_THAN", middle, border))
    soft = pattern.smooth(g, g.difference(here, border), -0.03, 0.03)
    belly = g.choose(given["Space"], plates, g.product(soft, g.math("GREATER_THAN", given["Belly"], 0.0)))
    x = g.split(back.place)[0]
    beside = g.quotient(g.difference(0.5, here), g.math("MAXIMUM", g.product(given["Belly"], 0.5), 1e-3))
    x = g.fused(g.product(beside, beside), 0.3, x)
    number = g.math("FLOOR", x)
    f = g.difference(x, number)
    free = g.math("MAXIMUM", g.product(g.difference(f, 1.0 - lattice.EDGE), 1.0 / lattice.EDGE), 0.0)
    root = g.math("MAXIMUM", g.product(g.difference(lattice.ROOT, f), 1.0 / lattice.ROOT), 0.0)
    slope = g.sum(
        g.product(free, -4.0 * lattice.EDGE_DROP / lattice.EDGE),
        g.product(root, 2.0 * lattice.ROOT_DROP / lattice.ROOT),
    )
    height = g.difference(
        g.product(f, lattice.RISE),
        g.sum(g.product(free, free, 2.0 * lattice.EDGE_DROP), g.product(root, root, lattice.ROOT_DROP)),
    )
    # Numbers of plates are whole as those of scales are; a third number keeps them apart.
    cell = g.join(number, 0.0, 4.0)
    centre = g.join(g.sum(number, 0.5), g.split(back.centre)[1], 0.0)
    mixed = {
        "cell": cell,
        "centre": centre,
        "slope": g.join(g.sum(slope, lattice.RISE), 0.0, 0.0),
        "shape": g.join(height, f, beside),
    }
    return plates, belly, Sheet(
        *(g.mix(plates, getattr(back, name), mixed[name]) if name in mixed else getattr(back, name)
          for name in Sheet.FIELDS)
    )  # fmt: skip
