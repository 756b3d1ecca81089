# SPDX-License-Identifier: GPL-3.0-or-later
"""What all directions of light share on a surface: its frame, the viewer, pigment, factors.

Blender is slow with trees of thousands of nodes, so that what repeats is a group of its own: each takes the sockets of
`shared` that it needs by their names.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from ....precompute.constants import LEAST_SCALE
from ....precompute.table.layout import TableLayout
from ..node import frame
from ..node_graph import Graph, Socket, Value, interface, new_group
from . import lookup
from . import value as values

_FLOAT, _VECTOR = "NodeSocketFloat", "NodeSocketVector"

#: Names of what groups hand on, and the types.
SHARED = {
    "T": _VECTOR,
    "B": _VECTOR,
    "N": _VECTOR,
    "Viewer": _VECTOR,
    "Position": _VECTOR,
    "CosR": _FLOAT,
    "Gain": _FLOAT,
    "AlbedoR": _FLOAT,
    "WrX": _FLOAT,
    "WrY": _FLOAT,
    "Scale": _FLOAT,
    "Scale2": _FLOAT,
    "Depth": _FLOAT,
    "Tile": _FLOAT,
    "TilePart": _FLOAT,
    "Shares": _VECTOR,
    "IsScaled": _FLOAT,
    "Knows": _FLOAT,
    "PlainFrom": _FLOAT,
    "IsDiffuse": _FLOAT,
    "Limit": _FLOAT,
    "Cone": _FLOAT,
    "Red": _VECTOR,
    "Green": _VECTOR,
    "Blue": _VECTOR,
    "R0": _FLOAT,
    "IOR": _FLOAT,
    "ConductorN": _VECTOR,
    "ConductorK": _VECTOR,
    "EEVEE": _FLOAT,
}


@dataclass(frozen=True)
class Parts:
    """The groups of a table that a surface uses.

    Parameters
    ----------
    name
        Of the table and of what is built in.
    layout
        Of the table.
    value
        `value.value`.
    albedo
        `lookup.albedo`, None where no albedo passes 1 or energy is not conserved.
    albedo_free
        Cosine above which no albedo passes 1.
    fresnel
        As in `material.Settings`.
    conserve
        Whether f is divided by albedos above 1.
    kept
        `lookup.reflectance` of a table that holds its stuff, whose R is then not multiplied in once more; else None.
    """

    name: str
    layout: TableLayout
    value: bpy.types.NodeTree
    albedo: bpy.types.NodeTree | None
    albedo_free: float
    fresnel: str
    conserve: bool
    kept: bpy.types.NodeTree | None = None


def shared(graph: Graph, given: Any, parts: Parts, rows: tuple[Socket, ...], knows: Socket) -> dict[str, Socket]:
    """The sockets of `SHARED`.

    Parameters
    ----------
    graph
        Of the node's group.
    given
        Outputs of its Group Input.
    parts
        Of the table.
    rows
        Of the matrix from XYZ to the working space.
    knows
        1 where the image of directions, which holds the albedos, is the one that was written.
    """
    eevee = graph.in_eevee()
    geometry = graph.add("ShaderNodeNewGeometry")
    viewer, normal = geometry.outputs["Incoming"], given["Normal"]
    has_normal = graph.math("GREATER_THAN", graph.scalar("LENGTH", normal), 0.0)
    n = graph.mix(has_normal, geometry.outputs["Normal"], graph.vector("NORMALIZE", normal))
    t, b = _frame(graph, given, n, eevee)
    cos_r = graph.scalar("DOT_PRODUCT", n, viewer)
    front = graph.difference(1.0, geometry.outputs["Backfacing"])
    # A painted surface: T' = s^2 T(s u, s v, q w). What is not linked is constant to Cycles, which drops what 1 leaves.
    # The larger of two, of which one is no number, is the first or the second: devices differ.
    scale, depth = (
        graph.math("MAXIMUM", LEAST_SCALE, graph.math("MAXIMUM", given[name], LEAST_SCALE))
        for name in ("Scale", "Depth")
    )
    is_one = [graph.math("COMPARE", each, 1.0, 0.0) for each in (scale, depth)]
    is_scaled = graph.difference(1.0, graph.product(*is_one))
    scale2 = graph.product(scale, scale)
    tile, tile_part, shares = lookup.scaled_place(graph, parts.layout, scale, depth)
    brightness = graph.product(front, given["Brightness"], 0.25 * parts.layout.scale)
    brightness = graph.product(brightness, graph.product(scale2, graph.math("POWER", depth, parts.layout.power)))
    root = graph.quotient(graph.difference(given["IOR"], 1.0), graph.sum(given["IOR"], 1.0))
    is_diffuse = graph.add("ShaderNodeLightPath").outputs["Is Diffuse Ray"]
    not_limited = graph.fused(is_diffuse, -1e20, 1e20)
    wr_x, wr_y = (graph.scalar("DOT_PRODUCT", axis, viewer) for axis in (t, b))
    albedo_r: Value = 1.0
    if parts.albedo is not None:
        against = {"AgainstT": graph.product(wr_x, -1.0), "AgainstB": graph.product(wr_y, -1.0)}
        found = graph.group(
            parts.albedo, Cosine=cos_r, EEVEE=eevee, Tile=tile, TilePart=tile_part, Shares=shares, IsScaled=is_scaled,
            Knows=knows, **against,
        ).outputs["Albedo"]  # fmt: skip
        albedo_r = graph.math("MAXIMUM", found, 1.0)
    return {
        "T": t, "B": b, "N": n, "Viewer": viewer, "Position": geometry.outputs["Position"], "CosR": cos_r,
        # The factor that `value` leaves out: 0 where the viewer is below the surface.
        "Gain": graph.math("MAXIMUM", graph.quotient(brightness, cos_r), 0.0),
        "AlbedoR": albedo_r, "WrX": wr_x, "WrY": wr_y,
        "Scale": scale, "Scale2": scale2, "Depth": depth, "Tile": tile, "TilePart": tile_part, "Shares": shares,
        "IsScaled": is_scaled, "Knows": knows,
        # the cosine below which a lobe is more than its plain f cos: where albedos count, for diffuse rays everywhere
        "PlainFrom": graph.fused(is_diffuse, 2.0, graph.choose(is_scaled, parts.albedo_free, 2.0)),
        # of f cos: none for other rays than diffuse ones
        "IsDiffuse": is_diffuse, "Limit": graph.math("MAXIMUM", not_limited, given["DiffuseLimit"]),
        "Cone": given["Cone"],
        **dict(zip(("Red", "Green", "Blue"), rows, strict=True)),
        "R0": graph.product(root, root), "IOR": given["IOR"],
        "ConductorN": given["ConductorN"], "ConductorK": given["ConductorK"],
        "EEVEE": eevee,
    }  # fmt: skip


def _columns(graph: Graph) -> list[Socket]:
    """The object's axes in world space, as long as they are scaled."""
    return [_in_world(graph, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]


def _in_world(graph: Graph, vector: Value) -> Socket:
    """A direction of the object's in world space, as long as it is scaled."""
    node = graph.add("ShaderNodeVectorTransform", vector_type="VECTOR", convert_from="OBJECT", convert_to="WORLD")
    graph.put(node.inputs["Vector"], vector)
    return node.outputs[0]


def _surface_direction(graph: Graph, columns: list[Socket], given: Socket) -> Socket:
    """Undo the transform of normals and apply that of directions, see ``shaders/diffraction.osl``.

    With M the object's matrix, a normal's transform is undone by its transpose: the components are the products with
    M's columns. (Vector Transform itself treats normals as directions.)
    """
    parts = [graph.scaled(column, graph.scalar("DOT_PRODUCT", given, column)) for column in columns]
    return graph.vector("ADD", graph.vector("ADD", parts[0], parts[1]), parts[2])


def _frame(graph: Graph, given: Any, n: Socket, in_eevee: Socket) -> tuple[Socket, Socket]:
    """Tangent and bitangent, mirrored as the UV map is.

    Where no tangent is given it is that of the active UV map. Cycles knows it in the object's space and the map's sign
    as attributes (a Tangent node turns it like a normal); the sign counts times that of the object's determinant. EEVEE
    has only the two vectors of a normal map, which cost more.
    """
    is_given = graph.math("GREATER_THAN", graph.scalar("LENGTH", given["Tangent"]), 0.0)
    columns = _columns(graph)
    read = [graph.add("ShaderNodeAttribute", attribute_name=name) for name in ("tangent", "tangent_sign")]
    # Without a UV map: along the object's x, or z where that stands upright.
    least = (1e-5, 0.0, 1e-9)
    along = _in_world(graph, graph.vector("ADD", read[0].outputs["Vector"], least))
    sign = read[1].outputs["Fac"]
    along_uv, across_uv = frame.uv_frame(graph.tree)
    node: Any
    for node in (along_uv.node, across_uv.node):
        node.hide = True
    least_in_world = _in_world(graph, least)
    of_map = graph.vector("ADD", _surface_direction(graph, columns, along_uv), least_in_world)
    as_normal = _surface_direction(graph, columns, given["Tangent"])
    own = graph.mix(given["TangentIsDirection"], as_normal, given["Tangent"])
    own = graph.vector("ADD", own, least_in_world)
    t = graph.mix(is_given, graph.mix(in_eevee, along, of_map), own)
    across = graph.vector("NORMALIZE", graph.vector("CROSS_PRODUCT", n, t))
    t = graph.vector("CROSS_PRODUCT", across, n)

    handedness = graph.choose(is_given, sign, given["Handedness"])
    determinant = graph.scalar("DOT_PRODUCT", graph.vector("CROSS_PRODUCT", *columns[:2]), columns[2])
    by_sign = graph.product(handedness, determinant)
    unknown = graph.math("COMPARE", handedness, 0.0, 0.5)
    of_given = _surface_direction(graph, columns, graph.scaled(given["Bitangent"], is_given))
    by_vector = graph.product(unknown, graph.scalar("DOT_PRODUCT", across, of_given))
    of_uv = graph.scalar("DOT_PRODUCT", across, _surface_direction(graph, columns, across_uv))
    by_uv = graph.product(in_eevee, graph.difference(1.0, is_given), of_uv)
    mirrored = graph.math("LESS_THAN", graph.sum(graph.sum(by_sign, by_vector), by_uv), 0.0)
    across = graph.scaled(across, graph.fused(mirrored, -2.0, 1.0))
    cos, sin = graph.math("COSINE", given["Rotation"]), graph.math("SINE", given["Rotation"])
    turned_b = graph.vector("SUBTRACT", graph.scaled(across, cos), graph.scaled(t, sin))
    turned_t = graph.vector("ADD", graph.scaled(t, cos), graph.scaled(across, sin))
    return turned_t, turned_b


class Surface:
    """Nodes for single directions of light, in the node's group or in one that is handed the shared sockets.

    Parameters
    ----------
    graph
        Of the group.
    parts
        Of the table.
    sockets
        By the names of `SHARED`.
    """

    def __init__(self, graph: Graph, parts: Parts, sockets: Any) -> None:
        self.graph, self.parts, self._sockets = graph, parts, sockets

    def __getitem__(self, name: str) -> Socket:
        return self._sockets[name]

    @classmethod
    def inside(
        cls, name: str, parts: Parts, inputs: dict[str, str], outputs: dict[str, str]
    ) -> tuple[Surface, Any, bpy.types.Node]:
        """A new group that is handed the shared sockets and more; its surface, inputs and output node.

        Parameters
        ----------
        name
            What the group does.
        inputs, outputs
            Its own sockets: name, type.
        """
        tree = new_group(f"Diffraction {name} {parts.name}")
        interface(tree, {each: (kind, None) for each, kind in (SHARED | inputs).items()}, outputs)
        graph = Graph(tree)
        given = graph.add("NodeGroupInput").outputs
        return cls(graph, parts, given), given, graph.add("NodeGroupOutput")

    def group(self, tree: bpy.types.NodeTree, **values: Value) -> bpy.types.Node:
        """An instance of a group, with the shared sockets that it knows."""
        names = {item.name for item in tree.interface.items_tree if item.in_out == "INPUT"}
        return self.graph.group(tree, **{each: self[each] for each in SHARED if each in names}, **values)

    def value(
        self, radius: tuple[Socket, Socket], turn: Socket, w: Socket, half: Socket, **random: Socket
    ) -> tuple[Socket, Socket]:  # fmt: skip
        """`value.value` for a direction: RGB and its factor; `radius` is |(u, v)| and its square."""
        places = dict(zip(("Radius", "Square"), radius, strict=True))
        found = self.group(self.parts.value, Turn=turn, W=w, Half=half, **places, **random).outputs
        return found["Value"], found["Factor"]

    def f_cos(self, h: Socket) -> tuple[Socket, Socket, Socket, Value]:
        """f cos for the sum h of the directions to light and viewer: RGB, its factor, that with the albedos.

        The last socket is 1 where an albedo may pass 1 and for diffuse rays: elsewhere the two factors are the same.
        Both are 0 where the light is below the surface.
        """
        graph = self.graph
        x, y, w = (graph.scalar("DOT_PRODUCT", self[axis], h) for axis in "TBN")
        gain = graph.product(self.is_above(h), self["Gain"])
        cos_i = graph.difference(w, self["CosR"])
        w, gain = self.behind_face(w, cos_i, gain)
        square = graph.fused(x, x, graph.product(y, y))
        rgb, factor = self.value((graph.math("SQRT", square), square), graph.math("ARCTAN2", y, x), w, h)
        gain = graph.product(gain, factor)
        return rgb, gain, *self.with_albedo(gain, x, y, cos_i)

    def is_above(self, h: Socket) -> Socket:
        """1 where the light lies above the surface, by the sum h of the directions to light and viewer."""
        w = self.graph.scalar("DOT_PRODUCT", self["N"], h)
        return self.graph.math("GREATER_THAN", w, self["CosR"])

    def with_albedo(self, gain: Socket, x: Socket, y: Socket, cos_i: Socket) -> tuple[Socket, Value]:
        """A factor with the larger of the light's albedo and the viewer's where that passes 1, and whether it may.

        Parameters
        ----------
        gain
            Without albedos.
        x, y
            Components of h along t and b.
        cos_i
            Cosine of the light's angle.
        """
        graph = self.graph
        if self.parts.albedo is None:
            return gain, self["IsDiffuse"]
        against = {"AgainstT": graph.difference(self["WrX"], x), "AgainstB": graph.difference(self["WrY"], y)}
        found = self.group(self.parts.albedo, Cosine=cos_i, **against).outputs["Albedo"]
        steeper = graph.math("MINIMUM", cos_i, self["CosR"])
        finished = graph.quotient(gain, graph.math("MAXIMUM", found, self["AlbedoR"]))
        return finished, graph.math("LESS_THAN", steeper, self["PlainFrom"])

    def behind_face(self, w: Socket, cos_i: Socket, gain: Socket) -> tuple[Socket, Socket]:
        """|w| and the factor of a direction under a clear layer of index n, see ``shaders/brdf.osl``; as given without.

        With refracted cosines c', ``w' = n (c_i' + c_r')``, ``f cos_i = t_i t_r R (1 + wi'.wr')^2 cos_i / (c_i' c_r'
        (w'/n)^2) T`` and ``1 + wi'.wr' = (u^2 + v^2 + w'^2) / (2 n^2)``: `value.value` at w' times the factor
        ``t_i t_r cos_i cos_r / (c_i' c_r' n^2)``.
        """
        index = self.parts.layout.index
        if index == 1.0:
            return w, gain
        graph, cos_r = self.graph, self["CosR"]
        inner_i, inner_r = self._refracted(cos_i), self._refracted(cos_r)
        through = graph.product(*(graph.difference(1.0, self.outer_face(cosine)) for cosine in (cos_i, cos_r)))
        factor = graph.quotient(graph.product(through, cos_i, cos_r), graph.product(inner_i, inner_r, index**2))
        return graph.product(graph.sum(inner_i, inner_r), index), graph.product(gain, factor)

    def _refracted(self, cosine: Socket) -> Socket:
        """Cosine of a direction behind the outer face."""
        graph, n2 = self.graph, self.parts.layout.index**2
        return graph.math("SQRT", graph.product(graph.fused(cosine, cosine, n2 - 1.0), 1.0 / n2))

    def outer_face(self, cosine: Socket) -> Socket:
        """Exact reflectance of the lacquer's outer face, as ``fresnel_exact`` in ``shaders/brdf.osl``."""
        return values.exact(self.graph, self.parts.layout.index**2, cosine)

    def limited(self, gain: Socket, red: Socket, green: Socket, blue: Socket) -> Socket:
        """The factor of a colour whose peaks diffuse rays shall not see."""
        graph = self.graph
        peak = graph.product(graph.math("MAXIMUM", graph.math("MAXIMUM", red, green), blue), gain)
        return graph.product(gain, graph.quotient(self["Limit"], graph.math("MAXIMUM", peak, self["Limit"])))

    def base(self, pigment: Socket, roughness: Socket) -> Socket:
        """The pigment, weighted by 1 - R at the view angle, and the mirror of a lacquer's outer face."""
        graph, fresnel = self.graph, self.parts.fresnel
        reflectance: Value = 1.0
        if fresnel == "DIELECTRIC":
            # From behind, too, it is that of the face seen from outside, and all is kept below the horizon.
            behind = graph.add("ShaderNodeNewGeometry").outputs["Backfacing"]
            turned = graph.difference(graph.quotient(1.0, self["IOR"]), self["IOR"])
            reflectance = values.dielectric(graph, graph.fused(behind, turned, self["IOR"]), self["N"])
            reflectance = graph.math("MAXIMUM", reflectance, graph.math("LESS_THAN", self["CosR"], 0.0))
        elif fresnel == "SCHLICK":
            reflectance = values.schlick(graph, self["R0"], graph.clamp(graph.difference(1.0, self["CosR"]), 0.0, 1.0))
        elif fresnel == "CONDUCTOR":
            each = values.conductor(graph, self["ConductorN"], self["ConductorK"], self["CosR"])
            reflectance = graph.product(graph.scalar("DOT_PRODUCT", each, (1.0, 1.0, 1.0)), 1.0 / 3.0)
        if self.parts.kept is not None:
            xyz = self.group(self.parts.kept, Cosine=self["CosR"]).outputs["XYZ"]
            rgb = [
                graph.clamp(graph.scalar("DOT_PRODUCT", self[row], xyz), 0.0, 1.0) for row in ("Red", "Green", "Blue")
            ]
            reflectance = graph.product(graph.sum(graph.sum(rgb[0], rgb[1]), rgb[2]), 1.0 / 3.0)
        below = self.mixed(reflectance, pigment, None)
        if self.parts.layout.index == 1.0:
            return below
        mirror = graph.add("ShaderNodeBsdfAnisotropic", distribution="GGX")
        face = graph.product(self.outer_face(self["CosR"]), graph.math("GREATER_THAN", self["CosR"], 0.0))
        graph.put(mirror.inputs["Color"], graph.join(face, face, face))
        graph.put(mirror.inputs["Roughness"], roughness)
        graph.put(mirror.inputs["Normal"], self["N"])
        return self.both(below, mirror.outputs[0])

    def mixed(self, factor: Value, a: Socket | None, b: Socket | None) -> Socket:
        """Closure a where the factor is 0, b where it is 1; Cycles steps over the nodes of the other one."""
        node = self.graph.add("ShaderNodeMixShader")
        node.inputs[0].default_value = 0.0  # what counts in Cycles where only EEVEE knows the factor
        for socket, value in zip(node.inputs, (factor, a, b), strict=True):
            if value is not None:
                self.graph.put(socket, value)
        return node.outputs[0]

    def both(self, a: Socket, b: Socket) -> Socket:
        """Two closures added."""
        node = self.graph.add("ShaderNodeAddShader")
        self.graph.put(node.inputs[0], a)
        self.graph.put(node.inputs[1], b)
        return node.outputs[0]

    def emitted(self, colour: Socket) -> Socket:
        """A closure that shows a colour."""
        node = self.graph.add("ShaderNodeEmission")
        self.graph.put(node.inputs["Color"], colour)
        return node.outputs[0]
